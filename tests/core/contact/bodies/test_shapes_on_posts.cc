// A tray whose shape is a box, on a ball, capsule or box between its corners. It rests with its weight, and
// tips if its centre of mass is beside its support. Dropped shapes gain no energy.
#include <gtest/gtest.h>

#include <cstdio>

#include "core/energy_balance.h"
#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_shapes_on_posts {
namespace {

const Vec3 tray_half(0.05, 0.04, 0.005);
constexpr Real tray_mass = 0.2, post_mass = 1;
const ContactLaw law = law_of(2e4, 1, 0.5, tray_mass);

/// A post whose highest point is the origin.
struct Post {
  const char* name;
  ShapeParams shape;
};
Post post_of(const char* name, ShapeParams shape) {
  Real top = shape.radius;
  const Vec3 up_S = shape.X_WS.q.toRotationMatrix().transpose() * Vec3::UnitZ();
  if (shape.kind == ShapeKind::box) top = up_S.cwiseAbs().dot(shape.half_extents);
  if (shape.kind == ShapeKind::capsule) top += std::abs(up_S.z()) * shape.half_length;
  shape.X_WS.p = Vec3(0, 0, -top);
  return {name, shape};
}
ShapeParams turned(ShapeParams shape, const Vec3& turn) {
  shape.X_WS.q = exp_so3(turn);
  return shape;
}
ShapeParams ball(Real radius) { return {.kind = ShapeKind::sphere, .radius = radius}; }
ShapeParams capsule(Real radius, Real half_length) {
  return {.kind = ShapeKind::capsule, .radius = radius, .half_length = half_length};
}
ShapeParams box(const Vec3& half) { return {.kind = ShapeKind::box, .half_extents = half}; }

std::vector<Post> posts() {
  const Vec3 quarter(pi / 4, 0, 0);
  const Quat corner_up = Quat::FromTwoVectors(Vec3(1, 1, 1), Vec3::UnitZ());
  ShapeParams on_corner = box(Vec3::Constant(0.02));
  on_corner.X_WS.q = corner_up;
  return {post_of("ball", ball(0.02)),
          post_of("end of a capsule", capsule(0.02, 0.03)),
          post_of("short side of a capsule", turned(capsule(0.01, 0.02), Vec3(0, pi / 2, 0))),
          post_of("long side of a capsule", turned(capsule(0.01, 0.2), Vec3(0, pi / 2, 0))),
          post_of("corner of a box", on_corner),
          post_of("short edge of a box", turned(box(Vec3(0.02, 0.02, 0.02)), quarter)),
          post_of("long edge of a box", turned(box(Vec3(0.2, 0.02, 0.02)), quarter)),
          post_of("face of a box", box(Vec3(0.01, 0.01, 0.02)))};
}
bool has_area(const Post& post) { return std::string(post.name) == "face of a box"; }

/// A tray above a post, by `offset` beside it. with_spheres: true for a sphere at each corner of the tray.
struct Setting {
  bool on_body = false, with_spheres = false, with_other = false;
  Vec3 offset = Vec3::Zero();
  Real gap = 2e-4;
};

template <class S>
struct OnPost {
  std::unique_ptr<Pile<S>> pile = std::make_unique<Pile<S>>();
  std::size_t tray = 0;

  OnPost(const Post& post, const Setting& of) {
    set_law(pile->par, law);
    pile->par.gravity_W = Vec3(0, 0, -earth_gravity);
    if (!of.on_body) {
      auto& contacts = pile->par.contacts;
      contacts.surfaces[contacts.num_surfaces++] = {.shape = post.shape};
    } else {
      // a stiff coupling holds the post where it is
      const Pose X = post.shape.X_WS;
      const std::size_t i = pile->add(solid_ball(post_mass, 0.02), {.X_WB = X, .V_WB = {}});
      ShapeParams own = post.shape;
      own.X_WS = {};
      pile->carry(i, own);
      pile->hold_at(i, X, {.k = 1e6, .g = 1e3, .k_r = 1e4, .g_r = 10});
    }
    tray = pile->add(solid_box(tray_mass, tray_half),
                     {.X_WB = at(of.offset + Vec3(0, 0, tray_half.z() + of.gap)), .V_WB = {}});
    for (int k = 0; of.with_spheres && k < 8; ++k)
      add_sphere(pile->par, tray,
                 (tray_half - Vec3::Constant(2e-3))
                     .cwiseProduct(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)),
                 2e-3);
    pile->carry(tray, {.kind = ShapeKind::box, .half_extents = tray_half});
    if (of.with_other) pile->add_brick({.X_WB = at(Vec3(5, 0, 0)), .V_WB = {}});
  }
};

/// Returns the mean height and force on the tray over the last tenth of a run.
template <class S>
void expect_rest(const Post& post, const Setting& setting) {
  OnPost<S> run(post, setting);
  const Vec3 weight(0, 0, tray_mass * earth_gravity);
  ASSERT_TRUE(run.pile->run(0.3));
  const RigidBodyState& tray = run.pile->at(run.tray);
  EXPECT_LT((run.pile->out.bodies[run.tray].contact.F_W.f - weight).norm(), 1e-3 * weight.norm());
  EXPECT_LT(tray.v_W.norm(), 1e-5);
  EXPECT_LT(tray.w_B.norm(), 1e-3);
  // the springs of a few contacts bear the weight
  EXPECT_LT(tray.X_WB.p.z(), tray_half.z());
  EXPECT_GT(tray.X_WB.p.z(), tray_half.z() - 1.1 * weight.norm() / law.k - (setting.on_body ? 1e-4 : 0));
}

