// Passive tools do not gain energy, joints included: random tools, long chains; separated joints are closed.
#include <iostream>
#include <memory>

#include "tests/core/joint/grasper_tool.h"
#include "tests/core/joint/random_tool.h"
#include "tests/core/joint/usual_scene.h"

namespace godobject::test_tool_energy {
namespace {

template <class I>
class ToolEnergy : public ::testing::Test {};
TYPED_TEST_SUITE(ToolEnergy, BothIntegrators);

/// Targets at rest where the bodies stand, or up to `jump` of the tool's size and `jump` rad beside.
template <Scene S>
void rest_targets(Running<S>& run, Real size, Real jump, Random& random) {
  for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
    Target target{.X_WD = run.x.bodies[i].x.X_WB, .V_WD = {}};
    target.X_WD.p += size * jump * random.direction();
    target.X_WD.q = exp_so3(Vec3(jump * random.direction())) * target.X_WD.q;
    engage_at<S>(run.x, i, target);
    run.in.devices[i].target.X_WD = target.X_WD;
  }
}

template <Scene S>
Real fastest_turn(const Running<S>& run) {
  Real w = 0;
  for (std::size_t i = 0; i < run.par.num_bodies; ++i) w = std::max(w, run.x.bodies[i].x.w_B.norm());
  return run.par.h * w;
}

/// Energy never above that of the start, but for rounding.
template <Scene S>
testing::AssertionResult gains_nothing(Running<S>& run, int steps) {
  const Real first = energy(run.par, run.x);
  for (int n = 0; n < steps; ++n) {
    run.step();
    if (any(run.out.fault)) return testing::AssertionFailure() << "fault in step " << n;
    const Real now = energy(run.par, run.x);
    if (!(now <= (1 + 1e-9) * first))
      return testing::AssertionFailure() << "step " << n << ": " << first << " J to " << now << " J";
  }
  return testing::AssertionSuccess();
}

/// Free tools that turn by up to 0.05 rad in a step (beyond, the joints' curvature may feed energy in).
TEST(ToolEnergyOfImplicitEuler, FreeToolsGainNothing) {
  Random random(1);
  int moving = 0;
  for (int n = 0; n < 3000; ++n) {
    Running<Articulated<ImplicitEuler>> run;
    run.par.h = random.log_uniform(1e-4, 1e-2);
    run.par.num_bodies = static_cast<std::size_t>(random.integer(2, 8));
    const Real size = random.log_uniform(1e-3, 1);
    for (std::size_t i = 0; i < run.par.num_bodies; ++i) add_random_body(run.par, i, size, random);
    place_randomly(run.par, run.x, size, random.log_uniform(1e-4, 5e-2) / run.par.h, random);
    rest_targets(run, size, 0, random);
    const Real turn = fastest_turn(run);
    if (turn == 0 || turn > 0.05) continue;
    ++moving;
    ASSERT_TRUE(gains_nothing(run, 100)) << "case " << n << ", " << turn << " rad per step";
  }
  EXPECT_GT(moving, 1000);
}

/// Tools released beside their targets, at any stiffness and damping, bodies up to 1000 times heavier than
/// others.
TEST(ToolEnergyOfImplicitEuler, CoupledToolsGainNothing) {
  Random random(2);
  for (int n = 0; n < 3000; ++n) {
    Running<Articulated<ImplicitEuler>> run;
    run.par.h = random.log_uniform(1e-4, 1e-2);
    run.par.num_bodies = static_cast<std::size_t>(random.integer(1, 8));
    const Real size = random.log_uniform(1e-3, 1), k = random.log_uniform(1, 1e10);
    for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
      add_random_body(run.par, i, size, random);
      const RigidBodyParams& body = run.par.bodies[i].body;
      const Real k_r = k * principal_moments(body.I_B).z() / body.m;
      run.par.bodies[i].coupling = spring(body, k, k_r, random.log_uniform(0.1, 10));
    }
    place_randomly(run.par, run.x, size, 0, random);
    rest_targets(run, size, random.log_uniform(1e-3, 0.1), random);
    ASSERT_TRUE(gains_nothing(run, 100)) << "case " << n << ", k " << k << ", h " << run.par.h;
  }
}

