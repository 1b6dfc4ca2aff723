#include "tests/oracle/reference_case.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/oracle/compare.h"

namespace godobject::oracle {
namespace {

namespace fs = std::filesystem;

/// The folder of reference solutions; empty where the shared files are absent.
fs::path reference_folder() {
  const char* shared = std::getenv("GODOBJECT_SHARED");
  const fs::path folder =
      (shared ? fs::path(shared) : fs::path(GODOBJECT_SOURCE_DIR) / ".." / "shared") / "reference";
  return fs::is_directory(folder) ? folder : fs::path();
}

/// Largest speeds of a solution, at least 1: what differences of velocities are measured by.
struct Speeds {
  double v = 1;  // m/s
  double w = 1;  // rad/s
};

Speeds largest_speeds(const Solution& solution) {
  Speeds largest;
  for (const auto& states : solution.states) {
    for (const RigidState& x : states) {
      largest.v = std::max(x.v.norm(), largest.v);
      largest.w = std::max(x.w.norm(), largest.w);
    }
  }
  return largest;
}

struct Agreement {
  const char* name;
  double bound;
};

// The reference of torque-free itself ends 1.0e-8 from the exact solution, see
// TumblingMeetsQuadruplePrecision.
constexpr Agreement coupling_step{"coupling-step", 1e-10};
constexpr Agreement coupling_lissajous{"coupling-lissajous", 1e-10};
constexpr Agreement torque_free{"torque-free", 1.1e-8};

class Reference : public testing::TestWithParam<Agreement> {
 protected:
  void SetUp() override {
    if (reference_folder().empty()) GTEST_SKIP() << "no ../shared/reference and GODOBJECT_SHARED not set";
  }
};

TEST_P(Reference, IsMet) {
  const auto [name, bound] = GetParam();
  const ReferenceCase loaded = load_reference_case(reference_folder() / name);
  ASSERT_FALSE(loaded.expected.times.empty());
  ASSERT_DOUBLE_EQ(loaded.expected.times.back(), loaded.duration);
  const Solution solution = solve(loaded.problem, loaded.expected.times);
  const WorstDifference worst = worst_difference(solution, loaded.expected);
  std::printf("%-18s against the reference: p %.1e m, q %.1e, v %.1e m/s, w %.1e rad/s\n", name, worst.p,
              worst.q, worst.v, worst.w);
  EXPECT_LT(worst.p, bound);
  EXPECT_LT(worst.q, bound);
  const Speeds largest = largest_speeds(loaded.expected);
  EXPECT_LT(worst.v / largest.v, bound);
  EXPECT_LT(worst.w / largest.w, bound);
}

INSTANTIATE_TEST_SUITE_P(Free, Reference, testing::Values(coupling_step, coupling_lissajous, torque_free),
                         [](const auto& tested) {
                           std::string name = tested.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(ReferenceCase, RefusesPartsTheOracleDoesNotSolve) {
  if (reference_folder().empty()) GTEST_SKIP() << "no ../shared/reference and GODOBJECT_SHARED not set";
  EXPECT_THROW(load_reference_case(reference_folder() / "bounce"), std::runtime_error);
}

TEST(ReferenceCase, NamesTheFileThatIsMissing) {
  try {
    load_reference_case("no-such-folder");
    FAIL() << "not refused";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("no-such-folder/case.json"), std::string::npos);
  }
}

}  // namespace
}  // namespace godobject::oracle
