// Reported forces of joints, terms and contacts are means over the step. With couplings and weights they
// equal the change of each body's momentum. Drawn trees of joints of every kind, with stops, prescribed
// coordinates, closing joints, springs, gears and a floor; one or two tools, some in flight.
#include <gtest/gtest.h>

#include <cstdio>
#include <optional>

#include "tests/core/joint/random_tool.h"
#include "tests/core/term/mechanism.h"

namespace godobject::test_force_balance {

template <class I>
struct Tool {
  static constexpr std::size_t max_bodies = 6;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<JointStops, PrescribedJoints>;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = BodyContacts<6, 2, 24>;
  using Terms = TermList<LoopJoints<1>, CoordinateSprings<3>, DampedSprings<1>>;
};

namespace {

constexpr Real size = 0.05;  // m, of a body
#ifdef NDEBUG
constexpr unsigned num_seeds = 200;
constexpr int least = 500;  // steps of each kind
#else
constexpr unsigned num_seeds = 5;  // builds with assertions and sanitizers take a hundred times as long
constexpr int least = 0;
#endif

/// A tree of bodies with the parts of one seed, thrown at a floor or in flight.
template <class I>
class Drawn : public Running<Tool<I>> {
 public:
  using S = Tool<I>;
  using Running<S>::par, Running<S>::x, Running<S>::in, Running<S>::w, Running<S>::out;

