// Attachments of nets: what they keep in flight, that nothing gains energy, what rests and where, what the hand feels, and what
// is refused.
#include <gtest/gtest.h>

#include "tests/net/usual_scene.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_net_attached_rest {
namespace {

#ifdef NDEBUG
constexpr unsigned seeds = 200;  // for each integrator
#else
constexpr unsigned seeds = 4;
#endif

template <class I>
using Scene_ = AttachedNetScene<I>;

/// A tube of 48 nodes on a body that nobody holds, eight of its nodes sewn to a second body, all flying.
template <class I>
std::unique_ptr<Running<Scene_<I>>> in_flight(unsigned seed, int max_iterations) {
  Random random(seed);
  auto run = std::make_unique<Running<Scene_<I>>>();
  auto& par = run->par;
  par.num_bodies = 2;
  par.net.max_iterations = max_iterations;
  const Real k = random.log_uniform(30, 300), m = random.log_uniform(1e-4, 1e-3),
             k_a = (seed % 2 == 0 ? 0.1 : 0.01) * k;
  add_tube(par,
           {.m = m,
            .k = k,
            .g = 0.1 * std::sqrt(k * m),
            .k_a = k_a,
            .g_a = 0.1 * std::sqrt(k_a * m),
            .carrier = 0},
           8, 6, 0.01);
  const Twist V{.w = 5 * random.vector(), .v = random.vector()};
  const Pose X{.p = 0.1 * random.vector(), .q = random.rotation()};
  for (std::size_t i = 0; i < 2; ++i) {
    par.bodies[i].body = rigid_body(0.02, random.inertia(Vec3(4e-6, 5e-6, 7e-6)));
    const Vec3 r = static_cast<Real>(i) * (X.q * Vec3(0, 0, 0.03));
    place(run->x, i, {.X_WB = {.p = X.p + r, .q = X.q}, .V_WB = {.w = V.w, .v = V.v + V.w.cross(r)}});
    run->in.devices[i] = {};
  }
  place_net(par.net, run->x);
  const Real k_s = random.log_uniform(30, 3000);
  for (std::uint32_t n = 40; n < 48; ++n) attach(par, run->x, n, 1, k_s, 0.1 * std::sqrt(k_s * m));
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
    run->x.net.nodes[n].p_W += 1e-3 * random.vector();
    run->x.net.nodes[n].v_W += 0.1 * random.vector();
  }
  EXPECT_EQ(validate(par), Invalid::nothing);
  return run;
}

/// Of bodies and nodes, about the origin, and what they are small against.
struct Momentum {
  Vec3 P = Vec3::Zero(), L = Vec3::Zero();
  Real P_scale = 0, L_scale = 0;

  template <class S>
  explicit Momentum(const Running<S>& run) {
    const auto add = [&](Real m, const Vec3& p, const Vec3& v) {
      P += m * v;
      L += m * p.cross(v);
      P_scale += m * v.norm();
      L_scale += m * p.norm() * v.norm();
    };
    for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
      const RigidBodyState& body = run.x.bodies[i].x;
      add(run.par.bodies[i].body.m, body.X_WB.p, body.v_W);
      const Vec3 spin = body.X_WB.q * (run.par.bodies[i].body.I_B * body.w_B);
      L += spin;
      L_scale += spin.norm();
    }
    for (std::size_t n = 0; n < run.par.net.num_nodes; ++n)
      add(run.par.net.nodes[n].m, run.x.net.nodes[n].p_W, run.x.net.nodes[n].v_W);
  }
};

template <class I>
void expect_momenta_kept() {
  Real linear = 0, angular = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    for (const int cap : {1, 2, 12}) {
      auto run = in_flight<I>(seed, cap);
      const Momentum first(*run);
      for (int n = 0; n < 500; ++n) {
        run->step();
        ASSERT_EQ(run->out.fault, Fault::none);
        const Momentum now(*run);
        linear = std::max(linear, (now.P - first.P).norm() / first.P_scale);
        angular = std::max(angular, (now.L - first.L).norm() / first.L_scale);
      }
    }
  }
  std::printf("%s: linear momentum within %.1e, angular momentum within %.1e of what they were\n", I::name,
              linear, angular);
  EXPECT_LT(linear, 1e-11);
  EXPECT_LT(angular, 1e-11);
}

TEST(NetAttached, MomentaAreKeptHoweverFewTheIterations) {
  expect_momenta_kept<ImplicitEuler>();
  expect_momenta_kept<TrBdf2>();
}

