// Delay from the host's death to zero torque, by a drive's profile and protocol.
#include "hal/rig/watchdog.h"

#include <gmock/gmock.h>

namespace godobject::test_watchdog {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double cycle_s = 1e-3;
constexpr canopen::ObjectAddress fault_reaction{0x605E, 0}, abort_connection{0x6007, 0};

class WatchdogTest : public testing::Test {
 protected:
  WatchdogTest() {
    rig.buses = {{.name = "can0"}};
    rig.drives = {{.joint = "yaw", .node_id = 7, .profile = "some.toml"}};
    profiles.drives = {NodeProfile{.file = "some.toml"}};
  }
  NodeProfile& profile() { return *profiles.drives[0]; }
  void set_deadline(std::uint16_t time_ms, PdoDirection direction = PdoDirection::receive, int number = 1) {
    profile().pdos.push_back(
        {.direction = direction, .number = number, .timer_ms = FromLine<std::uint16_t>{time_ms}});
  }
  void set_host_timeout(std::uint16_t time_ms, std::int64_t option) {
    profile().host_timeout_ms = FromLine<std::uint16_t>{time_ms};
    profile().after_map.push_back({.address = abort_connection, .value = option});
  }
  TimeToZero time() const { return time_to_zero(rig, cycle_s, 0, profiles); }
  std::vector<std::string> missing() const { return missing_watchdogs(rig, cycle_s, profiles); }

  RigParams rig;
  RigProfiles profiles;
};

TEST_F(WatchdogTest, DeadlineOfTheCommand) {
  set_deadline(20);
  EXPECT_EQ(time().s, 20e-3);
  EXPECT_EQ(time().mechanism, "RPDO1 deadline, 1400h:05, then the drive's own 605Eh");
  EXPECT_THAT(missing(), IsEmpty());
  profile().before_map.push_back({.address = fault_reaction, .value = 0});
  EXPECT_EQ(time().mechanism, "RPDO1 deadline, 1400h:05");
  profile().after_map.push_back({.address = fault_reaction, .value = 2});
  EXPECT_EQ(time().mechanism, "RPDO1 deadline, 1400h:05, then the ramp of 605Eh");
}

TEST_F(WatchdogTest, ShortestTimes) {
  set_deadline(1);
  EXPECT_EQ(time().s, 1e-3);
  profile() = {.file = "some.toml"};
  set_host_timeout(1, 1);
  EXPECT_EQ(time().s, 1e-3);
}

TEST_F(WatchdogTest, OtherTimersAreNone) {
  set_deadline(0);
  set_deadline(20, PdoDirection::transmit);
  set_deadline(20, PdoDirection::receive, 2);
  EXPECT_EQ(time().s, std::nullopt);
  EXPECT_THAT(time().mechanism, HasSubstr("its profile some.toml configures none"));
  EXPECT_THAT(missing(), ElementsAre("drive of joint 'yaw' (can0 node 7) has no watchdog, so its motor would "
                                     "keep its torque if this program died: " +
                                     time().mechanism +
                                     "; or accept it with watchdog = \"none\" in its [[device.drive]]"));
}

TEST_F(WatchdogTest, HeartbeatOfTheHost) {
  set_host_timeout(30, 1);
  EXPECT_EQ(time().s, 30e-3);
  EXPECT_EQ(time().mechanism, "host's heartbeat, 1016h:01, then the drive's own 605Eh");
}

TEST_F(WatchdogTest, HeartbeatWithoutTimeOrReactionIsNone) {
  set_host_timeout(0, 1);
  EXPECT_EQ(time().s, std::nullopt);
  profile() = {.file = "some.toml"};
  set_host_timeout(30, 0);
  EXPECT_EQ(time().s, std::nullopt);
  profile() = {.file = "some.toml", .host_timeout_ms = FromLine<std::uint16_t>{30}};
  EXPECT_EQ(time().s, std::nullopt) << "6007h is not written";
}

TEST_F(WatchdogTest, EarlierOfBothActs) {
  set_deadline(20);
  set_host_timeout(30, 1);
  EXPECT_EQ(time().s, 20e-3);
  set_host_timeout(10, 1);
  EXPECT_EQ(time().s, 10e-3);
  EXPECT_THAT(time().mechanism, HasSubstr("heartbeat"));
  set_host_timeout(20, 1);
  EXPECT_THAT(time().mechanism, HasSubstr("deadline")) << "at equal times the deadline is named";
}

TEST_F(WatchdogTest, WithoutAProfile) {
  profiles = {};
  EXPECT_EQ(time().s, std::nullopt);
  EXPECT_EQ(time().mechanism, "its profile is missing");
  rig.drives[0].profile.clear();
  EXPECT_EQ(time().mechanism, "it has no profile that configures one: set profile = \"generic-402\"");
}

TEST_F(WatchdogTest, ProfileOfTheOtherDrive) {
  rig.drives.push_back({.joint = "pitch", .node_id = 8});
  profiles.drives.push_back(std::nullopt);
  set_deadline(20);
  EXPECT_EQ(time_to_zero(rig, cycle_s, 1, profiles).s, std::nullopt);
  profiles.drives.pop_back();
  EXPECT_EQ(time_to_zero(rig, cycle_s, 1, profiles).s, std::nullopt);
  EXPECT_EQ(missing().size(), 1u);
}

TEST_F(WatchdogTest, OfTheDrivesOwnConfiguration) {
  rig.drives[0].watchdog = DriveWatchdog::drive;
  rig.drives[0].watchdog_ms = 40;
  EXPECT_EQ(time().s, 40e-3);
  EXPECT_THAT(time().mechanism, HasSubstr("according to the scene"));
  EXPECT_THAT(missing(), IsEmpty());
}

TEST_F(WatchdogTest, AcceptedWithout) {
  rig.drives[0].watchdog = DriveWatchdog::none;
  EXPECT_EQ(time().s, std::nullopt);
  EXPECT_EQ(time().mechanism, "accepted by watchdog = \"none\"");
  EXPECT_THAT(missing(), IsEmpty());
}

TEST_F(WatchdogTest, OfTheProtocol) {
  rig.drives[0].protocol = DriveProtocol::moteus;
  EXPECT_EQ(time().s, 20e-3);
  EXPECT_EQ(time_to_zero(rig, 10e-3, 0, profiles).s, 40e-3);
  EXPECT_THAT(missing(), IsEmpty());
  rig.drives[0].protocol = DriveProtocol::odrive;
  EXPECT_EQ(time().s, std::nullopt);
  EXPECT_THAT(missing(), ElementsAre(HasSubstr("enable_watchdog")));
}

}  // namespace
}  // namespace godobject::test_watchdog
