// Springs of nets four at a time, against the same spring by spring: products, factor, gains.
#include <gmock/gmock.h>

#include <numeric>

#include "tests/core/net/random_net.h"

namespace godobject::test_net_groups {
namespace {

using S = NetScene<ImplicitEuler>;
using Stage = NetStage<S::Net, S::max_bodies>;
using Vectors = std::array<Column, Stage::max_nodes>;

/// A net whose results compare up to rounding, in the last stage of some steps.
struct Stepped : RandomNet<ImplicitEuler> {
  explicit Stepped(unsigned seed)
      : RandomNet(seed, -1, [](Drawn& of) {
          of.k = std::clamp<Real>(of.k, 1, 1e4);
          of.m = std::clamp<Real>(of.m, 1e-4, 1e-2);
          of.contact_k = std::clamp<Real>(of.contact_k, 1, 1e5);
        }) {
    // some have reached their obstacles
    for (int n = 0; n < of.steps() / 2 && net().num_contacts == 0; ++n) this->step(1);
    Random random(seed);
    for (std::uint32_t n = 0; n < num(); ++n) this->x.net.nodes[n].v_W += 0.01 * random.vector();
    this->step(1);
  }
  Stage& net() { return this->w.contacts.net; }
  std::uint32_t num() const { return static_cast<std::uint32_t>(this->par.net.num_nodes); }
  Vectors drawn(unsigned seed) const {
    Random random(seed);
    Vectors v{};
    for (std::uint32_t n = 0; n < num(); ++n) v[n] = Column(random.vector());
    return v;
  }
};

/// (41) or (47) of one spring.
struct PlainSpring {
  Mat3 K;
  Vec3 J;
};
PlainSpring plain(const Stepped& run, const Stage& w, const NetSpring& s) {
  const Real h = run.par.h;
  const Vec3 x = w.p[s.j].vec() - w.p[s.i].vec(), x_dot = w.v[s.j].vec() - w.v[s.i].vec();
  const Real l = x.norm();
  const Vec3 u = l > 0 ? Vec3(x / l) : Vec3(Vec3::UnitZ());
  const Real a = w.report.majorised ? h * h * s.k
                 : l > 0            ? h * h * s.k * std::max<Real>(1 - s.l_0 / l, 0)
                                    : 0;
  const Real b = std::max<Real>(h * h * s.k + h * s.g - a, 0);
  const Mat3 K = a * Mat3::Identity() + b * u * u.transpose();
  return {.K = K, .J = K * x_dot - h * (s.k * (l - s.l_0) + s.g * u.dot(x_dot)) * u};
}
std::vector<PlainSpring> plain_springs(const Stepped& run, const Stage& w) {
  std::vector<PlainSpring> all;
  for (std::size_t s = 0; s < run.par.net.num_springs; ++s)
    all.push_back(plain(run, w, run.par.net.springs[s]));
  return all;
}

void expect_near(const std::vector<Vec3>& plain, const Vectors& got, Real tolerance, const std::string& of) {
  Real size = 0;
  for (const Vec3& a : plain) size = std::max(size, a.norm());
  ASSERT_GT(size, 0) << of;
  for (std::size_t n = 0; n < plain.size(); ++n)
    ASSERT_LE((plain[n] - got[n].vec()).norm(), tolerance * size) << of << ", node " << n;
}

constexpr unsigned num_nets = 48;  // six of each ordeal

TEST(NetGroups, ProductAndImpulsesAreThoseOfEachSpring) {
  for (unsigned seed = 0; seed < num_nets; ++seed) {
    Stepped run(seed);
    const Stage& w = run.net();
    const auto springs = plain_springs(run, w);
    const Vectors v = run.drawn(seed);
    Vectors y{}, J{};
    std::vector<Vec3> plain_y(run.num(), Vec3::Zero()), plain_J = plain_y;
    for (std::size_t s = 0; s < springs.size(); ++s) {
      const NetSpring& of = run.par.net.springs[s];
      const Vec3 Kd = springs[s].K * (v[of.j].vec() - v[of.i].vec());
      plain_y[of.j] += Kd;
      plain_y[of.i] -= Kd;
      plain_J[of.j] += springs[s].J;
      plain_J[of.i] -= springs[s].J;
    }
    add_springs_product(w, v, y);
    expect_near(plain_y, y, 1e-12, run.of.text());
    for (std::uint32_t n = 0; n < run.num(); ++n) {
      plain_J[n] += w.v_free[n].vec() * w.m[n] + w.J_anchor[n].vec();
      J[n] = w.b[n];
    }
    expect_near(plain_J, J, 1e-12, run.of.text());
  }
}

/// A thread is factored from its ends, and nothing is left out: one iteration is the solution.
TEST(NetGroups, FactorOfAThreadIsExact) {
  auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  const Stuff stuff{.m = 1e-3, .k = 1e4, .g = 0.1, .k_a = 1, .g_a = 0.01};
  for (std::uint32_t n = 0; n < 50; ++n) add_node(par, stuff, Vec3(0.01 * n, 0, 0));
  for (std::uint32_t n = 1; n < 50; ++n) add_spring(par, stuff, n - 1, n);
  for (std::uint32_t n = 50; n < 58; ++n) {  // with threads
    add_node(par, stuff, Vec3(0.05 * (n - 50), 0.01, 0));
    add_spring(par, stuff, n, 5 * (n - 50) + 3);
  }
  put_in_order(par.net);
  place_net(par.net, run->x);
  ASSERT_EQ(validate(par), Invalid::nothing);
  Random random(1);
  for (std::uint32_t n = 0; n < 58; ++n) run->x.net.nodes[n].v_W = random.vector();
  run->step();
  const Stage& w = run->w.contacts.net;
  Vectors r{}, y{}, z{};
  for (std::uint32_t n = 0; n < 58; ++n) r[n] = Column(random.vector());
  Vectors left = r;
  solve_nodes(w, left, z);
  add_springs_product(w, z, y);
  std::vector<Vec3> b;
  for (std::uint32_t n = 0; n < 58; ++n) {
    y[n] += z[n] * (w.m[n] + w.kappa[n]);
    b.push_back(r[n].vec());
  }
  expect_near(b, y, 1e-9, "a thread");
}

/// (43) by nodes in their order, and its solution.
std::vector<Vec3> plain_solution(const Stepped& run, const Stage& w, const Vectors& r) {
  const auto springs = plain_springs(run, w);
  const auto& par = run.par.net;
  std::vector<std::uint32_t> order(run.num());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](std::uint32_t n) { return 4 * par.places[n].group + par.places[n].lane; };
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return place(a) < place(b); });
  std::vector<Mat3> E(run.num());
  std::vector<Vec3> z(run.num());
  const auto each_spring = [&](std::uint32_t n, bool to_later, auto f) {
    for (std::size_t s = 0; s < springs.size(); ++s) {
      const NetSpring& of = par.springs[s];
      if (of.i != n && of.j != n) continue;
      const std::uint32_t other = of.i == n ? of.j : of.i;
      if ((place(n) < place(other)) == to_later) f(springs[s].K, other);
    }
  };
  for (const std::uint32_t n : order) {
    Mat3 D = (w.m[n] + w.kappa[n]) * Mat3::Identity();
    for (std::size_t c = 0; c < w.num_contacts; ++c) {
      const Vec3 normal = w.contacts[c].n.vec();
      if (w.contacts[c].node == n)
        D += w.contacts[c].a * Mat3::Identity() + w.contacts[c].b * normal * normal.transpose();
    }
    Vec3 sum = r[n].vec();
    each_spring(n, true, [&](const Mat3& K, std::uint32_t) { D += K; });
    each_spring(n, false, [&](const Mat3& K, std::uint32_t other) {
      D += K - K * E[other] * K;
      sum += K * z[other];
    });
    E[n] = D.inverse();
    z[n] = E[n] * sum;
  }
  for (auto n = order.rbegin(); n != order.rend(); ++n) {
    Vec3 sum = Vec3::Zero();
    each_spring(*n, true, [&](const Mat3& K, std::uint32_t other) { sum += K * z[other]; });
    z[*n] += E[*n] * sum;
  }
  return z;
}

