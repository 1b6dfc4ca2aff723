// The master configures simulated nodes in their factory state; the rig then works with them.
#include "hal/rig/commissioning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "hal/canopen/commissioning_steps.h"
#include "hal/canopen/pdo_map.h"
#include "hal/canopen/sdo/sequence.h"
#include "hal/rig/profile_validate.h"
#include "platform/scene/text/diagnostics.h"
#include "platform/scene/toml.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/simulated_rig.h"

namespace godobject::test_commissioning {
namespace {

using test::SimulatedRig;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr Nanoseconds ms = 1'000'000;
const std::string profile_folder = std::string(GODOBJECT_SOURCE_DIR) + "/hal/profiles/";

/// Returns the grasper's rig with generic profiles.
RigParams grasper() {
  const LoadResult loaded = load_scene(std::string(GODOBJECT_SOURCE_DIR) + "/sim/scenes/grasper.toml");
  EXPECT_THAT(loaded.errors, IsEmpty());
  RigParams rig = *loaded.scene->device->rig;
  for (EncoderParams& encoder : rig.encoders) encoder.profile = "generic-406";
  for (DriveParams& drive : rig.drives) drive.profile = "generic-402";
  return rig;
}

RigProfiles profiles_of(const RigParams& rig) {
  const RigProfilesResult loaded = load_profiles(rig, SimulatedRig::cycle_s, ".");
  EXPECT_THAT(loaded.errors, IsEmpty());
  return loaded.profiles;
}

/// Polls each millisecond until it is done or `limit` has passed.
void run(Commissioning& commissioning, SimulatedRig& sim, Nanoseconds limit = 10'000 * ms) {
  for (const Nanoseconds end = sim.now + limit; !commissioning.done() && sim.now < end;) {
    commissioning.poll(sim.now);
    sim.idle(ms);
  }
}

/// A shipped profile with one change, and the line of the change.
struct Changed {
  NodeProfile profile;
  std::string place;  // "generic-402.toml:21"
};
Changed changed(const std::string& name, const std::string& from, const std::string& to) {
  const std::string path = profile_folder + name + ".toml";
  std::string text = read_text(path).value();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  const ProfileResult parsed = parse_profile(text, name + ".toml");
  EXPECT_THAT(parsed.errors, IsEmpty());
  return {parsed.profile.value(), name + ".toml:" + std::to_string(line)};
}

std::string canopen_document() {
  return read_text(std::string(GODOBJECT_SOURCE_DIR) + "/docs/canopen.md").value();
}

TEST(ProfileReference, DocumentHoldsTheGeneratedTables) {
  const std::string expected =
      "<!-- keys: begin -->\n\n" + profile_reference_markdown() + "\n<!-- keys: end -->";
  EXPECT_THAT(canopen_document(), HasSubstr(expected))
      << "paste the tables of profile_reference_markdown() between the markers";
}

TEST(ProfileReference, DocumentHasTheNamesOfObjects) {
  for (const NamedObject& object : named_objects())
    EXPECT_THAT(canopen_document(), HasSubstr("`" + std::string(object.name) + "`"));
}

TEST(Commissioning, FactoryNodesDoNotWorkWithoutIt) {
  SimulatedRig sim(grasper(), false, {}, SimDefaults::factory);
  EXPECT_FALSE(sim.boot());
}

TEST(Commissioning, FactoryNodesBootAndArmAfterIt) {
  const RigParams params = grasper();
  SimulatedRig sim(params, false, {}, SimDefaults::factory);
  Commissioning commissioning(params, SimulatedRig::cycle_s, profiles_of(params), sim.hosts);
  EXPECT_FALSE(commissioning.done());
  EXPECT_EQ(commissioning.pending().size(), params.drives.size() + params.encoders.size());
  run(commissioning, sim);
  EXPECT_THAT(commissioning.errors(), IsEmpty());
  ASSERT_TRUE(commissioning.done());
  EXPECT_THAT(commissioning.pending(), IsEmpty());

  for (const auto& drive : sim.drives) {
    const ObjectDictionary& o = drive->objects();
    EXPECT_EQ(drive->nmt_state(), canopen::NmtState::pre_operational);
    EXPECT_EQ(o.value({0x6061, 0}), 10);
    EXPECT_EQ(o.value({0x1017, 0}), 50);
    EXPECT_EQ(o.value({0x1016, 1}), params.host_node_id << 16 | 300);
    EXPECT_EQ(o.value({0x60C2, 1}), 1);
    EXPECT_EQ(o.value({0x1A00, 2}), 0x60640020);
    EXPECT_EQ(o.value({0x1802, 1}) & 0x80000000, 0x80000000) << "the factory's TPDO3 is off";
  }

  ASSERT_TRUE(sim.boot()) << sim.rig->fault_text();
  EXPECT_TRUE(sim.rig->arm());
  sim.cycles(500);
  EXPECT_EQ(sim.rig->state(), RigState::armed) << sim.rig->fault_text();
  EXPECT_TRUE(sim.sample.valid);
}

TEST(Commissioning, PollAllocatesNothing) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "the sanitizer owns the allocator";
  const RigParams params = grasper();
  SimulatedRig sim(params, false, {}, SimDefaults::factory);
  Commissioning commissioning(params, SimulatedRig::cycle_s, profiles_of(params), sim.hosts);
  long calls = 0;
  for (int i = 0; i < 3000 && !commissioning.done(); ++i) {
    AllocationGuard guard;
    commissioning.poll(sim.now);
    calls += guard.calls();
    guard.disarm();
    sim.idle(ms);
  }
  EXPECT_TRUE(commissioning.done() && !commissioning.failed());
  EXPECT_EQ(calls, 0);
}

// A node may start by itself after its boot-up, and then refuse further configuration.
TEST(Commissioning, NodeIsHaltedBeforeTheFirstRequest) {
  const RigParams params = grasper();
  SimulatedRig sim(params, false, {}, SimDefaults::factory);
  std::vector<std::uint32_t> order;  // boot-up of node 1, pre-operational to it, first SDO request to it
  sim.wires[0].set_observer({[](void* context, const ReceivedFrame& received) {
                               const CanFrame& f = received.frame;
                               const bool halt = f.id == 0 && f.data[0] == 0x80 && f.data[1] == 1;
                               auto& seen = *static_cast<std::vector<std::uint32_t>*>(context);
                               if (halt || f.id == 0x601 || f.id == 0x701) seen.push_back(f.id);
                             },
                             &order});
  Commissioning commissioning(params, SimulatedRig::cycle_s, profiles_of(params), sim.hosts);
  run(commissioning, sim);
  ASSERT_GE(order.size(), 3u);
  EXPECT_EQ(std::vector(order.begin(), order.begin() + 3), (std::vector<std::uint32_t>{0x701, 0, 0x601}));
}

/// Expects all drives in fault with this error code, within this time after the host's last cycle.
void expect_drives_to_stop(const RigParams& params, const RigProfiles& profiles, Nanoseconds within,
                           std::uint16_t error_code) {
  SimulatedRig sim(params, false, {}, SimDefaults::factory);
  Commissioning commissioning(params, SimulatedRig::cycle_s, profiles, sim.hosts);
  run(commissioning, sim);
  ASSERT_FALSE(commissioning.failed());
  ASSERT_TRUE(sim.boot()) << sim.rig->fault_text();
  sim.idle(within);
  for (const auto& drive : sim.drives) {
    EXPECT_EQ(drive->drive_state(), cia402::DriveState::fault);
    EXPECT_EQ(drive->error_code(), error_code);
  }
}

// 1400h:05: the drives stop by themselves.
TEST(Commissioning, DrivesStopWhenTheHostVanishes) {
  const RigParams params = grasper();
  expect_drives_to_stop(params, profiles_of(params), 20 * ms, 0x8250);
}

// 1016h and 6007h: the same without a deadline.
TEST(Commissioning, DrivesStopWhenTheHostsHeartbeatStaysAway) {
  const RigParams params = grasper();
  RigProfiles profiles = profiles_of(params);
  for (std::optional<NodeProfile>& drive : profiles.drives)
    for (PdoProfile& pdo : drive->pdos)
      if (pdo.direction == PdoDirection::receive) pdo.timer_ms.reset();
  // the host's last heartbeat is up to 100 ms old; the profile's limit is 300 ms
  expect_drives_to_stop(params, profiles, 399 * ms, 0x8130);
}

TEST(Commissioning, NodesWithoutAProfileAreLeftAlone) {
  RigParams params = grasper();
  for (DriveParams& drive : params.drives) drive.profile = "";
  SimulatedRig sim(params, false, {}, SimDefaults::factory);
  Commissioning commissioning(params, SimulatedRig::cycle_s, profiles_of(params), sim.hosts);
  run(commissioning, sim);
  EXPECT_FALSE(commissioning.failed());
  EXPECT_EQ(sim.drives[0]->objects().value({0x1017, 0}), 0);
  EXPECT_EQ(sim.encoders[0]->objects().value({0x1017, 0}), 100);
  Commissioning nothing(params, SimulatedRig::cycle_s, {}, sim.hosts);
  EXPECT_TRUE(nothing.done());
}

struct Failing {
  explicit Failing(const RigParams& rig = grasper())
      : params(rig), sim(rig, false, {}, SimDefaults::factory) {
    profiles = profiles_of(params);
  }
  std::vector<std::string> errors() {
    Commissioning commissioning(params, SimulatedRig::cycle_s, profiles, sim.hosts);
    run(commissioning, sim);
    EXPECT_TRUE(commissioning.done() && commissioning.failed());
    return commissioning.errors();
  }
  /// Gives drive 0 a changed profile; returns the place of the change.
  std::string change(const std::string& from, const std::string& to) {
    Changed it = changed("generic-402", from, to);
    profiles.drives[0] = it.profile;
    return it.place;
  }

