// Mechanisms of one coordinate against its equation: a slider-crank, and a ladder of 1025 links whose 512
// windows are loops (IFToMM's N four-bars).
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/term/mechanism.h"

namespace godobject::test_ladder {
namespace {

constexpr Real gravity = 9.81, L = 1, m = 1;  // of each rod

/// Ladder of N windows: N + 1 uprights hinged to the ground, N rungs between their tops.
template <class I, std::size_t N>
std::unique_ptr<Running<Looped<I, 2 * N + 1, N>>> ladder(Real h) {
  auto run = std::make_unique<Running<Looped<I, 2 * N + 1, N>>>();
  run->par.num_bodies = 0;
  run->par.h = h;
  run->par.gravity_W = Vec3(0, -gravity, 0);
  const Real I_l = m * L * L / 12;
  const Mat3 I_B = Vec3(0.01 * I_l, I_l, I_l).asDiagonal();
  const auto at = [](const Vec3& p) { return Pose{.p = p, .q = Quat::Identity()}; };
  const auto foot = [](std::size_t i) { return Vec3(L * static_cast<Real>(i), 0, 0); };
  const Vec3 up(0, L, 0);
  std::uint32_t before = 0;
  for (std::size_t i = 0; i <= N; ++i) {
    const std::uint32_t upright =
        add_link(*run, m, I_B, rod(foot(i), foot(i) + up), JointKind::hinge, world, at(foot(i)));
    if (i > 0) close_loop(*run, JointKind::hinge, before, upright, at(foot(i) + up));
    if (i == N) break;
    before = add_link(*run, m, I_B, rod(foot(i) + up, foot(i + 1) + up), JointKind::hinge, upright,
                      at(foot(i) + up));
  }
  for (std::size_t i = 0; i < run->par.num_bodies; ++i) {
    auto& x = run->x.bodies[i].x;
    const bool is_rung = std::abs(x.X_WB.p.y() - L) < 1e-9;
    x.v_W = Vec3(is_rung ? 1 : 0.5, 0, 0);
    if (!is_rung) x.w_B = x.X_WB.q.conjugate() * Vec3(0, 0, -1 / L);
  }
  EXPECT_EQ(validate(run->par), Invalid::nothing);
  start_turns(run->par, run->x);
  return run;
}

/// Returns the lean of the uprights at time t.
Real lean(std::size_t N, Real t) {
  const Real n = static_cast<Real>(N);
  const Real M = ((n + 1) / 3 + n) * m * L * L, G = ((n + 1) / 2 + n) * m * gravity * L;
  return coordinate_at(
      t, [M](Real) { return M; }, [G](Real q) { return G * std::cos(q); }, 0, 1 / L);
}

template <class I, std::size_t N>
void check(Real h, Real T, Real tolerance) {
  const auto run = ladder<I, N>(h);
  Real farthest = 0;
  for (long n = 0; n < std::lround(T / h); ++n) {
    run->step();
    ASSERT_EQ(run->out.fault, Fault::none) << I::name << " at step " << n;
    farthest = std::max(farthest, apart(*run));
  }
  const Real exact = lean(N, T);
  Real worst = 0;
  for (std::size_t i = 0; i < run->par.num_bodies; ++i) {
    const Vec3 axis = run->x.bodies[i].x.X_WB.q * Vec3::UnitX();
    const bool is_rung = i % 2 == 1;
    worst =
        std::max(worst, is_rung ? std::abs(std::atan2(axis.y(), axis.x()))
                                : std::abs(std::remainder(std::atan2(axis.x(), axis.y()) - exact, 2 * pi)));
  }
  std::printf("%s: %zu links, lean %.4f rad off by %.1e, apart by %.1e m\n", I::name, 2 * N + 1, exact, worst,
              farthest);
  EXPECT_LT(worst, tolerance);
  EXPECT_LT(farthest, 1e-6);
}

constexpr Real crank = 0.05, rod_length = 0.15, m_crank = 0.1, m_rod = 0.3, m_piston = 0.5;

/// Crank on the ground, rod on its end, and a piston on rails along x that the rod's end drives.
template <class I>
std::unique_ptr<Running<Looped<I>>> slider_crank(Real h, Real start) {
  auto run = std::make_unique<Running<Looped<I>>>();
  run->par.num_bodies = 0;
  run->par.h = h;
  run->par.gravity_W = Vec3(0, -gravity, 0);
  const auto thin = [](Real mass, Real l) {
    const Real I_l = mass * l * l / 12;
    return Mat3(Vec3(0.01 * I_l, I_l, I_l).asDiagonal());
  };
  const auto hinge_at = [](const Vec3& p) { return Pose{.p = p, .q = Quat::Identity()}; };
  const Vec3 A = crank * Vec3(std::cos(start), std::sin(start), 0);
  const Vec3 B(A.x() + std::sqrt(rod_length * rod_length - A.y() * A.y()), 0, 0);
  const auto of_crank = add_link(*run, m_crank, thin(m_crank, crank), rod(Vec3::Zero(), A), JointKind::hinge,
                                 world, hinge_at(Vec3::Zero()));
  const auto of_rod =
      add_link(*run, m_rod, thin(m_rod, rod_length), rod(A, B), JointKind::hinge, of_crank, hinge_at(A));
  const auto piston = add_link(*run, m_piston, thin(m_piston, 0.02), hinge_at(B), JointKind::slider, world,
                               {.p = B, .q = turn_from_z(Vec3::UnitX())});
  close_loop(*run, JointKind::hinge, piston, of_rod, hinge_at(B));
  EXPECT_EQ(validate(run->par), Invalid::nothing);
  start_turns(run->par, run->x);
  return run;
}
Real inertia_of_crank(Real q) {
  const Real s = crank * std::sin(q), c = crank * std::cos(q), l = std::sqrt(rod_length * rod_length - s * s);
  const Real x_B = -s - s * c / l, turn = -c / l;  // rates of piston and rod
  const Vec3 v_mid((-s + x_B) / 2, c / 2, 0);
  return m_crank * crank * crank / 3 + m_piston * x_B * x_B + m_rod * v_mid.squaredNorm() +
         m_rod * rod_length * rod_length / 12 * turn * turn;
}

TEST(SliderCrank, TurnsAsItsEquationSays) {
  constexpr Real start = 1.2, T = 0.6;
  const Real exact = coordinate_at(
      T, inertia_of_crank, [](Real q) { return (m_crank + m_rod) / 2 * gravity * crank * std::sin(q); },
      start);
  const auto error = [&]<class I>(I, Real h) {
    const auto run = slider_crank<I>(h, start);
    for (long n = 0; n < std::lround(T / h); ++n) {
      run->step();
      EXPECT_EQ(run->out.fault, Fault::none);
    }
    EXPECT_LT(apart(*run), 1e-6);
    return std::abs(start + run->x.bodies[0].joint.q[0] - exact);
  };
  const auto orders = [&](auto I, Real least_order) {
    const Real e_2 = error(I, 2e-3), e_1 = error(I, 1e-3);
    std::printf("%s: crank at %.4f rad off by %.1e, %.1e rad\n", decltype(I)::name, exact, e_2, e_1);
    EXPECT_GT(std::log2(e_2 / e_1), least_order) << decltype(I)::name;
    return e_1;
  };
  orders(ImplicitEuler{}, 0.7);
  EXPECT_LT(orders(TrBdf2{}, 1.8), 5e-4);  // of 5.4 rad
}

TEST(Ladder, OfOneWindowLeansAsItsEquationSays) {
  check<TrBdf2, 1>(1e-3, 1.2, 1e-4);
  check<ImplicitEuler, 1>(1e-3, 0.5, 1e-2);
}
TEST(Ladder, Of512WindowsLeansAsItsEquationSays) { check<TrBdf2, 512>(5e-3, 0.5, 1e-3); }

}  // namespace
}  // namespace godobject::test_ladder
