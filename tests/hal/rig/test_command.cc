// A rig between its nodes and its caller: the sample of all joints, the commands of all drives, and states.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/rig_on_buses.h"

namespace godobject::test_command {
namespace {

using cia402::DriveState;
using test::RigOnBuses;
using test::row_of_hinges;
using test::row_on_two_buses;
using test::texts_of;

constexpr Nanoseconds ms = RigOnBuses::ms;

/// Two hinges with drives of different limits.
RigParams two_drives() {
  RigParams params = row_of_hinges(0, 2);
  params.drives[1].torque_max_Nm = 0.05;
  params.drives[1].torque_rate_Nm_per_s = 20;
  return params;
}

TEST(CommandReport, HasTheBitOfEachDrive) {
  RigOnBuses world(two_drives());
  ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
  world.F[0].f = Vec3(0, 0.4, 0);  // 0.04 N m about both hinges
  world.cycle();
  EXPECT_EQ(world.report.rate_limited, 0b10u);
  EXPECT_EQ(world.report.torque_limited, 0u);
  world.F[0].f = Vec3(0, 0.8, 0);
  world.cycles(3);
  EXPECT_EQ(world.report.torque_limited, 0b10u);
  EXPECT_EQ(world.report.rate_limited, 0u);
  EXPECT_NEAR(world.rig.commanded_torque_Nm(0), 0.08, 1e-12);
  EXPECT_NEAR(world.rig.commanded_torque_Nm(1), 0.05, 1e-12);
  EXPECT_EQ(world.report.drive_limited, 0u);
  world.drive(1).status_bits = cia402::status_internal_limit;
  world.cycle();
  EXPECT_EQ(world.report.drive_limited, 0b10u);
  EXPECT_EQ(world.report.not_sent, 0u);
  world.bus[0].refused_id = canopen::command_id(12);
  world.F[0].f = Vec3::Zero();
  world.cycle();
  EXPECT_EQ(world.report.not_sent, 0b10u);
  EXPECT_EQ(world.rig.commanded_torque_Nm(0), 0);
  EXPECT_NEAR(world.rig.commanded_torque_Nm(1), 0.05, 1e-12) << "the drive keeps its last target";
}

TEST(RefusedFrames, InARowAreAFaultOfTheirBus) {
  RigParams params = row_on_two_buses(0);
  params.heartbeat_period_s = 10;
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot());
  const auto refuse = [&](std::size_t bus, int count) {
    world.bus[bus].full = true;
    for (int i = 0; i < count; ++i) world.rig.sync(world.now += ms);
    world.bus[bus].full = false;
  };
  refuse(0, 2);
  world.rig.sync(world.now += ms);
  refuse(0, 2);
  refuse(1, 2);
  EXPECT_EQ(world.rig.faults(), RigFault::none);
  refuse(0, 1);
  EXPECT_EQ(world.rig.faults(), RigFault::none) << "a frame of the first bus was sent since";
  refuse(1, 3);
  ASSERT_EQ(world.rig.fault_log().records().size(), 1u);
  EXPECT_EQ(world.rig.fault_log().records()[0].place,
            (RigFaultPlace{.fault = RigFault::send_refused, .bus = 1}));
  EXPECT_FALSE(world.rig.fault_log().records()[0].evidence.heard) << "of no node";
  world.rig.clear_faults(world.now);
  refuse(1, 2);
  EXPECT_EQ(world.rig.faults(), RigFault::none) << "counted from the clearing on";
}

TEST(RefusedFrames, OfABusThatIsCutOffAreNoFurtherFault) {
  RigOnBuses world(row_of_hinges(1, 1));
  ASSERT_TRUE(world.boot_and_arm());
  world.bus[0].full = true;
  world.bus[0].bus_state = BusState::bus_off;
  world.cycles(5);
  EXPECT_EQ(world.rig.faults(), RigFault::bus_down);
  EXPECT_EQ(world.rig.fault_log().records()[0].place, (RigFaultPlace{.fault = RigFault::bus_down, .bus = 0}));
}

TEST(Fault, HasTheTimeOfTheCallThatRaisedIt) {
  const auto first_time = [](const RigOnBuses& world) {
    EXPECT_EQ(world.rig.fault_log().records().size(), 1u) << world.rig.fault_text();
    return world.rig.fault_log().records()[0].t_ns;
  };
  RigOnBuses started(row_of_hinges(1, 1));
  started.rig.start(7);
  started.rig.deadlines_missed();
  EXPECT_EQ(first_time(started), 7);
  RigOnBuses synced(row_of_hinges(1, 0));
  ASSERT_TRUE(synced.boot());
  synced.bus[0].full = true;
  for (int i = 0; i < 3; ++i) synced.rig.sync(synced.now += ms);
  EXPECT_EQ(first_time(synced), synced.now);
  RigOnBuses received(row_of_hinges(1, 1));
  ASSERT_TRUE(received.boot());
  received.receive(0, canopen::make_emergency({.node = 1, .error_code = 0x5112}));
  received.rig.receive(received.now + 3);
  EXPECT_EQ(first_time(received), received.now + 3);
  RigOnBuses commanded(row_of_hinges(1, 1));
  ASSERT_TRUE(commanded.boot());
  commanded.F[0].f.x() = std::numeric_limits<double>::quiet_NaN();
  static_cast<void>(commanded.rig.command(commanded.F, commanded.now + 5));
  EXPECT_EQ(first_time(commanded), commanded.now + 5);
}

TEST(Fault, IsNoneWhileOff) {
  RigOnBuses world(row_of_hinges(1, 1));
  world.rig.quick_stop();
  world.rig.deadlines_missed();
  EXPECT_EQ(world.rig.faults(), RigFault::none);
  EXPECT_EQ(world.rig.state(), RigState::off);
}

TEST(Command, BeforeTheFirstSampleIsChecked) {
  RigOnBuses world(row_of_hinges(1, 1));
  world.rig.start(0);
  static_cast<void>(world.rig.command(world.F, 0));
  EXPECT_EQ(world.rig.faults(), RigFault::none);
  EXPECT_EQ(world.sent(0, canopen::command_id(11)), 1);
  world.F[0].f.y() = std::numeric_limits<double>::quiet_NaN();
  static_cast<void>(world.rig.command(world.F, 0));
  EXPECT_EQ(world.rig.faults(), RigFault::command_not_finite);
}

TEST(Stop, DisablesEveryDriveOnItsBusAndEveryCanopenNode) {
  RigParams params = row_of_hinges(1, 2, DriveProtocol::odrive, 2);
  params.tree.joints.push_back({.name = "canopen"});
  params.drives.push_back({.joint = "canopen", .node_id = 11, .calibration = {.counts_per_unit = 1000}});
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
  for (test::ScriptedBus& bus : world.bus) bus.sent.clear();
  world.rig.stop();
  EXPECT_EQ(world.rig.state(), RigState::off);
  const auto pre_operational = [](std::uint8_t node) {
    return canopen::make_nmt(canopen::NmtCommand::enter_pre_operational, node);
  };
  EXPECT_EQ(texts_of(world.bus[0].sent),
            texts_of({cia402::make_command(11, {.controlword = cia402::disable_voltage}), pre_operational(1),
                      pre_operational(11)}));
  EXPECT_EQ(texts_of(world.bus[1].sent), texts_of({odrive::make_set_axis_state(11, odrive::axis_idle),
                                                   odrive::make_set_axis_state(12, odrive::axis_idle)}));
  for (test::ScriptedBus& bus : world.bus) bus.sent.clear();
  world.rig.stop();
  world.cycles(2);
  EXPECT_TRUE(world.bus[0].sent.empty() && world.bus[1].sent.empty()) << "nothing is sent while off";
}

TEST(Stop, IsRecordedIfItWasSent) {
  for (const bool refused : {false, true}) {
    RigOnBuses world(row_of_hinges(0, 1));
    ASSERT_TRUE(world.boot_and_arm());
    world.F[0].f = Vec3(0, 0.4, 0);
    world.cycle();
    world.bus[0].full = refused;
    world.rig.stop();
    EXPECT_EQ(world.rig.commanded_torque_Nm(0) != 0, refused);
  }
}

/// Returns the time until the boot's time-out, from 0, with another call on the way.
template <class Call>
int boot_timeout_cycles(Call&& call) {
  RigParams params = row_of_hinges(1, 0);
  params.boot_timeout_s = 0.1;
  RigOnBuses world(params);
  world.encoder().sends_heartbeats = false;
  world.rig.start(0);
  world.cycles(50);
  call(world);
  return 50 + world.cycles_to(RigState::fault, 200);
}

TEST(BootTime, CountsFromTheStartOrTheClearing) {
  const int from_start = boot_timeout_cycles([](RigOnBuses&) {});
  EXPECT_EQ(from_start, 101);
  EXPECT_EQ(boot_timeout_cycles([](RigOnBuses& world) { world.rig.start(world.now); }), from_start);
  EXPECT_EQ(boot_timeout_cycles([](RigOnBuses& world) { world.rig.clear_faults(world.now); }), from_start);
  EXPECT_EQ(boot_timeout_cycles([](RigOnBuses& world) {
              world.rig.quick_stop();
              world.rig.clear_faults(world.now);
            }),
            50 + from_start);
  EXPECT_EQ(boot_timeout_cycles([](RigOnBuses& world) {
              world.rig.stop();
              world.rig.start(world.now);
            }),
            50 + from_start);
}

/// True if the delay of a node is not known after a boot with answers that late.
bool delay_is_unknown(bool is_drive, std::uint8_t every_nth, std::size_t delay) {
  RigParams params = row_of_hinges(1, 1);
  params.boot_timeout_s = 0.5;
  params.drives[0].status_every_nth_sync = every_nth;
  RigOnBuses world(params);
  test::ScriptedNode& node = is_drive ? world.drive() : world.encoder();
  node.delay = delay;
  world.rig.start(0);
  world.cycles_to(RigState::fault);
  if (world.rig.state() == RigState::ready) return false;
  const RigFaultRecord& record = world.rig.fault_log().records()[0];
  EXPECT_EQ(record.place.node_id, node.id);
  EXPECT_TRUE(record.evidence.heard && record.evidence.answered && !record.evidence.silent);
  EXPECT_EQ(record.place.fault == RigFault::boot_timeout, record.evidence.delay_unknown);
  return record.evidence.delay_unknown;
}

/// Later ones are not valid in any case.
TEST(Delay, IsMeasuredUpToStaleAfter) {
  for (const bool is_drive : {false, true}) {
    EXPECT_FALSE(delay_is_unknown(is_drive, 1, 3)) << is_drive;
    EXPECT_TRUE(delay_is_unknown(is_drive, 1, 4)) << is_drive;
  }
  EXPECT_FALSE(delay_is_unknown(true, 3, 6)) << "and the SYNCs that it may skip";
  EXPECT_TRUE(delay_is_unknown(true, 3, 7));
}

TEST(Enabling, OneDriveThatFailsKeepsTheOthersOff) {
  RigOnBuses world(two_drives());
  world.drive(1).follows = false;
  world.rig.start(0);
  world.cycles_to(RigState::enabling);
  world.cycles(5);
  ASSERT_EQ(world.drive(0).state, DriveState::operation_enabled);
  ASSERT_EQ(world.drive(1).last_command.controlword, cia402::shutdown);
  world.drive(0).follows = false;
  world.drive(0).state = DriveState::fault;
  world.cycles(2);
  ASSERT_EQ(world.rig.state(), RigState::enabling) << "its code is awaited";
  EXPECT_EQ(world.drive(1).last_command.controlword, cia402::disable_voltage);
}

TEST(Fault, OfTheSimulationNeedsTorque) {
  RigOnBuses world(two_drives());
  ASSERT_TRUE(world.boot());
  world.rig.force_oscillates(1);
  world.rig.force_oscillates(std::nullopt);
  world.rig.energy_gained();
  EXPECT_EQ(world.rig.faults(), RigFault::none);
  ASSERT_TRUE(world.rig.arm());
  world.rig.force_oscillates(1);
  ASSERT_EQ(world.rig.fault_log().records().size(), 1u);
  EXPECT_EQ(world.rig.fault_log().records()[0].place,
            (RigFaultPlace{.fault = RigFault::force_oscillates, .bus = 0, .node_id = 12}));
  RigOnBuses without(two_drives());
  ASSERT_TRUE(without.boot_and_arm());
  without.rig.force_oscillates(std::nullopt);
  ASSERT_EQ(without.rig.fault_log().records().size(), 1u);
  EXPECT_EQ(without.rig.fault_log().records()[0].place, (RigFaultPlace{.fault = RigFault::force_oscillates}));
}

TEST(Buttons, OfTheEmergencyStopGripNothing) {
  RigParams params = row_of_hinges(1, 0);
  params.buttons = {{.use = ButtonUse::stop, .node_id = 3}};
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot());
  EXPECT_TRUE(world.rig.has_button(ButtonUse::stop));
  EXPECT_FALSE(world.rig.has_button(ButtonUse::hold) || world.rig.has_button(ButtonUse::clutch));
  world.receive(0, cia401::make_inputs(3, 1));
  world.cycle();
  EXPECT_EQ(world.rig.faults(), RigFault::quick_stop);
  EXPECT_EQ(world.sample.faults, RigFault::quick_stop);
  EXPECT_FALSE(world.sample.buttons.hold || world.sample.buttons.clutch);
}