  RigParams params;
  SimulatedRig sim;
  RigProfiles profiles;
};

TEST(CommissioningErrors, RejectedValueNamesDeviceObjectAndLine) {
  Failing failing;
  const std::string place = failing.change("mode = 10", "mode = 1");
  EXPECT_THAT(
      failing.errors(),
      ElementsAre(AllOf(HasSubstr("drive of joint 'pitch' (can0 node 1): 6060h:00 <- 1 rejected: 06090030 "),
                        HasSubstr("value range"), HasSubstr("(" + place + ")"))));
}

TEST(CommissioningErrors, ObjectThatTheDeviceDoesNotHave) {
  Failing failing;
  const std::string place =
      failing.change("about = ", "write = [{ index = 0x2000, type = \"i16\", value = 6 }]\nabout = ");
  EXPECT_THAT(failing.errors(), ElementsAre(AllOf(HasSubstr("2000h:00 <- 6 rejected: 06020000 "),
                                                  HasSubstr("does not exist"), HasSubstr(place))));
}

TEST(CommissioningErrors, ObjectThatCannotBeMapped) {
  Failing failing;
  const std::string place = failing.change("\"torque\"]", "\"6076h:00:16\"]");
  EXPECT_THAT(failing.errors(), ElementsAre(AllOf(HasSubstr("1A00h:03 <- "), HasSubstr("rejected: 06040041"),
                                                  HasSubstr(place))));
}

TEST(CommissioningErrors, OtherVendor) {
  Failing failing;
  const std::string place = failing.change("device_profile = 402", "vendor = 0xFB");
  EXPECT_THAT(failing.errors(), ElementsAre(AllOf(HasSubstr("1018h:01 is 3563 (00000DEBh), not 251"),
                                                  HasSubstr("another device"), HasSubstr(place))));
}

TEST(CommissioningErrors, EncoderWhereADriveShouldBe) {
  Failing failing;
  failing.profiles.encoders[0] = failing.profiles.drives[0];
  EXPECT_THAT(failing.errors(), ElementsAre(AllOf(HasSubstr("encoder of joint 'roll' (can0 node 3)"),
                                                  HasSubstr("1000h:00 is 406"), HasSubstr("not 402"))));
}

TEST(CommissioningErrors, RatedTorqueOfAnotherMotor) {
  Failing failing;
  failing.params.drives[0].torque_rated_Nm = 0.2;  // the simulated drive keeps 0.1
  EXPECT_THAT(failing.errors(),
              ElementsAre(AllOf(HasSubstr("6076h:00 is 100, not "), HasSubstr("torque_rated_Nm = 0.2"),
                                HasSubstr("generic-402.toml:"))));
}

TEST(CommissioningErrors, NodeThatIsNotThere) {
  Failing failing;
  failing.sim.drive_ports[1]->set_connected(false);
  EXPECT_THAT(failing.errors(),
              ElementsAre(AllOf(HasSubstr("drive of joint 'yaw' (can0 node 2)"),
                                HasSubstr("no boot-up message within 5000 ms"), HasSubstr("bit rate"))));
}

TEST(CommissioningErrors, NodeThatFallsSilentMidway) {
  Failing failing;
  Commissioning commissioning(failing.params, SimulatedRig::cycle_s, failing.profiles, failing.sim.hosts);
  run(commissioning, failing.sim, 20 * ms);
  ASSERT_FALSE(commissioning.done());
  failing.sim.drive_ports[0]->set_connected(false);
  run(commissioning, failing.sim);
  EXPECT_THAT(commissioning.errors(),
              ElementsAre(AllOf(HasSubstr("drive of joint 'pitch'"), HasSubstr("no answer within 1000 ms"),
                                HasSubstr("generic-402.toml:"))));
}

TEST(CommissioningErrors, NodeThatRebootsRepeatedly) {
  Failing failing;
  Commissioning commissioning(failing.params, SimulatedRig::cycle_s, failing.profiles, failing.sim.hosts);
  for (int k = 0; k < 400 && !commissioning.done(); ++k) {
    run(commissioning, failing.sim, 20 * ms);
    failing.sim.drives[0]->power_cycle(failing.sim.now);
  }
  EXPECT_THAT(commissioning.errors(),
              ElementsAre(HasSubstr("while it was set up: check its supply voltage")));
}

TEST(CommissioningErrors, BusThatSendsNothing) {
  Failing failing;
  failing.sim.hosts[1]->close();
  const std::vector<std::string> errors = failing.errors();
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_THAT(errors[0], AllOf(HasSubstr("(can1 node 1)"), HasSubstr("did not accept the reset")));
}

/// A server with objects that do not store written values.
class StubbornNode final : ObjectObserver {
 public:
  StubbornNode() {
    objects_.add({0x1A00, 1}, canopen::ObjectType::u32, ObjectAccess::read_write, 0x60410010);
    objects_.add({0x6061, 0}, canopen::ObjectType::i8, ObjectAccess::read_only, 1);
    EXPECT_TRUE(host_.open() && port_.open());
  }

