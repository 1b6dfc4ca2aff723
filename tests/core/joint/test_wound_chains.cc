// Counted turns of targets (16) in chains: links behind a wound one, and roots that are free.
#include <iostream>

#include "tests/core/joint/wound_tool.h"

namespace godobject::test_wound_chains {
namespace {

using namespace test_wound;

template <class I>
class WoundChains : public ::testing::Test {};
TYPED_TEST_SUITE(WoundChains, BothIntegrators);

/// A chain of two links. The first is wound against its stop, while the second bends about an axis at a slant
/// from the plane across that of the first.
template <class S>
void expect_chain_held(unsigned seed, int draws, Real slant) {
  Random random(seed);
  Real jump = 0, rest = 0, back = 0, depth = 0;
  for (int draw = 0; draw < draws; ++draw) {
    Winding t = Winding::random(random);
    t.is_stiff = false;
    t.k = std::min(t.k, t.inertia / (t.h * t.h));
    const Real k_r_2 = t.k_r * random.log_uniform(0.1, 1), bend = random.uniform(-1.5, 1.5);
    auto run = std::make_unique<Wound<S>>();
    run->par.h = t.h;
    run->q_WS = random.rotation();
    const Real around = random.uniform(0, 2 * pi);
    const Vec3 axis_2(std::cos(slant) * std::cos(around), std::cos(slant) * std::sin(around),
                      std::sin(slant));
    run->R_2 = turn_from_z(axis_2).toRotationMatrix();
    SCOPED_TRACE(testing::Message() << "draw " << draw << ' ' << t << " k_r_2 " << k_r_2 << " bend " << bend
                                    << " axis " << axis_2.transpose());
    run->add(0, all_turns[static_cast<std::size_t>(draw % 2)], t.inertia, t.k_r, t.zeta);
    run->add(1, all_turns[0], random.uniform(0.1, 1) * t.inertia, k_r_2, t.zeta);
    run->stop(0) = t.stop();
    run->start();
    const Real side = t.end > 0 ? 1 : -1;
    const Real all = t.k_r + k_r_2, g_r = run->par.bodies[0].coupling.g_r + run->par.bodies[1].coupling.g_r;
    const Real largest = all * std::abs(t.over) + g_r * (std::abs(t.rate) + std::abs(bend));
    const Real bound = t.depth(largest) + std::abs(t.rate) * (std::sqrt(4 * t.inertia / t.k) + t.h) +
                       t.width + t.h * t.h * largest / t.inertia;
    std::array<Vec3, 2> last{Vec3::Zero(), Vec3::Zero()};
    std::array<Real, 2> q_last{};
    const auto follow = [&](Real rate, Real rate_2) {
      run->follow({rate, rate_2});
      depth = std::max(depth, side * (run->q(0) - t.end) / bound);
      const Real moved = std::abs(run->q(0) - q_last[0]) + std::abs(run->q(1) - q_last[1]) +
                         t.h * (std::abs(rate) + std::abs(rate_2));
      for (std::size_t i = 0; i < 2; ++i) {
        const Vec3 tau = run->spring_torque(i) / run->par.bodies[i].coupling.k_r;
        jump = std::max(jump, (tau - last[i]).norm() - (2 + tau.norm()) * moved);
        last[i] = tau;
        q_last[i] = run->q(i);
      }
    };
    for (int n = 0; n < t.steps(); ++n) follow(t.rate, bend / (t.steps() * t.h));
    for (int n = 0; n < 3 * t.steps_at_rest(); ++n) follow(0, 0);
    const Real ahead = run->target[0] - run->q(0), ahead_2 = run->target[1] - run->q(1);
    if (slant == 0) rest = std::max(rest, std::abs(run->spring_torque(1).z() / (k_r_2 * ahead) - 1));
    // both turn about one axis: the second follows its target, whose turns are those of both
    if (slant == pi / 2) rest = std::max(rest, std::abs(ahead + ahead_2));
    for (int n = 0; n < t.steps(); ++n) follow(-t.rate, -bend / (t.steps() * t.h));
    for (int n = 0; n < 3 * t.steps_at_rest(); ++n) follow(0, 0);
    back = std::max({back, std::abs(run->q(0) - run->target[0]), std::abs(run->q(1) - run->target[1])});
    EXPECT_FALSE(run->balance.gains());
    ASSERT_LT(depth, 1);
    // a side that is kept beyond the half turn changes at another axis
    ASSERT_LT(jump, 2 * pi * half_turn_band);
    ASSERT_LT(rest, 1e-6);
    ASSERT_LT(back, 1e-3);
  }
  std::cout << S::Integrator::name << ", slant " << slant << ": depth " << depth
            << " of its bound, jump of the torque / k_r " << jump << " rad, at rest " << rest << ", back to "
            << back << " rad\n";
}

TYPED_TEST(WoundChains, PressChainsAcross) {
  expect_chain_held<Tool<TypeParam, 2>>(4, 30, 0);
  expect_chain_held<Tool<TypeParam, 5>>(5, 30, 0);
}
TYPED_TEST(WoundChains, PressChainsAlong) { expect_chain_held<Tool<TypeParam, 5>>(6, 30, pi / 2); }
TYPED_TEST(WoundChains, PressChainsAslant) { expect_chain_held<Tool<TypeParam, 5>>(7, 30, 0.7); }

/// A chain on a root that is free or on a ball joint. Its second link is wound on its stop while the targets
/// of the whole tool turn about any axis and back.
TYPED_TEST(WoundChains, OfAToolThatTurnsComeBack) {
  using S = Tool<TypeParam, 5>;
  Random random(9);
  for (int draw = 0; draw < 20; ++draw) {
    auto run = std::make_unique<Running<S>>();
    auto& par = run->par;
    par.num_bodies = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      auto& body = par.bodies[i];
      body.body = rigid_body(0.1, 1e-3 * Vec3(1, 1.3, 0.8).asDiagonal());
      body.coupling = spring(body.body, 1000, i == 0 ? 20 : 3);
      body.device = {.rise = 0, .lost = 0.02};
      body.joint.kind = i > 0 ? JointKind::hinge : draw % 2 == 0 ? JointKind::ball : JointKind::free;
      body.joint.parent = i == 0 ? world : i - 1;
    }
    par.bodies[1].joint.stop.stops[0] = {.lower = -2, .upper = 2, .k = 300, .g = 0.05, .width = 0.02};
    const Quat q_12 = random.rotation();
    par.bodies[2].joint.P.R = q_12.toRotationMatrix();
    const Vec3 axis = random.direction();
    const Real far = random.uniform(2, 14), turn = random.uniform(1, 7);
    const auto aim = [&](Real wound, Real turned) {
      const Quat q_0(Eigen::AngleAxis<Real>(turn * turned, axis));
      const Quat q_1 = q_0 * Quat(Eigen::AngleAxis<Real>(far * wound, Vec3::UnitZ()));
      run->in.devices[0].target.X_WD.q = q_0;
      run->in.devices[1].target.X_WD.q = q_1;
      run->in.devices[2].target.X_WD.q = q_1 * q_12;
    };
    aim(0, 0);
    for (std::size_t i = 0; i < 3; ++i) {
      const Pose& X_WD = run->in.devices[i].target.X_WD;
      place<S>(run->x, i, {.X_WB = X_WD, .V_WB = {}});
      engage_at<S>(run->x, i, {.X_WD = X_WD, .V_WD = {}});
    }
    start_turns(par, run->x);
    EnergyBalance<S> balance;
    balance.start(par, run->x);
    for (int n = 0; n < 9000; ++n) {
      const Real t = n * par.h;
      aim(std::clamp(t < 4.5 ? t / 2 : (8 - t) / 2, Real(0), Real(1)),
          std::clamp(t < 4.5 ? (t - 2) / 2 : (Real(6.5) - t) / 2, Real(0), Real(1)));
      run->step();
      balance.observe(par, run->x, run->w, run->out);
      ASSERT_FALSE(any(run->out.fault));
    }
    EXPECT_FALSE(balance.gains());
    for (std::size_t i = 1; i < 3; ++i) EXPECT_NEAR(run->x.bodies[i].joint.q[0], 0, 1e-9) << draw;
  }
}

}  // namespace
}  // namespace godobject::test_wound_chains
