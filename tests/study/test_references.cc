// The study's reference solutions against those of the shared folder, which another program computed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "tests/oracle/case/reference_case.h"
#include "tests/oracle/compare.h"
#include "tests/study/contact/case.h"
#include "tests/study/reference_scene.h"
#include "tests/support/shared_data.h"

namespace godobject::study::test_references {
namespace {

namespace fs = std::filesystem;

/// Bounds of the differences in position and rotation. A free body that tumbles, a chain and a top amplify
/// the last of 12 digits of the files.
const std::map<std::string, double> bounds{{"coupling-step", 1e-10},
                                           {"coupling-lissajous", 1e-10},
                                           {"torque-free", 2e-8},
                                           {"chain-5", 1e-9},
                                           {"heavy-top", 1e-9}};

TEST(References, AreThoseOfTheSharedFiles) {
  const fs::path folder = test::shared_file("reference");
  if (folder.empty()) GTEST_SKIP() << "shared/reference is not here";
  std::size_t num_compared = 0;
  for (const ReferenceScene& scene : reference_scenes()) {
    if (!bounds.contains(scene.name)) continue;
    ++num_compared;
    oracle::Solution expected = oracle::load_reference_case(folder / scene.name).expected;
    const auto end = std::ranges::upper_bound(expected.times, scene.duration + 1e-9);
    const auto num_times = static_cast<std::size_t>(end - expected.times.begin());
    expected.times.resize(num_times);
    expected.states.resize(num_times);
    ASSERT_GT(num_times, 10u) << scene.name;
    const oracle::WorstDifference worst =
        oracle::worst_difference(oracle::solve(scene.problem, expected.times), expected);
    EXPECT_LT(worst.p, bounds.at(scene.name)) << scene.name;
    EXPECT_LT(worst.q, bounds.at(scene.name)) << scene.name;
  }
  EXPECT_EQ(num_compared, bounds.size());
}

// Fall by 4 cm, then m z'' = -k z - c z' - m g.
TEST(References, TheFirstImpactIsThatInClosedForm) {
  const ContactCase bounce = contact_cases().back();
  const double m = 0.1, k = 5000, c = 2, g = 9.81, v_0 = -std::sqrt(2 * g * 0.04), t_0 = -v_0 / g;
  const double rest = -m * g / k, decay = c / (2 * m), w = std::sqrt(k / m - decay * decay);
  const double A = -rest, B = (v_0 + decay * A) / w;
  std::size_t num_in_contact = 0;
  for (std::size_t i = 0; i < bounce.exact.times.size() && bounce.exact.times[i] < t_0 + 0.01; ++i) {
    const double t = bounce.exact.times[i], s = t - t_0;
    const double wave = A * std::cos(w * s) + B * std::sin(w * s);
    const double z = s < 0 ? 0.04 - g * t * t / 2 : rest + std::exp(-decay * s) * wave;
    EXPECT_NEAR(bounce.exact.states[i].front().p.z() - bounce.scene.radius, z, 1e-13) << t;
    if (s > 0) ++num_in_contact;
  }
  EXPECT_GE(num_in_contact, 3u);
}

// The files are of RK4 at 1 us, which errs so much where the damper's force begins.
constexpr double error_of_files = 1e-6;

TEST(References, OfContactsAreThoseOfTheSharedFiles) {
  const fs::path folder = test::shared_file("reference");
  if (folder.empty()) GTEST_SKIP() << "shared/reference is not here";
  for (const ContactCase& contact : contact_cases()) {
    const std::string& name = contact.scene.name;
    const oracle::Solution expected =
        oracle::load_solution(folder / name / "reference.csv", contact.scene.problem.bodies);
    ASSERT_EQ(contact.exact.times.size(), expected.times.size()) << name;
    for (std::size_t i = 0; i < expected.times.size(); ++i) {
      ASSERT_NEAR(contact.exact.times[i], expected.times[i], 1e-9);
      const oracle::WorstDifference apart =
          oracle::worst_difference(contact.exact.states[i].front(), expected.states[i].front());
      EXPECT_LT(apart.p, error_of_files) << name << " at " << expected.times[i];
      EXPECT_LT(apart.q, error_of_files) << name << " at " << expected.times[i];
    }
  }
}

}  // namespace
}  // namespace godobject::study::test_references
