// Coordinates of joints from the poses of bodies: every kind, rotated by many turns.
#include "platform/session/record.h"

#include <gtest/gtest.h>

#include <random>

#include "platform/scene/joint/joints.h"

namespace godobject::test_joint_coordinates {
namespace {

Pose random_pose(std::mt19937& draw) {
  std::uniform_real_distribution<double> number(-1, 1);
  return {.p = Vec3(number(draw), number(draw), number(draw)),
          .q = Quat(number(draw), number(draw), number(draw), number(draw)).normalized()};
}

Pose inverse(const Pose& X) {
  const Quat q = X.q.conjugate();
  return {.p = -(q * X.p), .q = q};
}
Pose times(const Pose& a, const Pose& b) { return {.p = a.p + a.q * b.p, .q = (a.q * b.q).normalized()}; }

/// Returns the child frame in the parent's frame at these coordinates.
Pose moved(JointKind kind, const std::vector<double>& q) {
  const auto turn = [](double angle, const Vec3& axis) {
    return Pose{.p = Vec3::Zero(), .q = Quat(Eigen::AngleAxis<Real>(angle, axis))};
  };
  switch (kind) {
    case JointKind::hinge: return turn(q[0], Vec3::UnitZ());
    case JointKind::slider: return {.p = q[0] * Vec3::UnitZ(), .q = Quat::Identity()};
    case JointKind::cylindrical: return {.p = q[1] * Vec3::UnitZ(), .q = turn(q[0], Vec3::UnitZ()).q};
    case JointKind::universal: return times(turn(q[0], Vec3::UnitX()), turn(q[1], Vec3::UnitY()));
    default: return {};
  }
}

TEST(JointCoordinates, CountTheirTurns) {
  std::mt19937 draw(5);
  for (const JointKind kind :
       {JointKind::hinge, JointKind::slider, JointKind::cylindrical, JointKind::universal}) {
    for (const bool on_the_world : {true, false}) {
      SceneConfig scene;
      scene.bodies.resize(2);
      scene.bodies[0].name = "base";
      scene.bodies[1].name = "arm";
      scene.joints.resize(1);
      JointConfig& joint = scene.joints[0];
      joint = {};
      joint.name = "joint";
      joint.kind = kind;
      joint.parent = on_the_world ? world_name : "base";
      joint.child = "arm";
      joint.X_BP = random_pose(draw);
      joint.X_BC = random_pose(draw);
      const JointCoordinatesOf coordinates(scene);
      ASSERT_EQ(coordinates.size(), num_coordinates(kind));
      std::vector<double> read(coordinates.size()), q(coordinates.size());
      std::vector<BodyView> bodies(2);
      for (int i = 0; i <= 100;
           ++i) {  // eight turns there and half of them back, each step less than half a turn
        for (std::size_t k = 0; k < q.size(); ++k) q[k] = (i <= 60 ? i : 120 - i) * (k == 0 ? 0.9 : -0.7);
        bodies[0].X_WB = random_pose(draw);
        const Pose X_WP = on_the_world ? joint.X_BP : times(bodies[0].X_WB, joint.X_BP);
        bodies[1].X_WB = times(times(X_WP, moved(kind, q)), inverse(joint.X_BC));
        coordinates.read(bodies, read);
        for (std::size_t k = 0; k < q.size(); ++k)
          ASSERT_NEAR(read[k], q[k], 1e-9) << static_cast<int>(kind) << " " << k << " " << i;
      }
    }
  }
}

}  // namespace
}  // namespace godobject::test_joint_coordinates
