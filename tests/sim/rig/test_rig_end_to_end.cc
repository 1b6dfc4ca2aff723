// The rig against simulated encoders and drives on simulated wires.
#include <gtest/gtest.h>

#include <cmath>

#include "hal/joint/inverse_kinematics.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/simulated_rig.h"

namespace godobject::test_rig_end_to_end {
namespace {

using test::SimulatedRig;

constexpr double quantum_rad = 1 / test::arm_counts_per_rad;

// A pose motion through the arm's inverse kinematics, as input of the encoders.
struct PoseMotion {
  static Pose pose(double t) {
    Pose X;
    X.p = 0.08 * Vec3(std::sin(2 * t), std::sin(3 * t + 1), std::sin(2.5 * t + 2));
    X.q = Quat(Eigen::AngleAxisd(0.6 * std::sin(2 * t), Vec3(1, 0.5, -0.7).normalized()));
    return X;
  }
  static Twist twist(double t) {
    Twist V;
    V.v = 0.08 * Vec3(2 * std::cos(2 * t), 3 * std::cos(3 * t + 1), 2.5 * std::cos(2.5 * t + 2));
    V.w = 1.2 * std::cos(2 * t) * Vec3(1, 0.5, -0.7).normalized();
    return V;
  }
};

void follow_motion(SimulatedRig& sim) {
  auto ik = std::make_shared<InverseKinematics>(sim.params.tree);
  sim.q_ref = [ik](double t) { return ik->solve(PoseMotion::pose(t)).q; };
  sim.q_ref_dot = [ik](double t) {
    JointVector q_dot;
    EXPECT_TRUE(ik->joint_rates(PoseMotion::twist(t), q_dot));
    return q_dot;
  };
}

TEST(RigEndToEnd, BootsWithoutHelpAndAnswersEverySync) {
  SimulatedRig sim;
  EXPECT_FALSE(sim.rig->arm());
  ASSERT_TRUE(sim.boot()) << sim.rig->fault_text();
  for (const auto& drive : sim.drives) EXPECT_EQ(drive->drive_state(), cia402::DriveState::operation_enabled);
  for (int k = 0; k < 500; ++k) {
    sim.cycle();
    ASSERT_TRUE(sim.complete) << k;
    ASSERT_TRUE(sim.sample.valid);
    ASSERT_EQ(sim.sample.faults, RigFault::none) << sim.rig->fault_text();
    ASSERT_LT(sim.sample.age, SimulatedRig::deadline_ns);
  }
  EXPECT_EQ(sim.rig->counters().incomplete_syncs, 0u);
  EXPECT_EQ(sim.rig->counters().malformed, 0u);
}

TEST(RigEndToEnd, PoseIsTheTruePoseWithinHalfACountPerJoint) {
  SimulatedRig sim;
  follow_motion(sim);
  ASSERT_TRUE(sim.boot()) << sim.rig->fault_text();
  const KinematicTree arm(sim.params.tree);
  const double half_count = 0.5 * quantum_rad * 1.01;  // second order terms are far below 1 %
  for (int k = 0; k < 2000; ++k) {
    sim.cycle();
    ASSERT_TRUE(sim.sample.valid) << sim.rig->fault_text();
    // the nodes report the plant's state at the last of its 50 us steps before the SYNC ended
    const double t = 1e-9 * static_cast<double>(sim.cycle_start_ns - SimulatedRig::cycle_ns + 50'000);
    const Pose X = PoseMotion::pose(t);
    const HandleJacobian J = arm.at(sim.sample.q).jacobian(0).cwiseAbs();
    double position_bound = 0, angle_bound = 0;
    for (Eigen::Index i = 0; i < 6; ++i) {
      position_bound += half_count * J.col(i).tail<3>().norm();
      angle_bound += half_count * J.col(i).head<3>().norm();
    }
    ASSERT_LT((sim.sample.handles[0].X_WD.p - X.p).norm(), position_bound) << k;
    ASSERT_LT(2 * (sim.sample.handles[0].X_WD.q * X.q.conjugate()).vec().norm(), angle_bound) << k;
  }
}

TEST(RigEndToEnd, VelocityIsFarBetterThanDifferencesOfCounts) {
  SimulatedRig sim;
  follow_motion(sim);
  ASSERT_TRUE(sim.boot());
  sim.cycles(50);
  double sum_sq = 0, difference_sum_sq = 0;
  Vec3 last_p = sim.sample.handles[0].X_WD.p;
  constexpr int samples = 2000;
  for (int k = 0; k < samples; ++k) {
    sim.cycle();
    const double t = 1e-9 * static_cast<double>(sim.cycle_start_ns - SimulatedRig::cycle_ns + 50'000);
    const Vec3 v = PoseMotion::twist(t).v;
    ASSERT_LT((sim.sample.handles[0].V_WD.v - v).norm(), 0.10);  // speeds go up to 0.36 m/s
    sum_sq += (sim.sample.handles[0].V_WD.v - v).squaredNorm();
    difference_sum_sq += ((sim.sample.handles[0].X_WD.p - last_p) / 1e-3 - v).squaredNorm();
    last_p = sim.sample.handles[0].X_WD.p;
  }
  EXPECT_LT(std::sqrt(sum_sq / samples), 0.2 * std::sqrt(difference_sum_sq / samples));
}

TEST(RigEndToEnd, TorqueReachesTheMotorsWithTheRightSignAndValue) {
  SimulatedRig sim;
  ASSERT_TRUE(sim.boot());
  Wrench F;
  F.f = Vec3(0.3, -0.4, 0.5);
  sim.cycles(20, F);
  for (std::size_t i = 0; i < test::num_arm_drives; ++i) EXPECT_EQ(sim.drives[i]->applied_torque_Nm(), 0);
  ASSERT_TRUE(sim.rig->arm());
  sim.cycles(50, F);
  const JointVector tau = KinematicTree(sim.params.tree).at(sim.sample.q).joint_torques({&F, 1});
  for (std::size_t i = 0; i < test::num_arm_drives; ++i) {
    const DriveParams& drive = sim.params.drives[i];
    const double half_per_mille = 0.5e-3 * drive.torque_rated_Nm / drive.joint_per_motor_rad;
    EXPECT_NEAR(sim.applied_joint_torque(i), tau(static_cast<Eigen::Index>(i)), half_per_mille + 1e-12) << i;
    // the check above is not vacuous
    EXPECT_GT(std::abs(tau(static_cast<Eigen::Index>(i))), 10 * half_per_mille);
    const DriveFeedback feedback = sim.rig->drive_feedback(i, sim.now);
    EXPECT_NEAR(feedback.torque_Nm, sim.rig->commanded_torque_Nm(i), 0.5e-3 * drive.torque_rated_Nm + 1e-12);
    EXPECT_NEAR(feedback.position.q, 0, 1e-4);
  }
  EXPECT_EQ(sim.report.torque_limited | sim.report.rate_limited | sim.report.not_sent, 0u);
}

TEST(RigEndToEnd, AForceDeflectsTheHandAlongIt) {
  PlantConfig plant;
  plant.friction = 0;
  plant.hand_stiffness = 20;
  SimulatedRig sim(test::arm_rig_params(), true, plant);
  ASSERT_TRUE(sim.boot());
  ASSERT_TRUE(sim.rig->arm());
  Wrench F;
  F.f = Vec3(0.2, 0.2, 0.2);
  sim.cycles(1500, F);
  const JointVector tau = KinematicTree(sim.params.tree).at(sim.sample.q).joint_torques({&F, 1});
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(sim.plant.q()(i), tau(i) / plant.hand_stiffness, 2e-3 / plant.hand_stiffness) << i;
  }
  EXPECT_GT(sim.sample.handles[0].X_WD.p.dot(F.f), 0);
}

TEST(RigEndToEnd, CommandsSaturateAndSlew) {
  SimulatedRig sim;
  ASSERT_TRUE(sim.boot());
  ASSERT_TRUE(sim.rig->arm());
  Wrench F;
  F.f = Vec3(0, 50, 0);  // 17.5 N m on the yaw joint, 1.75 N m at its motor
  double last = 0;
  for (int k = 0; k < 30; ++k) {
    sim.cycle(F);
    const double torque = sim.rig->commanded_torque_Nm(0);
    EXPECT_LE(torque - last, 20e-3 * (1 + 1e-12));
    EXPECT_EQ((sim.report.rate_limited & 1u) != 0, k < 7) << k;  // 0.15 N m at 20 N m/s
    EXPECT_EQ(sim.report.torque_limited & 1u, 1u);
    last = torque;
  }
  EXPECT_DOUBLE_EQ(last, 0.15);
  EXPECT_DOUBLE_EQ(sim.drives[0]->applied_torque_Nm(), 0.15);
}

/// The pose is held after stale_after; after lost_after it is a fault.
TEST(RigEndToEnd, UnpluggedEncoderIsStaleWithinTheLimitAndTorqueRunsDown) {
  SimulatedRig sim;
  ASSERT_TRUE(sim.boot());
  ASSERT_TRUE(sim.rig->arm());
  Wrench F;
  F.f = Vec3(0, 1, 0);
  sim.cycles(50, F);
  ASSERT_GT(std::abs(sim.drives[0]->applied_torque_Nm()), 0.03);
  const Pose X_held = sim.sample.handles[0].X_WD;

  sim.encoder_ports[2]->set_connected(false);
  const Nanoseconds unplugged_ns = sim.now;
  while (sim.sample.valid && sim.now < unplugged_ns + 20'000'000) sim.cycle(F);
  EXPECT_LE(sim.now - unplugged_ns, 3'000'000 + SimulatedRig::cycle_ns);
  EXPECT_EQ(sim.rig->faults(), RigFault::none);
  while (!any(sim.rig->faults()) && sim.now < unplugged_ns + 200'000'000) sim.cycle(F);
  // At its max_speed of 50 rad/s the joint may move half a turn in 62.8 ms; then its angle is ambiguous.
  EXPECT_GE(sim.now - unplugged_ns, 62'000'000);
  EXPECT_LE(sim.now - unplugged_ns, 63'000'000 + SimulatedRig::cycle_ns);
  EXPECT_EQ(sim.rig->faults(), RigFault::sample_stale);
  EXPECT_EQ(sim.rig->state(), RigState::fault);
  EXPECT_FALSE(sim.sample.valid);
  EXPECT_EQ((sim.sample.handles[0].X_WD.p - X_held.p).norm(), 0);
  EXPECT_NE(sim.rig->fault_text().find("can0 node 3, encoder of elbow"), std::string::npos)
      << sim.rig->fault_text();

  double last = std::abs(sim.rig->commanded_torque_Nm(0));
  for (int k = 0; k < 10; ++k) {
    sim.cycle(F);
    const double torque = std::abs(sim.rig->commanded_torque_Nm(0));
    EXPECT_LE(torque, last);
    EXPECT_LE(last - torque, 20e-3 * (1 + 1e-12));
    last = torque;
  }
  EXPECT_EQ(last, 0);
  EXPECT_EQ(sim.drives[0]->applied_torque_Nm(), 0);

  // plugged in again: no motion until the fault is cleared and the rig armed
  sim.encoder_ports[2]->set_connected(true);
  sim.cycles(300, F);
  EXPECT_EQ(sim.drives[0]->applied_torque_Nm(), 0);
  EXPECT_FALSE(sim.rig->arm());
  sim.rig->clear_faults(sim.now);
  sim.cycles(300, F);
  ASSERT_EQ(sim.rig->state(), RigState::ready) << sim.rig->fault_text();
  EXPECT_EQ(sim.drives[0]->applied_torque_Nm(), 0);
  EXPECT_TRUE(sim.rig->arm());
  sim.cycles(50, F);
  EXPECT_GT(std::abs(sim.drives[0]->applied_torque_Nm()), 0.03);
}

TEST(RigEndToEnd, TrippedDriveStopsAllOfThem) {
  SimulatedRig sim;
  ASSERT_TRUE(sim.boot());
  ASSERT_TRUE(sim.rig->arm());
  Wrench F;
  F.f = Vec3(0, 1, 1);
  sim.cycles(50, F);
  sim.drives[1]->trip(0x2310);
  sim.cycles(20, F);
  EXPECT_TRUE(any(sim.rig->faults() & RigFault::emergency));
  EXPECT_EQ(sim.rig->fault_log().first(RigFault::emergency).place.emcy_code, 0x2310);
  EXPECT_EQ(sim.rig->fault_log().first(RigFault::emergency).place.node_id, 2);
  for (const auto& drive : sim.drives) EXPECT_EQ(drive->applied_torque_Nm(), 0);
  sim.rig->clear_faults(sim.now);
  sim.cycles(50);
  EXPECT_EQ(sim.rig->state(), RigState::ready) << sim.rig->fault_text();
}

TEST(RigEndToEnd, SilentNodeIsABootTimeout) {
  RigParams params = test::arm_rig_params();
  params.boot_timeout_s = 0.5;
  SimulatedRig sim(params);
  sim.encoder_ports[4]->set_connected(false);
  sim.rig->start(sim.now);
  sim.cycles(490);
  EXPECT_EQ(sim.rig->state(), RigState::booting);
  sim.cycles(20);
  EXPECT_EQ(sim.rig->faults(), RigFault::boot_timeout);
  EXPECT_EQ(sim.rig->fault_log().first(RigFault::boot_timeout).place.node_id, 5);
}

TEST(RigEndToEnd, ResetNodeIsSeenInsideItsHeartbeatTime) {
  SimulatedRig sim;
  ASSERT_TRUE(sim.boot());
  sim.cycles(10);
  sim.encoders[0]->on_frame(canopen::make_nmt(canopen::NmtCommand::reset_node, 1), sim.now);
  sim.cycles(2);
  EXPECT_TRUE(any(sim.rig->faults() & RigFault::node_restarted)) << sim.rig->fault_text();
  sim.rig->clear_faults(sim.now);
  sim.cycles(300);
  EXPECT_EQ(sim.rig->state(), RigState::ready) << sim.rig->fault_text();
}

TEST(RigEndToEnd, NotANumberIsAFaultAndNoTorque) {
  SimulatedRig sim;
  ASSERT_TRUE(sim.boot());
  ASSERT_TRUE(sim.rig->arm());
  Wrench F;
  F.f = Vec3(0, std::nan(""), 0);
  sim.cycles(5, F);
  EXPECT_EQ(sim.rig->faults(), RigFault::command_not_finite);
  for (const auto& drive : sim.drives) EXPECT_EQ(drive->applied_torque_Nm(), 0);
}

TEST(RigEndToEnd, StopSwitchesTheDrivesOff) {
  SimulatedRig sim;
  ASSERT_TRUE(sim.boot());
  sim.rig->stop();
  sim.cycles(5);
  EXPECT_EQ(sim.rig->state(), RigState::off);
  for (const auto& drive : sim.drives) EXPECT_NE(drive->drive_state(), cia402::DriveState::operation_enabled);
  for (const auto& encoder : sim.encoders)
    EXPECT_EQ(encoder->nmt_state(), canopen::NmtState::pre_operational);
}

TEST(RigEndToEnd, SamplesAreStampedWithTheEndOfASyncThatAForeignFrameDelayed) {
  SimulatedRig sim;
  ASSERT_TRUE(sim.boot());
  SimCanWire& wire = sim.wires[0];
  SimCanPort foreign(wire);
  ASSERT_TRUE(foreign.open());
  Nanoseconds sync_end_ns = 0;
  wire.set_observer({.on_frame =
                         [](void* context, const ReceivedFrame& received) {
                           if (received.frame.id == canopen::sync_cob_id)
                             *static_cast<Nanoseconds*>(context) = received.t_ns;
                         },
                     .context = &sync_end_ns});
  for (int k = 0; k < 20; ++k) {
    const Nanoseconds queued_ns = sim.now;
    ASSERT_EQ(foreign.try_send({.id = 0x7FE, .size = 8}), SendResult::queued);
    wire.advance_to(queued_ns);  // on the wire when SYNC is queued
    sim.cycle();
    ASSERT_TRUE(sim.complete) << k;
    ASSERT_GT(sync_end_ns, queued_ns + 150'000);
    for (std::size_t i = 0; i < sim.rig->num_encoders(); ++i)
      ASSERT_EQ(sim.rig->encoder(i).sample(sim.now).t_ns, sync_end_ns) << k << ' ' << i;
  }
}

TEST(RigEndToEnd, TheCycleDoesNotAllocate) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "malloc belongs to a sanitizer";
  SimulatedRig sim;
  Wrench F;
  F.f = Vec3(0, 1, 0);
  AllocationGuard guard;
  const bool booted = sim.boot();
  const bool armed = sim.rig->arm();
  sim.cycles(200, F);
  sim.encoder_ports[0]->set_connected(false);
  sim.cycles(20, F);
  sim.encoder_ports[0]->set_connected(true);
  sim.rig->clear_faults(sim.now);
  sim.cycles(200, F);
  const long calls = guard.calls();
  EXPECT_EQ(calls, 0) << guard.report();
  EXPECT_TRUE(booted && armed);
}

}  // namespace
}  // namespace godobject::test_rig_end_to_end
