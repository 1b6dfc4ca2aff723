#include "hal/rig/validate.h"

#include <gmock/gmock.h>

#include <functional>
#include <limits>

namespace godobject::test_rig_validate {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double cycle_s = 1e-3;

// Two hinges, the first with an encoder and a drive, the second with a drive only.
RigParams good_rig() {
  RigParams rig;
  rig.buses = {{.name = "can0"}, {.name = "can1"}};
  rig.tree.joints = {{.name = "yaw"}, {.name = "pitch"}};
  rig.tree.handles = {{.body = "tool", .joint = "pitch"}};
  rig.encoders = {{.joint = "yaw", .node_id = 1}};
  rig.drives = {{.joint = "yaw", .bus = 0, .node_id = 2}, {.joint = "pitch", .bus = 1, .node_id = 2}};
  return rig;
}

TEST(RigValidate, AcceptsAGoodRig) { EXPECT_THAT(validate(good_rig(), cycle_s), IsEmpty()); }

TEST(RigValidate, AcceptsBranchesFromAnyEarlierJointAndTheBase) {
  RigParams rig = good_rig();
  rig.tree.joints[1].parent = "base";
  rig.tree.joints.push_back({.name = "jaw", .parent = "yaw"});
  rig.tree.handles.push_back({.body = "jaw", .joint = "jaw"});
  rig.encoders.push_back({.joint = "jaw", .node_id = 3});
  EXPECT_THAT(validate(rig, cycle_s), IsEmpty());
}

TEST(RigValidate, AcceptsIncrementalSensorsWithAHomeButton) {
  RigParams rig = good_rig();
  rig.encoders[0].calibration.incremental = rig.drives[1].calibration.incremental = true;
  rig.buttons = {{.use = ButtonUse::home, .node_id = 5}};
  EXPECT_THAT(validate(rig, cycle_s), IsEmpty());
}

TEST(RigValidate, AnIncrementalDriveBesideAnEncoderNeedsNoHoming) {
  RigParams rig = good_rig();
  rig.drives[0].calibration.incremental = true;
  EXPECT_THAT(validate(rig, cycle_s), IsEmpty());
}

TEST(RigValidate, AcceptsOtherDrivesOnABusOfTheirOwnAndButtonsOfOneNode) {
  RigParams rig = good_rig();
  rig.drives[1].protocol = DriveProtocol::moteus;
  rig.buses[1].data_bit_rate = 5e6;
  rig.buttons = {{.node_id = 5, .bit = 0}, {.node_id = 5, .bit = 1}};
  EXPECT_THAT(validate(rig, cycle_s), IsEmpty());
}

struct BrokenRule {
  const char* says;
  std::function<void(RigParams&)> break_it;
};

class RigValidateEach : public testing::TestWithParam<BrokenRule> {};

TEST_P(RigValidateEach, NamesWhatIsWrong) {
  RigParams rig = good_rig();
  GetParam().break_it(rig);
  EXPECT_THAT(validate(rig, cycle_s), Contains(HasSubstr(GetParam().says)));
}

const BrokenRule broken_rules[] = {
    {"encoder of joint 'roll': the device has no such joint",
     [](RigParams& r) { r.encoders[0].joint = "roll"; }},
    {"drive of joint 'yaw': node_id 1 is taken by another device",
     [](RigParams& r) { r.drives[0].node_id = 1; }},
    {"node_id is 0, must be 1..127", [](RigParams& r) { r.encoders[0].node_id = 0; }},
    {"node_id is 200, must be 1..127", [](RigParams& r) { r.drives[1].node_id = 200; }},
    {"is the host's own", [](RigParams& r) { r.drives[0].node_id = 127; }},
    {"bus index is 2, the rig has 2 buses", [](RigParams& r) { r.drives[0].bus = 2; }},
    {"joint 'pitch': has no sensor", [](RigParams& r) { r.drives.pop_back(); }},
    {"joint 'yaw': has 2 encoders",
     [](RigParams& r) { r.encoders.push_back({.joint = "yaw", .node_id = 9}); }},
    {"joint 'yaw': has 2 drives", [](RigParams& r) { r.drives[1].joint = "yaw"; }},
    {"joint 'pitch': name must be given and unique",
     [](RigParams& r) { r.tree.joints.push_back({.name = "pitch"}); }},
    {"joint 'yaw': its sensor is incremental, so the user must confirm the home pose: add a "
     "[[device.button]]",
     [](RigParams& r) { r.encoders[0].calibration.incremental = true; }},
    {"a button has use = \"home\", but no joint is measured by an incremental sensor",
     [](RigParams& r) { r.buttons = {{.use = ButtonUse::home, .node_id = 5}}; }},
    {"encoder of joint 'yaw': offset_counts has no meaning with incremental = true",
     [](RigParams& r) {
       r.encoders[0].calibration.incremental = true;
       r.encoders[0].calibration.offset_counts = 5;
     }},
    {"joint 'yaw': home of its sensor is 2, must be within lower and upper",
     [](RigParams& r) {
       r.encoders[0].calibration.incremental = true;
       r.encoders[0].calibration.home = 2;
       r.tree.joints[0].lower = -1;
       r.tree.joints[0].upper = 1;
     }},
    {"axis must have unit length", [](RigParams& r) { r.tree.joints[0].axis_J = Vec3(1, 1, 0); }},
    {"handle of body 'tool': pose must be finite",
     [](RigParams& r) { r.tree.handles[0].X_LH.p.x() = std::numeric_limits<double>::quiet_NaN(); }},
    {"base pose must be finite, with a unit quaternion", [](RigParams& r) { r.tree.X_WB.q.w() = 2; }},
    {"the device has 0 joints, must be 1..16", [](RigParams& r) { r.tree.joints.clear(); }},
    {"the device has 17 joints, must be 1..16", [](RigParams& r) { r.tree.joints.resize(17); }},
    {"joint 'pitch': parent is 'roll', must be an earlier joint or 'base'",
     [](RigParams& r) { r.tree.joints[1].parent = "roll"; }},
    {"joint 'yaw': parent is 'pitch', must be an earlier joint or 'base'",
     [](RigParams& r) { r.tree.joints[0].parent = "pitch"; }},
    {"joint 'pitch': parent is 'pitch', must be", [](RigParams& r) { r.tree.joints[1].parent = "pitch"; }},
    {"joint 'base': is the reserved name of the base", [](RigParams& r) { r.tree.joints[0].name = "base"; }},
    {"the device has 0 handles, must be 1..8", [](RigParams& r) { r.tree.handles.clear(); }},
    {"the device has 9 handles, must be 1..8", [](RigParams& r) { r.tree.handles.resize(9); }},
    {"handle of body 'tool': body must be given and unique",
     [](RigParams& r) { r.tree.handles.push_back({.body = "tool", .joint = "yaw"}); }},
    {"handle of body '': body must be given", [](RigParams& r) { r.tree.handles[0].body = ""; }},
    {"handle of body 'tool': the device has no joint 'base'",
     [](RigParams& r) { r.tree.handles[0].joint = "base"; }},
    {"encoder of joint 'yaw': home is inf, must be finite",
     [](RigParams& r) { r.encoders[0].calibration.home = std::numeric_limits<double>::infinity(); }},
    {"the rig has 0 buses", [](RigParams& r) { r.buses.clear(); }},
    {"bus 'can1': bit_rate is 0, must be > 0", [](RigParams& r) { r.buses[1].bit_rate = 0; }},
    {"counts_per_unit is -5, must be > 0",
     [](RigParams& r) { r.encoders[0].calibration.counts_per_unit = -5; }},
    {"encoder of joint 'yaw': sign is 0, must be 1 or -1",
     [](RigParams& r) { r.encoders[0].calibration.sign = 0; }},
    {"modulus_counts is 8589934592",
     [](RigParams& r) { r.encoders[0].calibration.modulus_counts = 1ull << 33; }},
    {"half of modulus_counts within stale_after:",
     [](RigParams& r) {
       r.encoders[0].calibration.counts_per_unit = 1000;
       r.encoders[0].calibration.modulus_counts = 299;
     }},
    {"max_speed is nan, must be > 0",
     [](RigParams& r) { r.encoders[0].max_speed = std::numeric_limits<double>::quiet_NaN(); }},
    {"torque_rated_Nm is 0", [](RigParams& r) { r.drives[0].torque_rated_Nm = 0; }},
    {"bus 'can1': data_bit_rate is 500000, must be bit_rate..8e6",
     [](RigParams& r) { r.buses[1].data_bit_rate = 5e5; }},
    {"bus 'can1' has no data_bit_rate: protocol moteus needs CAN FD",
     [](RigParams& r) { r.drives[1].protocol = DriveProtocol::moteus; }},
    {"drive of joint 'pitch': node_id is 63, must be 1..62 with protocol odrive",
     [](RigParams& r) {
       r.drives[1].protocol = DriveProtocol::odrive;
       r.drives[1].node_id = 63;
     }},
    {"encoder of joint 'yaw': its bus has drives that are no CANopen nodes",
     [](RigParams& r) { r.drives[0].protocol = DriveProtocol::odrive; }},
    {"drive of joint 'pitch': bus 'can0' has drives of another protocol",
     [](RigParams& r) {
       r.drives[1].bus = 0;
       r.drives[1].node_id = 9;
       r.drives[1].protocol = DriveProtocol::odrive;
     }},
    {"status_every_nth_sync is 2, must be 1: it answers every request",
     [](RigParams& r) {
       r.drives[1].protocol = DriveProtocol::odrive;
       r.drives[1].status_every_nth_sync = 2;
     }},
    {"button of node 1: node_id 1 is taken by another device",
     [](RigParams& r) { r.buttons = {{.node_id = 1}}; }},
    {"button of node 5: bit is 8, must be 0..7",
     [](RigParams& r) { r.buttons = {{.node_id = 5, .bit = 8}}; }},
    {"button of node 5: bit 3 is used by another button",
     [](RigParams& r) {
       r.buttons = {{.node_id = 5, .bit = 3}, {.node_id = 5, .bit = 3}};
     }},
    {"torque_max_Nm is 4, must be at most 3.2767 with", [](RigParams& r) { r.drives[0].torque_max_Nm = 4; }},
    {"torque_rate_Nm_per_s is -1", [](RigParams& r) { r.drives[0].torque_rate_Nm_per_s = -1; }},
    {"joint_per_motor_rad is 0", [](RigParams& r) { r.drives[0].joint_per_motor_rad = 0; }},
    {"status_every_nth_sync is 241", [](RigParams& r) { r.drives[0].status_every_nth_sync = 241; }},
    {"max_slip is -1, must be >= 0", [](RigParams& r) { r.drives[0].max_slip = -1; }},
    {"max_slip needs an encoder on its joint",
     [](RigParams& r) {
       r.encoders.erase(r.encoders.begin());
       r.drives[0].max_slip = 0.01;
     }},
    {"stale_after is 0.0005, must be at least step (", [](RigParams& r) { r.stale_after_s = 5e-4; }},
    {"boot_timeout is 0", [](RigParams& r) { r.boot_timeout_s = 0; }},
    {"heartbeat_timeout is 0", [](RigParams& r) { r.heartbeat_timeout_s = 0; }},
    {"heartbeat_period is 0", [](RigParams& r) { r.heartbeat_period_s = 0; }},
    {"drive of joint 'yaw': counts_sign is 0", [](RigParams& r) { r.drives[0].calibration.sign = 0; }},
};

TEST(RigValidate, ChecksTheCycle) {
  EXPECT_THAT(validate(good_rig(), 0), Contains(HasSubstr("step is 0, must be > 0")));
  EXPECT_THAT(validate(good_rig(), 4e-3),
              Contains(HasSubstr("stale_after is 0.003, must be at least step (0.004)")));
}

INSTANTIATE_TEST_SUITE_P(Rules, RigValidateEach, testing::ValuesIn(broken_rules));

}  // namespace
}  // namespace godobject::test_rig_validate