/// Targets so far from the reach of the joints that attitudes are off by up to half a turn. Joints are
/// violated for a while, and the energy does not grow repeatedly.
TYPED_TEST(ToolEnergy, TargetsFarOffLeaveTheToolBounded) {
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    Running<Articulated<TypeParam>> run;
    run.par.num_bodies = static_cast<std::size_t>(random.integer(1, 8));
    constexpr Real size = 0.1;
    const Real k = random.log_uniform(1, 1e10);
    for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
      add_random_body(run.par, i, size, random);
      const RigidBodyParams& body = run.par.bodies[i].body;
      run.par.bodies[i].coupling = spring(body, k, k * principal_moments(body.I_B).z() / body.m);
    }
    place_randomly(run.par, run.x, size, 0, random);
    rest_targets(run, size, random.uniform(0.3, 3), random);
    const Real first = energy(run.par, run.x);
    for (int step = 0; step < 300; ++step) {
      run.step();
      ASSERT_FALSE(any(run.out.fault)) << "case " << n;
      ASSERT_LT(energy(run.par, run.x), 100 * first) << "case " << n << ", step " << step << ", k " << k;
    }
  }
}

/// 256 links on ball joints at an angle to the vertical, the last one 1000 times heavier.
template <class I>
Running<Articulated<I, TreeJoints<>, 256>> heavy_chain(Real angle) {
  constexpr std::size_t links = 256;
  constexpr Real length = 0.1;
  using S = Articulated<I, TreeJoints<>, links>;
  Running<S> run;
  run.par.num_bodies = links;
  run.par.gravity_W = Vec3(0, 0, -9.81);
  const Quat q = exp_so3(Vec3(angle, 0, 0));
  const Vec3 down = q * Vec3(0, 0, -1);
  for (std::size_t i = 0; i < links; ++i) {
    const Real share = i + 1 == links ? 1000 : 1;
    BodyParams<S>& b = run.par.bodies[i];
    b.body = rigid_body(share * 0.1, share * Vec3(8.333e-5, 8.333e-5, 5e-6).asDiagonal());
    b.joint.kind = JointKind::ball;
    b.joint.parent = i == 0 ? world : i - 1;
    b.joint.P.p = i == 0 ? Vec3(0, 0, 0) : Vec3(0, 0, -length / 2);
    b.joint.C.p = Vec3(0, 0, length / 2);
    const Real depth = (static_cast<Real>(i) + 0.5) * length;
    place<S>(run.x, i, {.X_WB = {.p = depth * down, .q = q}, .V_WB = {}});
    engage_at<S>(run.x, i, {.X_WD = run.x.bodies[i].x.X_WB, .V_WD = {}});
    run.in.devices[i].target.X_WD = run.x.bodies[i].x.X_WB;
  }
  return run;
}

TYPED_TEST(ToolEnergy, HeavyChainHangsStill) {
  const auto run =
      std::make_unique<Running<Articulated<TypeParam, TreeJoints<>, 256>>>(heavy_chain<TypeParam>(0));
  for (int n = 0; n < 2000; ++n) run->step();
  EXPECT_EQ(run->x.tick, 2000u);
  EXPECT_LT(drift(run->par, run->x).m, 1e-9);
  EXPECT_LT(kinetic_energy(run->par, run->x), 1e-12);
  for (const std::size_t i : {0u, 100u, 255u}) {
    const Real carried = (static_cast<Real>(255 - i) * 0.1 + 100) * 9.81;
    EXPECT_NEAR(run->out.bodies[i].joint.F_C.f.z(), carried, 1e-7 * carried) << i;
  }
}

