// Nets that touch each other and themselves: rest, folds, jaws, momenta, friction, symmetry and capacity.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/net/face_net.h"

namespace godobject::test_net_faces {
namespace {

/// A scene of nets of the world, beside a body far away.
template <class I, std::size_t contacts = 256>
struct Nets : Running<FaceScene<I, contacts>> {
  EnergyBalance<FaceScene<I, contacts>> balance;
  bool gains = false;
  Fault fault = Fault::none;

  Nets(Real h, const Vec3& gravity_W) {
    this->par.h = h;
    this->par.gravity_W = gravity_W;
    this->par.bodies[0].body = rigid_body(1, Mat3(Mat3::Identity()));
    this->in.devices[0].engaged = this->in.devices[0].valid = false;
    place(this->x, 0, {.X_WB = {.p = Vec3(0, 0, 50)}, .V_WB = {}});
  }
  void add_floor() { this->par.contacts.surfaces[this->par.contacts.num_surfaces++] = {.shape = {}}; }
  void start() {
    ASSERT_EQ(validate(this->par), Invalid::nothing);
    place_net(this->par.net, this->x);
    balance.start(this->par, this->x);
  }
  void run(int steps) {
    for (int n = 0; n < steps; ++n) {
      this->step();
      balance.observe(this->par, this->x, this->w, this->out);
      gains = gains || balance.gains();
      fault |= this->out.fault;
    }
  }
  /// Returns the mean position of the nodes [first, end).
  Vec3 mean(std::size_t first, std::size_t end) const {
    Vec3 p = Vec3::Zero();
    for (std::size_t n = first; n < end; ++n) p += this->x.net.nodes[n].p_W;
    return p / static_cast<Real>(end - first);
  }
};

constexpr auto is_on_world = [](const ContactForce& one) { return one.b == NetContactTerm::on_world; };
constexpr auto is_on_net = [](const ContactForce& one) { return one.b == NetContactTerm::on_net; };

template <class I>
class NetFaces : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(NetFaces, BothIntegrators);

/// Without the feature the upper sheet falls onto the floor, through the lower one.
TYPED_TEST(NetFaces, SheetsRestOnEachOther) {
  auto s = std::make_unique<Nets<TypeParam>>(1e-3, Vec3(0, 0, -9.81));
  const Stuff stuff{.m = 2e-4, .k = 100, .g = 0.02, .radius = 1e-3};
  add_touching_sheet(s->par, stuff, 7, 7, 0.005, {.p = Vec3(0, 0, 0.002)});
  const auto first =
      add_touching_sheet(s->par, stuff, 5, 5, 0.005, {.p = Vec3(0, 0, 0.006), .q = exp_so3(Vec3(0, 0, 0.4))});
  s->add_floor();
  s->par.contacts.laws[0][0] = {.k = 200, .c = 0.1, .mu = 0.3, .k_t = 200, .c_t = 0.1};
  s->start();
  s->run(800);
  const std::size_t num = s->par.net.num_nodes;
  const Real weight = static_cast<Real>(num) * stuff.m * 9.81,
             of_upper = static_cast<Real>(num - first) * stuff.m * 9.81;
  const Vec3 on_floor = force_of_nodes(*s, is_on_world);
  EXPECT_NEAR(on_floor.z(), weight, 2e-3 * weight);
  EXPECT_NEAR(s->mean(first, num).z() - s->mean(0, first).z(), 2 * stuff.radius, 0.05 * stuff.radius);
  // nodes of each sheet bear on faces of the other: both shares carry the upper sheet
  Real carried = 0;
  const auto& all = s->w.means.of_nodes;
  for (std::size_t i = 0; i < all.size; ++i)
    if (is_on_net(all.list[i])) carried += (all.list[i].a >= first ? 1 : -1) * all.list[i].F_W.z();
  EXPECT_NEAR(carried, of_upper, 0.01 * of_upper);
  EXPECT_FALSE(s->gains);
  EXPECT_FALSE(any(s->fault));
}

/// A bag pressed flat by a heavy upper half. Without the feature its walls pass through each other.
TYPED_TEST(NetFaces, ABagFoldsOnItself) {
  for (const bool touches_own : {true, false}) {
    auto s = std::make_unique<Nets<TypeParam>>(1e-3, Vec3(0, 0, -9.81));
    const Stuff stuff{.m = 3e-4, .k = 3, .g = 0.01, .g_a = 1e-2, .radius = 1e-3};
    add_bag(s->par, stuff, Vec3(0.02, 0.02, 0.006), 2, {.p = Vec3(0, 0, 0.008)}, touches_own);
    s->add_floor();
    s->par.contacts.laws[0][0] = {.k = 300, .c = 0.2, .mu = 0.3, .k_t = 300, .c_t = 0.2};
    s->start();
    s->run(600);
    Real lower = 0, upper = 0;
    int num = 0;  // pole nodes of both walls: inner ones, away from the rim
    for (std::size_t n = 0; n < s->par.net.num_nodes; ++n) {
      const Vec3 p = s->par.net.nodes[n].p_B - Vec3(0, 0, 0.008);
      if (p.head<2>().norm() > 0.012) continue;
      (p.z() > 0 ? upper : lower) += s->x.net.nodes[n].p_W.z();
      ++num;
    }
    const Real apart = 2 * (upper - lower) / num;
    std::printf("%s %d walls %.3g mm apart\n", TypeParam::name, touches_own, 1e3 * apart);
    if (touches_own) {
      EXPECT_GT(apart, 1.5 * stuff.radius);
    } else {
      EXPECT_LT(apart, stuff.radius);
    }
    EXPECT_FALSE(s->gains);
    EXPECT_FALSE(any(s->fault));
  }
}

/// Two jaws press two bags onto each other and let them go. Without the feature one passes through the other.
TYPED_TEST(NetFaces, BagsBetweenJawsStayApart) {
  auto s = std::make_unique<Nets<TypeParam>>(1e-3, Vec3(Vec3::Zero()));
  auto& par = s->par;
  par.num_bodies = 2;
  const auto target = [](std::size_t i, Real closed) {
    return Target{.X_WD = {.p = Vec3(0, 0, (i == 1 ? 1 : -1) * (0.030 - 0.014 * closed))}, .V_WD = {}};
  };
  for (std::size_t i = 0; i < 2; ++i) {
    par.bodies[i].body = rigid_body(0.05, Mat3(1e-5 * Mat3::Identity()));
    par.bodies[i].coupling = {.k = 500, .g = 10, .k_r = 1, .g_r = 0.05};
    par.bodies[i].device.rise = 0;
    par.contacts.surfaces[par.contacts.num_surfaces++] = {
        .body = i, .shape = {.kind = ShapeKind::box, .half_extents = Vec3(0.03, 0.03, 0.005)}};
    place(s->x, i, {.X_WB = target(i, 0).X_WD, .V_WB = {}});
    engage_at(s->x, i, target(i, 0));
  }
  const Stuff stuff{.m = 3e-4, .k = 200, .g = 0.02, .g_a = 1e-3, .radius = 1e-3};
  const Vec3 half(0.015, 0.012, 0.01);
  add_bag(par, stuff, half, 2, {.p = Vec3(0.001, 0, 0.0125)});
  const auto first = add_bag(par, stuff, half, 2, {.p = Vec3(0, 0.001, -0.0125)});
  par.contacts.laws[0][0] = {.k = 300, .c = 0.2, .mu = 0.3, .k_t = 300, .c_t = 0.2};
  s->start();
  Real nearest = 1, most = 0;
  for (int n = 0; n < 900; ++n) {
    const Real t = n * par.h, closed = std::clamp(std::min(t / 0.3, (0.9 - t) / 0.3), Real(0), Real(1));
    for (std::size_t i = 0; i < 2; ++i) {
      auto& device = s->in.devices[i];
      device.valid = device.engaged = true;
      device.target = target(i, closed);
    }
    s->run(1);
    nearest = std::min(nearest, s->mean(0, first).z() - s->mean(first, par.net.num_nodes).z());
    most = std::max(most, s->out.bodies[1].contact.F_W.f.z());
  }
  EXPECT_GT(nearest, 0.005);  // of 25 mm
  EXPECT_GT(most, 0.05);
  EXPECT_FALSE(s->gains);
  EXPECT_FALSE(any(s->fault));
}

/// Two free nets that collide keep their common momentum and angular momentum to rounding.
TYPED_TEST(NetFaces, CollidingNetsKeepTheirMomenta) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    Random random(seed);
    auto s = std::make_unique<Nets<TypeParam>>(random.log_uniform(2e-4, 1e-3), Vec3(Vec3::Zero()));
    const Stuff sheet{.m = 2e-4, .k = random.log_uniform(30, 300), .g = 0.02, .g_a = 1e-3, .radius = 1.5e-3};
    Stuff bag = sheet;
    bag.m *= random.log_uniform(0.1, 10);
    add_touching_sheet(s->par, sheet, 7, 7, 0.005, {.q = random.rotation()});
    const auto first = add_bag(s->par, bag, Vec3(0.012, 0.01, 0.008), 2,
                               {.p = 0.035 * random.direction(), .q = random.rotation()});
    const Real k = random.log_uniform(100, 500), c = 0.3 * std::sqrt(k * 2e-4);
    s->par.contacts.laws[0][0] = {.k = k, .c = c, .mu = 0.4, .k_t = k, .c_t = c};
    s->start();
    const Vec3 v_W = -0.5 * s->mean(first, s->par.net.num_nodes).normalized();
    for (std::size_t n = first; n < s->par.net.num_nodes; ++n) s->x.net.nodes[n].v_W = v_W;
    s->balance.start(s->par, s->x);
    const NetMomenta before = momenta_of(*s);
    std::size_t touched = 0;
    for (int n = 0; n < 0.1 / s->par.h; ++n) {
      s->run(1);
      touched = std::max(touched, s->out.net.num_contacts);
    }
    const NetMomenta after = momenta_of(*s);
    EXPECT_GT(touched, 0u) << "seed " << seed;
    EXPECT_LT((after.p - before.p).norm(), 1e-9 * before.speed) << "seed " << seed;
    EXPECT_LT((after.L - before.L).norm(), 1e-9 * before.turn) << "seed " << seed;
    EXPECT_FALSE(s->gains) << "seed " << seed;
    EXPECT_FALSE(any(s->fault)) << "seed " << seed;
  }
}