  explicit Drawn(unsigned seed) : random_(seed) {
    par.h = random_.log_uniform(2e-4, 3e-3);
    par.gravity_W = 9.81 * random_.direction();
    par.num_bodies = static_cast<std::size_t>(random_.integer(2, 6));
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      add_random_body(par, i, size, random_);
      if (i > 0 && random_.integer(0, 5) == 0) par.bodies[i].joint.kind = JointKind::free;
      in.devices[i].engaged = false;
    }
    const Real rate = random_.log_uniform(0.1, 10);
    place_randomly(par, x, size, rate, random_);
    const bool has_terms = random_.integer(0, 1) == 0;
    if (has_terms) draw_terms();
    for (std::size_t i = 0; i < par.num_bodies; ++i) draw_parts(i, has_terms);
    if (random_.integer(0, 1) == 0) draw_floor();
    EXPECT_EQ(validate(par), Invalid::nothing) << seed;
    start_turns(par, x);
    auto& springs = par.terms.template of<1>();
    for (std::size_t k = 0; k < springs.size; ++k) {
      CoordinateSpringParams& gear = springs.list[k];
      if (gear.size == 2)
        for (const CoordinateShare& share : gear.of)
          gear.y_0 += share.ratio * x.bodies[share.body].joint.q[0];
    }
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      x.bodies[i].joint.last.q = in.joints[i].q = first_[i] = x.bodies[i].joint.q;
      rates_[i] = 2 * random_.vector().head<2>();
    }
  }
  /// Makes a step. Prescribed coordinates swing by 0.1 rad or 1 cm.
  void go_on() {
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      if (!par.bodies[i].joint.motion.prescribed) continue;
      const JointKind kind = par.bodies[i].joint.kind;
      const JointCoordinates swing(kind == JointKind::slider ? 0.01 : 0.1, kind == JointKind::universal ? 0.1
                                                                           : kind == JointKind::cylindrical
                                                                               ? 0.01
                                                                               : 0);
      const Real t = static_cast<Real>(x.tick + 1) * par.h;
      for (int k = 0; k < 2; ++k) {
        in.joints[i].q[k] = first_[i][k] + swing[k] * std::sin(rates_[i][k] * t);
        in.joints[i].q_dot[k] = swing[k] * rates_[i][k] * std::cos(rates_[i][k] * t);
      }
    }
    this->step();
  }
  bool is_coupled() const { return is_coupled_; }

 private:
  std::optional<std::uint32_t> drawn_of(JointKind kind) {
    std::vector<std::uint32_t> all;
    for (std::uint32_t i = 0; i < par.num_bodies; ++i)
      if (par.bodies[i].joint.kind == kind) all.push_back(i);
    if (all.empty()) return std::nullopt;
    return all[static_cast<std::size_t>(random_.integer(0, static_cast<int>(all.size()) - 1))];
  }
  std::uint32_t drawn_body() {
    return static_cast<std::uint32_t>(random_.integer(0, static_cast<int>(par.num_bodies) - 1));
  }
  void draw_terms() {
    const std::uint32_t a = drawn_body(), b = drawn_body();
    if (a != b) {
      const Pose& X = x.bodies[b].x.X_WB;
      close_loop(*this, random_.integer(0, 1) ? JointKind::ball : JointKind::cylindrical, a, b,
                 {.p = X.p + size * random_.vector(), .q = random_.rotation()});
      auto& springs = par.terms.template of<2>();
      springs.list[springs.size++] = {.a = {.on = a, .p = size * random_.vector()},
                                      .b = {.on = b, .p = size * random_.vector()},
                                      .k = random_.log_uniform(1, 1e4),
                                      .g = random_.log_uniform(1e-2, 1),
                                      .l_0 = random_.integer(0, 1) * size};
    }
    for (const JointKind kind : {JointKind::hinge, JointKind::slider})
      if (const auto i = drawn_of(kind))
        add_spring<1>(*this, joint_spring(*i, random_.log_uniform(0.1, 1e3), random_.integer(0, 1) * 1e-3));
    const auto of_hinge = drawn_of(JointKind::hinge), to = drawn_of(JointKind::slider);
    if (!of_hinge || !to) return;
    CoordinateSpringParams& one = add_spring<1>(*this, gear(*of_hinge, *to, size * random_.normal()));
    one.is_rigid = random_.integer(0, 1) == 0;
    one.k = random_.log_uniform(1, 1e6);
  }
  /// Draws couplings, stops and prescribed coordinates, each of some bodies. in_loop: nothing is prescribed,
  /// which closing joints and gears would contradict.
  void draw_parts(std::size_t i, bool in_loop) {
    auto& body = par.bodies[i];
    if (random_.integer(0, 2) == 0)
      body.joint.stop.stops[0] = {.lower = -0.5, .upper = 0.5, .k = 20, .g = 0.1, .width = 0.05};
    const bool coupled = random_.integer(0, 3) == 0;
    const JointKind kind = body.joint.kind;
    body.joint.motion.prescribed = random_.integer(0, 3) == 0 && !in_loop && kind != JointKind::ball &&
                                   kind != JointKind::fixed && kind != JointKind::free;
    if (!coupled && !body.joint.motion.prescribed) return;
    is_coupled_ = is_coupled_ || coupled;
    if (coupled)
      body.coupling = spring(body.body, random_.log_uniform(10, 1e4), random_.log_uniform(0.01, 10));
    Pose X = x.bodies[i].x.X_WB;
    X.p += 0.1 * size * random_.vector();
    body.device.rise = 0;
    engage_at(x, i, Target{.X_WD = X, .V_WD = {}});
    in.devices[i].target.X_WD = X;
    in.devices[i].engaged = true;
  }
  void draw_floor() {
    Vec3 lowest = Vec3::Zero();
    const Vec3 up = -par.gravity_W / 9.81;
    Real depth = 0;
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      add_sphere(par, i, Vec3::Zero(), 0.2 * size);
      const Vec3& p = x.bodies[i].x.X_WB.p;
      if (i == 0 || up.dot(p) < depth) lowest = p, depth = up.dot(p);
    }
    add_plane(par, {.p = lowest - 0.22 * size * up, .q = turn_from_z(up)});
    set_law(par,
            {.k = random_.log_uniform(1e3, 1e5), .c = 1, .mu = random_.uniform(0, 1), .k_t = 1e3, .c_t = 1});
  }

  Random random_;
  bool is_coupled_ = false;
  std::array<JointCoordinates, 6> first_, rates_;
};

/// Returns the mean force of a coupling over a step of second order, or one of implicit Euler, N.
/// before: state of the body at the start of the step.
template <class I>
Vec3 mean_coupling(const Drawn<I>& run, const RigidBodyState& before, std::size_t i) {
  const SpringParams& spring = run.par.bodies[i].coupling;
  const auto& input = run.w.coupling_inputs[i];
  if (!input.ramp.engaged) return Vec3::Zero();
  const auto force = [&](const Target& to, const Vec3& p, const Vec3& v) -> Vec3 {
    return spring.k * (to.X_WD.p - p) + spring.g * (to.V_WD.v - v);
  };
  const RigidBodyState& x = run.x.bodies[i].x;
  const Vec3 F_2 = force(input.to, x.X_WB.p, x.v_W);
  if constexpr (I::order == 1) return F_2;
  else {
    // the middle of the step, from the base of the second stage
    constexpr std::size_t in_group = lanes<Tool<I>>;
    const Real h = run.par.h;
    const Vec3& p = before.X_WB.p;
    const Vec3 base = lane(run.w.bases[i / in_group].X_WB.p, i % in_group);
    const Vec3 v_1 = (base - p) / (I::b * h) - before.v_W;
    const auto& target = run.w.inside[i / in_group];
    Target inside;
    inside.X_WD.p = lane(target.X_WD.p, i % in_group);
    inside.V_WD.v = lane(target.V_WD.v, i % in_group);
    return I::b * (force(input.from, p, before.v_W) + force(inside, p + I::d * h * (before.v_W + v_1), v_1)) +
           I::d * F_2;
  }
}

