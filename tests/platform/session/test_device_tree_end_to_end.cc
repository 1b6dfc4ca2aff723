// A branched device with several handles against simulated encoders and drives on simulated wires.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/allocation_guard.h"
#include "tests/support/grasper_device.h"
#include "tests/support/simulated_rig.h"

namespace godobject::test_device_tree_end_to_end {
namespace {

using test::SimulatedRig;

constexpr int num_joints = 6;
constexpr std::size_t num_handles = 4;
// The nodes report the plant's state at the last of its 50 us steps before the SYNC ended.
constexpr Nanoseconds sampled_after_ns = 50'000;

JointVector moving(double t) {
  JointVector q(num_joints);
  for (int i = 0; i < num_joints; ++i) q(i) = (i == 2 ? 0.04 : 0.5) * std::sin((1.5 + 0.4 * i) * t + i);
  return q;
}
JointVector moving_rates(double t) {
  JointVector q_dot(num_joints);
  for (int i = 0; i < num_joints; ++i) {
    const double omega = 1.5 + 0.4 * i;
    q_dot(i) = (i == 2 ? 0.04 : 0.5) * omega * std::cos(omega * t + i);
  }
  return q_dot;
}

void follow_motion(SimulatedRig& sim) {
  sim.q_ref = moving;
  sim.q_ref_dot = moving_rates;
}

double sample_time(const SimulatedRig& sim) {
  return 1e-9 * static_cast<double>(sim.cycle_start_ns - SimulatedRig::cycle_ns + sampled_after_ns);
}

std::array<Wrench, num_handles> wrenches() {
  return {Wrench{Vec3(0.01, -0.02, 0.03), Vec3(0.1, 0.2, -0.1)},
          Wrench{Vec3(-0.02, 0.01, 0.04), Vec3(0.3, -0.2, 0.5)},
          Wrench{Vec3(0.01, 0.03, -0.01), Vec3(-0.4, 0.1, 0.2)},
          Wrench{Vec3(0.02, -0.01, 0.02), Vec3(0.2, 0.3, 0.1)}};
}

TEST(DeviceTreeEndToEnd, EveryHandleIsWhereItsJointsPutItWithinHalfACount) {
  SimulatedRig sim(test::grasper_rig_params());
  follow_motion(sim);
  ASSERT_TRUE(sim.boot()) << sim.rig->fault_text();
  ASSERT_EQ(sim.rig->num_handles(), num_handles);
  const KinematicTree tree(sim.params.tree);
  for (int k = 0; k < 1000; ++k) {
    sim.cycle();
    ASSERT_TRUE(sim.complete && sim.sample.valid) << sim.rig->fault_text();
    const TreeConfiguration exact = tree.at(moving(sample_time(sim)));
    for (std::size_t i = 0; i < num_handles; ++i) {
      const HandleJacobian J = exact.jacobian(i);
      double position_bound = 0, angle_bound = 0;
      for (Eigen::Index j = 0; j < num_joints; ++j) {
        const double half_count =
            0.505 / sim.params.encoders[static_cast<std::size_t>(j)].calibration.counts_per_unit;
        position_bound += half_count * J.col(j).tail<3>().norm();
        angle_bound += half_count * J.col(j).head<3>().norm();
      }
      const Pose& X_WH = sim.sample.handles[i].X_WD;
      ASSERT_LT((X_WH.p - exact.X_WH(i).p).norm(), position_bound) << k << ' ' << i;
      ASSERT_LT(2 * (X_WH.q * exact.X_WH(i).q.conjugate()).vec().norm(), angle_bound) << k << ' ' << i;
    }
  }
}

TEST(DeviceTreeEndToEnd, EveryHandleHasItsVelocity) {
  SimulatedRig sim(test::grasper_rig_params());
  follow_motion(sim);
  ASSERT_TRUE(sim.boot());
  sim.cycles(50);
  const KinematicTree tree(sim.params.tree);
  std::array<double, num_handles> error_sq{}, speed_sq{};
  for (int k = 0; k < 1000; ++k) {
    sim.cycle();
    const double t = sample_time(sim);
    const TreeConfiguration exact = tree.at(moving(t));
    for (std::size_t i = 0; i < num_handles; ++i) {
      const Twist V = exact.twist(i, moving_rates(t));
      error_sq[i] += (sim.sample.handles[i].V_WD.w - V.w).squaredNorm();
      speed_sq[i] += V.w.squaredNorm();
    }
  }
  for (std::size_t i = 0; i < num_handles; ++i)
    EXPECT_LT(std::sqrt(error_sq[i]), 0.05 * std::sqrt(speed_sq[i])) << i;
}

TEST(DeviceTreeEndToEnd, TheTorquesOfAllHandlesReachTheDrivenJointsAndNoOther) {
  SimulatedRig sim(test::grasper_rig_params());
  JointVector posture = moving(0.3);
  sim.q_ref = [&](double) { return posture; };
  ASSERT_TRUE(sim.boot());
  ASSERT_TRUE(sim.rig->arm());
  const std::array<Wrench, num_handles> F = wrenches();
  sim.cycles(50, F);
  ASSERT_EQ(sim.rig->state(), RigState::armed) << sim.rig->fault_text();
  EXPECT_EQ(sim.report.torque_limited | sim.report.rate_limited | sim.report.not_sent, 0u);

  // J^T written out from the true posture, one wrench and column at a time
  const TreeConfiguration exact = KinematicTree(sim.params.tree).at(posture);
  JointVector tau = sim.zero();
  for (std::size_t i = 0; i < num_handles; ++i) {
    Eigen::Matrix<double, 6, 1> F_i;
    F_i << F[i].tau, F[i].f;
    tau += exact.jacobian(i).transpose() * F_i;
  }
  ASSERT_EQ(sim.drives.size(), 5u);
  for (std::size_t i = 0; i < sim.drives.size(); ++i) {
    const DriveParams& drive = sim.params.drives[i];
    const double wanted = tau(sim.joint_named(drive.joint));
    const double half_per_mille = 0.5e-3 * drive.torque_rated_Nm / drive.joint_per_motor_rad;
    EXPECT_NEAR(sim.applied_joint_torque(i), wanted, half_per_mille + 1e-4) << drive.joint;
    EXPECT_GT(std::abs(wanted), 5 * half_per_mille) << drive.joint;  // the check above is not vacuous
  }
  EXPECT_GT(std::abs(tau(sim.joint_named("roll"))), 0.01);  // needed, and without a drive to display it
}

TEST(DeviceTreeEndToEnd, AForceOnOneJawDeflectsItsJawAndTheJointsBelowOnly) {
  PlantConfig plant;
  plant.friction = 0;
  SimulatedRig sim(test::grasper_rig_params(), true, plant);
  ASSERT_TRUE(sim.boot());
  ASSERT_TRUE(sim.rig->arm());
  std::array<Wrench, num_handles> F;
  F[2].tau = KinematicTree(sim.params.tree).at(sim.zero()).X_WH(2).q * Vec3(0, 0.2, 0);
  sim.cycles(1500, F);
  EXPECT_GT(sim.plant.q()(sim.joint_named("jaw_left")), 5e-3);
  EXPECT_NEAR(sim.plant.q()(sim.joint_named("jaw_right")), 0, 1e-4);
  EXPECT_GT(std::abs(sim.plant.q()(sim.joint_named("yaw"))), 1e-3);
}

TEST(DeviceTreeEndToEnd, HandlesWithoutAWrenchAreNotLoaded) {
  SimulatedRig few(test::grasper_rig_params()), all(test::grasper_rig_params());
  std::array<Wrench, num_handles> F = wrenches();
  F[2] = F[3] = Wrench{};
  for (SimulatedRig* sim : {&few, &all}) {
    ASSERT_TRUE(sim->boot());
    ASSERT_TRUE(sim->rig->arm());
    sim->cycles(30, sim == &few ? std::span<const Wrench>(F).first(2) : std::span<const Wrench>(F));
  }
  for (std::size_t i = 0; i < few.drives.size(); ++i)
    EXPECT_EQ(few.drives[i]->applied_torque_Nm(), all.drives[i]->applied_torque_Nm()) << i;
  EXPECT_NE(few.drives[0]->applied_torque_Nm(), 0);
}

TEST(DeviceTreeEndToEnd, ALostEncoderMakesEveryHandleInvalidAndHoldsItsJoint) {
  SimulatedRig sim(test::grasper_rig_params());
  ASSERT_TRUE(sim.boot());
  sim.cycles(5);
  sim.encoder_ports[5]->set_connected(false);  // of jaw_right
  sim.cycles(10);
  EXPECT_FALSE(sim.sample.valid);
  EXPECT_EQ(sim.rig->faults(), RigFault::none);
  sim.cycles(100);  // lost_after
  EXPECT_EQ(sim.rig->faults(), RigFault::sample_stale);
  EXPECT_NE(sim.rig->fault_text().find("encoder of jaw_right"), std::string::npos);
}

TEST(DeviceTreeEndToEnd, ReadAndCommandDoNotAllocate) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "malloc belongs to a sanitizer";
  SimulatedRig sim(test::grasper_rig_params());
  const std::array<Wrench, num_handles> F = wrenches();
  AllocationGuard guard;
  const bool booted = sim.boot();
  const bool armed = sim.rig->arm();
  sim.cycles(200, F);
  sim.encoder_ports[0]->set_connected(false);
  sim.cycles(120, F);  // lost_after
  const bool faulted = sim.rig->state() == RigState::fault;
  const long calls = guard.calls();
  EXPECT_EQ(calls, 0) << guard.report();
  EXPECT_TRUE(booted && armed && faulted);
}

}  // namespace
}  // namespace godobject::test_device_tree_end_to_end