/// Returns the way of a sheet on an inclined, held sheet in 0.3 s, m, of that without friction.
template <class I>
Real slid(Real ratio) {
  constexpr Real slope = 0.3;
  auto s = std::make_unique<Nets<I>>(1e-3, 9.81 * Vec3(std::sin(slope), 0, -std::cos(slope)));
  Stuff held{.m = 1e-3, .k = 1000, .g = 0.1, .k_a = 1e4, .g_a = 3, .radius = 2e-3};
  add_touching_sheet(s->par, held, 9, 7, 0.01, {});
  const Stuff stuff{.m = 2e-4, .k = 300, .g = 0.05, .radius = 2e-3};
  const auto first = add_touching_sheet(s->par, stuff, 4, 4, 0.008, {.p = Vec3(-0.02, 0.001, 0.004)});
  const Real k = 500, c = 0.3;
  s->par.contacts.laws[0][0] = {.k = k, .c = c, .mu = ratio * std::tan(slope), .k_t = k, .c_t = c};
  s->start();
  const Real from = s->mean(first, s->par.net.num_nodes).x();
  s->run(300);
  EXPECT_FALSE(any(s->fault));
  EXPECT_FALSE(s->gains);
  return (s->mean(first, s->par.net.num_nodes).x() - from) / (0.5 * 9.81 * std::sin(slope) * 0.3 * 0.3);
}
TYPED_TEST(NetFaces, ASheetSticksOnASheetBelowTheThresholdOnly) {
  EXPECT_NEAR(slid<TypeParam>(2), 0, 2e-3);
  EXPECT_NEAR(slid<TypeParam>(1.1), 0, 2e-3);
  EXPECT_NEAR(slid<TypeParam>(0.5), 0.5, 0.1);
}

