// Law of contact: forces as functions of depth, velocity and stretch, their linearisation over a stage, the
// relaxation of the rest penetration, and the energy. Core states them in no other file, so that another law
// replaces this file alone (tests/core/contact/hunt_crossley).
//
//   (22)  F_n = max(k (d - e) - c v_n, 0) where d > 0
//   (23)  F_t = -(k_t xi + c_t v_t) while |F_t| <= mu F_n; beyond, the contact point slips and |F_t| = mu F_n
//
// d: depth, m. v: velocity of the contact point against the surface, m/s, n off the surface. xi: drag of the
// contact point since it stuck, m. e: rest penetration, offset of the contact spring, m. Bodies that start
// inside each other begin with e = d; it is relaxed at the depenetration velocity.
//
// At the end of a stage (22) and (23) are linear in the velocity within a mode (open, stick, slip). With the
// geometry at the predicted end of the stage, and d_0 the depth at its start,
//
//   (24)  F_n = k (d_0 - h v_n - e) - c v_n  = F_0 - eta_n v_n,   eta_n = h k + c;
//         open, F_0 = eta_n d_0 / h
//         F_t = -eta_t s,  s = v_t + k_t xi_0 / (h k_t + c_t),  eta_t = min(h k_t + c_t, mu F_n / |s|)
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/math/lanes.h"
#include "core/tuning.h"

namespace godobject {

/// Law of a pair of materials, for the contact of one sphere. The stiffness of spheres that share a load adds
/// up.
struct ContactLaw {
  Real k = 0;            // N/m
  Real c = 0;            // N s/m
  Real mu = 0;           // Coulomb friction, sticking and slipping
  Real k_t = 0;          // stiffness of a sticking contact point, N/m
  Real c_t = 0;          // damping of a sticking contact point, N s/m; k_t and c_t are not both zero unless
                         // mu is
  Real push_out = 0.05;  // depenetration velocity, at which the rest penetration is relaxed, m/s
  // damping in addition to c and c_t, in units of sqrt(m k), m: mass of the contact's lighter body
  Real ratio = 0, ratio_t = 0;

