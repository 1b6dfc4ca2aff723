// The study's reference solutions against those of the shared folder, which another program computed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "tests/oracle/case/csv_table.h"
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

oracle::Solution solution_in(const fs::path& file, const std::string& body) {
  const oracle::CsvTable table(file);
  oracle::Solution solution{.times = table.column("t"), .states = {}};
  solution.states.resize(solution.times.size(), {{}});
  const auto read = [&](const char* name, auto&& number_of) {
    const std::vector<double> column = table.column(body + "." + name);
    for (std::size_t i = 0; i < column.size(); ++i) number_of(solution.states[i].front()) = column[i];
  };
  const std::array<const char*, 3> positions{"x", "y", "z"}, vectors{"qx", "qy", "qz"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    read(positions[i], [=](oracle::RigidState& x) -> double& { return x.p[axis]; });
    read(vectors[i], [=](oracle::RigidState& x) -> double& { return x.q.coeffs()[axis]; });
  }
  read("qw", [](oracle::RigidState& x) -> double& { return x.q.w(); });
  return solution;
}

TEST(References, OfContactsAreThoseOfTheSharedFiles) {
  const fs::path folder = test::shared_file("reference");
  if (folder.empty()) GTEST_SKIP() << "shared/reference is not here";
  for (const ContactCase& contact : contact_cases()) {
    const std::string& name = contact.scene.name;
    const oracle::Solution expected =
        solution_in(folder / name / "reference.csv", contact.scene.problem.bodies.front().name);
    ASSERT_EQ(contact.exact.times.size(), expected.times.size()) << name;
    for (std::size_t i = 0; i < expected.times.size(); ++i) {
      ASSERT_NEAR(contact.exact.times[i], expected.times[i], 1e-9);
      const oracle::WorstDifference apart =
          oracle::worst_difference(contact.exact.states[i].front(), expected.states[i].front());
      EXPECT_LT(apart.p, 1e-9) << name << " at " << expected.times[i];
      EXPECT_LT(apart.q, 1e-9) << name << " at " << expected.times[i];
    }
  }
}

}  // namespace
}  // namespace godobject::study::test_references