TEST(Sample, NeedsEveryDriveBesideTheEncoders) {
  RigParams params = row_of_hinges(1, 1);
  params.drives[0].joint = params.encoders[0].joint;
  params.tree.joints.pop_back();
  params.tree.handles[0].joint = params.encoders[0].joint;
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot());
  EXPECT_TRUE(world.sample.valid && world.sample.fresh);
  world.drive().answers = false;
  world.cycles(2);
  EXPECT_TRUE(world.sample.valid) << "not older than stale_after";
  world.cycles(2);
  EXPECT_FALSE(world.sample.valid);
  EXPECT_TRUE(world.sample.fresh) << "the encoder measures the joint";
}

TEST(Sample, OfASlowDriveIsFreshWhileNoneIsDue) {
  RigParams params = row_of_hinges(0, 1);
  params.drives[0].status_every_nth_sync = 3;
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot()) << world.rig.fault_text();
  world.cycles(100);
  while (world.drive().num_syncs % 3 != 0) world.cycle();
  world.drive().answers = false;
  for (int missing = 0; missing < 5; ++missing) {
    EXPECT_EQ(world.sample.fresh, missing < 3) << missing;
    world.cycle();
  }
}

TEST(Sample, OfAnEncoderIsDueInEveryCycleBesideASlowDrive) {
  RigParams params = row_of_hinges(1, 1);
  params.drives[0].joint = params.encoders[0].joint;
  params.drives[0].status_every_nth_sync = 3;
  params.tree.joints.pop_back();
  params.tree.handles[0].joint = params.encoders[0].joint;
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot()) << world.rig.fault_text();
  world.cycles(100);
  EXPECT_TRUE(world.sample.fresh);
  world.encoder().answers = false;
  world.cycle();
  EXPECT_FALSE(world.sample.fresh);
}

