// The reference cases through the program, against the accurate solutions of the shared folder.
#include <gtest/gtest.h>

#include <cmath>

#include "core/types.h"
#include "sim/csv.h"
#include "tests/platform/program.h"
#include "tests/support/shared_data.h"

namespace godobject::test {
namespace {

struct WorstError {
  double m = 0, rad = 0;
};

class ReferenceRuns : public ProgramTest {
 protected:
  CsvTable run(const std::string& scene, const std::string& options) const {
    const ProgramResult result =
        run_program("run sim/scenes/reference/" + scene + ".toml --bus direct --fast --trace " +
                    path("t.csv") + " " + options);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return read_csv(path("t.csv")).table.value();
  }

  /// Worst over the times of the reference, which the run must all have.
  WorstError error_of(const std::string& scene, const std::string& integrator, double step) const {
    const std::string folder = shared_file("reference/" + scene).string();
    const CsvTable ours = run(scene, "--integrator " + integrator + " --step " + std::to_string(step) +
                                         " --motion " + folder + "/motion.csv");
    const CsvTable reference = read_csv(folder + "/reference.csv").table.value();
    WorstError worst;
    for (std::size_t row = 0; row < reference.num_rows(); ++row) {
      const auto at = static_cast<std::size_t>(std::llround(reference.at(row, 0) / step));
      EXPECT_NEAR(ours.at(at, 0), reference.at(row, 0), 1e-9);
      double p_sq = 0, minus_sq = 0, plus_sq = 0;
      for (std::size_t c = 1; c <= 3; ++c) p_sq += std::pow(ours.at(at, c) - reference.at(row, c), 2);
      for (std::size_t c = 4; c <= 7; ++c) {
        minus_sq += std::pow(ours.at(at, c) - reference.at(row, c), 2);
        plus_sq += std::pow(ours.at(at, c) + reference.at(row, c), 2);
      }
      worst.m = std::max(worst.m, std::sqrt(p_sq));
      worst.rad = std::max(worst.rad, 2 * std::sqrt(std::min(minus_sq, plus_sq)));  // |dq| = 2 sin(angle / 4)
    }
    return worst;
  }
  WorstError lissajous(const std::string& integrator, double step) const {
    return error_of("coupling-lissajous", integrator, step);
  }
};

TEST_F(ReferenceRuns, LissajousIsWithinBoundsAtOneMillisecond) {
  if (shared_file("reference").empty()) GTEST_SKIP() << "shared/reference is not here";
  const WorstError euler = lissajous("implicit-euler", 1e-3), second = lissajous("tr-bdf2", 1e-3);
  EXPECT_LE(euler.m, 1e-4);
  EXPECT_LE(second.m, 3e-6);
  EXPECT_LE(second.rad, 1e-4);
  std::printf("worst error at 1 ms: implicit-euler %.2g m %.2g rad, tr-bdf2 %.2g m %.2g rad\n", euler.m,
              euler.rad, second.m, second.rad);
}

TEST_F(ReferenceRuns, LissajousConvergesWithTheOrdersOfTheSchemes) {
  if (shared_file("reference").empty()) GTEST_SKIP() << "shared/reference is not here";
  for (const auto& [integrator, order] : {std::pair{"implicit-euler", 0.9}, {"tr-bdf2", 1.9}}) {
    const WorstError coarse = lissajous(integrator, 2e-3), fine = lissajous(integrator, 0.25e-3);
    const double halvings = 3;
    EXPECT_GE(std::log2(coarse.m / fine.m) / halvings, order) << integrator;
    EXPECT_GE(std::log2(coarse.rad / fine.rad) / halvings, order) << integrator;
  }
}

TEST_F(ReferenceRuns, StepResponseIsWithinBoundsAndOfSecondOrder) {
  if (shared_file("reference").empty()) GTEST_SKIP() << "shared/reference is not here";
  const WorstError coarse = error_of("coupling-step", "tr-bdf2", 1e-3);
  const WorstError fine = error_of("coupling-step", "tr-bdf2", 0.25e-3);
  EXPECT_LE(coarse.m, 1e-4);
  EXPECT_LE(coarse.rad, 5e-4);
  const double halvings = 2;
  EXPECT_GE(std::log2(coarse.m / fine.m) / halvings, 1.9);
  EXPECT_GE(std::log2(coarse.rad / fine.rad) / halvings, 1.9);
  std::printf("worst error of tr-bdf2: %.3g m %.3g rad at 1 ms, %.3g m %.3g rad at 0.25 ms\n", coarse.m,
              coarse.rad, fine.m, fine.rad);
}

TEST_F(ReferenceRuns, TorqueFreeKeepsEnergyAndAngularMomentum) {
  const CsvTable t = run("torque-free", "--integrator tr-bdf2 --step 1e-3");
  const Vec3 I(0.02, 0.05, 0.08);  // of the scene
  double energy_0 = 0;
  Vec3 L_0 = Vec3::Zero();
  double worst_energy = 0, worst_L = 0;
  ASSERT_EQ(t.num_rows(), 4001u);
  for (std::size_t row = 0; row < t.num_rows(); ++row) {
    const Quat q(t.at(row, 4), t.at(row, 5), t.at(row, 6), t.at(row, 7));
    const Vec3 w_B = q.conjugate() * Vec3(t.at(row, 11), t.at(row, 12), t.at(row, 13));
    const Vec3 L_B = I.cwiseProduct(w_B);
    const double energy = 0.5 * w_B.dot(L_B);
    const Vec3 L = q * L_B;
    if (row == 0) {
      energy_0 = energy;
      L_0 = L;
    }
    worst_energy = std::max(worst_energy, std::abs(energy - energy_0) / energy_0);
    worst_L = std::max(worst_L, (L - L_0).norm() / L_0.norm());
  }
  EXPECT_LE(worst_energy, 1e-3);
  EXPECT_LE(worst_L, 1e-3);
}

}  // namespace
}  // namespace godobject::test
