// Nets attached to bodies, free and on joints, over the ranges of stiffness, mass, damping and step of
// scenes. Finite, and no energy except that of gravity; damped nets come to rest.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_attached_sweep {
namespace {

#ifdef NDEBUG
constexpr unsigned seeds = 200;  // for each integrator
#else
constexpr unsigned seeds = 4;
#endif

/// Drawn quantities of a case.
struct Drawn {
  Real k = 0, m = 0, k_s = 0, zeta = 0, h = 0, anchors = 0;
  std::array<Real, 4> body_m{};
  int cap = 12, kinds = 0;
  Real relative_motion = 0;  // mass for which dampers are designed, kg; 0: that of a node
  bool on_carrier = true, damped = false, pulled_out = false;

  std::string text() const {
    std::ostringstream os;
    os.precision(3);
    os << "k " << k << " m " << m << " attachments " << k_s << " zeta " << zeta << " anchors " << anchors
       << " h " << h << " bodies " << body_m[0] << " " << body_m[1] << " " << body_m[2] << " " << body_m[3]
       << " cap " << cap << " kinds " << kinds << (on_carrier ? "" : " world")
       << (pulled_out ? " pulled out" : "");
    return os.str();
  }
};

/// A sheet on a body held by the target, or in the world. It is attached to a free body, to two links of a
/// chain from the world, or to some of them.
template <class I>
struct Sweep : Running<AttachedNetScene<I>> {
  Drawn of;
  EnergyBalance<AttachedNetScene<I>> balance;

  explicit Sweep(unsigned seed, bool damped = false) {
    Random random(seed);
    of.k = random.log_uniform(1, 1e8);
    of.m = random.log_uniform(1e-6, 1);
    of.k_s = random.log_uniform(1, 1e8);
    of.zeta = random.integer(0, 2) == 0 ? 0 : random.log_uniform(0.01, 2);
    of.anchors = random.integer(0, 3) == 0 ? 0 : random.log_uniform(1e-3, 10);
    of.h = random.log_uniform(1e-4, 5e-3);
    const int caps[] = {12, 12, 12, 1, 2, 4};
    of.cap = caps[random.integer(0, 5)];
    of.on_carrier = random.integer(0, 3) > 0;
    of.kinds = random.integer(1, 7);
    for (Real& m : of.body_m) m = random.log_uniform(1e-3, 1);
    if (damped) hold_firmly();
    of.damped = damped;
    build(random);
  }

  /// Net and attachments hold their bodies at 200 rad/s or above, damped for all of them, and for every link.
  void hold_firmly() {
    of.on_carrier = true;
    of.cap = 12;
    of.anchors = std::max(of.anchors, Real(0.1));
    of.zeta = std::max(of.zeta, Real(0.2));
    of.relative_motion = of.m + of.body_m[1] + of.body_m[2] + of.body_m[3];
    constexpr Real omega_sq = 200 * 200;  // 1/s^2
    of.k_s = std::max(of.k_s, omega_sq * of.relative_motion);
    of.k = std::max(of.k, omega_sq * of.relative_motion / of.anchors);
    if ((of.kinds & 2) != 0) of.kinds |= 4;
  }

