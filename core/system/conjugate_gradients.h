// Solution of A V = b by conjugate gradients, preconditioned by the incomplete factor if blocks are short.
#pragma once

#include <limits>

#include "core/system/block_factor.h"
#include "core/tuning.h"

namespace godobject {

/// Vectors of the iteration, undefined between steps. V: solution, r = b - A V; V_0: start, and A V_0.
template <class System>
struct SystemVectors {
  typename System::Vector V, V_0, r, AV_0, z, p, Ap;
};

/// Computes V^T A V of a positive definite A; zero if it is below its own rounding, because V has no length
/// then.
class SquaredLength {
 public:
  template <class Vector>
  void add(const Vector& V, const Vector& AV) noexcept {
    sum_.add(V, AV);
    size_.add(abs(V), abs(AV));
  }
  operator Real() const noexcept {
    const Real sum = sum_, size = size_;
    return sum > std::numeric_limits<Real>::epsilon() * size ? sum : 0;
  }

 private:
  static Column abs(const Column& v) noexcept { return Column(godobject::abs(v.p)); }
  static SpatialVector abs(const SpatialVector& V) noexcept { return {.w = abs(V.w), .v = abs(V.v)}; }

  SpatialSum sum_, size_;
};

/// End of an iteration: its number of steps, and whether all velocities converged.
struct Iterated {
  int iterations = 0;
  bool converged = false;
};

/// Scales V, A V = b - r, so that (28) holds up to rounding.
template <class System, class Vectors>
void keep_balance(const System& system, Vectors& x) noexcept {
  const auto& b = system.b;
  SpatialSum V_b, V_r;
  system.each([&](auto u) noexcept {
    V_b.add(x.V[u], b[u]);
    V_r.add(x.V[u], x.r[u]);
  });
  const Real V_A_V = V_b - V_r, balance = V_A_V > std::numeric_limits<Real>::min() ? V_b / V_A_V : 1;
  system.each([&](auto u) noexcept {
    x.V[u] = x.V[u] * balance;
    x.r[u] = b[u] * (1 - balance) + x.r[u] * balance;
  });
}

/// Iterates from the best multiple of V_0, with all directions conjugate to V_0. Every iterate then has the
/// energy balance of the exact solution, as iterations from V = 0 do:
///
///   (28)  V^T A V = V^T b
///
/// Rounding errors of this balance are corrected at the end. A direction without a length ends the iteration.
/// Each step length is optimal along its direction. The system keeps its loaded values: is_complete is false.
/// speed_sq(u, V): squared speed of unknown u at V. tolerance: m/s; the iteration ends when all speeds are
/// below it.
template <class System, class Vectors, class Speed>
Iterated iterate(int iteration_limit, Real tolerance, const System& system, Vectors& x,
                 Speed speed_sq) noexcept {
  const auto& b = system.b;
  system.multiply(x.V_0, x.AV_0);
  SquaredLength V_0_A_V_0;
  SpatialSum V_0_b;
  system.each([&](auto u) noexcept {
    V_0_A_V_0.add(x.V_0[u], x.AV_0[u]);
    V_0_b.add(x.V_0[u], b[u]);
  });
  const Real norm_0 = V_0_A_V_0, scale = norm_0 > 0 ? V_0_b / norm_0 : 0;
  system.each([&](auto u) noexcept {
    x.V[u] = x.V_0[u] * scale;
    x.r[u] = x.Ap[u] = b[u] - x.AV_0[u] * scale;
  });
  Real last = 1;
  bool converged = false;
  int iterations = 0;
  for (; iterations < iteration_limit; ++iterations) {
    solve(system, x.Ap, x.z);
    Real error_sq = 0;
    SpatialSum rz, AV_0_z;
    system.each([&](auto u) noexcept {
      if constexpr (!System::is_coupled) error_sq = std::max(error_sq, speed_sq(u, x.z[u]));
      rz.add(x.r[u], x.z[u]);
      AV_0_z.add(x.AV_0[u], x.z[u]);
    });
    // coupled: residual exactly zero, as of a net at rest
    converged = System::is_coupled ? rz == 0 : iterations > 0 && error_sq <= tolerance * tolerance;
    if (converged || !(rz > 0)) break;  // unless converged: the preconditioner has lost its precision
    const Real mu = norm_0 > 0 ? AV_0_z / norm_0 : 0, beta = rz / last;
    last = rz;
    system.each([&](auto u) noexcept {
      x.p[u] = (iterations == 0 ? x.z[u] : x.z[u] + x.p[u] * beta) - x.V_0[u] * mu;
    });
    system.multiply(x.p, x.Ap);
    SpatialSum pr;
    SquaredLength pAp;
    system.each([&](auto u) noexcept {
      pr.add(x.p[u], x.r[u]);
      pAp.add(x.p[u], x.Ap[u]);
    });
    if (!(pAp > 0)) break;
    const Real alpha = pr / pAp;
    Real change_sq = 0;
    system.each([&](auto u) noexcept {
      x.V[u] = x.V[u] + x.p[u] * alpha;
      x.r[u] = x.Ap[u] = x.r[u] - x.Ap[u] * alpha;
      if constexpr (System::is_coupled) change_sq = std::max(change_sq, speed_sq(u, x.p[u]));
    });
    // coupled: each preconditioner solve is expensive, so the size of the step decides
    if (System::is_coupled && alpha * alpha * change_sq <= tolerance * tolerance) {
      converged = true;
      ++iterations;
      break;
    }
  }
  if (!System::is_coupled && !converged) {  // r of the recurrence may have drifted
    system.multiply(x.V, x.Ap);
    system.each([&](auto u) noexcept { x.r[u] = b[u] - x.Ap[u]; });
  }
  keep_balance(system, x);
  return {.iterations = iterations, .converged = converged};
}

}  // namespace godobject