  bool operator==(const ContactLaw&) const = default;
};

/// True if all numbers are finite and at least 0, and friction has a spring or a damper.
inline bool is_valid(const ContactLaw& law) noexcept {
  bool valid = law.mu == 0 || law.k_t > 0 || law.c_t > 0 || (law.ratio_t > 0 && law.k > 0);
  for (const Real a : {law.k, law.c, law.mu, law.k_t, law.c_t, law.push_out, law.ratio, law.ratio_t})
    valid = valid && a >= 0 && a - a == 0;
  return valid;
}

/// Returns a law with at least the energy of both.
inline ContactLaw stiffest(const ContactLaw& a, const ContactLaw& b) noexcept {
  return {
      .k = std::max(a.k, b.k), .k_t = std::max(a.k_t, b.k_t), .push_out = std::max(a.push_out, b.push_out)};
}

/// Returns the energy of the springs of a contact, J. pressed: compression, m. xi_sq: squared stretch, m^2.
inline Real stored_energy(const ContactLaw& law, Real pressed, Real xi_sq) noexcept {
  return Real(0.5) * (law.k * pressed * pressed + law.k_t * xi_sq);
}
/// Returns the energy of a body of mass m at the depenetration velocity, J.
inline Real push_out_energy(const ContactLaw& law, Real m) noexcept {
  return Real(0.5) * m * law.push_out * law.push_out;
}

/// Returns the largest penetration stored without measured approach (35), m. Its spring holds the energy of
/// the lighter body, of mass m, at the depenetration velocity. A larger one would drive stiff bodies apart
/// that rotated into each other unpredicted.
inline Real max_stored_penetration(const ContactLaw& law, Real m) noexcept {
  return law.k > 0 ? law.push_out * std::sqrt(m / law.k) : std::numeric_limits<Real>::infinity();
}
/// Returns the energy that such a penetration adds to a spring, J.
inline Real max_found_energy(const ContactLaw& law, Real pressed, Real m) noexcept {
  if (!(law.k > 0)) return 0;
  const Real more = max_stored_penetration(law, m);
  return Real(0.5) * law.k * more * (2 * pressed + more);
}

/// Law of contacts in a stage of length h (24). A law of zeros carries no force.
template <class T>
struct StageLawOf {
  T k = 0;                       // N/m
  T eta_n = 0;                   // N s/m
  T eta_n_h = 0;                 // eta_n / h, N/m
  T max_eta_t = 0;               // eta_t of a sticking contact point, N s/m
  T v_per_xi = 0;                // k_t / max_eta_t, 1/s
  T mu = 0;                      // Coulomb friction
  T kept = 0;                    // share of xi that remains at the end of a stage without friction
  T given = 0;                   // change of xi per friction force, m/N
  T max_decrease = 0;            // largest decrease of e in the stage, m
  T max_lag = 0;                 // largest distance of a decreasing e below the depth, m
  T max_stored_penetration = 0;  // m (35)
};

/// Returns the law of contacts in a stage of length h.
/// m: mass of the lighter body, kg. M: the same in the stage, with couplings, kg.
/// relaxation_time: time over which e is relaxed, s.
/// on_world: the contact is with the world; its e may then be below the depth by any amount.
template <class Contacts>
StageLawOf<Real> stage_law(const ContactLaw& law, Real m, Real M, Real h, Real relaxation_time,
                           bool on_world) noexcept {
  constexpr Real infinity = std::numeric_limits<Real>::infinity();
  const Real unit = std::sqrt(m * law.k), c = law.c + law.ratio * unit, c_t = law.c_t + law.ratio_t * unit;
  const Real eta_t = h * law.k_t + c_t, per_eta_t = law.k_t > 0 ? 1 / eta_t : 0,
             by = relaxation_time * law.push_out, stored = max_stored_penetration(law, M),
             most = max_relaxation * stored;
  return {.k = law.k,
          .eta_n = h * law.k + c,
          .eta_n_h = law.k + c / h,
          .max_eta_t = eta_t,
          .v_per_xi = law.k_t * per_eta_t,
          .mu = law.mu,
          .kept = c_t * per_eta_t,
          .given = h * per_eta_t,
          .max_decrease = Contacts::between_bodies ? std::min(by, most) : by,
          .max_lag = on_world ? infinity : std::min(max_pushed_steps * by, most),
          .max_stored_penetration = stored};
}

/// Returns a law of four contacts with the members of(member).
template <class F>
StageLawOf<Pack> each_number(F of) noexcept {
  using Law = StageLawOf<Real>;
  return {.k = of(&Law::k),
          .eta_n = of(&Law::eta_n),
          .eta_n_h = of(&Law::eta_n_h),
          .max_eta_t = of(&Law::max_eta_t),
          .v_per_xi = of(&Law::v_per_xi),
          .mu = of(&Law::mu),
          .kept = of(&Law::kept),
          .given = of(&Law::given),
          .max_decrease = of(&Law::max_decrease),
          .max_lag = of(&Law::max_lag),
          .max_stored_penetration = of(&Law::max_stored_penetration)};
}

/// Normal force in a stage, linear in the opening speed (24).
template <class T>
struct NormalForceOf {
  T F_0, eta_n;  // N, N s/m
};
/// Returns the normal force (22) in a stage of length h from the depth d_0. v_n: predicted opening speed, at
/// which a law that is not linear is linearised.
template <class T>
NormalForceOf<T> normal_force(const StageLawOf<T>& law, const T& d_0, const T& e,
                              [[maybe_unused]] const T& v_n, [[maybe_unused]] Real h) noexcept {
  return {select(d_0 < 0, law.eta_n_h * d_0, law.k * (d_0 - e)), law.eta_n};
}

/// Returns the relaxed rest penetration (35): decreases by at most max_decrease, never below d - max_lag nor
/// below 0.
template <class T>
T relax_offset(const StageLawOf<T>& law, const T& e, const T& d) noexcept {
  return max(min(e, max(e - law.max_decrease, d - law.max_lag)), T(0));
}

/// Returns the change of energy of a contact spring (38), J. before: compression at the end of a stage, m.
/// now: compression at the start of the next.
template <class T>
T spring_energy_change(const StageLawOf<T>& law, const T& before, const T& now) noexcept {
  return T(0.5) * law.k * (now * now - before * before);
}

/// Friction (23) in a stage, at the normal force and slip speed.
template <class T>
struct FrictionOf {
  T mu, max_eta_t;
};
template <class T>
FrictionOf<T> friction_of(const StageLawOf<T>& law) noexcept {
  return {.mu = law.mu, .max_eta_t = law.max_eta_t};
}
/// Returns the friction of a slipping contact point, N.
template <class T>
T slipping_friction(const FrictionOf<T>& law, const T& F_n) noexcept {
  return law.mu * F_n;
}
/// Returns eta_t of (24) at a slip speed.
template <class T>
T friction(const FrictionOf<T>& law, const T& speed, const T& F_n) noexcept {
  return min(slipping_friction(law, F_n) / speed, law.max_eta_t);
}

/// Spring and damper of a sticking contact point (23) in a stage.
template <class T>
struct StickingOf {
  T v_per_xi, kept, given;  // as in StageLawOf
};
template <class T>
StickingOf<T> sticking_of(const StageLawOf<T>& law) noexcept {
  return {.v_per_xi = law.v_per_xi, .kept = law.kept, .given = law.given};
}
/// Returns the share of the slip s of (24) that the stretch xi_0 at the start causes, m/s.
template <class T>
Vector3<T> slip_by_stretch(const StickingOf<T>& law, const Vector3<T>& xi_0) noexcept {
  return xi_0 * law.v_per_xi;
}
/// Returns the stretch at the end of the stage. Spring and damper of (23) move with the contact point; the
/// difference has slipped.
template <class T>
Vector3<T> stretch_at_end(const StickingOf<T>& law, const Vector3<T>& xi_0, const Vector3<T>& F_t) noexcept {
  return xi_0 * law.kept - F_t * law.given;
}

}  // namespace godobject
