// Nets at rest and in small motions, against independent solutions: an equilibrium by Newton's method, the
// catenary, the first frequency of a stretched sheet.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_statics {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

template <class S>
std::unique_ptr<Running<S>> empty_scene() {
  auto run = std::make_unique<Running<S>>();
  run->par.bodies[0].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
  run->in.devices[0] = {};
  return run;
}
template <class S>
Real speed(const Running<S>& run) {
  Real most = 0;
  for (std::size_t n = 0; n < run.par.net.num_nodes; ++n)
    most = std::max(most, run.x.net.nodes[n].v_W.norm());
  return most;
}
template <class S>
void solve_tightly(Running<S>& run) {
  run.par.net.max_iterations = 3000;
  run.par.net.tolerance = 1e-14 / (run.par.h * run.par.h);
}
/// Anchors a node to the world, or releases it.
template <class S>
void hold(Running<S>& run, std::size_t n, Real k) {
  run.par.net.nodes[n].k = k;
}

/// Steps towards the equilibrium of a net in the world by Newton's method, until it holds.
template <class S>
VectorXd equilibrium(const Params<S>& par, VectorXd x) {
  const auto n3 = static_cast<Eigen::Index>(3 * par.net.num_nodes);
  const auto at = [](std::size_t n) { return static_cast<Eigen::Index>(3 * n); };
  for (int k = 0; k < 50; ++k) {
    VectorXd F = VectorXd::Zero(n3);
    MatrixXd K = MatrixXd::Zero(n3, n3);
    for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
      const NetNode& node = par.net.nodes[n];
      F.segment<3>(at(n)) += node.m * par.gravity_W - node.k * (x.segment<3>(at(n)) - node.p_B);
      K.block<3, 3>(at(n), at(n)) += node.k * Mat3::Identity();
    }
    for (std::size_t s = 0; s < par.net.num_springs; ++s) {
      const NetSpring& spring = par.net.springs[s];
      const Eigen::Index i = at(spring.i), j = at(spring.j);
      const Vec3 d = x.segment<3>(j) - x.segment<3>(i);
      const Real l = d.norm();
      const Vec3 u = d / l, f = -spring.k * (l - spring.l_0) * u;
      const Mat3 k_s =
          spring.k * (u * u.transpose() + (1 - spring.l_0 / l) * (Mat3::Identity() - u * u.transpose()));
      F.segment<3>(j) += f;
      F.segment<3>(i) -= f;
      K.block<3, 3>(i, i) += k_s;
      K.block<3, 3>(j, j) += k_s;
      K.block<3, 3>(i, j) -= k_s;
      K.block<3, 3>(j, i) -= k_s;
    }
    const VectorXd dx = K.ldlt().solve(F);
    x += dx;
    if (dx.norm() < 1e-15 * x.norm()) return x;
  }
  return x;
}

/// A sheet held by its corners sags and rests.
template <class I>
void expect_equilibrium(bool tight) {
  using S = NetScene<I>;
  auto run = empty_scene<S>();
  auto& par = run->par;
  par.gravity_W = Vec3(1, 0.5, -9.81);
  add_sheet(par, {.m = 1e-3, .k = 60, .g = 0.12, .g_a = 0.01}, 7, 7,
            0.01);  // in air: springs do not damp a swing
  for (const std::size_t corner : {0u, 6u, 42u, 48u}) hold(*run, corner, 500);
  if (tight) solve_tightly(*run);
  place_net(par.net, run->x);
  ASSERT_EQ(validate(par), Invalid::nothing);
  run->step(8000);
  VectorXd x(3 * 49), p(3 * 49);
  for (std::size_t n = 0; n < 49; ++n) {
    x.segment<3>(static_cast<Eigen::Index>(3 * n)) = run->x.net.nodes[n].p_W;
    p.segment<3>(static_cast<Eigen::Index>(3 * n)) = par.net.nodes[n].p_B;
  }
  const VectorXd exact = equilibrium(par, x);
  const Real deformation = (exact - p).template lpNorm<Eigen::Infinity>();
  const Real miss = (exact - x).template lpNorm<Eigen::Infinity>() / deformation;
  std::printf("%s, %s iterations: sags by %.2e m, which it misses by %.1e of it; speed %.1e m/s\n", I::name,
              tight ? "many" : "default", deformation, miss, speed(*run));
  EXPECT_GT(deformation, 5e-3);
  EXPECT_LT(miss, 1e-6);
}

TEST(NetStatics, RestsInTheSolvedEquilibrium) {
  for (const bool tight : {true, false}) {
    expect_equilibrium<ImplicitEuler>(tight);
    expect_equilibrium<TrBdf2>(tight);
  }
}

