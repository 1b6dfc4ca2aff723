// Configuration of nodes: maps that are right already or cannot be changed, and nodes that boot again
// meanwhile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "hal/canopen/pdo_map.h"
#include "hal/rig/commissioning.h"
#include "tests/support/simulated_rig.h"

namespace godobject::test_set_up_again {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr Nanoseconds ms = 1'000'000;

MappedObject mapped(const char* name) { return parse_mapped_object(name).value(); }

/// Returns a profile with the rig's requirements on a drive, as in the shipped profiles.
NodeProfile drive_profile() {
  NodeProfile profile{.file = "drive.toml"};
  profile.heartbeat_ms = FromLine<std::uint16_t>{.value = 50};
  profile.pdos = {
      {.direction = PdoDirection::receive,
       .transmission = {.value = 1},
       .map = {mapped("controlword"), mapped("target_torque")}},
      {.transmission = {.value = 1}, .map = {mapped("statusword"), mapped("position"), mapped("torque")}},
      {.number = 2,
       .transmission = {.value = 255},
       .timer_ms = FromLine<std::uint16_t>{.value = 20},
       .map = {mapped("velocity"), mapped("mode_display"), mapped("error_code")}}};
  profile.mode = FromLine<std::int8_t>{.value = 10};
  return profile;
}

/// An arm with a profile for its first drive.
class SettingUp {
 public:
  explicit SettingUp(SimDefaults defaults, const NodeProfile& profile = drive_profile())
      : sim(test::arm_rig_params(), false, {}, defaults) {
    profiles.encoders.resize(sim.params.encoders.size());
    profiles.drives.resize(sim.params.drives.size());
    profiles.drives[0] = profile;
    sim.wires[1].set_observer({.on_frame = note, .context = this});
  }

  /// Runs to the end; calls `meanwhile` before each millisecond.
  std::vector<std::string> run(const std::function<void(Nanoseconds since_start)>& meanwhile = {}) {
    Commissioning commissioning(sim.params, SimulatedRig::cycle_s, profiles, sim.hosts);
    const Nanoseconds start = sim.now;
    while (!commissioning.done() && sim.now < start + 20'000 * ms) {
      if (meanwhile) meanwhile(sim.now - start);
      commissioning.poll(sim.now);
      sim.idle(ms);
    }
    EXPECT_TRUE(commissioning.done());
    return commissioning.errors();
  }
  SimDrive& drive() { return *sim.drives[0]; }
  void make_read_only(std::uint16_t index) {
    for (std::uint8_t sub = 0; sub <= max_mapped_objects; ++sub)
      if (Object* const object = drive().objects().find({index, sub}))
        object->access = ObjectAccess::read_only;
  }
  bool was_written(std::uint16_t index) const { return std::ranges::find(written, index) != written.end(); }

  test::SimulatedRig sim;
  RigProfiles profiles;
  std::vector<std::uint16_t> written;  // indexes, by SDO

