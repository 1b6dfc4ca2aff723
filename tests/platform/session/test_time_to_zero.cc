// Time for which a motor keeps its torque after the host died: determined only by the drive's configuration.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "hal/rig/watchdog.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test_time_to_zero {
namespace {

using test::FaultyRig;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr Nanoseconds ms = 1'000'000;
const std::string profile_folder = std::string(GODOBJECT_SOURCE_DIR) + "/hal/profiles/";

SceneConfig scene_with(const std::string& profile) {
  SceneConfig scene = test::two_joints();
  for (DriveParams& drive : scene.device->rig->drives) drive.profile = profile;
  return scene;
}

/// A rig with torque on its motors and a host that then stops sending.
class DyingHost {
 public:
  explicit DyingHost(const SceneConfig& scene) : device(scene) {
    device.link.set_observer({.on_frame = on_frame, .context = this});
    booted = device.boot();
  }

  /// Returns the time from the last command to the first zero torque, s; none if longer than `limit_s`.
  std::optional<double> time_to_zero(double limit_s) {
    const Nanoseconds end = device.t_sync_ns + std::llround(1e9 * limit_s);
    for (Nanoseconds t = device.t_sync_ns; t < end;) {
      t = device.link.begin_cycle(device.motion_time);
      for (const Nanoseconds next = t + ms; t < next - 1;) {
        t = device.link.wait(next - 1);
        if (device.motor_torque() == 0) return 1e-9 * static_cast<double>(t - t_command_ns);
      }
    }
    return std::nullopt;
  }

  FaultyRig device;
  bool booted = false;
  Nanoseconds t_command_ns = 0;
  std::vector<std::uint16_t> emergencies;

