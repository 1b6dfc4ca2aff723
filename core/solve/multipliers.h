// Multipliers of closing joints (62) in a stage: the solution of an island is repeated with its factor until
// the multipliers have converged.
//
// One solve leaves a closing joint violated by the change of its multiplier, divided by K_rigid. The next
// step corrects the violation against the force of the joint, which adds energy. Near a singular pose of a
// loop, a joint has far less effective mass than its bodies, and the multiplier needs hundreds of solves.
// With r the change that a solve leaves, conjugate residuals (Stiefel 1955) solve
//
//   (63)  S x = r,  S = K L A^-1 L^T,   then   h F_0 += x,  V += A^-1 L^T x
//
// S is symmetric in the product a . K^-1 b, with eigenvalues from 0, of redundant directions, to 1.
#pragma once

#include <array>
#include <utility>

#include "core/solve/island_terms.h"

namespace godobject {

/// Impulses of all terms of a scene at their points, as unknowns of (63).
template <std::size_t max>
using TermImpulses = std::array<SpatialVector, max>;

/// Calls f(kind, number among all terms, stage) for the closing joints of an island.
template <class Contacts, std::size_t N, class F>
void each_closing_joint(const Island& island, BodyContactScratch<Contacts, N>& w, F f) noexcept {
  each_term(island, w, [&](auto kind, std::uint32_t t, const TermEdge&, auto& stage) noexcept {
    if constexpr (requires { kind.add_to_multiplier(SpatialVector{}, stage); }) f(kind, t, stage);
  });
}

/// Computes Sr = S r (63), and the velocities V = A^-1 L^T r.
template <class Contacts, std::size_t N, std::size_t max, class Vector>
void apply(const Island& island, const TermImpulses<max>& r, BodyContactScratch<Contacts, N>& w,
           TermImpulses<max>& Sr, Vector& V) noexcept {
  auto& b = w.x.Ap;
  w.system.each([&](std::uint32_t u) noexcept { b[u] = SpatialVector::zero(); });
  each_closing_joint(island, w, [&](auto kind, std::uint32_t t, const auto& stage) noexcept {
    kind.each_impulse_of(r[t], stage,
                         [&](std::uint32_t u, const SpatialVector& J) noexcept { b[u] = b[u] + J; });
  });
  solve_again(w.system, b, V);
  each_closing_joint(island, w, [&](auto kind, std::uint32_t t, const auto& stage) noexcept {
    Sr[t] = kind.stiff_impulse(V, stage);
  });
}

/// Converges the multipliers of an island's closing joints (63), after a solution by the complete factor. A
/// solution suffices if correcting its violation does work below 1 / rigid_mass_ratio of the kinetic energy.
/// Loops in motion need one solution. Iterations also end when the rest of r is redundant, or after as many
/// as there are constrained directions.
template <class Contacts, std::size_t N>
[[gnu::noinline]] void converge_multipliers(const Island& island,
                                            BodyContactScratch<Contacts, N>& w) noexcept {
  constexpr std::size_t max = Contacts::max_terms;
  constexpr Real small = 1 / rigid_mass_ratio;
  auto& x = w.x;
  TermImpulses<max> r, Sr, p, Sp;
  int joints = 0;
  const auto product = [&](const TermImpulses<max>& a, const TermImpulses<max>& b) noexcept {
    Real sum = 0;
    each_closing_joint(island, w, [&](auto kind, std::uint32_t t, const auto& stage) noexcept {
      sum += kind.weighted(a[t], b[t], stage);
    });
    return sum;
  };
  each_closing_joint(island, w, [&](auto kind, std::uint32_t t, const auto& stage) noexcept {
    r[t] = kind.force(x.V, stage) - stage.multiplier;
    ++joints;
  });
  const auto is_converged = [&]() noexcept {
    Real F_F = 0, T = 0;
    const Real r_r = product(r, r);
    each_closing_joint(island, w, [&](auto kind, std::uint32_t t, const auto& stage) noexcept {
      const SpatialVector F = stage.multiplier + r[t];
      F_F += kind.weighted(F, F, stage);
    });
    w.system.each([&](std::uint32_t u) noexcept { T += dot(x.V[u], times(w.stages[u], x.V[u])); });
    return !(F_F * r_r > small * small * T * T);
  };
  if (is_converged()) return;
  const Real smallest = product(r, r) * small * small;
  auto &V_p = x.p, &V_r = x.z;
  apply(island, r, w, Sr, V_r);
  p = r, Sp = Sr;
  w.system.each([&](std::uint32_t u) noexcept { V_p[u] = V_r[u]; });
  Real r_Sr = product(r, Sr);
  for (int k = 0; k < 6 * joints; ++k) {
    const Real Sp_Sp = product(Sp, Sp);
    if (!(Sp_Sp > smallest)) return;
    const Real alpha = r_Sr / Sp_Sp;
    each_closing_joint(island, w, [&](auto kind, std::uint32_t t, auto& stage) noexcept {
      kind.add_to_multiplier(p[t] * alpha, stage);
      kind.each_impulse_of(p[t] * alpha, stage, [&](std::uint32_t u, const SpatialVector& J) noexcept {
        w.system.add_impulse(u, J);
      });
      r[t] -= Sp[t] * alpha;
    });
    w.system.each([&](std::uint32_t u) noexcept { x.V[u] = x.V[u] + V_p[u] * alpha; });
    if (is_converged() || !(product(r, r) > smallest)) return;
    apply(island, r, w, Sr, V_r);
    const Real before = std::exchange(r_Sr, product(r, Sr)), beta = r_Sr / before;
    each_closing_joint(island, w, [&](auto, std::uint32_t t, const auto&) noexcept {
      p[t] = r[t] + p[t] * beta;
      Sp[t] = Sr[t] + Sp[t] * beta;
    });
    w.system.each([&](std::uint32_t u) noexcept { V_p[u] = V_r[u] + V_p[u] * beta; });
  }
}

}  // namespace godobject
