// Study of contacts: its measures on closed-form motions, and its results for the core.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "platform/scene/toml.h"
#include "tests/study/contact/imposed.h"
#include "tests/study/study.h"

namespace godobject::study::test_contact_study {
namespace {

void say_nothing(const std::string&) {}

/// Returns a ball of radius 1 cm that falls from a height and rebounds with half its speed, twice.
oracle::Solution ideal_bounces(double g, double height) {
  oracle::Solution solution;
  const auto sample = [&](double t, double z, double v) {
    oracle::RigidState x;
    x.p.z() = z + 0.01;
    x.v.z() = v;
    solution.times.push_back(t);
    solution.states.push_back({x});
  };
  double t_0 = 0, v_0 = 0, z_0 = height;
  for (int bounce = 0; bounce < 3; ++bounce) {
    const double flight = (v_0 + std::sqrt(v_0 * v_0 + 2 * g * z_0)) / g;
    for (double t = 1e-4; t < flight; t += 1e-4) sample(t_0 + t, z_0 + v_0 * t - g * t * t / 2, v_0 - g * t);
    t_0 += flight;
    sample(t_0, -1e-6, 0);
    v_0 = (g * flight - v_0) / 2;
    z_0 = 0;
  }
  return solution;
}

bench::ContactScene ball() {
  bench::ContactScene scene;
  scene.problem.gravity = Vec3(0, 0, -9.81);
  scene.problem.bodies.resize(1);
  scene.problem.bodies[0].m = 0.1;
  scene.centres = {Vec3::Zero()};
  scene.radius = 0.01;
  scene.law = {.k = 5000};
  return scene;
}

TEST(ContactCase, MeasuresTheFlightsOfABall) {
  const std::vector<Flight> found = flights(ball(), ideal_bounces(9.81, 0.04));
  ASSERT_EQ(found.size(), 3u);
  const double fall = std::sqrt(2 * 0.04 / 9.81);
  EXPECT_NEAR(found[0].apex, 0.04, 1e-9);
  EXPECT_NEAR(found[1].apex, 0.01, 1e-9);
  EXPECT_NEAR(found[2].apex, 0.0025, 1e-9);
  EXPECT_NEAR(found[0].landing, fall, 1e-9);
  EXPECT_NEAR(found[1].landing, 2 * fall, 1e-9);
  EXPECT_NEAR(restitution(found), 0.5, 1e-9);
  std::vector<Flight> higher = found;
  higher[1].apex *= 1.02;
  EXPECT_NEAR(worst_flight_error(higher, found), 0.02, 1e-9);
  higher.pop_back();
  EXPECT_TRUE(std::isinf(worst_flight_error(higher, found)));
}

TEST(ContactCase, PenetrationAndEnergyAreThoseOfTheSprings) {
  const bench::ContactScene scene = ball();
  oracle::RigidState x;
  x.p.z() = 0.008;
  x.v.z() = -2;
  EXPECT_NEAR(penetration(scene, x), 0.002, 1e-15);
  EXPECT_NEAR(mechanical_energy(scene, x, 0), 0.1 * 9.81 * 0.008 + 0.2 + 0.5 * 5000 * 0.002 * 0.002, 1e-12);
  x.p.z() = 0.02;
  EXPECT_EQ(penetration(scene, x), 0);
}

TEST(ContactErrorStudy, MeasuresThePressAndTheRestitutionThatIsLost) {
  const ContactErrors errors = study_contact_errors(contact_cases(), true, say_nothing);
  const ContactErrorRow* const press = find(errors.rows, "press", "implicit-euler", 1e-3);
  ASSERT_NE(press, nullptr);
  EXPECT_LT(press->position, 1e-4);
  EXPECT_GT(find(errors.rows, "press", "implicit-euler", 0.25e-3)->order.value(), 0.8);
  EXPECT_GT(find(errors.rows, "press", "tr-bdf2", 0.5e-3)->order.value(), 1.7);
  ASSERT_TRUE(errors.restitution_reference);
  const ContactErrorRow &first = *find(errors.rows, "bounce", "implicit-euler", 1e-3),
                        &second = *find(errors.rows, "bounce", "tr-bdf2", 0.25e-3);
  EXPECT_LT(first.restitution.value(), *errors.restitution_reference);
  EXPECT_NEAR(second.restitution.value(), *errors.restitution_reference, 0.02);
  EXPECT_LT(second.flight_error.value(), 0.02);
}

TEST(ContactStability, GainsNothingAtTheCornersOfTheMap) {
  for (const char* integrator : {"implicit-euler", "tr-bdf2"})
    for (const double k : {1e2, 1e9})
      for (const double damping : {0.0, 100.0}) {
        const ContactStability r = contact_gain(integrator, {.k = k, .damping = damping, .h = 5e-3});
        EXPECT_FALSE(r.failed) << integrator << ' ' << k << ' ' << damping;
        EXPECT_LT(r.gain, max_contact_gain) << integrator << ' ' << k << ' ' << damping;
      }
}

/// Figs. 5 and 6 of the paper: a brick placed at the device's pose ejects the others. Dragged slowly it only
/// presses them. Over starts some nm apart, the force on the pulled brick is 0.5 to 0.6 N. That on the placed
/// one depends on jammed bricks: 4.6 to 33 N. Contact depth depends on the start for both, therefore medians
/// are compared: 0.07 to 0.4 mm and 0.2 to 1 mm.
TEST(ImposedStudy, APlacedBrickPressesWhatAGodObjectPushes) {
  double pulled_force = 0, placed_force = 0;  // the worst of all
  std::vector<double> pulled_overlaps, placed_overlaps;
  for (int start = 0; start < 9; ++start) {
    LoadResult loaded = load_scene((default_scene_directory() / "lego.toml").string());
    ASSERT_TRUE(loaded.scene);
    for (std::size_t i = 0; i < loaded.scene->bodies.size(); ++i) {
      BodyConfig& brick = loaded.scene->bodies[i];
      if (!brick.coupling) brick.X_WB.p.x() += 1e-10 * start * static_cast<double>(i);
    }
    const double duration = 2;
    const PileRun pull = run_pile(*loaded.scene, CouplingMode::god_object, "", duration),
                  place = run_pile(*loaded.scene, CouplingMode::imposed, "", duration);
    EXPECT_EQ(pull.bricks, 61u);
    EXPECT_EQ(pull.samples.size(), 200u);
    EXPECT_EQ(pull.num_faults, 0u);
    EXPECT_EQ(pull.worst.ejected, 0u);
    EXPECT_GT(pull.worst.force, 0.01);
    pulled_force = std::max(pulled_force, pull.worst.force);
    pulled_overlaps.push_back(pull.worst.overlap);
    placed_force = std::max(placed_force, place.worst.force);
    placed_overlaps.push_back(place.worst.overlap);
  }
  EXPECT_GT(placed_force, 10 * pulled_force);
  for (auto* const overlaps : {&pulled_overlaps, &placed_overlaps}) std::ranges::sort(*overlaps);
  EXPECT_GT(placed_overlaps[4], 2 * pulled_overlaps[4]);
}

/// The device goes into the pile within 10 ms.
TEST(PlacedBrick, EjectsOthersInAPlungeAGodObjectDoesNot) {
  const SceneConfig scene = load_scene((default_scene_directory() / "lego.toml").string()).scene.value();
  const PileRun pull = run_pile(scene, both_couplings()[0], plunge_motion(), plunge_duration),
                place = run_pile(scene, both_couplings()[1], plunge_motion(), plunge_duration);
  EXPECT_EQ(pull.worst.ejected, 0u);
  EXPECT_LT(pull.worst.force, 30);
  EXPECT_LT(pull.worst.overlap, 5e-4);
  EXPECT_GT(place.worst.ejected, 0u);
  EXPECT_GT(place.worst.force, 10 * pull.worst.force);
  EXPECT_GT(place.worst.overlap, 10 * pull.worst.overlap);
  EXPECT_EQ(place.num_faults, 0u) << "the step solves the placed brick, too";
}

TEST(ImposedStudy, SaysWhatItCannotRead) {
  EXPECT_THROW(static_cast<void>(study_imposed("/nowhere", true, say_nothing)), std::runtime_error);
}

TEST(ContactCosts, ContactsCostDataAndOnlyWhereTheyAre) {
  InstructionCounter counter("/nowhere");
  std::string why_not;
  const std::vector<ContactCostRow> rows =
      study_contact_costs(default_probe_directory(), true, counter, say_nothing, why_not);
  if (rows.empty()) GTEST_SKIP() << why_not;
  std::size_t without = 0, with = 0;
  for (const ContactCostRow& r : rows) {
    if (r.size.composition == "bricks-64 implicit-euler") without = r.size.state_bytes;
    if (r.size.composition == "bricks-contacts-64 implicit-euler") with = r.size.state_bytes;
  }
  EXPECT_GT(without, 0u);
  EXPECT_GT(with, without);
}

}  // namespace
}  // namespace godobject::study::test_contact_study
