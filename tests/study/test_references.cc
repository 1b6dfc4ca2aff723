// The study's reference solutions against those of the shared folder, which another program computed.
#include <gtest/gtest.h>

#include <algorithm>
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

/// Bounds of the differences in position and rotation. A free body that tumbles, a chain and a top amplify the
/// last of 12 digits of the files.
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

TEST(References, OfContactsAreThoseOfTheSharedFiles) {
  const fs::path folder = test::shared_file("reference");
  if (folder.empty()) GTEST_SKIP() << "shared/reference is not here";
  for (const ContactCase& contact : contact_cases()) {
    const oracle::Solution expected = oracle::load_reference_case(folder / contact.scene.name).expected;
    std::size_t num_compared = 0;
    for (std::size_t i = 0, n = 0; i < expected.times.size(); ++i) {
      while (n + 1 < contact.exact.times.size() && contact.exact.times[n] < expected.times[i] - 1e-9) ++n;
      if (std::abs(contact.exact.times[n] - expected.times[i]) > 1e-9) continue;
      const oracle::WorstDifference apart =
          oracle::worst_difference(contact.exact.states[n].front(), expected.states[i].front());
      EXPECT_LT(apart.p, 1e-9) << contact.scene.name << " at " << expected.times[i];
      EXPECT_LT(apart.q, 1e-9) << contact.scene.name << " at " << expected.times[i];
      ++num_compared;
    }
    EXPECT_GE(num_compared, 100u) << contact.scene.name;
  }
}

}  // namespace
}  // namespace godobject::study::test_references