/// Random pairs far outside comfort gain no energy. With TR-BDF2 three do, two of them in contact at
/// 6e6 N/m and above, and report it.
TYPED_TEST(NetFaces, NeverGainEnergy) {
  unsigned touched = 0, gaining = 0;
  constexpr unsigned seeds = 60;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    Random random(1000 + seed);
    const Real a = random.log_uniform(1e-3, 1e-2);
    const Vec3 gravity_W(0, 0, -9.81 * random.integer(0, 1));
    auto s = std::make_unique<Nets<TypeParam>>(random.log_uniform(1e-4, 5e-3), gravity_W);
    const auto stuff = [&] {
      const Real m = random.log_uniform(1e-6, 1e-1), k = random.log_uniform(1, 1e7);
      return Stuff{.m = m,
                   .k = k,
                   .g = random.integer(0, 1) * random.uniform(0, 1) * std::sqrt(k * m),
                   .g_a = random.integer(0, 1) * 1e-2 * std::sqrt(k * m),
                   .radius = a * random.uniform(0.2, 0.6)};
    };
    const Pose X_sheet{.q = random.rotation()};
    add_touching_sheet(s->par, stuff(), 6, 6, a, X_sheet, true);
    const Pose X_bag{.p = 8 * a * random.direction(), .q = random.rotation()};
    const auto first = add_bag(s->par, stuff(), a * Vec3(2.5, 2, 2), 2, X_bag);
    const Real k = random.log_uniform(1, 1e7), c = random.uniform(0, 1) * std::sqrt(k * 1e-4);
    s->par.contacts.laws[0][0] = {
        .k = k, .c = c, .mu = random.integer(0, 1) * random.uniform(0, 1), .k_t = k, .c_t = c};
    s->start();
    const Vec3 v_W = -random.log_uniform(0.1, 20) * s->mean(first, s->par.net.num_nodes).normalized();
    for (std::size_t n = first; n < s->par.net.num_nodes; ++n) s->x.net.nodes[n].v_W = v_W;
    s->balance.start(s->par, s->x);
    bool pressed = false;
    for (int n = 0; n < 120; ++n) {
      s->run(1);
      pressed = pressed || s->out.net.num_contacts > 0;
    }
    EXPECT_FALSE(has(s->fault, Fault::state_not_finite)) << "seed " << seed;
    touched += pressed ? 1 : 0;
    if (!s->gains) continue;
    ++gaining;
    std::printf("%s seed %u gains %.3g of %.3g J\n", TypeParam::name, seed, s->balance.watch().gained(),
                s->balance.watch().at_work());
  }
  std::printf("%s: %u of %u touched, %u gain\n", TypeParam::name, touched, seeds, gaining);
  EXPECT_LE(gaining, TypeParam::order == 1 ? 0u : 3u);
  EXPECT_GT(touched, seeds / 3);
}

