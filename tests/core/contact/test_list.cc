// The list of contacts: full lists, order, replay, bad parameters and inputs, bodies that begin inside an
// obstacle. A scene without contacts has no storage for any.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/core/contact/contact_scene.h"

namespace godobject::test_contact_list {
namespace {

constexpr Real radius = 0.01;
constexpr ContactLaw law{.k = 2e4, .c = 20, .mu = 0.3, .k_t = 2e4, .c_t = 20};

/// A bar of twelve spheres, half of which may touch at a time.
constexpr int num_spheres = 12, max_contacts = 6;
template <class I>
using Bar = Running<Touching<I, 1, num_spheres, PoseDevice, 2, max_contacts>>;

/// Held with sphere i at a depth of i * step.
template <class I>
std::unique_ptr<Bar<I>> bar(Real step = 1e-4) {
  auto run = std::make_unique<Bar<I>>();
  auto& par = run->par;
  par.bodies[0].body = rigid_body(0.1, Vec3(3e-4, 3e-4, 3e-4).asDiagonal());
  par.bodies[0].coupling = spring(par.bodies[0].body, 1e4, 10);
  par.bodies[0].device.rise = 0;
  for (int i = 0; i < num_spheres; ++i) {
    const int row = i / 4, column = i % 4;
    add_sphere(par, 0, Vec3(0.02 * column, 0.02 * row, radius - i * step), radius);
  }
  add_plane(par);
  set_law(par, law);
  place(run->x, 0, {.X_WB = {}, .V_WB = {}});
  hold_at(*run, {});
  return run;
}

template <class I>
class ContactList : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(ContactList, BothIntegrators);

TYPED_TEST(ContactList, KeepsTheDeepestWhenFullAndSaysSo) {
  const auto run = bar<TypeParam>();
  run->step();
  EXPECT_EQ(run->out.fault, Fault::contacts_full);
  EXPECT_EQ(run->x.tick, 1u);
  EXPECT_EQ(run->out.contacts.num_near, std::size_t{max_contacts});
  ASSERT_EQ(run->x.contacts.size, std::size_t{max_contacts});
  for (std::size_t i = 0; i < max_contacts; ++i)
    EXPECT_EQ(sphere_of(run->x.contacts.list[i].key), num_spheres - max_contacts + i);
  run->device().target.X_WD.p.z() = 0.1;
  run->step(200);
  EXPECT_EQ(run->out.fault, Fault::none);
  EXPECT_EQ(run->x.tick, 201u);
  EXPECT_EQ(run->x.contacts.size, 0u);
}

/// Keeps the first of equally deep contacts.
TYPED_TEST(ContactList, IsInOrder) {
  const auto run = bar<TypeParam>(0);
  run->device().target.X_WD.p.z() = -0.002;
  for (int n = 0; n < 100; ++n) {
    run->step();
    ASSERT_EQ(run->out.fault, Fault::contacts_full);
  }
  ASSERT_EQ(run->x.contacts.size, std::size_t{max_contacts});
  for (std::size_t i = 1; i < run->x.contacts.size; ++i)
    EXPECT_LT(run->x.contacts.list[i - 1].key, run->x.contacts.list[i].key);
}

Pose wobble(std::uint64_t n) {
  const Real t = 1e-3 * static_cast<Real>(n);
  return {.p = Vec3(0.02 * std::sin(9 * t), 0.01 * std::sin(7 * t), 0.004 * std::sin(31 * t)),
          .q = exp_so3(Vec3(0.2 * std::sin(11 * t), 0.3 * std::sin(5 * t), 0.1))};
}
template <class Run>
void follow(Run& run) {
  run.device().target.X_WD = wobble(run.x.tick + 1);
  run.step();
}

/// Bit by bit, also from a state in mid-run, whatever the scratch holds.
TYPED_TEST(ContactList, IsReplayed) {
  using S = Touching<TypeParam, 1, num_spheres, PoseDevice, 2, max_contacts>;
  const auto run = bar<TypeParam>(), again = bar<TypeParam>();
  const auto elsewhere = bar<TypeParam>();
  elsewhere->device().target.X_WD.p.z() = -0.005;
  elsewhere->step(100);
  std::uint64_t touched = 0;
  for (int n = 0; n < 1000; ++n) {
    follow(*run);
    follow(*again);
    if (n % 100 == 50) again->w = elsewhere->w;
    ASSERT_EQ(run->hash(), again->hash()) << n;
    touched += run->x.contacts.size;
  }
  EXPECT_GT(touched, 500u);
  EXPECT_LT(touched, 1000u * max_contacts);
  State<S> other = run->x;
  other.contacts.size = 1;
  const std::uint64_t before = state_hash(run->par, other);
  other.contacts.list[0].xi_b += Column(Vec3(1e-12, 0, 0));
  EXPECT_NE(state_hash(run->par, other), before);  // the hash sees contacts
}

TYPED_TEST(ContactList, OutlivesInputsThatAreNoNumbers) {
  const auto run = bar<TypeParam>(), untroubled = bar<TypeParam>();
  for (int n = 0; n < 400; ++n) {
    follow(*untroubled);
    const std::uint64_t before = run->hash();
    for (const Real bad : {std::nan(""), 1e308, std::numeric_limits<Real>::infinity()}) {
      run->device().target.X_WD = wobble(run->x.tick + 1);
      run->device().target.X_WD.p.z() = bad;
      run->step();
      ASSERT_TRUE(has(run->out.fault, Fault::input_not_finite | Fault::state_not_finite)) << bad;
      ASSERT_EQ(run->hash(), before) << bad;
    }
    follow(*run);
    ASSERT_EQ(run->hash(), untroubled->hash()) << n;
  }
}

/// A law without stiffness and depenetration velocity carries no force.
TYPED_TEST(ContactList, TakesLawsWithoutStiffness) {
  for (const ContactLaw& soft :
       {ContactLaw{.push_out = 0}, ContactLaw{}, ContactLaw{.c = 1, .push_out = 0}}) {
    const auto run = bar<TypeParam>();
    set_law(run->par, soft);
    run->device().target.X_WD.p.z() = -0.005;
    ASSERT_EQ(validate(run->par), Invalid::nothing);
    EnergyBalance<Touching<TypeParam, 1, num_spheres, PoseDevice, 2, max_contacts>> balance;
    balance.start(run->par, run->x);
    for (int n = 0; n < 200; ++n) {
      run->step();
      ASSERT_FALSE(has(run->out.fault, Fault::state_not_finite));
      balance.observe(run->par, run->x, run->w, run->out);
    }
    EXPECT_NEAR(run->body().X_WB.p.z(), -0.005, soft.c > 0 ? 1e-3 : 1e-6);
    EXPECT_FALSE(balance.gains());
  }
}

// Bodies that begin inside.

/// Highest speed of a sphere released with its centre on the surface, and its depth after a second.
struct LetOut {
  Real speed = 0, depth = 0;
};
template <class I>
LetOut let_out(Real k, Real zeta, Real h, const Pose& X_WS, bool from_box) {
  Bar<I> run;
  constexpr Real m = 0.01;
  run.par.h = h;
  run.par.bodies[0].body = rigid_body(m, 1e-6 * Mat3::Identity());
  const Real c = zeta * 2 * std::sqrt(k * m);
  add_sphere(run.par, 0, Vec3::Zero(), radius);
  if (from_box) add_box(run.par, X_WS, Vec3(0.05, 0.03, 0.02));
  else add_plane(run.par, X_WS);
  set_law(run.par, {.k = k, .c = c, .mu = 0.3, .k_t = k, .c_t = c});
  run.device().engaged = false;
  place(
      run.x, 0,
      {.X_WB = {.p = X_WS.p + X_WS.q * Vec3(0, 0, from_box ? 0.02 : 0), .q = Quat::Identity()}, .V_WB = {}});
  LetOut out;
  for (int n = 0; n < 1 / h; ++n) {
    run.step();
    EXPECT_FALSE(any(run.out.fault));
    out.speed = std::max(out.speed, run.body().v_W.norm());
  }
  out.depth = radius - nearest(run.par.contacts.surfaces[0].shape, run.body().X_WB.p, 1).distance;
  return out;
}

TYPED_TEST(ContactList, LetsBodiesOutSlowly) {
  Random random(1);
  Real fastest = 0;
  for (int decade = 2; decade <= 9; ++decade)
    for (const Real zeta : {0.0, 0.3, 1.0, 100.0})
      for (const Real h : {2e-4, 1e-3, 5e-3})
        for (const bool from_box : {false, true}) {
          const Pose X_WS{.p = random.vector(), .q = random.rotation()};
          const LetOut out = let_out<TypeParam>(std::pow(10, decade), zeta, h, X_WS, from_box);
          fastest = std::max(fastest, out.speed);
          EXPECT_LT(out.speed, 1) << "k 1e" << decade << ", " << zeta << ", h " << h;
          const bool slow = 2 * zeta * std::sqrt(0.01 / std::pow(10, decade)) > 0.1;  // c / k, s
          EXPECT_LT(out.depth, slow ? radius : 0.1 * radius)
              << "k 1e" << decade << ", " << zeta << ", h " << h;
        }
  std::printf("%s: relaxed at %.3f m/s at most\n", TypeParam::name, fastest);
}

// Parameters.

using BarParams = Params<Touching<ImplicitEuler, 1, num_spheres, PoseDevice, 2, max_contacts>>;

/// Returns the result of validate() for the bar after a change.
template <class Change>
Invalid validated(Change change) {
  const auto run = bar<ImplicitEuler>();
  change(run->par);
  return validate(run->par);
}

TEST(ContactParams, AreValid) {
  EXPECT_EQ(validated([](BarParams&) {}), Invalid::nothing);
  EXPECT_EQ(validated([](BarParams& par) { add_box(par, {}, Vec3(1, 2, 3)); }), Invalid::nothing);
}

TEST(ContactParams, NameABadSphere) {
  const auto sphere = [](auto change) {
    return validated([&](BarParams& par) { change(par.contacts.spheres[3]); });
  };
  const Real nan = std::nan("");
  for (const Real r : {0.0, -1.0, nan, std::numeric_limits<Real>::infinity()})
    EXPECT_EQ(sphere([&](BodySphere& s) { s.radius = r; }), Invalid::contact_sphere) << r;
  EXPECT_EQ(sphere([&](BodySphere& s) { s.p_B.y() = nan; }), Invalid::contact_sphere);
  EXPECT_EQ(sphere([](BodySphere& s) { s.body = 1; }), Invalid::contact_sphere);
  EXPECT_EQ(sphere([](BodySphere& s) { s.body = world; }), Invalid::contact_sphere);
  EXPECT_EQ(sphere([](BodySphere& s) { s.material = max_materials; }), Invalid::contact_sphere);
  EXPECT_EQ(validated([](BarParams& par) { par.contacts.num_spheres = num_spheres + 1; }),
            Invalid::contact_sphere);
}

TEST(ContactParams, NameABadSurface) {
  const auto surface = [](auto change) {
    return validated([&](BarParams& par) { change(par.contacts.surfaces[0]); });
  };
  EXPECT_EQ(surface([](Surface& s) { s.shape.kind = ShapeKind::box; }), Invalid::contact_surface);
  EXPECT_EQ(surface([](Surface& s) { s.shape.X_WS.p.x() = std::nan(""); }), Invalid::contact_surface);
  EXPECT_EQ(surface([](Surface& s) { s.shape.X_WS.q.w() = 2; }), Invalid::contact_surface);
  EXPECT_EQ(surface([](Surface& s) { s.body = 0; }), Invalid::contact_surface);  // of the world, here
  EXPECT_EQ(surface([](Surface& s) { s.material = max_materials; }), Invalid::contact_surface);
  EXPECT_EQ(validated([](BarParams& par) { par.contacts.num_surfaces = 3; }), Invalid::contact_surface);
}

TEST(ContactParams, NameABadLaw) {
  for (Real ContactLaw::*const member :
       {&ContactLaw::k, &ContactLaw::c, &ContactLaw::mu, &ContactLaw::k_t, &ContactLaw::c_t,
        &ContactLaw::push_out, &ContactLaw::ratio, &ContactLaw::ratio_t})
    for (const Real bad : {-1.0, std::nan(""), std::numeric_limits<Real>::infinity()})
      EXPECT_EQ(validated([&](BarParams& par) {
                  ContactLaw its = law;
                  its.*member = bad;
                  set_law(par, its, 2, 5);
                }),
                Invalid::contact_law);
  EXPECT_EQ(validated([](BarParams& par) { par.contacts.laws[1][2].k = 1; }),
            Invalid::contact_law);  // of 2 and 1?
  EXPECT_EQ(validated([](BarParams& par) { set_law(par, {.k = 1, .mu = 0.1}); }), Invalid::contact_law);
}

// Bytes.

struct Plain {
  static constexpr std::size_t max_bodies = 3;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Joints = TreeJoints<>;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
};

/// Parameters of a scene before there were contacts.
template <class S>
struct OldParams {
  Real h;
  std::size_t num_bodies;
  Vec3 gravity_W;
  std::array<BodyParams<S>, S::max_bodies> bodies;
};
template <class S>
struct OldState {
  std::array<BodyState<S>, S::max_bodies> bodies;
  std::uint64_t tick;
};
template <class S>
struct OldBodyOutput {
  Pose X_WB;
  Twist V_WB;
  typename S::Feedback::Output feedback;
  typename S::Joints::Output joint;
};
template <class S>
struct OldOutput {
  std::array<OldBodyOutput<S>, S::max_bodies> bodies;
  Fault fault;
  Limited limited;
};
template <class S>
struct OldScratch {
  using T = Lanes<S>;
  std::array<CouplingInput, S::max_bodies> pulls;
  std::array<Next<S>, max_groups<S>> next;
  std::array<TargetOf<T>, max_groups<S>> inside;
  std::array<RigidBodyStateOf<T>, max_groups<S>> bases;
  std::array<StageVelocityOf<T>, max_groups<S>> velocities;
  [[no_unique_address]] Tree<S::max_bodies, typename S::Joints> tree;
  [[no_unique_address]] std::array<Wrench, S::max_bodies> wanted;
  Iteration<S> iteration;
  decltype(Scratch<S>::means) means;  // of joint wrenches
};

TEST(SceneWithoutContacts, HasNotAByteForThem) {
  static_assert(!uses<ContactsOf<Plain>>);
  EXPECT_EQ(sizeof(Params<Plain>), sizeof(OldParams<Plain>));
  EXPECT_EQ(sizeof(State<Plain>), sizeof(OldState<Plain>));
  EXPECT_EQ(sizeof(Output<Plain>), sizeof(OldOutput<Plain>));
  EXPECT_EQ(sizeof(Scratch<Plain>), sizeof(OldScratch<Plain>));
}

}  // namespace
}  // namespace godobject::test_contact_list