 private:
  static void on_frame(void* context, std::size_t bus, const ReceivedFrame& received) {
    auto& self = *static_cast<DyingHost*>(context);
    if (bus != 1) return;
    const bool is_command =
        received.frame.fd || (received.frame.id & 0x780u) == 0x200 || (received.frame.id & 0x1Fu) == 0x0E;
    if (is_command) self.t_command_ns = received.t_ns;
    canopen::Emergency emergency;
    if (canopen::parse_emergency(received.frame, emergency) == ParseResult::ok && emergency.error_code != 0)
      self.emergencies.push_back(emergency.error_code);
  }
};

std::string shown(const std::optional<double>& s) { return s ? std::to_string(1e3 * *s) + " ms" : "never"; }

void expect_zero_in_time(const SceneConfig& scene, std::uint16_t emergency) {
  DyingHost host(scene);
  ASSERT_TRUE(host.booted) << host.device.rig.fault_text();
  const std::optional<double> time = host.time_to_zero(1);
  ASSERT_TRUE(time) << "never";
  std::printf("%s\n", shown(time).c_str());
  EXPECT_LE(*time, 0.02 + 1e-3) << shown(time);
  EXPECT_GT(*time, 0.01) << "so fast it was not the watchdog: " << shown(time);
  host.device.cycles(2);
  if (emergency != 0) EXPECT_THAT(host.emergencies, ElementsAre(emergency, emergency));
  else EXPECT_THAT(host.emergencies, IsEmpty());
}

TEST(TimeToZero, GenericProfileTakesTheTorqueAwayByTheDeadlineOfRpdo1) {
  expect_zero_in_time(scene_with("generic-402"), canopen::emcy_rpdo_timeout);
}

TEST(TimeToZero, ProfilesWithoutADeadlineTakeItAwayByTheHostsHeartbeat) {
  for (const char* const profile : {"epos4", "nanotec"}) {
    SceneConfig scene = scene_with(profile);
    scene.device->rig->heartbeat_period_s = 5e-3;
    expect_zero_in_time(scene, 0x8130);
  }
}

TEST(TimeToZero, OdriveByTheWatchdogOfItsConfiguration) {
  expect_zero_in_time(test::two_joints(DriveProtocol::odrive, DriveWatchdog::drive), 0);
}

TEST(TimeToZero, MoteusByTheRegisterThatEachCommandSets) {
  expect_zero_in_time(test::two_joints(DriveProtocol::moteus, DriveWatchdog::host), 0);
}

// The configured value is used even if it is bad: the profile as it was shipped before.
TEST(TimeToZero, IsWhatTheProfileSaysAndNotWhatTheSimulationWouldLike) {
  std::string text = read_text(profile_folder + "generic-402.toml").value();
  const std::size_t deadline = text.find("deadline_ms");
  text.erase(deadline, text.find('\n', deadline) + 1 - deadline);
  const std::string slow = "slow-402.toml";  // in the folder of the scene
  std::ofstream(slow) << text;
  DyingHost host(scene_with(slow));
  std::filesystem::remove(slow);
  ASSERT_TRUE(host.booted) << host.device.rig.fault_text();
  const std::optional<double> time = host.time_to_zero(1);
  ASSERT_TRUE(time);
  std::printf("%s\n", shown(time).c_str());
  EXPECT_GT(*time, 0.19) << shown(time);
  EXPECT_LE(*time, 0.301) << shown(time);
  EXPECT_THAT(host.emergencies, Each(0x8130));
}

TEST(TimeToZero, DriveThatNobodySetUpKeepsItsTorque) {
  for (const DriveProtocol protocol : {DriveProtocol::cia402, DriveProtocol::odrive}) {
    DyingHost host(test::two_joints(protocol, DriveWatchdog::none));
    ASSERT_TRUE(host.booted) << host.device.rig.fault_text();
    const std::optional<double> time = host.time_to_zero(5);
    EXPECT_FALSE(time) << drive_protocol_names[static_cast<std::size_t>(protocol)] << ": " << shown(time);
    EXPECT_GT(host.device.motor_torque(), 0);
  }
}

// A delay of the host below the deadline has no effect; above it, the motors are off until it arms again.
TEST(TimeToZero, HiccupOfTheHostIsForgivenUpToTheDeadline) {
  for (const int late_ms : {10, 30}) {
    SceneConfig scene = scene_with("generic-402");
    scene.device->rig->stale_after_s = 0.1;
    for (EncoderParams& encoder : scene.device->rig->encoders) encoder.max_speed = 5;
    DyingHost host(scene);
    ASSERT_TRUE(host.booted) << host.device.rig.fault_text();
    for (int i = 0; i < late_ms; ++i)
      static_cast<void>(host.device.link.begin_cycle(host.device.motion_time));
    host.device.cycles(5);
    if (late_ms < 20) {
      EXPECT_EQ(host.device.rig.state(), RigState::armed) << host.device.rig.fault_text();
      EXPECT_GT(host.device.motor_torque(), 0);
      EXPECT_THAT(host.emergencies, IsEmpty());
      continue;
    }
    EXPECT_TRUE(any(host.device.rig.faults() & RigFault::emergency)) << host.device.rig.fault_text();
    host.device.cycles(500);
    EXPECT_EQ(host.device.motor_torque(), 0) << "re-enabled by itself";
    host.device.rig.clear_faults(host.device.t_sync_ns);
    EXPECT_TRUE(host.device.boot()) << host.device.rig.fault_text();
  }
}

// In every state with the deadline active the drive receives its RPDO1: booting, enabling, in a fault,
// running down.
TEST(TimeToZero, TheHostsOwnCycleNeverTripsIt) {
  DyingHost host(scene_with("generic-402"));
  ASSERT_TRUE(host.booted) << host.device.rig.fault_text();
  host.device.play("spike bus=can0 node=1 duration=0.02");
  host.device.cycles(200);  // a fault of an encoder: the drives stay enabled, at zero
  EXPECT_EQ(host.device.rig.state(), RigState::fault);
  host.device.rig.clear_faults(host.device.t_sync_ns);
  ASSERT_TRUE(host.device.boot()) << host.device.rig.fault_text();
  host.device.rig.disarm();
  host.device.cycles(200);
  host.device.rig.stop();
  host.device.cycles(200);
  EXPECT_THAT(host.emergencies, IsEmpty());
  EXPECT_EQ(host.device.motor_torque(), 0);
}

TEST(MissingWatchdogs, AreReportedWithTheDriveAndTheRemedy) {
  const auto lines = [](const SceneConfig& scene) {
    return missing_watchdogs(*scene.device->rig, scene.step, test::profiles_of(scene));
  };
  using testing::AllOf;
  using testing::HasSubstr;
  EXPECT_THAT(lines(scene_with("generic-402")), IsEmpty());
  EXPECT_THAT(lines(scene_with("")),
              ElementsAre(AllOf(HasSubstr("drive of joint 'turret' (can1 node 1)"),
                                HasSubstr("profile = \"generic-402\""), HasSubstr("watchdog = \"none\"")),
                          HasSubstr("drive of joint 'elbow' (can1 node 2)")));
  EXPECT_THAT(lines(test::two_joints(DriveProtocol::odrive, DriveWatchdog::host)),
              Each(AllOf(HasSubstr("enable_watchdog"), HasSubstr("watchdog = \"drive\""))));
  EXPECT_THAT(lines(test::two_joints(DriveProtocol::odrive, DriveWatchdog::drive)), IsEmpty());
  EXPECT_THAT(lines(test::two_joints(DriveProtocol::moteus, DriveWatchdog::host)), IsEmpty());
  EXPECT_THAT(lines(test::two_joints(DriveProtocol::cia402, DriveWatchdog::none)), IsEmpty());
}

}  // namespace
}  // namespace godobject::test_time_to_zero
