// Nets attached to bodies other than their carriers: against the oracle, at rest, and by the displayed
// wrench.
#include <gtest/gtest.h>

#include "tests/core/net/oracle_net.h"
#include "tests/core/net/usual_scene.h"
#include "tests/oracle/solve.h"
#include "tests/oracle/target.h"
#include "tests/study/joint/oracle_joint.h"

namespace godobject::test_net_attached {
namespace {

inline constexpr Real spacing = 0.01, duration = 0.128;  // m, s
inline constexpr std::uint32_t side = 4;
inline constexpr Stuff sheet{.m = 2e-3, .k = 40, .g = 0.05, .k_a = 8, .g_a = 0.02, .carrier = 0};

enum class Carrier : std::uint8_t { hand, hand_and_hinge, world, no_anchor };

/// Joins the second body to the world.
inline oracle::Joint hinge() {
  oracle::Joint joint;
  joint.type = oracle::JointType::hinge;
  joint.child = 2;
  joint.anchor_P = Vec3(0.05, 0, -0.008);
  joint.anchor_C = Vec3(0.02, 0, 0);
  joint.axis_P = Vec3::UnitY();
  return joint;
}

/// A sheet that the hand sways or that lies in the scene, two corners of it sewn to a body, two to another.
template <class I>
struct Sewn : Running<AttachedNetScene<I>> {
  Sewn(Carrier carrier, Real h) {
    auto& par = this->par;
    par.h = h;
    par.gravity_W = Vec3(1, 2, -9.81);
    par.num_bodies = 3;
    const Vec3 at[] = {Vec3::Zero(), Vec3(-0.03, 0.002, -0.01), Vec3(0.03, 0, -0.008)};
    for (std::size_t i = 0; i < 3; ++i) {
      par.bodies[i].body = rigid_body(i == 0 ? 0.05 : 0.02, Vec3(1e-5, 1.5e-5, 2e-5).asDiagonal());
      place(this->x, i, {.X_WB = {.p = at[i], .q = exp_so3(Vec3(0.3, -0.2, 0.1))}, .V_WB = {}});
      this->in.devices[i] = {};
    }
    if (carrier == Carrier::hand_and_hinge) {
      place(this->x, 2, {.X_WB = {.p = at[2]}, .V_WB = {}});
      static_cast<JointParams&>(par.bodies[2].joint) = joint_params(hinge());
    }
    par.bodies[0].coupling = {.k = 200, .g = 4, .k_r = 0.05, .g_r = 1e-3};
    par.bodies[0].device.rise = 0;
    Stuff stuff = sheet;
    const bool on_hand = carrier == Carrier::hand || carrier == Carrier::hand_and_hinge;
    if (!on_hand) stuff.carrier = world;
    if (carrier == Carrier::no_anchor) stuff.k_a = stuff.g_a = 0;
    add_sheet(par, stuff, side, side, spacing);
    place_net(par.net, this->x);
    engage_at(this->x, 0, target(0));
    attach(par, this->x, 0, 1, 60, 0.05);
    attach(par, this->x, side * (side - 1), 1, 60, 0.05);
    attach(par, this->x, side - 1, 2, 30, 0.02);
    attach(par, this->x, side * side - 1, 2, 30, 0.02);
    if (validate(par) != Invalid::nothing) throw std::runtime_error("invalid");
  }
  void solve_tightly() {
    this->par.net.max_iterations = 2000;
    this->par.net.tolerance = 1e-13 / (this->par.h * this->par.h);
  }
  Target target(Real t) const {
    const Real omega = 2 * pi * 5, s = 1 - std::cos(omega * t), ds = omega * std::sin(omega * t);
    const Vec3 by(4e-3, -3e-3, 5e-3), turn(0, 0, 0.1);
    const Quat q = exp_so3(Vec3(0.3, -0.2, 0.1));
    return {.X_WD = {.p = s * by, .q = exp_so3(Vec3(s * turn)) * q}, .V_WD = {.w = ds * turn, .v = ds * by}};
  }
  std::vector<Vec3> moved() {
    for (long n = 1; n <= std::lround(duration / this->par.h); ++n) {
      const Target to = target(static_cast<Real>(n) * this->par.h);
      this->in.devices[0] = {};
      this->in.devices[0].target.X_WD = to.X_WD;
      this->in.devices[0].target.V_WD = to.V_WD;
      this->step();
      if (any(this->out.fault)) throw std::runtime_error("the step reported a fault");
    }
    return places();
  }
  std::vector<Vec3> places() const {
    std::vector<Vec3> p;
    for (std::size_t i = 0; i < 3; ++i) p.push_back(this->x.bodies[i].x.X_WB.p);
    for (std::size_t n = 0; n < this->par.net.num_nodes; ++n) p.push_back(this->x.net.nodes[n].p_W);
    return p;
  }
};

std::vector<Vec3> solved_exactly(Carrier of) {
  const auto sewn = std::make_unique<Sewn<TrBdf2>>(of, 1e-3);
  const auto& par = sewn->par;
  oracle::Case c;
  c.gravity = par.gravity_W;
  for (std::size_t i = 0; i < 3; ++i) {
    oracle::Body& body = c.bodies.emplace_back();
    body.name = "body" + std::to_string(i);
    body.m = par.bodies[i].body.m;
    body.I_B = par.bodies[i].body.I_B;
    body.start.p = sewn->x.bodies[i].x.X_WB.p;
    body.start.q = sewn->x.bodies[i].x.X_WB.q;
  }
  const SpringParams& k = par.bodies[0].coupling;
  c.bodies[0].coupling = {
      .k_t = k.k,
      .g_t = k.g,
      .k_r = k.k_r,
      .g_r = k.g_r,
      .target = std::make_shared<oracle::FunctionTarget>([&sewn](double t) -> oracle::RigidState {
        const Target to = sewn->target(t);
        return {.p = to.X_WD.p, .q = to.X_WD.q, .v = to.V_WD.v, .w = to.V_WD.w};
      })};
  if (of == Carrier::hand_and_hinge) c.joints.push_back(hinge());
  // springs join bodies: a body fixed to the world
  const std::size_t ground = c.bodies.size();
  oracle::Body& still = c.bodies.emplace_back();
  still.name = "ground";
  still.m = 1;
  still.I_B = Mat3::Identity();
  still.start.p = Vec3::Zero();
  oracle::Joint& fixed = c.joints.emplace_back();
  fixed.type = oracle::JointType::fixed;
  fixed.child = ground;
  add_net(*sewn, c, ground);
  const oracle::Solution solution = oracle::solve(c, std::vector{duration}, 1e-11);
  std::vector<Vec3> p;
  for (std::size_t i = 0; i < solution.states[0].size(); ++i)
    if (i != ground) p.push_back(solution.states[0][i].p);
  return p;
}

template <class I>
Real error(Carrier of, Real h, bool tight, const std::vector<Vec3>& truth) {
  auto sewn = std::make_unique<Sewn<I>>(of, h);
  if (tight) sewn->solve_tightly();
  const std::vector<Vec3> p = sewn->moved();
  Real most = 0;
  for (std::size_t n = 0; n < p.size(); ++n) most = std::max(most, (p[n] - truth[n]).norm());
  return most;
}

template <class I>
Real order(Carrier of, const std::vector<Vec3>& truth) {
  const Real e_1 = error<I>(of, 5e-4, true, truth), e_2 = error<I>(of, 2.5e-4, true, truth),
             e_3 = error<I>(of, 1.25e-4, true, truth);
  std::printf("%s: %.2e, %.2e, %.2e m, order %.2f; default iterations at 1 ms %.2e m\n", I::name, e_1, e_2,
              e_3, std::log2(e_2 / e_3), error<I>(of, 1e-3, false, truth));
  return std::log2(e_2 / e_3);
}

TEST(NetAttached, ConvergesAsItsIntegratorDoes) {
  for (const Carrier of : {Carrier::hand, Carrier::hand_and_hinge, Carrier::world, Carrier::no_anchor}) {
    const std::vector<Vec3> truth = solved_exactly(of), start = Sewn<TrBdf2>(of, 1e-3).places();
    EXPECT_GT((truth[1] - start[1]).norm(), 5e-3) << "the bodies swing";
    EXPECT_GE(order<ImplicitEuler>(of, truth), 0.9);
    EXPECT_GE(order<TrBdf2>(of, truth), 1.9);
    EXPECT_LE(error<TrBdf2>(of, 1e-3, true, truth), 1e-4);
  }
}

}  // namespace
}  // namespace godobject::test_net_attached