  /// Runs the steps to their end; returns the error, or empty.
  std::string run(std::vector<SdoStep> steps) {
    SdoSequence sequence(5, std::move(steps), 100 * ms, 50 * ms);
    for (Nanoseconds now = 0; !sequence.done() && !sequence.failed() && now < 1000 * ms; now += ms) {
      for (ReceivedFrame received; host_.try_receive(received);) sequence.on_frame(received.frame);
      sequence.poll(now, host_);
      wire_.advance_to(now + ms / 2);
      for (ReceivedFrame received; port_.try_receive(received);) {
        sdo::Message request;
        if (sdo::parse_frame(received.frame, sdo::request_cob_id(5), request) != ParseResult::ok) continue;
        const sdo::Message answer = server_.answer(request).value();
        EXPECT_EQ(port_.try_send(sdo::make_frame(sdo::response_cob_id(5), answer)), SendResult::queued);
      }
      wire_.advance_to(now + ms);
    }
    EXPECT_TRUE(sequence.done() || sequence.failed());
    return sequence.error_text();
  }

 private:
  sdo::AbortCode may_write(canopen::ObjectAddress, std::int64_t) noexcept override {
    return sdo::AbortCode::none;
  }
  void on_written(canopen::ObjectAddress address, std::int64_t) noexcept override {
    objects_.find(address)->value = 0x60410010;
  }
  void before_read() noexcept override {}