/// Steps that were checked, and the largest missing impulse of a body, of the largest one in its step.
struct Balance {
  Real off = 0;
  int steps = 0, touching = 0, stopped = 0, of_terms = 0, of_couplings = 0;
};

template <class I>
void take(Drawn<I>& run, Balance& balance) {
  constexpr std::size_t N = Tool<I>::max_bodies;
  const auto& par = run.par;
  const Real h = par.h;
  std::array<RigidBodyState, N> before;
  for (std::size_t i = 0; i < N; ++i) before[i] = run.x.bodies[i].x;
  run.go_on();
  ASSERT_FALSE(any(run.out.fault)) << static_cast<unsigned>(run.out.fault);
  const bool is_known = run.x.tick > 1 && !has(run.out.limited, Limited::first_order) &&
                        !has(run.out.limited, Limited::substeps);
  if (run.is_coupled() && !is_known) return;  // the mean of the couplings
  std::array<Vec3, N + 1> J;
  J.fill(Vec3::Zero());
  Real largest = 0;
  const auto act = [&](std::size_t i, const Vec3& F) {
    J[std::min(i, N)] += h * F;
    largest = std::max(largest, h * F.norm());
  };
  bool touches = false;
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    const auto& out = run.out.bodies[i];
    act(i, par.bodies[i].body.m * par.gravity_W);
    act(i, out.contact.F_W.f);
    act(i, mean_coupling(run, before[i], i));
    touches = touches || out.contact.F_W.f.norm() > 0;
    const JointParams& joint = par.bodies[i].joint;
    if (joint.kind == JointKind::free) continue;
    act(i, out.joint.F_C.f);
    act(joint.parent, -out.joint.F_C.f);
  }
  std::size_t t = 0;
  const auto& terms = par.terms.of_kinds;
  const auto between = [&](std::size_t a, std::size_t b) {
    act(b, run.out.terms.list[t].f);
    act(a, -run.out.terms.list[t++].f);
  };
  for (std::size_t k = 0; k < std::get<0>(terms).size; ++k)
    between(std::get<0>(terms).list[k].a, std::get<0>(terms).list[k].b);
  for (std::size_t k = 0; k < std::get<1>(terms).size; ++k) {  // forces along a slide
    const CoordinateSpringParams& spring = std::get<1>(terms).list[k];
    const std::uint32_t body = spring.of[spring.size - 1].body;
    between(par.bodies[body].joint.parent, body);
  }
  for (std::size_t k = 0; k < std::get<2>(terms).size; ++k)
    between(std::get<2>(terms).list[k].a.on, std::get<2>(terms).list[k].b.on);
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    const Vec3 change = par.bodies[i].body.m * (run.x.bodies[i].x.v_W - before[i].v_W);
    largest = std::max(largest, change.norm());
    balance.off = std::max(balance.off, (change - J[i]).norm() / largest);
  }
  ++balance.steps;
  balance.touching += touches;
  balance.stopped += run.w.tree.stop_acts;
  balance.of_terms += t > 0;
  balance.of_couplings += run.is_coupled();
}

template <class I>
void expect_balance() {
  Balance all;
  for (unsigned seed = 1; seed <= num_seeds; ++seed) {
    SCOPED_TRACE(seed);
    const auto run = std::make_unique<Drawn<I>>(seed);
    for (int n = 0; n < 100 && !::testing::Test::HasFatalFailure(); ++n) take(*run, all);
    ASSERT_LT(all.off, 1e-9) << I::name;
  }
  std::printf("%s: forces off by %.1e of the largest\n", I::name, all.off);
  std::printf("%d steps, %d touch, %d in stops, %d with terms, %d with couplings\n", all.steps, all.touching,
              all.stopped, all.of_terms, all.of_couplings);
  for (const int steps : {all.touching, all.stopped, all.of_terms, all.of_couplings}) EXPECT_GE(steps, least);
}
TEST(ForceBalance, OfJointsAndTermsImplicitEuler) { expect_balance<ImplicitEuler>(); }
TEST(ForceBalance, OfJointsAndTermsTrBdf2) { expect_balance<TrBdf2>(); }

}  // namespace
}  // namespace godobject::test_force_balance
