// Coordinates of joints from the poses of bodies: every kind, rotated by many turns.
#include "platform/session/record.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "core/math/pose.h"
#include "platform/scene/joint/joints.h"
#include "tests/platform/session/attacked.h"

namespace godobject::test_joint_coordinates {
namespace {

Pose random_pose(std::mt19937& draw) {
  std::uniform_real_distribution<double> number(-1, 1);
  return {.p = Vec3(number(draw), number(draw), number(draw)),
          .q = Quat(number(draw), number(draw), number(draw), number(draw)).normalized()};
}

/// Returns the child frame in the parent's frame at these coordinates.
Pose moved(JointKind kind, const std::vector<double>& q) {
  const auto turn = [](double angle, const Vec3& axis) {
    return Pose{.p = Vec3::Zero(), .q = Quat(Eigen::AngleAxis<Real>(angle, axis))};
  };
  switch (kind) {
    case JointKind::hinge: return turn(q[0], Vec3::UnitZ());
    case JointKind::slider: return {.p = q[0] * Vec3::UnitZ(), .q = Quat::Identity()};
    case JointKind::cylindrical: return {.p = q[1] * Vec3::UnitZ(), .q = turn(q[0], Vec3::UnitZ()).q};
    case JointKind::universal: return turn(q[0], Vec3::UnitX()) * turn(q[1], Vec3::UnitY());
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
        const Pose X_WP = on_the_world ? joint.X_BP : bodies[0].X_WB * joint.X_BP;
        bodies[1].X_WB = X_WP * moved(kind, q) * inverse(joint.X_BC);
        coordinates.read(bodies, read);
        for (std::size_t k = 0; k < q.size(); ++k)
          ASSERT_NEAR(read[k], q[k], 1e-9) << static_cast<int>(kind) << " " << k << " " << i;
      }
    }
  }
}

/// A wheel that turns freely from a coordinate `start` towards stops at +-`end`.
std::string wheel(double start, double end, double rate, const char* kind, const char* more = "") {
  std::ostringstream text;
  text.precision(17);
  text << "[scene]\nname = 'a'\n[[body]]\nname = 'wheel'\nmass = 0.2\ninertia = [0.01, 0.01, 0.01]\n"
       << "angular_velocity = [" << (std::string(kind) == "universal" ? rate : 0) << ", 0.0, "
       << (std::string(kind) == "universal" ? 0 : rate) << "]\n[[joint]]\nname = 'j'\nkind = '" << kind
       << "'\nchild = 'wheel'\ncoordinates = [" << (std::string(kind) == "hinge" ? "'q'" : "'q', 'other'")
       << "]\nstart = " << start << "\n[[joint.stop]]\ncoordinate = 'q'\nlower = " << -end
       << "\nupper = " << end << "\nstiffness = 1e3\nwidth = 0.02\n"
       << more;
  return text.str();
}

/// Starts beyond half a turn, in one of several turns that the stops allow.
TEST(JointCoordinates, AreCountedFromTheScenesStart) {
  for (const char* kind : {"hinge", "cylindrical", "universal"})
    for (const char* integrator : {"implicit-euler", "tr-bdf2"})
      for (const double start : {5.0, -4.0, 3.2, 13.0, -0.5})
        for (const double rate : {6.0, -9.0}) {
          SCOPED_TRACE(testing::Message() << kind << ' ' << integrator << ' ' << start << ' ' << rate);
          const double end = 15, way = (rate > 0 ? end - start : end + start) / std::abs(rate);
          const LoadResult loaded = parse_scene(wheel(start, end, rate, kind), "a.toml");
          ASSERT_TRUE(loaded.scene) << loaded.errors.front();
          SceneConfig scene = *loaded.scene;
          scene.integrator = integrator;
          EXPECT_NEAR(coordinates_at_start(scene.bodies, scene.joints[0])[0], start, 1e-14);
          double farthest = 0, turned = 0;
          attacked(scene, Motion(scene), way + 0.1, [&](const CycleRecord& r) {
            if (r.t < way - 2 * scene.step) {
              EXPECT_NEAR(r.joint_q[0], start + rate * r.t, 1e-9);
            }
            if (std::abs(r.joint_q[0]) > farthest) turned = r.t;
            farthest = std::max(farthest, std::abs(r.joint_q[0]));
          });
          EXPECT_GT(farthest, end);
          EXPECT_LT(farthest, end + 0.02 + std::abs(rate) * (std::sqrt(0.01 / 1e3) + scene.step));
          EXPECT_NEAR(turned, way, 0.02);
        }
}

TEST(JointCoordinates, ASpringPullsToItsRestInItsTurn) {
  for (const double start : {7.0, 6.0}) {
    const LoadResult loaded = parse_scene(
        wheel(start, 20, 0, "hinge", "[[joint.spring]]\nstiffness = 1.0\nrest = 7.0\n"), "a.toml");
    ASSERT_TRUE(loaded.scene) << loaded.errors.front();
    attacked(*loaded.scene, Motion(*loaded.scene), 1,
             [&](const CycleRecord& r) { ASSERT_LT(std::abs(r.joint_q[0] - 7), 7 - start + 1e-9) << r.t; });
  }
}

}  // namespace
}  // namespace godobject::test_joint_coordinates