/// Moves nodes for 200 cycles. steps: counts in each cycle.
void move(RigOnBuses& world, const std::vector<int>& steps) {
  for (int k = 0; k < 200; ++k) {
    for (std::size_t i = 0; i < steps.size(); ++i) world.nodes[i].counts += steps[i];
    world.cycle();
  }
}

TEST(Sample, IsThatOfTheJointsBehindATransmission) {
  RigParams params = row_of_hinges(2, 0);
  params.transmissions = {{.joints = {"hinge0", "hinge1"}, .joint_per_actuator = {{1, 0}, {-1, 1}}}};
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot());
  move(world, {1, 3});
  EXPECT_NEAR(world.sample.q(0), 0.2, 1e-12);
  EXPECT_NEAR(world.sample.q(1), 0.4, 1e-12);
  EXPECT_NEAR(world.sample.q_dot(0), 1, 0.01);
  EXPECT_NEAR(world.sample.q_dot(1), 2, 0.01);
}

TEST(Command, IsThatOfTheActuatorsBehindATransmission) {
  RigParams params = row_of_hinges(0, 2);
  params.transmissions = {{.joints = {"hinge0", "hinge1"}, .joint_per_actuator = {{1, 0}, {-0.5, 1}}}};
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot_and_arm());
  world.F[0].f = Vec3(0, 0.4, 0);
  world.cycle();
  EXPECT_NEAR(world.rig.commanded_torque_Nm(0), 0.02, 1e-12);
  EXPECT_NEAR(world.rig.commanded_torque_Nm(1), 0.04, 1e-12);
}