 private:
  static void note(void* context, const ReceivedFrame& received) {
    sdo::Message message;
    if (sdo::parse_frame(received.frame, sdo::request_cob_id(1), message) != ParseResult::ok) return;
    if (sdo::command_of(message) == static_cast<std::uint8_t>(sdo::Request::initiate_download))
      static_cast<SettingUp*>(context)->written.push_back(sdo::address_of(message).index);
  }
};

TEST(SetUp, MapsThatAreRightAreNotWritten) {
  SettingUp setting(SimDefaults::rig);
  for (const std::uint16_t index : std::initializer_list<std::uint16_t>{0x1600, 0x1A00, 0x1A01, 0x1800})
    setting.make_read_only(index);
  EXPECT_THAT(setting.run(), IsEmpty());
  for (const std::uint16_t index :
       std::initializer_list<std::uint16_t>{0x1600, 0x1A00, 0x1A01, 0x1400, 0x1800, 0x1801})
    EXPECT_FALSE(setting.was_written(index)) << std::hex << index;
  EXPECT_TRUE(setting.was_written(0x1017));
}

TEST(SetUp, OnlyWhatDiffersIsWritten) {
  NodeProfile profile = drive_profile();
  profile.pdos[1].transmission.value = 3;
  profile.pdos[2].timer_ms->value = 30;
  SettingUp setting(SimDefaults::rig, profile);
  for (const std::uint16_t index : std::initializer_list<std::uint16_t>{0x1A00, 0x1A01})
    setting.make_read_only(index);
  EXPECT_THAT(setting.run(), IsEmpty());
  EXPECT_FALSE(setting.was_written(0x1A00) || setting.was_written(0x1A01) || setting.was_written(0x1400));
  EXPECT_EQ(setting.drive().objects().value({0x1800, 2}), 3);
  EXPECT_EQ(setting.drive().objects().value({0x1801, 5}), 30);
  EXPECT_EQ(setting.drive().objects().value({0x1800, 1}) >> 31, 0) << "it is on again";
}

TEST(SetUp, AnIdentifierThatIsReadOnlyLeavesThePdoOn) {
  NodeProfile profile = drive_profile();
  profile.pdos[1].transmission.value = 2;
  SettingUp setting(SimDefaults::rig, profile);
  setting.make_read_only(0x1A00);
  setting.drive().objects().find({0x1800, 1})->access = ObjectAccess::read_only;
  EXPECT_THAT(setting.run(), IsEmpty());
  EXPECT_EQ(setting.drive().objects().value({0x1800, 2}), 2);
}

TEST(SetUp, AMapThatDiffersAndIsReadOnlyIsAnError) {
  SettingUp setting(SimDefaults::factory);
  setting.make_read_only(0x1A00);
  EXPECT_THAT(setting.run(), testing::ElementsAre(HasSubstr("1A00h:00")));
}

TEST(SetUp, AFactorysMapIsReplaced) {
  SettingUp setting(SimDefaults::factory);
  EXPECT_THAT(setting.run(), IsEmpty());
  EXPECT_EQ(setting.drive().objects().value({0x1A00, 0}), 3);
  EXPECT_EQ(setting.drive().objects().value({0x1A00, 2}), 0x60640020);
}

TEST(SetUp, BeginsAgainWhereTheNodeBootsAgain) {
  std::mt19937 random(38);
  for (int k = 0; k < 20; ++k) {
    SettingUp setting(SimDefaults::factory);
    const auto first = static_cast<Nanoseconds>(5 + random() % 60) * ms;
    const auto second = first + static_cast<Nanoseconds>(1 + random() % 40) * ms;
    EXPECT_THAT(setting.run([&](Nanoseconds t) {
      if (t == first || (k % 2 == 0 && t == second)) setting.drive().power_cycle(setting.sim.now);
    }),
                IsEmpty());
    EXPECT_EQ(setting.drive().objects().value({0x1A00, 2}), 0x60640020) << first / ms;
    EXPECT_EQ(setting.drive().objects().value({0x6060, 0}), 10);
    EXPECT_EQ(setting.drive().objects().value({0x1017, 0}), 50);
  }
}

TEST(SetUp, EndsWhereTheNodeBootsForEver) {
  SettingUp setting(SimDefaults::factory);
  const std::vector<std::string> errors = setting.run([&](Nanoseconds t) {
    if (t % (20 * ms) == 0) setting.drive().power_cycle(setting.sim.now);
  });
  EXPECT_THAT(errors, testing::ElementsAre(HasSubstr("while it was set up: check its supply voltage")));
}

/// A node that simulates the device of a profile passes its identity and torque checks.
TEST(SetUp, ASimulatedNodePlaysTheDeviceOfAProfile) {
  NodeProfile profile = drive_profile();
  profile.identity = {{.address = {0x1000, 0}, .value = 402},
                      {.address = {0x1018, 1}, .value = 0xFB},
                      {.address = {0x1018, 2}, .value = 0x6050'0000}};
  SettingUp strange(SimDefaults::rig, profile);
  EXPECT_THAT(strange.run(), testing::ElementsAre(HasSubstr("1018h:01")));
  SettingUp setting(SimDefaults::rig, profile);
  setting.drive().identify_as(profile.identity);
  EXPECT_THAT(setting.run(), IsEmpty());
}

}  // namespace
}  // namespace godobject::test_set_up_again
