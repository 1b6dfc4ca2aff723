// The reference cases through the program, against the accurate solutions of the shared folder.
#include <gtest/gtest.h>

#include <cmath>

#include "platform/scene/joint/joints.h"
#include "platform/scene/text/csv.h"
#include "platform/scene/toml.h"
#include "tests/support/program.h"
#include "tests/support/shared_data.h"

namespace godobject::test::test_reference_runs {
namespace {

struct WorstError {
  double m = 0, rad = 0;
  double drift_m = 0, drift_rad = 0;  // of the joints
};

double order(double coarse, double fine, double halvings) { return std::log2(coarse / fine) / halvings; }

class ReferenceRuns : public ProgramTest {
 protected:
  CsvTable run(const std::string& scene, const std::string& options) const {
    const ProgramResult result =
        run_program("run sim/scenes/reference/" + scene + ".toml --bus direct --fast --trace " +
                    path("t.csv") + " " + options);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return read_csv(path("t.csv")).table.value();
  }

  /// Returns the largest errors over the bodies and the reference times up to `until`, and the largest drift
  /// of the run. The run must contain all these times.
  WorstError error_of(const std::string& scene, const std::string& integrator, double step,
                      double until = 1e9) const {
    const std::filesystem::path folder = shared_file("reference/" + scene);
    const bool moved = std::filesystem::exists(folder / "motion.csv");
    const CsvTable ours = run(scene, "--integrator " + integrator + " --step " + std::to_string(step) +
                                         (moved ? " --motion " + (folder / "motion.csv").string() : ""));
    const CsvTable reference = read_csv((folder / "reference.csv").string()).table.value();
    const std::vector<BodyConfig> bodies = scene_of(scene).bodies;
    WorstError worst = drift_of(scene, ours);
    for (std::size_t row = 0; row < reference.num_rows() && reference.at(row, 0) <= until + 1e-9; ++row) {
      const auto at = static_cast<std::size_t>(std::llround(reference.at(row, 0) / step));
      EXPECT_NEAR(ours.at(at, 0), reference.at(row, 0), 1e-9);
      for (const BodyConfig& body : bodies) {
        const Pose is = pose(ours, at, body.name), expected = pose(reference, row, body.name);
        worst.m = std::max(worst.m, (is.p - expected.p).norm());
        worst.rad = std::max(worst.rad, 2 * (is.q.conjugate() * expected.q).vec().norm());
      }
    }
    return worst;
  }
  static WorstError drift_of(const std::string& scene, const CsvTable& ours) {
    const SceneConfig config = scene_of(scene);
    std::vector<BodyConfig> bodies = config.bodies;
    WorstError worst;
    for (std::size_t row = 0; row < ours.num_rows(); ++row) {
      for (BodyConfig& body : bodies) body.X_WB = pose(ours, row, body.name);
      for (const JointConfig& joint : config.joints) {
        const JointGap gap = gap_at_start(bodies, joint);
        worst.drift_m = std::max(worst.drift_m, gap.m);
        worst.drift_rad = std::max(worst.drift_rad, gap.rad);
      }
    }
    return worst;
  }
  static SceneConfig scene_of(const std::string& name) {
    return load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/reference/" + name + ".toml").scene.value();
  }
  static Pose pose(const CsvTable& table, std::size_t row, const std::string& body) {
    const std::size_t c = table.find(body + ".x").value();
    return {Vec3(table.at(row, c), table.at(row, c + 1), table.at(row, c + 2)),
            Quat(table.at(row, c + 3), table.at(row, c + 4), table.at(row, c + 5), table.at(row, c + 6))
                .normalized()};
  }
  /// Returns kinetic plus potential energy, J.
  static double energy(const SceneConfig& scene, const CsvTable& table, std::size_t row) {
    double e = 0;
    for (const BodyConfig& body : scene.bodies) {
      const Pose X = pose(table, row, body.name);
      const std::size_t c = table.find(body.name + ".vx").value();
      const Vec3 v(table.at(row, c), table.at(row, c + 1), table.at(row, c + 2));
      const Vec3 w(table.at(row, c + 3), table.at(row, c + 4), table.at(row, c + 5));
      const Vec3 w_B = X.q.conjugate() * w;
      e += 0.5 * body.mass * v.squaredNorm() + 0.5 * w_B.dot(body.inertia * w_B) -
           body.mass * scene.gravity.dot(X.p);
    }
    return e;
  }
  static void print(const char* scene, const char* integrator, double step, const WorstError& e) {
    std::printf("%s, %s at %g ms: %.2g m, %.2g rad; joint drift %.2g m, %.2g rad\n", scene, integrator,
                1e3 * step, e.m, e.rad, e.drift_m, e.drift_rad);
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

TEST_F(ReferenceRuns, GrasperIsWithinBoundsAndConverges) {
  if (shared_file("reference").empty()) GTEST_SKIP() << "shared/reference is not here";
  const WorstError second = error_of("grasper", "tr-bdf2", 1e-3),
                   euler = error_of("grasper", "implicit-euler", 1e-3);
  print("grasper", "tr-bdf2", 1e-3, second);
  print("grasper", "implicit-euler", 1e-3, euler);
  EXPECT_LE(second.m, 5e-6);
  EXPECT_LE(second.drift_m, 1e-6);
  EXPECT_LE(second.drift_rad, 1e-5);
  EXPECT_LE(euler.m, 5e-5);
  EXPECT_LE(euler.drift_m, 5e-5);
  for (const auto& [integrator, wanted] : {std::pair{"implicit-euler", 0.9}, {"tr-bdf2", 1.9}}) {
    const WorstError coarse = error_of("grasper", integrator, 2e-3),
                     fine = error_of("grasper", integrator, 0.25e-3);
    EXPECT_GE(order(coarse.m, fine.m, 3), wanted) << integrator;
    EXPECT_GE(order(coarse.rad, fine.rad, 3), wanted) << integrator;
    std::printf("grasper, %s: orders %.2f in m, %.2f in rad\n", integrator, order(coarse.m, fine.m, 3),
                order(coarse.rad, fine.rad, 3));
  }
}

/// Chaotic after about a second, so errors are taken over the first half.
TEST_F(ReferenceRuns, ChainFollowsTheReferenceForHalfASecond) {
  if (shared_file("reference").empty()) GTEST_SKIP() << "shared/reference is not here";
  for (const auto& [integrator, wanted] : {std::pair{"implicit-euler", 0.9}, {"tr-bdf2", 1.9}}) {
    const WorstError coarse = error_of("chain-5", integrator, 0.2e-3, 0.5);
    const WorstError fine = error_of("chain-5", integrator, 0.05e-3, 0.5);
    print("chain-5", integrator, 0.2e-3, coarse);
    EXPECT_GE(order(coarse.m, fine.m, 2), wanted) << integrator;
    std::printf("chain-5, %s: order %.2f in m\n", integrator, order(coarse.m, fine.m, 2));
  }
}

TEST_F(ReferenceRuns, ChainKeepsItsEnergyAndEndsWhereTheReferenceDoes) {
  if (shared_file("reference").empty()) GTEST_SKIP() << "shared/reference is not here";
  const SceneConfig scene = scene_of("chain-5");
  const CsvTable reference = read_csv(shared_file("reference/chain-5/reference.csv").string()).table.value();
  struct Bound {
    const char* integrator;
    double energy_J, end_m;
  };
  for (const Bound& bound : {Bound{"implicit-euler", 0.15, 0.02}, {"tr-bdf2", 2e-4, 5e-5}}) {
    const CsvTable ours =
        run("chain-5", std::string("--step 1e-3 --duration 0.5 --integrator ") + bound.integrator);
    double worst = 0;
    std::size_t row = 0;
    for (; row < reference.num_rows() && reference.at(row, 0) <= 0.5 + 1e-9; ++row) {
      const auto at = static_cast<std::size_t>(std::llround(reference.at(row, 0) / 1e-3));
      worst = std::max(worst, std::abs(energy(scene, ours, at) - energy(scene, reference, row)));
    }
    const Vec3 end = pose(ours, ours.num_rows() - 1, "link4").p,
               expected = pose(reference, row - 1, "link4").p;
    EXPECT_LE(worst, bound.energy_J) << bound.integrator;
    EXPECT_LE((end - expected).norm(), bound.end_m) << bound.integrator;
    std::printf("chain-5, %s at 1 ms: energy within %.2g J, end within %.2g m at 0.5 s\n", bound.integrator,
                worst, (end - expected).norm());
  }
}

TEST_F(ReferenceRuns, HeavyTopIsBoundedAtOneMillisecondAndConvergesDownToATenth) {
  if (shared_file("reference").empty()) GTEST_SKIP() << "shared/reference is not here";
  for (const auto& [integrator, wanted] : {std::pair{"implicit-euler", 0.85}, {"tr-bdf2", 1.9}}) {
    const WorstError bounded = error_of("heavy-top", integrator, 1e-3);
    print("heavy-top", integrator, 1e-3, bounded);
    EXPECT_LE(bounded.m, 2 + bounded.drift_m);  // the top stays on its ball joint, 1 m from the origin
    EXPECT_LE(bounded.drift_m, 0.1);
    const WorstError coarse = error_of("heavy-top", integrator, 0.1e-3),
                     fine = error_of("heavy-top", integrator, 0.05e-3);
    print("heavy-top", integrator, 0.1e-3, coarse);
    EXPECT_GE(order(coarse.m, fine.m, 1), wanted) << integrator;
    std::printf("heavy-top, %s: order %.2f in m\n", integrator, order(coarse.m, fine.m, 1));
  }
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
}  // namespace godobject::test::test_reference_runs