TEST(Handles, ArePredictedAndTheForceActsWhereTheyAre) {
  constexpr double ahead_s = 0.05, q = 0.2, force_N = 0.4;
  for (const bool predicts : {false, true}) {
    RigParams params = row_of_hinges(1, 1);
    params.tree.handles.push_back(
        {.body = "other", .joint = "hinge0", .X_LH = {Vec3(0, 1, 0), Quat::Identity()}});
    params.compensation.ahead_s = predicts ? ahead_s : 0;
    RigOnBuses world(params);
    ASSERT_TRUE(world.boot_and_arm());
    ASSERT_EQ(world.rig.num_handles(), 2u);
    world.F = {Wrench{.f = Vec3(0, force_N, 0)}};
    move(world, {0, 1});
    const double shown = q + (predicts ? ahead_s : 0);
    const double tolerance = 2e-3;
    EXPECT_NEAR(world.sample.q(1), q, 1e-12);
    EXPECT_NEAR(world.sample.handles[0].X_WD.p.x(), 0.1 * std::cos(shown), tolerance);
    EXPECT_NEAR(world.sample.handles[0].X_WD.p.y(), 0.1 * std::sin(shown), tolerance);
    EXPECT_NEAR(world.sample.handles[0].V_WD.v.y(), 0.1 * std::cos(shown), tolerance);
    EXPECT_NEAR(world.sample.handles[1].X_WD.p.y(), 1, 1e-12);
    EXPECT_NEAR(world.rig.commanded_torque_Nm(0), 0.1 * std::cos(q) * force_N, 1e-9);
  }
}