  void build(Random& random) {
    auto& par = this->par;
    par.h = of.h;
    par.gravity_W = of.damped ? Vec3(Vec3::Zero()) : Vec3(0, 0, -9.81 * random.integer(0, 1));
    par.num_bodies = 4;
    const Real a = random.log_uniform(1e-3, 1e-2), size = 5 * a;
    const Vec3 at[] = {Vec3::Zero(), Vec3(0, size, 0.1 * size), Vec3(size, 0, 0), Vec3(2 * size, 0, 0)};
    for (std::size_t i = 0; i < 4; ++i) {
      par.bodies[i].body =
          rigid_body(of.body_m[i], (of.body_m[i] / 6 * size * size * Vec3(1, 1.3, 0.7)).asDiagonal());
      place(this->x, i, {.X_WB = {.p = at[i]}, .V_WB = {}});
      par.bodies[i].device.rise = 0;
      this->in.devices[i] = {};
    }
    const Real m = std::max(of.relative_motion, of.m), held = of.body_m[0] + (of.damped ? 49 * m : 0);
    const Real k = 900 * held * random.log_uniform(1, 100);
    par.bodies[0].coupling = {.k = k,
                              .g = 1.4 * std::sqrt(k * held),
                              .k_r = k * size * size / 6,
                              .g_r = 1.4 * std::sqrt(k * held) * size * size / 6};
    this->in.devices[0].engaged = this->in.devices[0].valid = true;
    for (std::size_t i = 2; i < 4; ++i) {
      auto& joint = par.bodies[i].joint;
      joint.kind = random.integer(0, 1) == 0 ? JointKind::hinge : JointKind::universal;
      joint.parent = i == 2 ? world : 2;
      joint.P.p = Vec3(0.5 * size, 0, 0);
      joint.C.p = Vec3(-0.5 * size, 0, 0);
    }
    Stuff stuff{.m = of.m,
                .k = of.k,
                .g = 2 * of.zeta * std::sqrt(of.k * m),
                .k_a = of.anchors * of.k,
                .carrier = of.on_carrier ? 0 : world};
    stuff.g_a = 2 * of.zeta * std::sqrt(stuff.k_a * m);
    const auto side = static_cast<std::uint32_t>(random.integer(3, 7));
    add_sheet(par, stuff, side, side, a);
    place_net(par.net, this->x);
    const Real g_s = 2 * of.zeta * std::sqrt(of.k_s * m);
    const auto num = static_cast<int>(par.net.num_nodes);
    for (std::size_t i = 1; i < 4; ++i)
      for (int n = of.damped ? 6 : random.integer(1, 6); (of.kinds >> (i - 1) & 1) != 0 && n > 0; --n)
        attach(par, this->x, static_cast<std::uint32_t>(random.integer(0, num - 1)), i, of.k_s, g_s);
    par.net.max_iterations = of.cap;
    const Real v = random.log_uniform(0.01, 3), turn = random.log_uniform(0.1, 30);
    for (std::size_t n = 0; n < par.net.num_nodes; ++n) this->x.net.nodes[n].v_W = v * 0.3 * random.vector();
    place(this->x, 1,
          {.X_WB = {.p = at[1]}, .V_WB = {.w = turn * random.vector(), .v = 0.3 * v * random.vector()}});
    of.pulled_out = random.integer(0, 3) == 0 && !of.damped;
    if (of.pulled_out)
      place(this->x, 1,
            {.X_WB = {.p = at[1] + 3 * size * random.vector(), .q = random.rotation()}, .V_WB = {}});
    engage_at(this->x, 0, {});
    if (validate(par) != Invalid::nothing) throw std::runtime_error("invalid");
    balance.start(par, this->x);
  }

  bool step_and_watch() {
    this->step();
    if (has(this->out.fault, Fault::state_not_finite)) return false;
    balance.observe(this->par, this->x, this->w, this->out);
    return true;
  }
};

template <class I>
void expect_no_gain(unsigned seed) {
  auto sweep = std::make_unique<Sweep<I>>(seed);
  for (int n = 0; n < 400; ++n) {
    ASSERT_TRUE(sweep->step_and_watch()) << I::name << " seed " << seed << ": " << sweep->of.text();
    const GainWatch& watch = sweep->balance.watch();
    ASSERT_FALSE(sweep->balance.gains())
        << I::name << " seed " << seed << " step " << n << ": gains " << watch.gained() << " J of "
        << watch.at_work() << " J: " << sweep->of.text();
  }
}
template <class I>
void expect_no_gain() {
  for (unsigned seed = 0; seed < seeds; ++seed) expect_no_gain<I>(seed);
}

TEST(NetAttachedSweep, GainsNoEnergyWithImplicitEuler) { expect_no_gain<ImplicitEuler>(); }
TEST(NetAttachedSweep, GainsNoEnergyWithTrBdf2) { expect_no_gain<TrBdf2>(); }

/// Cases of 3000 that gained while stages with nets were not subdivided (39), and do not now.
TEST(NetAttachedSweep, GainsNoEnergyWhereStagesAreParted) {
  for (const unsigned seed : {495, 863, 978, 1462, 1595, 1616, 2660}) expect_no_gain<ImplicitEuler>(seed);
  for (const unsigned seed : {227, 1376, 1595}) expect_no_gain<TrBdf2>(seed);
}

/// Damped, held by the target and let alone for 2.5 s.
template <class I>
void expect_rest() {
  constexpr Real settled = 2.5, at_rest = 1e-3;  // s, m/s
  for (unsigned seed = 0; seed < seeds / 10 + 2; ++seed) {
    auto sweep = std::make_unique<Sweep<I>>(seed, true);
    for (int n = 0; n < static_cast<int>(settled / sweep->of.h); ++n)
      ASSERT_TRUE(sweep->step_and_watch()) << sweep->of.text();
    Real fastest = 0;
    for (std::size_t n = 0; n < sweep->par.net.num_nodes; ++n)
      fastest = std::max(fastest, sweep->x.net.nodes[n].v_W.norm());
    for (std::size_t i = 0; i < 4; ++i)
      if (i == 0 || (sweep->of.kinds >> (i - 1) & 1) != 0)
        fastest = std::max(fastest, sweep->x.bodies[i].x.v_W.norm());
    EXPECT_LT(fastest, at_rest) << I::name << " seed " << seed << ": " << sweep->of.text();
  }
}

TEST(NetAttachedSweep, WhatIsDampedComesToRest) {
  expect_rest<ImplicitEuler>();
  expect_rest<TrBdf2>();
}

}  // namespace
}  // namespace godobject::test_net_attached_sweep