/// What is drawn of a case.
struct Drawn {
  Real k = 0, m = 0, k_s = 0, zeta = 0, h = 0, anchors = 0;
  std::array<Real, 4> body_m{};
  int cap = 12, kinds = 0;
  bool on_carrier = true, damped = false;

  std::string text() const {
    std::ostringstream os;
    os.precision(3);
    os << "k " << k << " m " << m << " attachments " << k_s << " zeta " << zeta << " anchors " << anchors
       << " h " << h << " bodies " << body_m[0] << " " << body_m[1] << " " << body_m[2] << " " << body_m[3]
       << " cap " << cap << " kinds " << kinds << (on_carrier ? "" : " world");
    return os.str();
  }
};

/// A sheet on a body that the target holds, or in the world, attached to a free body and to two links of a chain that hangs
/// on the world, or to some of them.
template <class I>
struct Sweep : Running<Scene_<I>> {
  Drawn of;
  EnergyBalance<Scene_<I>> balance;

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
    if (damped) {
      of.on_carrier = true;
      of.cap = 12;
      of.anchors = std::max(of.anchors, Real(0.1));
      of.zeta = std::max(of.zeta, Real(0.2));
    }
    of.damped = damped;
    build(random);
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
    const Real k = 900 * of.body_m[0] * random.log_uniform(1, 100);
    par.bodies[0].coupling = {.k = k,
                              .g = 1.4 * std::sqrt(k * of.body_m[0]),
                              .k_r = k * size * size / 6,
                              .g_r = 1.4 * std::sqrt(k * of.body_m[0]) * size * size / 6};
    this->in.devices[0].engaged = this->in.devices[0].valid = true;
    for (std::size_t i = 2; i < 4; ++i) {
      auto& joint = par.bodies[i].joint;
      joint.kind = random.integer(0, 1) == 0 ? JointKind::hinge : JointKind::universal;
      joint.parent = i == 2 ? world : 2;
      joint.P.p = i == 2 ? Vec3(0.5 * size, 0, 0) : Vec3(0.5 * size, 0, 0);
      joint.C.p = Vec3(-0.5 * size, 0, 0);
    }
    Stuff stuff{.m = of.m,
                .k = of.k,
                .g = 2 * of.zeta * std::sqrt(of.k * of.m),
                .k_a = of.anchors * of.k,
                .carrier = of.on_carrier ? 0 : world};
    stuff.g_a = 2 * of.zeta * std::sqrt(stuff.k_a * of.m);
    const auto side = static_cast<std::uint32_t>(random.integer(3, 7));
    add_sheet(par, stuff, side, side, a);
    place_net(par.net, this->x);
    const Real g_s = 2 * of.zeta * std::sqrt(of.k_s * of.m);
    const auto num = static_cast<int>(par.net.num_nodes);
    for (std::size_t i = 1; i < 4; ++i)
      for (int n = random.integer(1, 6); (of.kinds >> (i - 1) & 1) != 0 && n > 0; --n)
        attach(par, this->x, static_cast<std::uint32_t>(random.integer(0, num - 1)), i, of.k_s, g_s);
    par.net.max_iterations = of.cap;
    const Real v = random.log_uniform(0.01, 3), turn = random.log_uniform(0.1, 30);
    for (std::size_t n = 0; n < par.net.num_nodes; ++n) this->x.net.nodes[n].v_W = v * 0.3 * random.vector();
    place(this->x, 1,
          {.X_WB = {.p = at[1]}, .V_WB = {.w = turn * random.vector(), .v = 0.3 * v * random.vector()}});
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
void expect_no_gain() {
  for (unsigned seed = 0; seed < seeds; ++seed) {
    auto sweep = std::make_unique<Sweep<I>>(seed);
    for (int n = 0; n < 400; ++n) {
      ASSERT_TRUE(sweep->step_and_watch()) << I::name << " seed " << seed << ": " << sweep->of.text();
      const GainWatch& watch = sweep->balance.watch();
      if (!sweep->balance.gains()) continue;
      ADD_FAILURE() << I::name << " seed " << seed << " step " << n << ": gains " << watch.gained()
                    << " J of " << watch.at_work() << " J: " << sweep->of.text();
      break;
    }
  }
}

TEST(NetAttached, GainsNoEnergyWithImplicitEuler) { expect_no_gain<ImplicitEuler>(); }
TEST(NetAttached, GainsNoEnergyWithTrBdf2) { expect_no_gain<TrBdf2>(); }

}  // namespace
}  // namespace godobject::test_net_attached_rest