  SimCanWire wire_{{}};
  SimCanPort host_{wire_}, port_{wire_};
  ObjectDictionary objects_{*this};
  SdoServer server_{objects_};
};

TEST(SdoSequence, ValueThatIsNotKeptIsFoundByReadingItBack) {
  StubbornNode node;
  const SdoStep write{.address = {0x1A00, 1}, .low = 0x60640020};
  SdoStep check = write;
  check.action = SdoAction::check;
  check.high = check.low;
  check.hint = "see its manual";
  EXPECT_EQ(node.run({write, check}),
            "1A00h:01 is 1614872592 (60410010h), not 1617166368 (60640020h): see its manual");
}

TEST(SdoSequence, ModeThatTheDriveDoesNotTake) {
  StubbornNode node;
  const SdoStep wait{.action = SdoAction::wait_for,
                     .address = {0x6061, 0},
                     .type = canopen::ObjectType::i8,
                     .low = 10,
                     .high = 10};
  EXPECT_EQ(node.run({wait}), "6061h:00 stays 1 for 50 ms, not 10");
}

TEST(SdoSequence, ObjectOfAnotherType) {
  StubbornNode node;
  const SdoStep check{.action = SdoAction::check, .address = {0x6061, 0}, .low = 1, .high = 1};
  EXPECT_EQ(node.run({check}), "6061h:00 has 1 bytes, not the 4 of u32");
}

TEST(SdoSequence, PdoThatIsNotThereNeedNotBeSwitchedOff) {
  StubbornNode node;
  const SdoStep off{.action = SdoAction::switch_off_if_there, .address = {0x1803, 1}};
  EXPECT_EQ(node.run({off}), "");
  SdoStep must = off;
  must.action = SdoAction::switch_off;
  EXPECT_THAT(node.run({must}), HasSubstr("1803h:01 read: rejected: 06020000"));
}

TEST(InterpolationTime, PeriodsThatSixtyC2Carries) {
  EXPECT_EQ(interpolation_time(1e-3)->value, 1);
  EXPECT_EQ(interpolation_time(1e-3)->exponent, -3);
  EXPECT_EQ(interpolation_time(0.5e-3)->value, 5);
  EXPECT_EQ(interpolation_time(0.5e-3)->exponent, -4);
  EXPECT_EQ(interpolation_time(0.25e-3)->value, 25);
  EXPECT_EQ(interpolation_time(0.25e-3)->exponent, -5);
  EXPECT_FALSE(interpolation_time(1.0 / 3000));
}

TEST(Profile, ShippedOnesAreValid) {
  EXPECT_THAT(shipped_profiles(), ElementsAre("epos4", "generic-402", "generic-406", "nanotec"));
  for (const std::string& name : shipped_profiles()) {
    RigParams rig = grasper();
    rig.heartbeat_period_s = 5e-3;  // checked by epos4 and nanotec
    if (name == "generic-406") rig.encoders[0].profile = name;
    else rig.drives[0].profile = name;
    EXPECT_THAT(load_profiles(rig, SimulatedRig::cycle_s, ".").errors, IsEmpty());
  }
}

TEST(Profile, ErrorsHaveTheirPlaceAndTheNearestName) {
  const auto errors = [](const std::string& toml) { return parse_profile(toml, "p.toml").errors; };
  EXPECT_THAT(errors("abuot = \"x\""), ElementsAre(AllOf(HasSubstr("p.toml:1:"), HasSubstr("'about'"))));
  EXPECT_THAT(errors("[drive]\nmodes = 10"), ElementsAre(AllOf(HasSubstr("p.toml:2:"), HasSubstr("'mode'"))));
  EXPECT_THAT(errors("[[pdo]]\npdo = \"tpdo1\"\nmap = [\"positon\"]"),
              ElementsAre(AllOf(HasSubstr("p.toml:3:"), HasSubstr("\"position\""))));
  EXPECT_THAT(errors("[[pdo]]\npdo = \"tpdo1\"\nmap = [\"position\", \"velocity\", \"mode\"]"),
              ElementsAre(HasSubstr("72 bits")));
  EXPECT_THAT(errors("[[pdo]]\npdo = \"rpdo1\"\nevent_timer_ms = 5\nmap = [\"controlword\"]"),
              ElementsAre(HasSubstr("deadline_ms")));
  EXPECT_THAT(errors("[[pdo]]\npdo = \"tpdo2\"\ntransmission = 255\nmap = [\"velocity\"]"),
              ElementsAre(HasSubstr("event_timer_ms")));
  EXPECT_THAT(errors("[[pdo]]\npdo = \"tpdo2\"\ntransmission = 250\nmap = [\"velocity\"]"),
              ElementsAre(HasSubstr("reserved")));
  EXPECT_THAT(
      errors("[[pdo]]\npdo = \"tpdo1\"\nmap = [\"mode\"]\n[[pdo]]\npdo = \"tpdo1\"\nmap = [\"mode\"]"),
      ElementsAre(AllOf(HasSubstr("p.toml:5:"), HasSubstr("earlier"))));
  EXPECT_THAT(errors("[[write]]\nindex = 0x2000\ntype = \"u8\"\nvalue = 256"),
              ElementsAre(HasSubstr("does not fit into u8")));
  EXPECT_THAT(errors("[drive\n"), ElementsAre(HasSubstr("not TOML")));
}

TEST(Profile, ContradictionsWithTheSceneAreFoundBeforeTheBus) {
  RigParams rig = grasper();
  rig.heartbeat_period_s = 0.2;
  rig.heartbeat_timeout_s = 0.05;
  const std::vector<std::string> errors = load_profiles(rig, 1.0 / 3000, ".").errors;
  EXPECT_THAT(errors, testing::Contains(HasSubstr("host: set at least twice")));
  EXPECT_THAT(errors, testing::Contains(HasSubstr("at most half of the scene's heartbeat_timeout")));
  EXPECT_THAT(errors, testing::Contains(HasSubstr("60C2h cannot represent")));
  rig = grasper();
  EXPECT_THAT(load_profiles(rig, 0.02, ".").errors,
              ElementsAre(HasSubstr("stop between two commands of the host")));
}

TEST(Profile, MapThatTheRigWouldMisreadIsAnError) {
  const RigParams rig = grasper();
  RigProfiles profiles = profiles_of(rig);
  const Changed swapped = changed("generic-402", "[\"statusword\", \"position\", \"torque\"]",
                                  "[\"position\", \"statusword\", \"torque\"]");
  profiles.drives[0] = swapped.profile;
  EXPECT_THAT(validate(rig, SimulatedRig::cycle_s, profiles),
              ElementsAre(AllOf(HasSubstr(swapped.place), HasSubstr("objects of 16, 32, 16 bits"))));
}

TEST(Profile, NameThatIsNotThere) {
  RigParams rig = grasper();
  rig.drives[2].profile = "epos";
  rig.encoders[0].profile = "my/encoder.toml";
  EXPECT_THAT(
      load_profiles(rig, SimulatedRig::cycle_s, "scenes").errors,
      ElementsAre(AllOf(HasSubstr("encoder of joint 'roll'"), HasSubstr("my/encoder.toml")),
                  AllOf(HasSubstr("drive of joint 'insertion'"), HasSubstr("the nearest is \"epos4\""))));
}

}  // namespace
}  // namespace godobject::test_commissioning
