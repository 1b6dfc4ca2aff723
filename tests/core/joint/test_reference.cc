// The articulated reference cases: error, order and joint drift of both integrators.
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/core/joint/oracle_tool.h"
#include "tests/core/joint/usual_scene.h"
#include "tests/oracle/case/reference_case.h"

namespace godobject::test_reference {
namespace {

struct Errors {
  double position = 0, angle = 0;     // worst against the reference, m and rad
  double drift_m = 0, drift_rad = 0;  // worst violation of a joint
};

template <class I>
Errors run(const oracle::ReferenceCase& reference, double h, double until) {
  OracleTool<I> tool(reference.problem, h);
  Errors e;
  const std::vector<double>& times = reference.expected.times;
  std::size_t row = 0;
  for (long tick = 0; row < times.size() && times[row] <= until + 1e-9; ++tick) {
    if (tick > 0) tool.step();
    const auto [m, rad] = tool.drift();
    e.drift_m = std::max(e.drift_m, m);
    e.drift_rad = std::max(e.drift_rad, rad);
    if (std::abs(static_cast<double>(tick) * h - times[row]) > 1e-9) continue;
    for (std::size_t i = 0; i < reference.problem.bodies.size(); ++i) {
      const oracle::RigidState& expected = reference.expected.states[row][i];
      const Pose& X = tool.state().bodies[i].x.X_WB;
      e.position = std::max(e.position, (X.p - expected.p).norm());
      const Quat q(expected.q.w(), expected.q.x(), expected.q.y(), expected.q.z());
      e.angle = std::max(e.angle, 2 * (X.q.conjugate() * q).vec().norm());
    }
    ++row;
  }
  return e;
}

class ArticulatedReference : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("GODOBJECT_SHARED");
    folder_ = std::filesystem::path(shared ? shared : GODOBJECT_SOURCE_DIR "/../shared") / "reference";
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << "no reference cases at " << folder_;
  }

  oracle::ReferenceCase load(const char* name) const { return oracle::load_reference_case(folder_ / name); }

  std::filesystem::path folder_;
};

template <class I>
void print(const char* name, double h, const Errors& e) {
  std::printf("%-10s %-14s %7.4f ms: %.2e m, %.2e rad; drift %.1e m, %.1e rad\n", name, I::name, 1e3 * h,
              e.position, e.angle, e.drift_m, e.drift_rad);
}

/// Errors at a ladder of halved steps, printed.
template <class I>
std::vector<Errors> ladder(const char* name, const oracle::ReferenceCase& reference, double h, int steps,
                           double until) {
  std::vector<Errors> all;
  for (int i = 0; i < steps; ++i, h /= 2) {
    all.push_back(run<I>(reference, h, until));
    print<I>(name, h, all.back());
  }
  return all;
}

double order(double coarse, double fine) { return std::log2(coarse / fine); }

TEST_F(ArticulatedReference, GrasperSecondOrder) {
  const auto e = ladder<TrBdf2>("grasper", load("grasper"), 2e-3, 4, 2);
  EXPECT_LE(e[1].position, 5e-6);
  EXPECT_LE(e[1].drift_m, 1e-6);
  EXPECT_LE(e[1].drift_rad, 1e-5);
  EXPECT_GE(order(e[0].position, e[3].position) / 3, 1.9);
}

TEST_F(ArticulatedReference, GrasperImplicitEuler) {
  const auto e = ladder<ImplicitEuler>("grasper", load("grasper"), 2e-3, 4, 2);
  EXPECT_LE(e[1].position, 5e-5);
  EXPECT_LE(e[1].drift_m, 5e-5);
  EXPECT_GE(order(e[0].position, e[3].position) / 3, 0.9);
}

TEST_F(ArticulatedReference, ChainFirstHalfSecond) {
  const oracle::ReferenceCase chain = load("chain-5");
  const auto second = ladder<TrBdf2>("chain-5", chain, 1e-3, 3, 0.5);
  EXPECT_LE(second[0].position, 1e-3);
  EXPECT_GE(order(second[0].position, second[2].position) / 2, 1.9);
  const auto first = ladder<ImplicitEuler>("chain-5", chain, 1e-3, 3, 0.5);
  EXPECT_GE(order(first[0].position, first[2].position) / 2, 0.8);
}

TEST_F(ArticulatedReference, HeavyTop) {
  const oracle::ReferenceCase top = load("heavy-top");
  const auto second = ladder<TrBdf2>("heavy-top", top, 1e-3, 4, 2);
  EXPECT_LE(second[0].drift_m, 1e-4);
  EXPECT_GE(order(second[2].position, second[3].position), 1.9);
  // of 2 m that are possible, the top being 1 m long: Euler takes the energy of the fast spin
  const auto first = ladder<ImplicitEuler>("heavy-top", top, 1e-3, 4, 2);
  EXPECT_LE(first[0].position, 1.2);
  EXPECT_GE(order(first[2].position, first[3].position), 0.7);
}

}  // namespace
}  // namespace godobject::test_reference