TEST(Compensation, ActsAlongTheMotionWhileArmed) {
  RigParams params = row_of_hinges(0, 1);
  params.compensation.friction = {0.01};
  params.compensation.certain_speed = {0.5};
  params.tree.joints[0].mass = 0.02;
  params.tree.joints[0].p_LM = Vec3(0.1, 0, 0);
  params.compensation.gravity_W = Vec3(0, -10, 0);
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot());
  move(world, {1});
  EXPECT_EQ(world.rig.commanded_torque_Nm(0), 0) << "not armed";
  ASSERT_TRUE(world.rig.arm());
  world.nodes[0].counts += 1;
  world.cycle();
  EXPECT_NEAR(world.rig.commanded_torque_Nm(0), 0.01 + 0.02 * 10 * 0.1 * std::cos(0.201), 1e-6);
  move(world, {-1});
  EXPECT_NEAR(world.rig.commanded_torque_Nm(0), -0.01 + 0.02 * 10 * 0.1 * std::cos(0.001), 1e-6);
}

// A second controller and filter beside the rig receive its samples and torques, and its resets.
TEST(PassivityControl, SeesTheSamplesAndTheTorquesOfItsJoint) {
  constexpr double stiffness = 3, inertia = 1e-3, cutoff = 30, jpm = 0.5;
  RigParams params = row_of_hinges(0, 1);
  params.drives[0].sign = -1;
  params.drives[0].joint_per_motor_rad = jpm;
  params.tree.joints[0].mass = 0.02;
  params.tree.joints[0].p_LM = Vec3(0.1, 0, 0);
  params.compensation.gravity_W = Vec3(0, -1, 0);
  params.compensation.inertia = {inertia};
  params.compensation.inertia_cutoff = cutoff;
  RigOnBuses world(params);
  const PassivityParams axis{.inertia = 2e-3,
                             .damping = 1e-4,
                             .needed = 5e-3,
                             .stiffness = stiffness,
                             .resolution = 1e-3,
                             .energy_J = 1e-5,
                             .carried = inertia};
  world.rig.control_passivity(std::span(&axis, 1));
  PassivityController controller(axis);
  InertiaCompensation moved(inertia, cutoff, RigOnBuses::cycle_s);
  ASSERT_TRUE(world.boot());
  double most_energy = 0;
  int num_missing = 0;
  for (int k = 0; k < 400; ++k) {
    if (k == 20 || k == 280) {
      ASSERT_TRUE(world.rig.arm());
    }
    if (k == 220) world.rig.disarm();
    world.drive().counts = static_cast<std::int32_t>(std::lround(20 * std::sin(0.2 * k) + 0.2 * k));
    world.drive().answers = !(k > 100 && k < 103) && !(k > 140 && k < 150);
    const double q_before = world.sample.q(0);
    world.F[0].f = Vec3(0, q_before > 0 ? -stiffness * q_before / 0.1 : 0, 0);
    world.cycle();
    const bool is_new = world.drive().answers && world.sent(0, canopen::sync_cob_id) == 1;
    num_missing += is_new ? 0 : 1;
    const double q = world.sample.q(0), beside = 0.02 * 0.1 * std::cos(q);
    if (world.rig.state() != RigState::armed) {
      controller.reset();
      moved.reset();
      EXPECT_EQ(world.rig.generated_energy_J(0), 0);
      EXPECT_EQ(world.rig.commanded_torque_Nm(0), 0);
      controller.sent(0);
      continue;
    }
    const double wanted = 0.1 * std::cos(q) * world.F[0].f.y();
    const double moving = moved.update(q, is_new && world.sample.valid, world.sample.valid);
    const double joint_Nm = controller.limit(wanted, q, is_new && world.sample.valid, moving) + beside;
    const double motor_Nm = std::clamp(-jpm * joint_Nm, -0.1, 0.1);
    ASSERT_NEAR(world.rig.commanded_torque_Nm(0), motor_Nm, 1e-12) << k;
    controller.sent(motor_Nm / -jpm - beside);
    ASSERT_NEAR(world.rig.generated_energy_J(0), controller.energy_J(), 1e-15) << k;
    most_energy = std::max(most_energy, controller.energy_J());
  }
  EXPECT_GT(most_energy, 1e-6);
  EXPECT_GT(num_missing, 10);
  EXPECT_EQ(world.rig.faults(), RigFault::none) << world.rig.fault_text();
}

}  // namespace
}  // namespace godobject::test_command
