// Near spheres of bodies and obstacles, against all pairs one by one: depth, point, normal and bodies.
#include <gtest/gtest.h>

#include <map>

#include "tests/core/contact/bodies/bricks.h"

namespace godobject::test_find_spheres {
namespace {

constexpr std::size_t num_bodies = 20, num_spheres = 160;
template <class Part>
struct SearchIn {
  Part::Params par;
  Part::State before;
  ContactFinder<Part, num_bodies> w;
  NearContacts<Part::max_contacts> near;

  static constexpr Real h = 5e-3;
  void find() { find_contacts(par, before, num_bodies, h, w, near); }
};
using Search = SearchIn<BodyContacts<num_spheres, 2, 4000>>;
constexpr std::uint32_t num_obstacles = 60;
using SearchOnObstacles = SearchIn<FixedContacts<num_spheres, num_obstacles, 4000>>;

/// Bodies of some spheres each, in a room of this size; a third of them on one tree of joints.
template <class In = Search>
std::unique_ptr<In> clusters(Real size, Random& random) {
  auto s = std::make_unique<In>();
  for (std::uint32_t i = 0; i < num_bodies; ++i) {
    TreePlace& at = s->w.at[i];
    at.p_W = at.a_W = size * random.vector();
    at.R_WB = random.rotation().toRotationMatrix();
    at.V = {.w = random.vector(), .v = random.vector()};
    s->w.owned[i].tree = i % 3 == 0 ? 0 : i;
    for (int k = random.integer(0, static_cast<int>(num_spheres / num_bodies)); k > 0; --k)
      s->par.spheres[s->par.num_spheres++] = {
          .body = i, .p_B = 0.03 * random.vector(), .radius = random.log_uniform(1e-3, 0.03)};
  }
  return s;
}

template <class In>
Vec3 centre(const In& s, const BodySphere& sphere) {
  const TreePlace& at = s.w.at[sphere.body];
  return at.p_W + at.R_WB * sphere.p_B;
}

TEST(FindSpheres, FindsWhatAllPairsOneByOneFind) {
  Random random(1);
  std::size_t contacts = 0;
  for (int n = 0; n < 1000; ++n) {
    const auto s = clusters(random.log_uniform(0.02, 1), random);
    s->find();
    std::map<std::pair<std::uint32_t, std::uint32_t>, const NearContact*> found;
    for (std::size_t i = 0; i < s->near.size; ++i) {
      const NearContact& c = s->near.list[i];
      if (i > 0) {
        EXPECT_LT(s->near.list[i - 1].key, c.key);
      }
      found[{c.of - 2, c.on - 2}] = &c;
    }
    EXPECT_EQ(found.size(), s->near.size);
    std::size_t expected = 0;
    for (std::uint32_t i = 0; i < s->par.num_spheres; ++i)
      for (std::uint32_t j = i + 1; j < s->par.num_spheres; ++j) {
        const BodySphere &a = s->par.spheres[i], &b = s->par.spheres[j];
        if (a.body == b.body || s->w.owned[a.body].tree == s->w.owned[b.body].tree) continue;
        const Vec3 apart = centre(*s, a) - centre(*s, b);
        const Real d = a.radius + b.radius - apart.norm();
        const Vec3 n_W = apart.normalized();
        // midway between the two surfaces
        const Vec3 p_W = (centre(*s, a) - a.radius * n_W + centre(*s, b) + b.radius * n_W) / 2;
        const auto velocity = [&](std::size_t body) {
          const TreePlace& at = s->w.at[body];
          return Vec3(at.V.v + at.V.w.cross(p_W - at.p_W));
        };
        const Real v_n = n_W.dot(velocity(a.body) - velocity(b.body));
        // where the stage is predicted to end, or where it starts
        if (std::max(d, d + Search::h * v_n) <= -contact_reach * std::min(a.radius, b.radius)) continue;
        ++expected;
        ASSERT_EQ(found.count({i, j}), 1u);
        const NearContact& c = *found[{i, j}];
        EXPECT_EQ(c.a, a.body);
        EXPECT_EQ(c.b, b.body);
        EXPECT_NEAR(c.d, d, 1e-12);
        EXPECT_LT((c.n_W - n_W).norm(), 1e-9);
        EXPECT_LT((c.p_W - p_W).norm(), 1e-12);
        EXPECT_NEAR(c.v_n, v_n, 1e-12);
      }
    EXPECT_EQ(s->near.size, expected);
    contacts += expected;
  }
  EXPECT_GT(contacts, 5000u);
}

/// A ball, capsule or box somewhere, as long or flat as it comes.
ShapeParams random_obstacle(Real size, Random& random) {
  constexpr std::array kinds{ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};
  const auto length = [&]() { return random.log_uniform(1e-3, 0.1); };
  return {.kind = kinds[static_cast<std::size_t>(random.integer(0, 2))],
          .X_WS = {.p = size * random.vector(), .q = random.rotation()},
          .half_extents = Vec3(length(), length(), length()),
          .radius = length(),
          .half_length = length()};
}

/// Spheres that are skipped four at a time are not near.
TEST(FindSpheres, FindsWhatAllObstaclesOneByOneAreTouchedBy) {
  Random random(3);
  std::size_t contacts = 0, apart = 0;
  for (int n = 0; n < 400; ++n) {
    const Real size = random.log_uniform(0.1, 0.5);
    const auto s = clusters<SearchOnObstacles>(size, random);
    for (auto& at : s->w.at) at.V = {.w = 0.02 * at.V.w, .v = 0.02 * at.V.v};  // slow: nothing is swept
    for (std::uint32_t o = 0; o < num_obstacles; ++o)
      s->par.surfaces[s->par.num_surfaces++].shape = random_obstacle(size, random);
    s->find();
    std::map<std::pair<std::uint32_t, std::uint32_t>, const NearContact*> found;
    for (std::size_t i = 0; i < s->near.size; ++i)
      found[{s->near.list[i].of - num_obstacles, s->near.list[i].on}] = &s->near.list[i];
    for (std::uint32_t i = 0; i < s->par.num_spheres; ++i)
      for (std::uint32_t o = 0; o < num_obstacles; ++o) {
        const BodySphere& a = s->par.spheres[i];
        const TreePlace& at = s->w.at[a.body];
        const Vec3 p_W = centre(*s, a);
        const SurfacePoint surface = nearest(s->par.surfaces[o].shape, p_W, 1);
        const Real d = a.radius - surface.distance;
        const Vec3 v = at.V.v + at.V.w.cross(p_W - a.radius * surface.n - at.a_W);
        const Real reached = std::max(d, d + SearchOnObstacles::h * surface.n.dot(v));
        if (surface.distance < 0) continue;  // it may have come in elsewhere: test_tunnelling.cc
        const auto c = found.find({i, o});
        ASSERT_EQ(c != found.end(), reached > -contact_reach * a.radius)
            << n << ": " << reached << " of " << a.radius;
        if (c == found.end()) {
          ++apart;
          continue;
        }
        ++contacts;
        EXPECT_NEAR(c->second->d, d, 1e-12);
        EXPECT_LT((c->second->n_W - surface.n).norm(), 1e-9);
      }
  }
  EXPECT_GT(contacts, 2000u);
  EXPECT_GT(apart, 10 * contacts);
}

/// If centres coincide, the bodies determine the normal; if those coincide too, the z axis.
TEST(FindSpheres, CoincidentCentresHaveANormal) {
  for (const Vec3& apart : {Vec3(0.004, 0, 0), Vec3(0, 0, 0)}) {
    auto s = std::make_unique<Search>();
    for (std::uint32_t i = 0; i < num_bodies; ++i) s->w.owned[i].tree = i;
    s->w.at[0].p_W = apart;
    s->par.num_spheres = 2;
    s->par.spheres[0] = {.body = 0, .p_B = -apart, .radius = 0.01};
    s->par.spheres[1] = {.body = 1, .p_B = Vec3::Zero(), .radius = 0.02};
    s->find();
    ASSERT_EQ(s->near.size, 1u);
    EXPECT_EQ(s->near.list[0].n_W, apart.norm() > 0 ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitZ()));
    EXPECT_NEAR(s->near.list[0].d, 0.03, 1e-15);
  }
}

/// A body that is somewhere that is no number touches nothing, and disturbs no other.
TEST(FindSpheres, ABodyThatIsNotFiniteIsLeftOut) {
  Random random(2);
  const auto s = clusters(0.05, random);
  s->find();
  const auto of_others = [&](std::uint32_t body) {
    std::vector<std::uint64_t> keys;
    for (std::size_t i = 0; i < s->near.size; ++i)
      if (s->near.list[i].a != body && s->near.list[i].b != body) keys.push_back(s->near.list[i].key);
    return keys;
  };
  const auto before = of_others(7);
  for (const Real odd : {std::numeric_limits<Real>::quiet_NaN(), std::numeric_limits<Real>::infinity()}) {
    s->w.at[7].p_W.x() = odd;
    s->find();
    EXPECT_EQ(of_others(7), before);
    EXPECT_EQ(before.size(), s->near.size);
  }
}

}  // namespace
}  // namespace godobject::test_find_spheres
