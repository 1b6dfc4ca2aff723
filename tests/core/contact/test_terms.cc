// Terms in a scene: a ball on a damped spring, on a jointed tool that stands on the floor.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/core/contact/contact_scene.h"
#include "tests/core/snapping_chain.h"
#include "tests/oracle/solve.h"
#include "tests/oracle/target.h"

namespace godobject::test_terms {
namespace {

template <class I>
struct Tethered {
  static constexpr std::size_t max_bodies = 6;  // three of them unused, but in a chain with two balls
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<>;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = BodyContacts<4, 2, 16>;
  using Terms = TermList<DampedSprings<3>>;
};

constexpr Real duration = 0.128, radius = 0.01, link = 0.06;  // s, m, m
// all initial depth is pressed, none is rest penetration (35)
constexpr ContactLaw floor_law{.k = 800, .c = 1.5, .push_out = 10};

/// A ball without contacts, for springs at its centre.
inline RigidBodyParams ball(Real m) { return rigid_body(m, Mat3(1e-5 * Mat3::Identity())); }

/// A link of 0.06 m along x on the ground, by a sphere at either end, its hinge about y. The second link
/// stands on it, the ball hangs beside it.
template <class S>
struct Rig : Running<S> {
  using Running<S>::par;
  Vec3 start = Vec3(link / 2, 0, 0);  // of the lower link