template <class I>
struct ShapesOnPosts : ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(ShapesOnPosts, Integrators);

TYPED_TEST(ShapesOnPosts, ATrayRestsWithItsWeight) {
  for (const Post& post : posts())
    for (const bool with_spheres : {false, true}) {
      SCOPED_TRACE(::testing::Message() << post.name << (with_spheres ? ", spheres at the corners" : ""));
      expect_rest<OneTool<TypeParam>>(post, {.with_spheres = with_spheres});
      for (const bool on_body : {false, true})
        for (const bool with_other : {false, true})
          expect_rest<FewBodies<TypeParam>>(
              post, {.on_body = on_body, .with_spheres = with_spheres, .with_other = with_other});
    }
}

TYPED_TEST(ShapesOnPosts, ATrayTipsIfItsCentreIsBesideItsSupport) {
  for (const Post& post : posts()) {
    if (!has_area(post)) continue;
    for (const bool on_body : {false, true})
      for (const bool with_spheres : {false, true})
        for (const Real x : {0.0085, 0.0115}) {
          OnPost<FewBodies<TypeParam>> run(
              post, {.on_body = on_body, .with_spheres = with_spheres, .offset = Vec3(x, 0, 0)});
          ASSERT_TRUE(run.pile->run(0.6));
          const Vec3 up = run.pile->at(run.tray).X_WB.q * Vec3::UnitZ();
          EXPECT_EQ(up.z() > 0.9999, x < 0.01) << "stays or tips at " << x;
          EXPECT_EQ(up.z() < 0.9, x > 0.01) << "stays or tips at " << x;
        }
  }
}

#ifdef NDEBUG
constexpr unsigned draws = 400;
#else
constexpr unsigned draws = 4;  // builds with assertions and sanitizers take a hundred times as long
#endif

ShapeParams drawn_shape(Random& random) {
  constexpr std::array kinds{ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};
  const auto length = [&] { return random.log_uniform(4e-3, 0.03); };
  switch (kinds[static_cast<std::size_t>(random.integer(0, 2))]) {
    case ShapeKind::sphere: return ball(length());
    case ShapeKind::capsule: return capsule(length(), length());
    default: return box(Vec3(length(), length(), length()));
  }
}

/// Drops a few drawn shapes onto a drawn post and onto each other. Returns the largest gain of energy (38),
/// as a share of the energy at work.
template <class I>
Real gain_of_fall(unsigned seed, std::size_t& contacts) {
  Random random(seed);
  auto pile = std::make_unique<Pile<FewBodies<I>>>();
  auto& par = pile->par;
  par.h = random.log_uniform(2e-4, 2e-3);
  par.gravity_W = Vec3(0, 0, -earth_gravity);
  const Real m = random.log_uniform(0.01, 0.5);
  set_law(par, law_of(random.log_uniform(1e3, 3e4), random.uniform(0, 1), random.uniform(0, 0.8), m));
  ShapeParams post = drawn_shape(random);
  post.X_WS = {.p = Vec3::Zero(), .q = random.rotation()};
  par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = post};
  const int num = random.integer(1, 3);
  for (int n = 0; n < num; ++n) {
    const ShapeParams shape = drawn_shape(random);
    const Pose X{.p = Vec3(0.01 * random.normal(), 0.01 * random.normal(), 0.11 + 0.1 * n),
                 .q = random.rotation()};
    const Real size = shape.radius + shape.half_length + shape.half_extents.norm();
    const std::size_t i = pile->add(solid_ball(m, size),
                                    {.X_WB = X, .V_WB = {.w = 3 * random.vector(), .v = Vec3(0, 0, -0.5)}});
    for (std::uint32_t j = 0; random.integer(0, 2) == 0 && j < num_points(shape.kind); ++j) {
      const ShapePoint point = point_of(shape, j, half_thickness(shape));
      add_sphere(par, i, point.p_S, point.r);
    }
    pile->carry(i, shape);
  }
  EnergyBalance<FewBodies<I>> balance;
  balance.start(par, pile->x);
  for (long n = std::lround(0.25 / par.h); n > 0; --n) {
    pile->step();
    EXPECT_FALSE(any(pile->out.fault));
    balance.observe(par, pile->x, pile->w, pile->out);
    EXPECT_FALSE(balance.gains()) << "seed " << seed << " at " << pile->x.tick;
    if (balance.gains()) break;
    contacts += pile->out.contacts.num_contacts;
  }
  const GainWatch& watch = balance.watch();
  return watch.at_work() > 0 ? watch.gained() / watch.at_work() : 0;
}

TYPED_TEST(ShapesOnPosts, DroppedShapesGainNoEnergy) {
  std::size_t contacts = 0;
  Real worst = 0;
  for (unsigned seed = 0; seed < draws; ++seed) {
    worst = std::max(worst, gain_of_fall<TypeParam>(seed, contacts));
  }
  std::printf("%zu contacts, largest gain %.1e of the energy at work\n", contacts, worst);
  EXPECT_GT(contacts, 10 * draws);
}

}  // namespace
}  // namespace godobject::test_shapes_on_posts
