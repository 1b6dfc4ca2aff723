// The scenes of ../shared/attacks behave correctly, and so do many random variants of each.
#include "tests/platform/session/attacked.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <sstream>

#include "platform/scene/checks.h"
#include "tests/support/box_overlap.h"

namespace godobject::test_attack_scenes {
namespace {

#ifdef NDEBUG
constexpr unsigned num_variants = 30;
#else
constexpr unsigned num_variants = 2;  // builds with assertions and sanitizers take a hundred times as long
#endif

/// Returns the name of a scene for messages.
std::string label(const SceneConfig& scene, const std::string& name, unsigned seed) {
  std::ostringstream text;
  text << name << ", seed " << seed << ": " << scene.integrator << ", step " << scene.step << ", masses";
  for (const BodyConfig& body : scene.bodies) text << ' ' << body.mass;
  if (scene.bodies[0].coupling) text << ", coupling " << scene.bodies[0].coupling->k;
  if (!scene.contacts.empty()) text << ", contact " << scene.contacts[0].law.k;
  return text.str();
}

constexpr const char* no_attacks = "no attacks/ in the shared folder";

/// Expects energy not to increase, joints to hold, and no fault. most_gain: limit as a share of the largest
/// kinetic energy.
void keeps(const SceneConfig& scene, double seconds, double most_gain, double most_drift,
           const std::string& what, Course& worst) {
  const Course c = course_of(scene, seconds);
  EXPECT_FALSE(any(c.fault)) << what;
  EXPECT_LT(c.gained(), most_gain) << what;
  EXPECT_LT(c.drift, most_drift) << what;
  if (c.gained() > worst.gained()) worst.gain = c.gain, worst.moving = c.moving;
  worst.drift = std::max(worst.drift, c.drift);
}

class HeavyEnds : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(AttackScenes, HeavyEnds,
                         testing::Values("heavy-end-chain3-10000-tr-bdf2", "heavy-end-chain4-500-tr-bdf2",
                                         "heavy-end-chain5-2000-implicit-euler",
                                         "heavy-end-chain5-500-implicit-euler"));

TEST_P(HeavyEnds, GainNothingAndHold) {
  const auto original = attack(GetParam());
  if (!original) GTEST_SKIP() << no_attacks;
  Course worst;
  keeps(*original, original->duration, 1e-3, 1e-5, GetParam(), worst);
  for (unsigned seed = 0; seed < num_variants; ++seed) {
    Random random(seed);
    SceneConfig scene = *original;
    scene.integrator = any_integrator(random);
    scene.step = random.log_uniform(2e-4, 3e-3);
    BodyConfig& end = scene.bodies.back();
    const double heavier = random.log_uniform(1, 2e4) * scene.bodies[0].mass / end.mass;
    end.mass *= heavier;
    end.inertia *= heavier;
    turn(scene, random.rotation());
    keeps(scene, 5, 1e-3, 1e-5, label(scene, GetParam(), seed), worst);
  }
  std::printf("%s: gain %.1e, drift %.1e m\n", GetParam(), worst.gained(), worst.drift);
}

class Chatter : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(AttackScenes, Chatter,
                         testing::Values("chatter-box-1e3", "chatter-box-1e4", "chatter-velocity-tr-bdf2",
                                         "chatter-wedge"));

/// Expects the scene at rest, and the supporting contact reported.
void rests(const SceneConfig& scene, double seconds, const std::string& what, double& worst) {
  double after = 0;
  const CycleRecord end = attacked(scene, Motion(scene), seconds, [&](const CycleRecord& r) {
    if (r.t > seconds - 20.5 * scene.step) after = std::max(after, fastest(r));
  });
  EXPECT_LT(after, 1e-9) << what;
  EXPECT_FALSE(any(end.fault)) << what;
  EXPECT_GT(end.contacts.num_contacts, 0u) << what;
  EXPECT_GT(end.contacts.deepest, 0) << what;
  EXPECT_GT(end.bodies[0].contact_W.f.norm(), 0) << what;
  worst = std::max(worst, after);
}

TEST_P(Chatter, RestsAndSaysWhatItTouches) {
  const auto original = attack(GetParam());
  if (!original) GTEST_SKIP() << no_attacks;
  double worst = 0;
  rests(*original, original->duration, GetParam(), worst);
  for (unsigned seed = 0; seed < num_variants; ++seed) {
    Random random(seed);
    SceneConfig scene = *original;
    BodyConfig& body = scene.bodies[0];
    scene.integrator = any_integrator(random);
    scene.step = random.log_uniform(1e-4, 5e-3);
    const double k_c = random.log_uniform(1e2, 1e6), r = random.log_uniform(1e-4, 9e-3);
    set_stiffness(body, k_c, 1e-3 * k_c);
    set_contact(scene, random.log_uniform(1e3, 1e9), 1.4, random.integer(0, 2) * random.uniform(0, 0.5));
    for (SphereConfig& sphere : body.spheres) {
      const Vec3 half = sphere.p_B.cwiseAbs() + Vec3::Constant(sphere.radius);
      sphere.p_B = sphere.p_B.cwiseSign().cwiseProduct(half - Vec3::Constant(r));
      sphere.radius = r;
    }
    scene.motion->X_WD.p = Vec3(0, 0, -random.log_uniform(1e-3, 1));
    rests(scene, original->duration + 1, label(scene, GetParam(), seed), worst);
  }
  std::printf("%s: %.1e m/s at most\n", GetParam(), worst);
}

/// Returns a motion with each body's target at rest.
Motion resting_at(const SceneConfig& scene, const std::vector<Pose>& targets) {
  std::ostringstream csv;
  csv.precision(17);
  csv << "t";
  for (const BodyConfig& body : scene.bodies)
    for (const char* column : {"x", "y", "z", "qw", "qx", "qy", "qz"})
      csv << ',' << body.name << '.' << column;
  for (const double t : {0, 100}) {
    csv << '\n' << t;
    for (const Pose& X : targets)
      for (const double v : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}) csv << ',' << v;
  }
  MotionResult read = Motion::parse(csv.str() + '\n', "resting.csv", scene);
  EXPECT_THAT(read.errors, testing::IsEmpty());
  return read.motion.value();
}

TEST(AttackScenes, ContradictedTreesRest) {
  const auto original = attack("contradicted-tree");
  if (!original) GTEST_SKIP() << no_attacks;
  const std::string motion = test::shared_file("attacks/contradicted-tree.csv").string();
  EXPECT_LT(
      fastest(attacked(*original, *Motion::read(motion, *original).motion, original->duration, [](auto&) {})),
      1e-6);
  double worst = 0;
  for (unsigned seed = 0; seed < num_variants; ++seed) {
    Random random(seed);
    SceneConfig scene = *original;
    scene.integrator = any_integrator(random);
    scene.step = random.log_uniform(2e-4, 5e-3);
    const double off = random.log_uniform(0.03, 3) * 0.1;
    std::vector<Pose> targets;
    for (BodyConfig& body : scene.bodies) {
      const double k = random.log_uniform(1e3, 1e8), heavier = random.log_uniform(0.1, 10);
      body.mass *= heavier;
      body.inertia *= heavier;
      set_stiffness(body, k, 1e-3 * k);
      targets.push_back({.p = body.X_WB.p + off * random.direction(), .q = random.rotation()});
    }
    const CycleRecord end = attacked(scene, resting_at(scene, targets), 4, [](auto&) {});
    const std::string what = label(scene, "contradicted-tree", seed);
    EXPECT_FALSE(any(end.fault)) << what;
    EXPECT_LT(fastest(end), 1e-6) << what;
    EXPECT_LT(joint_drift(scene, end), 1e-6) << what;
    worst = std::max(worst, fastest(end));
  }
  std::printf("contradicted trees: %.1e m/s at most\n", worst);
}

TEST(AttackScenes, NothingPassesTheEdgeOfABox) {
  const auto original = attack("tunnel-box-edge");
  if (!original) GTEST_SKIP() << no_attacks;
  EXPECT_GT(attacked(*original, Motion(*original), original->duration, [](auto&) {}).bodies[0].X_WB.p.z(),
            0.03);
  for (unsigned seed = 0; seed < 3 * num_variants; ++seed) {
    Random random(seed);
    SceneConfig scene = *original;
    BodyConfig& ball = scene.bodies[0];
    scene.integrator = any_integrator(random);
    scene.step = random.log_uniform(1e-4, 5e-3);
    const double r = random.log_uniform(1e-3, 0.01), a = 0.05, inside = random.log_uniform(1e-4, 0.05);
    ball.spheres.at(0).radius = r;
    ball.mass = random.log_uniform(0.01, 1);
    ball.inertia = 0.4 * ball.mass * r * r * Mat3::Identity();
    scene.obstacles.at(0).shape.half_extents = Vec3(a, a, random.log_uniform(0.005, 0.05));
    const double top = scene.obstacles[0].shape.half_extents->z();
    set_contact(scene, random.log_uniform(1e4, 1e9), 1.4, 0.3);
    const double speed = random.log_uniform(0.02, 0.95) * top_speed(scene)->top();
    ball.X_WB.p =
        Vec3(a - inside, random.uniform(-a, a), top + r + speed * scene.step * random.uniform(0.01, 3));
    ball.V_WB.v = Vec3(0, 0, -speed);
    double lowest = 1;
    const double seconds =
        std::min(20 * scene.step + 20 * std::sqrt(ball.mass / scene.contacts[0].law.k), 2.0);
    attacked(scene, Motion(scene), seconds,
             [&](const CycleRecord& r) { lowest = std::min(lowest, r.bodies[0].X_WB.p.z()); });
    EXPECT_GT(lowest, 0) << label(scene, "tunnel-box-edge", seed) << ", " << speed << " m/s, " << inside
                         << " m inside";
  }
}

box_overlap::PosedBox box_of(const SceneConfig& scene, const CycleRecord& r, std::size_t i) {
  const Pose& X = r.bodies[i].X_WB;
  return {.p = X.p, .h = *scene.bodies[i].shapes.at(0).half_extents, .R = X.q.toRotationMatrix()};
}

TEST(AttackScenes, LockedPairsPart) {
  const auto original = attack("locked-pair");
  if (!original) GTEST_SKIP() << no_attacks;
  double fast = 0;
  const auto parts = [&](const SceneConfig& scene, const std::string& what) {
    const CycleRecord end = attacked(scene, Motion(scene), original->duration,
                                     [&](const CycleRecord& r) { fast = std::max(fast, fastest(r)); });
    // depth of contact is at most the radius of the spheres at the corners
    EXPECT_TRUE(any(end.fault) || box_overlap::overlap(box_of(scene, end, 0), box_of(scene, end, 1)) < 1e-4)
        << what;
  };
  parts(*original, "locked-pair");
  for (unsigned seed = 0; seed < num_variants; ++seed) {
    Random random(seed);
    SceneConfig scene = *original;
    scene.integrator = any_integrator(random);
    scene.step = random.log_uniform(2.5e-4, 5e-3);
    set_contact(scene, random.log_uniform(1e3, 1e6), 1.4, 0.3);
    for (BodyConfig& body : scene.bodies) body.X_WB.q = random.rotation();
    scene.bodies[1].X_WB.p = random.uniform(0, 0.015) * random.direction();
    parts(scene, label(scene, "locked-pair", seed));
  }
  std::printf("locked pairs: %.2g m/s at most\n", fast);
}

TEST(AttackScenes, SparseMotionsDoNotOvershoot) {
  const auto original = attack("ramp_sparse");
  if (!original) GTEST_SKIP() << no_attacks;
  double most = 0;
  const auto stays = [&](Motion motion, double from, double to, const std::string& what) {
    const double way = to - from;
    attacked(*original, std::move(motion), original->duration, [&](const CycleRecord& r) {
      const double x = (r.bodies[0].target.X_WD.p.x() - from) / way;
      EXPECT_GE(x, -1e-9) << what;
      EXPECT_LE(x, 1 + 1e-9) << what;
      most = std::max(most, (r.bodies[0].X_WB.p.x() - from) / way);
    });
  };
  stays(*Motion::read(test::shared_file("attacks/ramp_sparse.csv").string(), *original).motion, 0, 0.01,
        "ramp_sparse");
  for (unsigned seed = 0; seed < num_variants; ++seed) {
    Random random(seed);
    const double begin = random.uniform(0.3, 1), takes = random.log_uniform(1e-3, 0.5),
                 way = random.log_uniform(1e-3, 1);
    std::ostringstream csv;
    csv << "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz";
    csv.precision(17);
    for (const auto& [t, x] : {std::pair{0.0, 0.0}, {begin, 0.0}, {begin + takes, way}, {10.0, way}})
      csv << '\n' << t << ',' << x << ",0,0,1,0,0,0";
    stays(*Motion::parse(csv.str() + '\n', "ramp.csv", *original).motion, 0, way,
          "seed " + std::to_string(seed));
  }
  std::printf("sparse motions: the tool goes to %.3f of the way\n", most);
}

class Thrown : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(AttackScenes, Thrown, testing::Values("thrown-1286", "thrown-65"));

TEST_P(Thrown, ToolsGainNothingAndHold) {
  const auto original = attack(GetParam());
  if (!original) GTEST_SKIP() << no_attacks;
  Course worst;
  keeps(*original, original->duration, 1e-3, 1e-5, GetParam(), worst);
  for (unsigned seed = 0; seed < num_variants; ++seed) {
    Random random(seed);
    SceneConfig scene = *original;
    scene.integrator = any_integrator(random);
    scene.step = random.log_uniform(2e-4, 3e-3);
    for (BodyConfig& body : scene.bodies) {
      const double heavier = random.log_uniform(0.3, 30);
      body.mass *= heavier;
      body.inertia *= heavier;
    }
    set_contact(scene, random.log_uniform(1e3, 1e9), random.integer(0, 1) * 1.4, random.uniform(0, 0.8));
    const Vec3 p = scene.bodies[0].X_WB.p;
    for (BodyConfig& body : scene.bodies) body.X_WB.p -= p;
    turn(scene, random.rotation());
    for (BodyConfig& body : scene.bodies) body.X_WB.p += p;
    keeps(scene, 1.2, 3e-2, 1e-4, label(scene, GetParam(), seed), worst);
  }
  std::printf("%s: gain %.1e, drift %.1e m\n", GetParam(), worst.gained(), worst.drift);
}

TEST(AttackScenes, NineLinksRunWithAndWithoutAPlane) {
  for (const char* name : {"needle9", "needle9c"}) {
    const auto original = attack(name);
    if (!original) GTEST_SKIP() << no_attacks;
    for (const char* integrator : integrator_names) {
      SceneConfig scene = *original;
      scene.integrator = integrator;
      const Course c = course_of(scene, scene.duration);
      EXPECT_FALSE(any(c.fault)) << name;
      EXPECT_LT(c.drift, 1e-5) << name;
    }
  }
}

}  // namespace
}  // namespace godobject::test_attack_scenes