  explicit Rig(Real h, Real l_0) {
    par.h = h;
    par.gravity_W = Vec3(0, 0, -9.81);
    par.num_bodies = 3;
    const RigidBodyParams body = rigid_body(0.05, Vec3(2e-6, 2e-5, 2e-5).asDiagonal());
    for (std::size_t i = 0; i < 3; ++i) {
      par.bodies[i].body = i < 2 ? body : ball(0.02);
      par.bodies[i].device.rise = 0;
      this->in.devices[i].engaged = false;
    }
    start.z() = radius - (0.1 + 0.02) * 9.81 / (2 * floor_law.k);
    auto& joint = par.bodies[1].joint;
    joint.kind = JointKind::hinge;
    joint.parent = 0;
    const Mat3 about_y = turn_from_z(Vec3::UnitY()).toRotationMatrix();
    joint.P = {.p = Vec3(link / 2, 0, 0), .R = about_y};
    joint.C = {.p = Vec3(-link / 2, 0, 0), .R = about_y};
    par.bodies[0].joint.kind = par.bodies[2].joint.kind = JointKind::free;
    place(this->x, 0, {.X_WB = {.p = start, .q = Quat::Identity()}, .V_WB = {}});
    place(this->x, 1, {.X_WB = upper(), .V_WB = {}});
    for (const Real end : {-1.0, 1.0}) add_sphere(par, 0, Vec3(end * link / 2, 0, 0), radius);
    add_plane(par);
    set_law(par, floor_law);
    place(this->x, 2, {.X_WB = {.p = hung(), .q = Quat::Identity()}, .V_WB = {}});
    auto& springs = par.terms.template of<0>();
    springs.list[springs.size++] = {
        .a = {.on = 1, .p = tip()}, .b = {.on = 2}, .k = 30, .g = 0.2, .l_0 = l_0};
    springs.list[springs.size++] = {.a = {.p = anchor()}, .b = {.on = 2}, .k = 20, .g = 0.1};
    springs.list[springs.size++] = {
        .a = {.on = 0, .p = Vec3(0, 0.02, 0)}, .b = {.on = 1, .p = tip()}, .k = 10, .g = 0.02};
    coupling() = {.k = 50, .g = 1, .k_r = 0.02, .g_r = 1e-4};
    engage_at(this->x, 0, target(0));
    EXPECT_EQ(validate(par), Invalid::nothing);
  }
  SpringParams& coupling() { return par.bodies[0].coupling; }
  Pose upper() const { return {.p = start + Vec3(link / 2, 0, link / 2), .q = exp_so3(Vec3(0, -pi / 2, 0))}; }
  static Vec3 tip() { return Vec3(link / 2, 0, 0.01); }
  Vec3 hung() const { return start + Vec3(link / 2 + 0.03, 0.01, link + 0.02); }
  Vec3 anchor() const { return hung() + Vec3(0.01, 0.02, 0.02); }
  /// The device sways the lower link to and fro and turns it.
  Target target(Real t) const {
    const Real omega = 2 * pi * 5, s = 1 - std::cos(omega * t), ds = omega * std::sin(omega * t);
    const Vec3 by(2e-3, 1e-3, -2e-4), turn(0, 0, 0.05);
    return {.X_WD = {.p = start + s * by, .q = exp_so3(Vec3(s * turn))},
            .V_WD = {.w = ds * turn, .v = ds * by}};
  }
  /// Positions of links and ball at the end.
  std::vector<Vec3> moved() {
    for (long n = 1; n <= std::lround(duration / par.h); ++n) {
      const Target to = target(static_cast<Real>(n) * par.h);
      this->in.devices[0] = {};
      this->in.devices[0].target = to;
      this->in.devices[0].engaged = true;
      this->in.devices[0].valid = true;
      this->step();
      EXPECT_EQ(this->out.fault, Fault::none);
    }
    return {this->x.bodies[0].x.X_WB.p, this->x.bodies[1].x.X_WB.p, this->x.bodies[2].x.X_WB.p};
  }
};

/// Returns the result of the oracle at the end.
oracle::Solution solved_exactly(Real l_0) {
  using Tether = Rig<Tethered<TrBdf2>>;
  const Tether rig(1e-3, l_0);
  oracle::Case c;
  c.gravity = rig.par.gravity_W;
  for (std::size_t i = 0; i < 2; ++i) {
    const RigidBodyState& x = rig.x.bodies[i].x;
    oracle::Body& body = c.bodies.emplace_back();
    body.name = std::to_string(i);
    body.m = 0.05;
    body.I_B = rig.par.bodies[i].body.I_B;
    body.start.p = x.X_WB.p;
    body.start.q = x.X_WB.q;
  }
  const SpringParams& k = rig.par.bodies[0].coupling;
  c.bodies[0].coupling = {
      .k_t = k.k,
      .g_t = k.g,
      .k_r = k.k_r,
      .g_r = k.g_r,
      .target = std::make_shared<oracle::FunctionTarget>([&rig](double t) -> oracle::RigidState {
        const Target to = rig.target(t);
        return {.p = to.X_WD.p, .q = to.X_WD.q, .v = to.V_WD.v, .w = to.V_WD.w};
      })};
  oracle::Body& ball = c.bodies.emplace_back();
  ball.name = "ball";
  ball.m = rig.par.bodies[2].body.m;
  ball.I_B = rig.par.bodies[2].body.I_B;
  ball.start.p = rig.hung();
  oracle::Joint hinge{.name = "hinge", .type = oracle::JointType::hinge, .parent = 0, .child = 1};
  hinge.anchor_P = Vec3(link / 2, 0, 0);
  hinge.anchor_C = Vec3(-link / 2, 0, 0);
  hinge.axis_P = Vec3::UnitY();
  hinge.q_PC = exp_so3(Vec3(0, -pi / 2, 0));
  c.joints.push_back(hinge);
  c.springs = {{.a = 1, .b = 2, .p_A = Tether::tip(), .k = 30, .g = 0.2, .l_0 = l_0},
               {.b = 2, .p_A = rig.anchor(), .k = 20, .g = 0.1},
               {.a = 0, .b = 1, .p_A = Vec3(0, 0.02, 0), .p_B = Tether::tip(), .k = 10, .g = 0.02}};
  for (const Real end : {-1.0, 1.0})
    c.on_floor.push_back(
        {.body = 0, .p_B = Vec3(end * link / 2, 0, 0), .radius = radius, .k = floor_law.k, .c = floor_law.c});
  return oracle::solve(c, std::vector{duration});
}
std::vector<Vec3> exact(Real l_0) {
  const oracle::Solution solution = solved_exactly(l_0);
  return {solution.states[0][0].p, solution.states[0][1].p, solution.states[0][2].p};
}
Vec3 reaction(Real l_0) { return solved_exactly(l_0).reactions[0][0].f; }

template <class I>
Real error(Real h, Real l_0, const std::vector<Vec3>& exact) {
  auto rig = std::make_unique<Rig<Tethered<I>>>(h, l_0);
  const std::vector<Vec3> p = rig->moved();
  Real most = 0;
  for (std::size_t i = 0; i < p.size(); ++i) most = std::max(most, (p[i] - exact[i]).norm());
  return most;
}

template <class I>
Real order(Real l_0) {
  const std::vector<Vec3> truth = exact(l_0);
  const Real e_1 = error<I>(1e-3, l_0, truth), e_2 = error<I>(5e-4, l_0, truth),
             e_3 = error<I>(2.5e-4, l_0, truth);
  std::printf("%s, rest length %.2f m: %.1e, %.1e, %.1e m, order %.2f\n", I::name, l_0, e_1, e_2, e_3,
              std::log2(e_2 / e_3));
  return std::log2(e_2 / e_3);
}

TEST(Terms, ABallOnASpringMovesAsTheOracleSays) {
  for (const Real l_0 : {0.0, 0.02, 0.06}) {
    EXPECT_GT(order<ImplicitEuler>(l_0), 0.9);
    EXPECT_GT(order<TrBdf2>(l_0), 1.9);
    EXPECT_LT(error<TrBdf2>(1e-3, l_0, exact(l_0)), 2e-5);
  }
}

TEST(Terms, AreInWhatAJointBears) {
  constexpr Real h = 1.25e-4;
  auto rig = std::make_unique<Rig<Tethered<TrBdf2>>>(h, 0.02);
  rig->moved();
  const Vec3 exact = reaction(0.02);
  EXPECT_LT((rig->out.bodies[1].joint.F_C.f - exact).norm(), 2e-2 * exact.norm());
}

/// Balls on the first two links of a chain whose stages are subdivided (39).
template <class I>
void expect_chain_to_hold(Real m, Real k) {
  using S = Tethered<I>;
  auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  par.h = 1e-2;
  build_snapping_chain(*run, 4, 175 * pi / 180, true);
  auto& springs = par.terms.template of<0>();
  par.num_bodies = 6;
  for (std::uint32_t j = 0; j < 2; ++j) {
    const std::uint32_t on = 4 + j;
    par.bodies[on].body = rigid_body(m, Mat3(1e-4 * m * Mat3::Identity()));
    par.bodies[on].joint.kind = JointKind::free;
    place(run->x, on, {.X_WB = run->x.bodies[j].x.X_WB, .V_WB = {}});
    springs.list[springs.size++] = {.a = {.on = j}, .b = {.on = on}, .k = k, .g = 0.02 * std::sqrt(k * m)};
  }
  ASSERT_EQ(validate(par), Invalid::nothing);
  const Snapped snapped = snap(*run, 2000);
  EXPECT_LT(snapped.drift, 1e-5) << I::name << ", " << m << " kg on " << k << " N/m";
  EXPECT_FALSE(snapped.gains) << I::name << ", " << m << " kg on " << k << " N/m";
}

TEST(Terms, HangOnChainsThatSnapTaut) {
  for (const auto& [m, k] : {std::pair{0.005, 1e6}, {0.2, 200.0}}) {
    expect_chain_to_hold<ImplicitEuler>(m, k);
    expect_chain_to_hold<TrBdf2>(m, k);
  }
}

template <class I>
struct Web {
  static constexpr std::size_t max_bodies = 7;
  using Integrator = I;
  using Device = None;
  using Joints = None;
  using Coupling = None;
  using Feedback = None;
  using Contacts = FixedContacts<1, 1, 4>;
  using Terms = TermList<DampedSprings<2>, DampedSprings<10>>;
};

/// Balls, and springs without rest length between their centres and the world, drawn at random.
template <class S>
void weave(Random& random, Running<S>& run) {
  auto& par = run.par;
  par.h = random.log_uniform(1e-4, 5e-3);
  par.num_bodies = 7;
  for (std::size_t i = 0; i < 7; ++i) {
    par.bodies[i].body = rigid_body(random.log_uniform(1e-6, 1), Mat3::Identity());
    const Vec3 p = 0.05 * random.vector();
    place(run.x, i, {.X_WB = {.p = p}, .V_WB = {.v = 0.3 * random.vector()}});
  }
  const auto draw = [&](auto& springs) {
    for (; springs.size < springs.list.size(); ++springs.size) {
      DampedSpringParams& spring = springs.list[springs.size];
      const auto a = static_cast<std::uint32_t>(random.integer(0, 7)), b = (a + 3) % 7;
      spring.b.on = b;
      if (a < 7) spring.a.on = a;
      else spring.a.p = 0.05 * random.vector();
      spring.k = random.log_uniform(1, 1e8);
      spring.g = random.integer(0, 1) * random.log_uniform(1e-3, 10);
    }
  };
  draw(par.terms.template of<0>());
  draw(par.terms.template of<1>());
  ASSERT_EQ(validate(par), Invalid::nothing);
}

template <class I>
void expect_no_gain() {
  Real least = 1;
  for (unsigned seed = 0; seed < 300; ++seed) {
    Random random(seed);
    auto run = std::make_unique<Running<Web<I>>>();
    weave(random, *run);
    EnergyBalance<Web<I>> balance;
    balance.start(run->par, run->x);
    const Real E_0 = balance.energy();
    Real most = 0;
    for (int n = 0; n < 300; ++n) {
      run->step();
      ASSERT_EQ(run->out.fault, Fault::none) << "seed " << seed;
      balance.observe(run->par, run->x, run->w, run->out);
      most = std::max(most, balance.energy() / E_0);
    }
    EXPECT_FALSE(balance.watch().gains()) << "seed " << seed;
    EXPECT_LT(most, 1 + 1e-9) << "seed " << seed;
    least = std::min(least, most);
  }
  std::printf("%s: 300 webs, none gains; least of the energies that are largest after the first step: %.2g\n",
              I::name, least);
}

// springs without rest length are linear: 1 to 1e8 N/m between 1e-6 and 1 kg, undamped and damped, at 0.1 to
// 5 ms
TEST(Terms, WebsOfLinearSpringsNeverGain) {
  expect_no_gain<ImplicitEuler>();
  expect_no_gain<TrBdf2>();
}

/// A ball on the floor carries its weight; its energy gain is reported.
TEST(Terms, BalanceTellsOfBallsThatTouch) {
  using S = Web<ImplicitEuler>;
  auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  par.gravity_W = Vec3(0, 0, -9.81);
  par.bodies[0].body = ball(0.01);
  par.contacts.spheres[par.contacts.num_spheres++] = {.body = 0, .radius = radius};
  par.contacts.surfaces[par.contacts.num_surfaces++] = {};
  par.contacts.laws[0][0] = {.k = 1000, .c = 1};
  place(run->x, 0, {.X_WB = {.p = Vec3(0, 0, radius)}, .V_WB = {}});
  ASSERT_EQ(validate(par), Invalid::nothing);
  EnergyBalance<S> balance;
  balance.start(par, run->x);
  const auto step = [&] {
    run->step();
    ASSERT_EQ(run->out.fault, Fault::none);
    balance.observe(par, run->x, run->w, run->out);
  };
  for (int n = 0; n < 500; ++n) step();
  ASSERT_EQ(run->out.contacts.num_contacts, 1u);
  EXPECT_FALSE(balance.gains());
  for (int n = 0; n < 40; ++n) {
    run->x.bodies[0].x.v_W.x() += 0.5;  // without external work
    step();
  }
  EXPECT_TRUE(balance.gains());
}

/// Ends in one place have no direction between them.
TEST(Terms, ASpringMayStartWithoutLength) {
  auto run = std::make_unique<Running<Web<TrBdf2>>>();
  auto& par = run->par;
  par.bodies[0].body = ball(0.1);
  auto& springs = par.terms.of<1>();
  springs.list[springs.size++] = {.a = {}, .b = {.on = 0}, .k = 1, .g = 1, .l_0 = 5};
  ASSERT_EQ(validate(par), Invalid::nothing);
  run->step(100);
  EXPECT_EQ(run->out.fault, Fault::none);
  EXPECT_EQ(run->x.tick, 100u);
}

TEST(Terms, KeepMomentum) {
  auto run = std::make_unique<Running<Web<TrBdf2>>>();
  Random random(7);
  weave(random, *run);
  for (auto* springs : {&run->par.terms.of<1>()})
    for (std::size_t s = 0; s < springs->size; ++s)
      if (springs->list[s].a.on == TermEnds::on_world)
        springs->list[s].a.on = (springs->list[s].b.on + 1) % 7;
  for (std::size_t s = 0; s < 2; ++s) {
    SpringEnd& a = run->par.terms.of<0>().list[s].a;
    if (a.on == TermEnds::on_world) a.on = (run->par.terms.of<0>().list[s].b.on + 1) % 7;
  }
  const auto momentum = [&] {
    Vec3 P = Vec3::Zero();
    for (std::size_t i = 0; i < 7; ++i) P += run->par.bodies[i].body.m * run->x.bodies[i].x.v_W;
    return P;
  };
  const Vec3 before = momentum();
  run->step(500);
  EXPECT_LT((momentum() - before).norm(), 1e-9 * before.norm());
}

TEST(Terms, AreCheckedBeforeTheFirstStep) {
  const auto validated = [](auto change) {
    auto run = std::make_unique<Running<Web<TrBdf2>>>();
    Random random(1);
    weave(random, *run);
    change(run->par);
    return validate(run->par);
  };
  using Par = Params<Web<TrBdf2>>;
  EXPECT_EQ(validated([](Par&) {}), Invalid::nothing);
  EXPECT_EQ(validated([](Par& par) { par.terms.of<0>().list[1].k = -1; }), Invalid::term);
  EXPECT_EQ(validated([](Par& par) { par.terms.of<1>().list[0].b.on = 7; }), Invalid::term);
  EXPECT_EQ(validated([](Par& par) { par.terms.of<1>().list[0].b.on = TermEnds::on_world; }), Invalid::term);
  EXPECT_EQ(validated([](Par& par) { par.terms.of<1>().list[3].a.on = par.terms.of<1>().list[3].b.on; }),
            Invalid::term);
}

}  // namespace
}  // namespace godobject::test_terms