/// A fast sheet of thin material does not pass another in a step, though it moves many thicknesses in one.
TYPED_TEST(NetFaces, AFastNetDoesNotPassAThinOne) {
  for (const Real speed : {1.0, 5.0, 20.0}) {
    auto s = std::make_unique<Nets<TypeParam>>(1e-3, Vec3(Vec3::Zero()));
    const Stuff wall{.m = 1e-2, .k = 1e4, .g = 1, .k_a = 1e4, .g_a = 10, .radius = 2e-4};
    add_touching_sheet(s->par, wall, 9, 9, 0.005, {});
    const Stuff thrown{.m = 1e-4, .k = 100, .g = 0.02, .radius = 2e-4};
    const auto first = add_touching_sheet(s->par, thrown, 4, 4, 0.005, {.p = Vec3(1e-3, 2e-3, 0.03)});
    s->par.contacts.laws[0][0] = {.k = 1e5, .c = 1};
    s->start();
    for (std::size_t n = first; n < s->par.net.num_nodes; ++n) s->x.net.nodes[n].v_W = Vec3(0, 0, -speed);
    s->balance.start(s->par, s->x);
    s->run(static_cast<int>(0.06 / (speed * s->par.h)) + 2);
    for (std::size_t n = first; n < s->par.net.num_nodes; ++n)
      EXPECT_GT(s->x.net.nodes[n].p_W.z(), -0.001) << speed << " m/s, node " << n;
  }
}

/// More contacts than there is room for are a fault; the step is taken.
TYPED_TEST(NetFaces, AFullListIsAFault) {
  auto s = std::make_unique<Nets<TypeParam, 8>>(1e-3, Vec3(0, 0, -9.81));
  const Stuff stuff{.m = 2e-4, .k = 100, .g = 0.02, .k_a = 10, .radius = 1e-3};
  add_touching_sheet(s->par, stuff, 5, 5, 0.005, {});
  add_touching_sheet(s->par, stuff, 5, 5, 0.005, {.p = Vec3(1e-3, 1e-3, 0.0015)});
  s->par.contacts.laws[0][0] = {.k = 200, .c = 0.1};
  s->start();
  s->run(1);
  EXPECT_TRUE(has(s->fault, Fault::contacts_full));
  EXPECT_EQ(s->x.tick, 1u);
}

