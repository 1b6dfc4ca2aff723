// The velocities of the bodies of an island, A V = b with the cases of their contacts given.
#pragma once

#include "core/contact/pairs.h"

namespace godobject {

/// The iterations, one at least, end when all bodies' velocities are known to this, m/s.
inline constexpr Real velocity_tolerance = 1e-3;

/// A sum of products over bodies.
class TwistSum {
 public:
  void add(const AnchorTwist& a, const AnchorTwist& b) noexcept { sum_ += a.w.p * b.w.p + a.v.p * b.v.p; }
  operator Real() const noexcept { return (sum_[0] + sum_[1]) + sum_[2]; }

 private:
  Pack sum_ = 0;
};

/// The velocity, m/s, of the centre of mass at which a body would have the kinetic energy that it has at V; squared.
inline Real speed_sq(const BodyStage& stage, const AnchorTwist& V) noexcept {
  return dot(V.v, V.v) + dot(V.w, stage.A_ww * V.w) / stage.M;
}

/// V = A^-1 b of an island that is factored. Returns what is left unbalanced: nothing.
template <class Contacts, std::size_t N>
Real solve_factored(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  w.tree.each_body(island, [&](std::uint32_t i, const TouchingBody&) noexcept { w.Ap[i] = w.b[i]; });
  solve(w.factor, w.Ap, w.V);
  w.tree.each_body(island, [&](std::uint32_t i, const TouchingBody&) noexcept { w.r[i] = {}; });
  return 0;
}

/// The largest force that b (1 - s) + r s leaves unbalanced, times h.
template <class Contacts, std::size_t N>
Real largest_left(Real s, const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  if constexpr (Contacts::jointed) {
    w.tree.each_body(island, [&](std::uint32_t i, const TouchingBody&) noexcept {
      w.Ap[i] = w.b[i] * (1 - s) + w.r[i] * s;
    });
    return largest_unborne(island, w.tree, w.stages, w.Ap);
  }
  Real most = 0;
  w.tree.each_body(island, [&](std::uint32_t i, const TouchingBody&) noexcept {
    const Column left = w.b[i].v * (1 - s) + w.r[i].v * s;
    most = std::max(most, dot(left, left));
  });
  return std::sqrt(most);
}

/// V = A^-1 b by conjugate gradients, from the best multiple of V_0 and with all directions conjugate to it: (28) holds
/// for every iterate as it does from rest; what rounding takes of it is given back in the end. Every step is the best
/// one along its direction. Returns the largest force that is left unbalanced, times h.
template <class Contacts, std::size_t N>
Real iterate(int most_iterations, const Island& island, BodyContactScratch<Contacts, N>& w,
             int& iterations) noexcept {
  const auto each = [&](auto f) noexcept {
    for (std::uint32_t k = island.first_body; k < island.end_body; ++k) f(w.tree.order[k]);
  };
  constexpr Real tiny = std::numeric_limits<Real>::min();
  multiply(island, w.tree, w.V_0, w.AV_0);
  TwistSum V_0_A_V_0, V_0_b;
  each([&](std::uint32_t i) noexcept {
    V_0_A_V_0.add(w.V_0[i], w.AV_0[i]);
    V_0_b.add(w.V_0[i], w.b[i]);
  });
  const Real norm_0 = std::max<Real>(V_0_A_V_0, tiny), scale = V_0_b / norm_0;
  each([&](std::uint32_t i) noexcept {
    w.V[i] = w.V_0[i] * scale;
    w.r[i] = w.Ap[i] = w.b[i] - w.AV_0[i] * scale;
  });
  Real last = 1;
  bool converged = false;
  for (int k = 0; k < most_iterations; ++k) {
    solve(island, w.tree, w.Ap, w.z);
    Real error_sq = 0;
    TwistSum rz, AV_0_z;
    each([&](std::uint32_t i) noexcept {
      error_sq = std::max(error_sq, speed_sq(w.stages[i], w.z[i]));
      rz.add(w.r[i], w.z[i]);
      AV_0_z.add(w.AV_0[i], w.z[i]);
    });
    converged = k > 0 && error_sq <= velocity_tolerance * velocity_tolerance;
    if (converged || !(rz > 0)) break;  // otherwise the tree has lost its last digits: no direction is left
    const Real mu = AV_0_z / norm_0, beta = rz / last;
    last = rz;
    each([&](std::uint32_t i) noexcept {
      w.p[i] = (k == 0 ? w.z[i] : w.z[i] + w.p[i] * beta) - w.V_0[i] * mu;
    });
    multiply(island, w.tree, w.p, w.Ap);
    TwistSum pr, pAp;
    each([&](std::uint32_t i) noexcept {
      pr.add(w.p[i], w.r[i]);
      pAp.add(w.p[i], w.Ap[i]);
    });
    const Real alpha = pr / std::max<Real>(pAp, tiny);
    each([&](std::uint32_t i) noexcept {
      w.V[i] = w.V[i] + w.p[i] * alpha;
      w.r[i] = w.Ap[i] = w.r[i] - w.Ap[i] * alpha;
    });
    ++iterations;
  }
  if (!converged) {  // r of the recurrence may have drifted
    multiply(island, w.tree, w.V, w.Ap);
    each([&](std::uint32_t i) noexcept { w.r[i] = w.b[i] - w.Ap[i]; });
  }
  // A V = b - r
  TwistSum V_b, V_r;
  each([&](std::uint32_t i) noexcept {
    V_b.add(w.V[i], w.b[i]);
    V_r.add(w.V[i], w.r[i]);
  });
  const Real V_A_V = V_b - V_r, balance = V_A_V > tiny ? V_b / V_A_V : 1;
  each([&](std::uint32_t i) noexcept { w.V[i] = w.V[i] * balance; });
  return largest_left(balance, island, w);
}

}  // namespace godobject