/// The largest distance of a hanging chain of so many links from the catenary of its length, of its sag.
template <class I>
Real chain_error(std::size_t links) {
  using S = NetScene<I>;
  auto run = empty_scene<S>();
  auto& par = run->par;
  par.gravity_W = Vec3(0, 0, -9.81);
  const Real length = 0.3, span = 0.2, l_0 = length / static_cast<Real>(links), mass = 0.03;
  const Stuff chain{.m = mass / static_cast<Real>(links), .k = 1e4 * static_cast<Real>(links), .g = 0.5};
  // as a V at first
  for (std::size_t n = 0; n <= links; ++n) {
    const Real s = static_cast<Real>(n) / static_cast<Real>(links),
               depth = std::sqrt(length * length - span * span) / 2;
    add_node(par, chain, Vec3(span * (s - 0.5), 0, -depth * (1 - std::abs(2 * s - 1))));
    par.net.nodes[n].g = 0.02 * mass / static_cast<Real>(links) * 100;  // of the air
    if (n > 0)
      par.net.springs[par.net.num_springs++] = {.i = static_cast<std::uint32_t>(n - 1),
                                                .j = static_cast<std::uint32_t>(n),
                                                .k = chain.k,
                                                .g = chain.g,
                                                .l_0 = l_0};
  }
  put_in_order(par.net);
  hold(*run, 0, 1e7);
  hold(*run, links, 1e7);
  place_net(par.net, run->x);
  EXPECT_EQ(validate(par), Invalid::nothing);
  run->step(20000);
  EXPECT_LT(speed(*run), 1e-6);
  // 2 a sinh(span / 2 a) = length; at arc length s from the lowest point x = a asinh(s / a), z = a cosh(x /
  // a)
  Real lo = 1e-3, hi = 10;
  for (int k = 0; k < 200; ++k) {
    const Real a = (lo + hi) / 2;
    (2 * a * std::sinh(span / (2 * a)) > length ? lo : hi) = a;
  }
  const Real a = lo, top = a * std::cosh(span / (2 * a)), sag = top - a;
  Real most = 0;
  for (std::size_t n = 0; n <= links; ++n) {
    const Real s = length * (static_cast<Real>(n) / static_cast<Real>(links) - 0.5),
               x = a * std::asinh(s / a);
    most = std::max(most, (run->x.net.nodes[n].p_W - Vec3(x, 0, a * std::cosh(x / a) - top)).norm());
  }
  return most / sag;
}

TEST(NetStatics, AChainHangsAsACatenary) {
  const Real e_16 = chain_error<ImplicitEuler>(16), e_32 = chain_error<ImplicitEuler>(32),
             e_64 = chain_error<TrBdf2>(64);
  std::printf("chains of 16, 32, 64 links: %.1e, %.1e, %.1e of the sag from the catenary\n", e_16, e_32,
              e_64);
  EXPECT_LT(e_64, 1e-3);
  EXPECT_GT(e_16 / e_32, 3);  // of second order in the length of a link
  EXPECT_GT(e_32 / e_64, 3);
}

/// A square of n x n springs a side, stretched from l_0 to a, its rim held: m w^2 = 8 T / a sin^2(pi / 2 n),
/// T = k (a - l_0).
TEST(NetDynamics, AStretchedSheetHasItsFirstFrequency) {
  using S = NetScene<TrBdf2>;
  constexpr std::uint32_t n = 7;
  constexpr Real a = 0.01, l_0 = 0.008, k = 200, m = 1e-3;
  auto run = empty_scene<S>();
  auto& par = run->par;
  par.h = 5e-4;
  solve_tightly(*run);
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      add_node(par, {.m = m, .k_a = x % n == 0 || y % n == 0 ? 1e7 : 0}, a * Vec3(x, y, 0));
      if (x > 0) add_spring(par, {.k = k}, y * (n + 1) + x - 1, y * (n + 1) + x);
      if (y > 0) add_spring(par, {.k = k}, (y - 1) * (n + 1) + x, y * (n + 1) + x);
    }
  }
  put_in_order(par.net);
  for (std::size_t s = 0; s < par.net.num_springs; ++s) par.net.springs[s].l_0 = l_0;
  place_net(par.net, run->x);
  ASSERT_EQ(validate(par), Invalid::nothing);
  const auto mode = [&](std::size_t at) {
    const std::size_t row = at / (n + 1), column = at % (n + 1);
    return std::sin(pi * static_cast<Real>(column) / n) * std::sin(pi * static_cast<Real>(row) / n);
  };
  const auto amplitude = [&] {
    Real sum = 0;
    for (std::size_t at = 0; at < par.net.num_nodes; ++at) sum += mode(at) * run->x.net.nodes[at].p_W.z();
    return sum;
  };
  for (std::size_t at = 0; at < par.net.num_nodes; ++at) run->x.net.nodes[at].p_W.z() = 1e-5 * mode(at);
  const Real omega = std::sqrt(8 * k * (a - l_0) / (a * m)) * std::sin(pi / (2 * n));
  // from the first to the 21st time that it goes through zero
  Real before = amplitude(), first = 0;
  int crossings = 0;
  for (long step = 1; crossings < 21 && step < 40000; ++step) {
    run->step();
    const Real now = amplitude();
    if (before * now < 0) {
      const Real t = par.h * (static_cast<Real>(step) - now / (now - before));
      if (crossings++ == 0) first = t;
      if (crossings == 21) {
        const Real measured = 20 * pi / (t - first);
        std::printf("first frequency %.4f Hz, it is %.4f Hz\n", measured / (2 * pi), omega / (2 * pi));
        EXPECT_NEAR(measured, omega, 2e-3 * omega);
      }
    }
    before = now;
  }
  EXPECT_EQ(crossings, 21);
}

}  // namespace
}  // namespace godobject::test_net_statics
