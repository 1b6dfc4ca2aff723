// A device whose discs move several joints, through simulated buses: poses in, torques out.
#include <gtest/gtest.h>

#include <cmath>

#include "hal/joint/transmission.h"
#include "platform/session/passivity.h"
#include "platform/simulated/session.h"
#include "tests/support/tool_scene.h"

namespace godobject::test::test_transmission_session {
namespace {

JointVector vector_of(const std::vector<double>& numbers) {
  return JointVector::Map(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

TEST(TransmissionSession, JointsAreMeasuredAndTorquesShownThroughTheDiscs) {
  const SceneConfig scene = load_shipped("needle-driver.toml");
  const RigParams& rig = *scene.device->rig;
  const Motion motion(scene);
  const Session::Made made = make_session(scene, motion, BusChoice::sim);
  ASSERT_TRUE(made.session) << made.errors.front();
  ASSERT_TRUE(made.session->boot(3)) << made.session->rig()->fault_text();
  const KinematicTree tree(rig.tree);
  CycleRecord record = made.session->at_start();
  double largest = 0;
  int compared = 0;
  while (record.t < 1.2) {
    made.session->cycle(record);
    ASSERT_EQ(record.rig_faults, RigFault::none);
    const JointVector q = vector_of(record.device_q);
    if (record.t < 0.2 || !q.allFinite()) continue;
    // the hand of 20 N m/rad yields to at most 0.3 N m; the joints move by 0.1 to 0.9 rad
    ASSERT_LT((q - motion.joints(record.t).q).cwiseAbs().maxCoeff(), 0.016) << "at " << record.t;
    std::vector<Wrench> F;
    for (const HandleParams& handle : rig.tree.handles)
      F.push_back(record.bodies[*body_named(scene, handle.body)].feedback_D);
    const JointVector tau = tree.at(q).joint_torques(F);
    // M^T tau, written out
    const double expected[] = {-1.5632 * tau(0), 1.0186 * tau(1) - 0.8306 * tau(2),
                               0.6089 * tau(2) - 1.2177 * tau(3), 0.6089 * tau(2) + 1.2177 * tau(3)};
    if (record.drives.torque_limited != 0 || record.drives.rate_limited != 0) continue;
    for (std::size_t i = 0; i < 4; ++i)
      ASSERT_NEAR(record.drive_torque[i], rig.drives[i].sign * expected[i], 1e-9) << i << " at " << record.t;
    largest = std::max(largest, std::abs(expected[3]));
    ++compared;
  }
  EXPECT_GT(compared, 500);
  EXPECT_GT(largest, 1e-3);  // the grip is felt
}

/// The margin of a disc counts the inertia, damping and stiffness of all joints that it moves.
TEST(TransmissionSession, PassivityIsThatOfTheDiscs) {
  SceneConfig scene = load_shipped("needle-driver.toml");
  const JointVector q = joints_at_start(scene, Motion(scene));
  const Passivity coupled = passivity(scene, q);
  scene.device->rig->transmissions.clear();
  const Passivity alone = passivity(scene, q);
  ASSERT_EQ(coupled.joints.size(), 4u);
  const double yaw = 0.6089, jaw = 1.2177;
  for (std::size_t i = 2; i < 4; ++i) {
    const SampledAxis &disc = coupled.joints[i].axis, &of_yaw = alone.joints[2].axis,
                      &of_jaw = alone.joints[3].axis;
    EXPECT_NEAR(disc.inertia, yaw * yaw * of_yaw.inertia + jaw * jaw * of_jaw.inertia, 1e-12);
    EXPECT_NEAR(disc.damping, yaw * yaw * of_yaw.damping + jaw * jaw * of_jaw.damping, 1e-12);
    EXPECT_NE(disc.K, alone.joints[i].axis.K);
  }
}

}  // namespace
}  // namespace godobject::test::test_transmission_session
