// Law of Hunt and Crossley in the place of core/contact/law.h, without friction. The include path of its test
// has this file before that of core, and nothing else of core is replaced.
//
//   (22)  F_n = max(k (d - e)^(3/2) (1 - alpha v_n), 0) where d > e
//   (24)  at the predicted opening speed v^ and compression d^ = d_0 - h v^ - e: F_n = F_0 - eta_n v_n,
//         eta_n = h 3/2 k d^^(1/2) (1 - alpha v^) + alpha k d^^(3/2)
//
// Hunt and Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", J. Applied Mechanics
// 42 (1975).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/math/lanes.h"

namespace godobject {

/// Law of a pair of materials, for the contact of one sphere.
struct ContactLaw {
  Real k = 0;            // N/m^(3/2)
  Real alpha = 0;        // s/m
  Real push_out = 0.05;  // depenetration velocity, m/s

  bool operator==(const ContactLaw&) const = default;
};

inline bool is_valid(const ContactLaw& law) noexcept {
  return law.k >= 0 && law.alpha >= 0 && law.push_out >= 0;
}
inline ContactLaw stiffest(const ContactLaw& a, const ContactLaw& b) noexcept {
  return {.k = std::max(a.k, b.k), .push_out = std::max(a.push_out, b.push_out)};
}

inline Real stored_energy(const ContactLaw& law, Real pressed, Real) noexcept {
  return Real(0.4) * law.k * pressed * pressed * std::sqrt(pressed);
}
inline Real push_out_energy(const ContactLaw& law, Real m) noexcept {
  return Real(0.5) * m * law.push_out * law.push_out;
}
inline Real max_stored_penetration(const ContactLaw& law, Real m) noexcept {
  if (!(law.k > 0)) return std::numeric_limits<Real>::infinity();
  return std::pow(push_out_energy(law, m) / (Real(0.4) * law.k), Real(0.4));
}
inline Real max_found_energy(const ContactLaw& law, Real pressed, Real m) noexcept {
  if (!(law.k > 0)) return 0;
  return stored_energy(law, pressed + max_stored_penetration(law, m), 0) - stored_energy(law, pressed, 0);
}

/// Law of contacts in a stage. A law of zeros carries no force.
template <class T>
struct StageLawOf {
  T k = 0, alpha = 0;
  T max_decrease = 0;            // m (35)
  T max_stored_penetration = 0;  // m (35)
};
template <class Contacts>
StageLawOf<Real> stage_law(const ContactLaw& law, Real, Real M, Real, Real relaxation_time, bool) noexcept {
  return {.k = law.k,
          .alpha = law.alpha,
          .max_decrease = relaxation_time * law.push_out,
          .max_stored_penetration = max_stored_penetration(law, M)};
}
template <class F>
StageLawOf<Pack> each_number(F of) noexcept {
  using Law = StageLawOf<Real>;
  return {.k = of(&Law::k),
          .alpha = of(&Law::alpha),
          .max_decrease = of(&Law::max_decrease),
          .max_stored_penetration = of(&Law::max_stored_penetration)};
}

/// Normal force in a stage, linear in the opening speed (24).
template <class T>
struct NormalForceOf {
  T F_0, eta_n;
};
template <class T>
NormalForceOf<T> normal_force(const StageLawOf<T>& law, const T& d_0, const T& e, const T& v_n,
                              Real h) noexcept {
  using std::sqrt;
  const T d = max(d_0 - h * v_n - e, T(0)), per_d = law.k * sqrt(d), damped = max(1 - law.alpha * v_n, T(0));
  const T eta_n = T(1.5) * h * per_d * damped + law.alpha * per_d * d;
  return {per_d * d * damped + eta_n * v_n, eta_n};
}

template <class T>
T relax_offset(const StageLawOf<T>& law, const T& e, const T& d) noexcept {
  return max(min(e, max(e - law.max_decrease, d)), T(0));
}
template <class T>
T spring_energy_change(const StageLawOf<T>& law, const T& before, const T& now) noexcept {
  using std::sqrt;
  return T(0.4) * law.k * (now * now * sqrt(now) - before * before * sqrt(before));
}

/// No friction.
template <class T>
struct FrictionOf {
  T max_eta_t = 0;
};
template <class T>
T slipping_friction(const FrictionOf<T>&, const T&) noexcept {
  return 0;
}
template <class T>
FrictionOf<T> friction_of(const StageLawOf<T>&) noexcept {
  return {};
}
template <class T>
T friction(const FrictionOf<T>&, const T&, const T&) noexcept {
  return 0;
}
template <class T>
struct StickingOf {};
template <class T>
StickingOf<T> sticking_of(const StageLawOf<T>&) noexcept {
  return {};
}
template <class T>
Vector3<T> slip_by_stretch(const StickingOf<T>&, const Vector3<T>& xi_0) noexcept {
  return xi_0 * T(0);
}
template <class T>
Vector3<T> stretch_at_end(const StickingOf<T>&, const Vector3<T>& xi_0, const Vector3<T>&) noexcept {
  return xi_0 * T(0);
}

}  // namespace godobject