TYPED_TEST(ToolEnergy, HeavyChainSwings) {
  const auto run =
      std::make_unique<Running<Articulated<TypeParam, TreeJoints<>, 256>>>(heavy_chain<TypeParam>(pi / 4));
  const Real first = energy(run->par, run->x);
  Drift worst_drift;
  Real highest = first;
  for (int n = 0; n < 3000; ++n) {
    run->step();
    ASSERT_FALSE(any(run->out.fault));
    worst_drift = worst(worst_drift, drift(run->par, run->x));
    highest = std::max(highest, energy(run->par, run->x));
  }
  const Real fallen = kinetic_energy(run->par, run->x);
  std::cout << TypeParam::name << ": chain drift " << worst_drift.m << " m, kinetic energy " << fallen
            << " J, energy rises by " << highest - first << " J\n";
  EXPECT_LT(worst_drift.m, 1e-6);
  EXPECT_GT(fallen, 1000);  // it moves
  EXPECT_LT(highest - first, 1e-6 * fallen);
}

/// How far a violation has gone beyond zero, by its size, turns counted on the tool's radius of 0.1 m.
Real overshoot(const Twist& e, const Twist& first) {
  constexpr Real radius_sq = 0.01;
  const Real size_sq = radius_sq * first.w.squaredNorm() + first.v.squaredNorm();
  return size_sq > 1e-12 ? -(radius_sq * e.w.dot(first.w) + e.v.dot(first.v)) / size_sq : 0;
}

/// Bodies put beside their joints are pulled together at once, and stay.
template <class I>
void expect_pulled_together(std::size_t body, const Pose& apart, Real h, Real stiffness) {
  GrasperTool<I> tool({.h = h, .stiffness = stiffness, .motion = GrasperMotion::at_rest()});
  Pose& X = tool.x.bodies[body].x.X_WB;
  X = {.p = X.p + apart.p, .q = apart.q * X.q};
  std::array<Twist, 4> first;
  for (std::size_t i = 0; i < 4; ++i) first[i] = violation(tool.par, tool.x, i);
  Real beyond = 0;
  for (int n = 0; n < 300; ++n) {
    tool.step();
    ASSERT_FALSE(any(tool.out.fault));
    for (std::size_t i = 0; i < 4; ++i)
      beyond = std::max(beyond, overshoot(violation(tool.par, tool.x, i), first[i]));
  }
  EXPECT_LE(beyond, 0.1) << "body " << body << ", h " << h << ", stiffness " << stiffness << ", turn "
                         << 2 * apart.q.vec().transpose();
  EXPECT_LT(tool.drift().m, 1e-6);
  EXPECT_LT(tool.drift().rad, 1e-4);
}

constexpr std::array directions{std::array{1.0, 0.0, 0.0}, std::array{0.0, 1.0, 0.0},
                                std::array{0.0, 0.0, 1.0}, std::array{0.6, 0.48, 0.64}};

template <class I>
void expect_all_pulled_together(Real shift, Real turn) {
  for (const Real h : {1e-4, 1e-3, 1e-2})
    for (const Real stiffness : {0.0, 1e3, 1e7})
      for (std::size_t body = 0; body < 4; ++body)
        for (const auto& [x, y, z] : directions) {
          const Vec3 u(x, y, z);
          expect_pulled_together<I>(body, {.p = shift * u, .q = exp_so3(Vec3(turn * u))}, h, stiffness);
        }
}

TYPED_TEST(ToolEnergy, JointsACentimetreApartArePulledTogetherWithoutOvershoot) {
  expect_all_pulled_together<TypeParam>(0.01, 0);
}

TYPED_TEST(ToolEnergy, JointsTurnedApartArePulledTogetherWithoutOvershoot) {
  expect_all_pulled_together<TypeParam>(0, 0.3);
}

}  // namespace
}  // namespace godobject::test_tool_energy
