// Residual of a solve of bodies in contact, as a force.
#pragma once

#include "core/solve/pairs.h"

namespace godobject {

/// Returns the squared velocity of the centre of mass at which a body would have the kinetic energy that it
/// has at V, m^2/s^2.
inline Real speed_sq(const BodyStage& stage, const SpatialVector& V) noexcept {
  return dot(V.v, V.v) + dot(V.w, stage.A_ww * V.w) / stage.M;
}

/// Returns speed_sq of unknown u; a node is its own centre of mass.
template <class Stages>
Real speed_sq_of(const Stages& stages, std::uint32_t u, const SpatialVector& V) noexcept {
  return speed_sq(stages[u], V);
}
template <class Stages>
Real speed_sq_of(const Stages&, NetNodeNumber, const Column& v) noexcept {
  return dot(v, v);
}

inline Real force_sq(const SpatialVector& F) noexcept { return dot(F.v, F.v); }
inline Real force_sq(const Column& F) noexcept { return dot(F, F); }

/// Returns the largest impulse of r that joints cannot carry. A torque tau about an axis counts as the force
/// tau sqrt(m / I), with the same energy for an impulse.
template <class System, class Contacts, std::size_t N>
Real largest_residual(const System& system, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& F = w.x.Ap;
  Real most = 0;
  system.each([&](auto u) noexcept { F[u] = w.x.r[u]; });
  system.each([&](auto u) noexcept {  // children before parents
    const BlockJoint* joint = system.joint_of(u);
    if (joint == nullptr) {
      most = std::max(most, force_sq(F[u]));
      return;
    }
    if constexpr (std::is_same_v<decltype(u), std::uint32_t>) {
      for (std::size_t a = 0; a < static_cast<std::size_t>(joint->num_axes); ++a) {
        const Real tau = dot(joint->s[a], F[u]);
        most = std::max(most, tau * tau / speed_sq(w.stages[u], joint->s[a]));
      }
      if (joint->has_parent()) F[joint->parent] = F[joint->parent] + moved_wrench(F[u], joint->d);
    }
  });
  return std::sqrt(most);
}

}  // namespace godobject