/// Rotated and mirrored scenes move likewise.
TYPED_TEST(NetFaces, RotatedAndMirroredNetsMoveLikewise) {
  const auto moved = [](const Quat& q, bool mirrored) {
    auto s = std::make_unique<Nets<TypeParam>>(1e-3, Vec3(q * Vec3(0, 0, -9.81)));
    const Stuff stuff{.m = 2e-4, .k = 100, .g = 0.02, .k_a = 2, .g_a = 0.01, .radius = 1e-3};
    add_touching_sheet(s->par, stuff, 6, 5, 0.005, {});
    const Stuff free{.m = 2e-4, .k = 100, .g = 0.02, .radius = 1e-3};
    add_touching_sheet(s->par, free, 4, 4, 0.005,
                       {.p = Vec3(2e-3, 1e-3, 0.004), .q = exp_so3(Vec3(0.2, 0.1, 0.5))});
    for (std::size_t n = 0; n < s->par.net.num_nodes; ++n) {
      Vec3& p = s->par.net.nodes[n].p_B;
      if (mirrored) p.x() = -p.x();
      p = q * p;
    }
    put_in_order(s->par.net);
    s->par.contacts.laws[0][0] = {.k = 200, .c = 0.1, .mu = 0.4, .k_t = 200, .c_t = 0.1};
    s->par.net.max_iterations = 500;
    s->par.net.tolerance = 1e-6;
    s->start();
    s->run(60);
    EXPECT_GT(s->out.net.num_contacts, 3u);
    std::vector<Vec3> p;
    for (std::size_t n = 0; n < s->par.net.num_nodes; ++n) {
      p.push_back(q.conjugate() * s->x.net.nodes[n].p_W);
      if (mirrored) p.back().x() = -p.back().x();
    }
    return p;
  };
  const std::vector<Vec3> as_is = moved(Quat::Identity(), false);
  for (const auto& other : {moved(exp_so3(Vec3(0.7, -1.1, 0.4)), false), moved(Quat::Identity(), true)})
    for (std::size_t n = 0; n < as_is.size(); ++n) EXPECT_LT((other[n] - as_is[n]).norm(), 1e-7) << n;
}

/// The nearest point by its definition: the least distance over a grid of weights, refined about the best.
Vec3 nearest_by_search(const Corners& t, const Vec3& p) {
  const auto at = [&](Real u, Real v) -> Vec3 { return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]); };
  Real u = 1.0 / 3, v = 1.0 / 3;
  for (Real step = 0.25; step > 1e-9; step /= 1.1) {
    Real best_u = u, best_v = v, least = (at(u, v) - p).squaredNorm();
    for (int i = -3; i <= 3; ++i)
      for (int j = -3; j <= 3; ++j) {
        const Real b = std::clamp(u + i * step, Real(0), Real(1)),
                   c = std::clamp(v + j * step, Real(0), 1 - b), d = (at(b, c) - p).squaredNorm();
        if (d < least) {
          least = d;
          best_u = b;
          best_v = c;
        }
      }
    u = best_u;
    v = best_v;
  }
  return at(u, v);
}

TEST(NearestOnFace, AgreesWithASearch) {
  Random random(7);
  for (int n = 0; n < 4000; ++n) {
    const Corners t{random.vector(), random.vector(), random.vector()};
    const Vec3 p = random.log_uniform(0.01, 3) * random.vector();
    const FacePoint q = nearest_on_face(t, p);
    EXPECT_NEAR(q.weights.sum(), 1, 1e-12);
    EXPECT_GE(q.weights.minCoeff(), 0);
    EXPECT_NEAR((q.of(t) - p).norm(), (nearest_by_search(t, p) - p).norm(), 1e-6) << n;
  }
}
TEST(NearestOnFace, OfATriangleWithoutArea) {
  const Corners line{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(3, 0, 0)};
  EXPECT_NEAR((nearest_on_face(line, Vec3(2, 1, 0)).of(line) - Vec3(2, 0, 0)).norm(), 0, 1e-12);
  const Corners point{Vec3::Ones(), Vec3::Ones(), Vec3::Ones()};
  EXPECT_EQ(nearest_on_face(point, Vec3::Zero()).of(point), Vec3(Vec3::Ones()));
}

}  // namespace
}  // namespace godobject::test_net_faces
