// Scenes of ../shared/cases in which a body sticks on another that moves: the place at which it sticks stays
// on both.
#include "tests/platform/session/attacked.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace godobject::test_sticking_cases {
namespace {

/// Returns a scene of the shared folder `cases`; none if the folder is absent.
std::optional<SceneConfig> case_scene(const std::string& name, const std::string& integrator) {
  const std::filesystem::path file = test::shared_file("cases/" + name + ".toml");
  if (file.empty()) return std::nullopt;
  LoadResult loaded = load_scene(file.string());
  EXPECT_TRUE(loaded.scene) << name;
  if (loaded.scene) loaded.scene->integrator = integrator;
  return loaded.scene;
}

/// Place of a body on another, m in the other's axes, over time.
struct PlaceOn {
  PlaceOn(const SceneConfig& scene, const std::string& body, const std::string& on)
      : body_(*body_named(scene, body)), on_(*body_named(scene, on)) {}
  Vec3 operator()(const CycleRecord& r) const {
    const Pose& X_WO = r.bodies[on_].X_WB;
    return X_WO.q.conjugate() * (r.bodies[body_].X_WB.p - X_WO.p);
  }

 private:
  std::size_t body_, on_;
};

/// Returns the distance between the places at two times, s, of one run.
double crept(const SceneConfig& scene, Motion motion, const PlaceOn& place, double from, double to) {
  Vec3 first = Vec3::Zero(), last = Vec3::Zero();
  attacked(scene, std::move(motion), to, [&](const CycleRecord& r) {
    if (r.t < from + scene.step / 2) first = place(r);
    last = place(r);
  });
  return (last - first).norm();
}

class StickingCases : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(BothIntegrators, StickingCases, testing::Values("implicit-euler", "tr-bdf2"),
                         [](const auto& of) {
                           return std::string(of.param) == "tr-bdf2" ? "TrBdf2" : "ImplicitEuler";
                         });

TEST_P(StickingCases, ABoxOnATurntableStays) {
  const auto scene = case_scene("turntable", GetParam());
  if (!scene) GTEST_SKIP() << "no cases/ in the shared folder";
  EXPECT_LT(crept(*scene, Motion(*scene), PlaceOn(*scene, "box", "disc"), 2, 10), 8 * 1e-9);
}

TEST_P(StickingCases, APartOnASpatulaStays) {
  const auto scene = case_scene("spatula", GetParam());
  const std::filesystem::path file = test::shared_file("cases/spatula.csv");
  if (!scene || file.empty()) GTEST_SKIP() << "no cases/ in the shared folder";
  MotionResult read = Motion::read(file.string(), *scene);
  ASSERT_TRUE(read.motion);
  // the same phase, 28 periods later
  EXPECT_LT(crept(*scene, *read.motion, PlaceOn(*scene, "part", "spatula"), 11, 51), 1e-9);
}

/// Returns the motion of a palm that turns about (1, 1, 1) once a second, and of the jaws on it, which close
/// by 2.5 mm: 5 N.
std::string turning_grip() {
  std::string csv = "t";
  for (const char* body : {"palm", "L", "R"})
    for (const char* column : {"x", "y", "z", "qw", "qx", "qy", "qz"})
      csv += std::string(",") + body + "." + column;
  for (double t = 0; t < 6; t += 2e-3) {
    const double closed = 0.0025 * std::min(1.0, t / 0.3), turned = std::max(0.0, t - 0.5),
                 turns = turned < 0.5 ? turned * turned : turned - 0.25;
    const Quat q(Eigen::AngleAxisd(2 * M_PI * turns, Vec3(1, 1, 1).normalized()));
    char row[32];
    const auto add = [&](double number) {
      std::snprintf(row, sizeof(row), ",%.15g", number);
      csv += row;
    };
    std::snprintf(row, sizeof(row), "\n%.3f", t);
    csv += row;
    for (const Vec3& p : {Vec3(0, 0, 0.05), Vec3(closed - 0.012, 0, 0), Vec3(0.012 - closed, 0, 0)}) {
      const Vec3 p_W = q * p;
      for (const double number : {p_W.x(), p_W.y(), p_W.z(), q.w(), q.x(), q.y(), q.z()}) add(number);
    }
  }
  return csv + "\n";
}

TEST_P(StickingCases, ABoxInAGripThatTurnsStays) {
  const auto scene = case_scene("creep-grip-trbdf2-2e3", GetParam());
  if (!scene) GTEST_SKIP() << "no cases/ in the shared folder";
  MotionResult read = Motion::parse(turning_grip(), "grip.csv", *scene);
  ASSERT_TRUE(read.motion) << (read.errors.empty() ? "" : read.errors.front());
  // the same angle, three turns later
  EXPECT_LT(crept(*scene, *read.motion, PlaceOn(*scene, "obj", "palm"), 2.75, 5.75), 3 * 1e-10);
}

}  // namespace
}  // namespace godobject::test_sticking_cases