TEST(NetGroups, FactorIsThatOfEachNode) {
  int num_touching = 0;
  for (unsigned seed = 0; seed < num_nets; ++seed) {
    Stepped run(seed);
    Stage& w = run.net();
    factor_nodes(w);
    num_touching += w.num_contacts > 0 ? 1 : 0;
    Vectors r = run.drawn(seed), z{};
    const std::vector<Vec3> plain = plain_solution(run, w, r);
    solve_nodes(w, r, z);
    expect_near(plain, z, 1e-9, run.of.text());
  }
  EXPECT_GE(num_touching, 4);
}

TEST(NetGroups, ContactsPutInAndTakenOutLeaveTheFactorOfTheRest) {
  int num_touching = 0;
  for (unsigned seed = 0; seed < num_nets; ++seed) {
    Stepped run(seed);
    Stage& w = run.net();
    if (w.num_contacts == 0) continue;
    ++num_touching;
    factor_nodes(w);
    const auto with_contacts = w.D_inverse;
    remove_contacts_from_factor(w);
    for (std::size_t c = 0; c < w.num_contacts; ++c) {
      const NodePlace& place = run.par.net.places[w.contacts[c].node];
      const Vec3 n = w.contacts[c].n.vec();
      const auto along = [&](const SymmetricPack& E) {
        return n.dot(
            lane(E * gathered(lanes_of_four, [&](std::size_t) -> const Vec3& { return n; }), place.lane));
      };
      if (w.contacts[c].a + w.contacts[c].b > 0) {
        EXPECT_GT(along(w.D_inverse[place.group]), along(with_contacts[place.group])) << run.of.text();
      }
    }
    add_contacts_to_factor(w);
    for (std::size_t g = 0; g < run.par.net.num_groups; ++g)
      for (int k = 0; k < 3; ++k) {
        const Pack &a = with_contacts[g].diagonal[k], &b = w.D_inverse[g].diagonal[k];
        for (std::size_t j = 0; j < run.par.net.groups[g].size; ++j)
          EXPECT_NEAR(a[j], b[j], 1e-12 * a[j]) << run.of.text();
      }
  }
  EXPECT_GE(num_touching, 4);
}

TEST(NetGroups, GainIsThatOfEachSpring) {
  for (unsigned seed = 0; seed < num_nets; ++seed) {
    Stepped run(seed);
    const Stage& w = run.net();
    const Vectors v = run.drawn(seed);
    const Real h = run.par.h;
    Real gained = 0, exchanged = 0, mass = 0;
    for (std::uint32_t n = 0; n < run.num(); ++n) {
      gained -= w.m[n] / 2 * (v[n].vec() - w.v_free[n].vec() + h * run.par.gravity_W).squaredNorm();
      mass += w.m[n];
    }
    for (std::size_t s = 0; s < run.par.net.num_springs; ++s) {
      const NetSpring& of = run.par.net.springs[s];
      const PlainSpring spring = plain(run, w, of);
      const Vec3 start = (w.p[of.j].vec() - w.p[of.i].vec()) - h * (w.v[of.j].vec() - w.v[of.i].vec()),
                 v_ji = v[of.j].vec() - v[of.i].vec();
      const auto U = [&](const Vec3& x) { return of.k / 2 * (x.norm() - of.l_0) * (x.norm() - of.l_0); };
      const Real dU = U(start + h * v_ji) - U(start);
      gained += dU + (spring.J - spring.K * v_ji).dot(v_ji);
      exchanged += std::abs(dU);
    }
    const SpringGain sum = spring_gain<S::Net>(run.par.net, v, run.par.gravity_W, h, w);
    EXPECT_NEAR(sum.gained, gained, 1e-9 * (std::abs(gained) + exchanged)) << run.of.text();
    EXPECT_NEAR(sum.exchanged, exchanged, 1e-9 * exchanged) << run.of.text();
    EXPECT_NEAR(sum.mass, mass, 1e-12 * mass);
  }
}

}  // namespace
}  // namespace godobject::test_net_groups
