// Contacts of a body during a stage, four at a time.
//
// Within a mode (open, stick, slip) the forces of the law are linear in the velocity v of the contact point
// (24), F_n = F_0 - eta_n v_n and F_t = -eta_t s.
//
// A contact is thus an effective mass h (eta_t 1 + (eta_n - eta_t) n n^T) at its point, and enters its body's
// A and b like a mass. Its mode, active or not and eta_t, is found by Newton iterations on the active set.
// Each iteration starts with the modes of the previous one. Against the world, the first iterations linearise
// a slipping contact by its tangent,
//
//   (25)  F_t = -mu F_n s^/|s^| - eta_t (1 - s^ s^T / |s|^2) s
//
// which converges at once if the slip keeps its direction. The next iterations use (24) unchanged. The last
// ones keep eta_t, which cannot add energy, and find the active set. Their error is reported as the residual.
#pragma once

#include <limits>

#include "core/contact/recall.h"
#include "core/math/spatial.h"

namespace godobject {

/// Treatment of friction in an iteration.
enum class Pass { by_tangent, by_secant, unchanged };

/// Four contacts of a body with the world, or with one other body.
struct ContactPack : NormalForceOf<Pack>, FrictionOf<Pack> {
  bool changed = true;  // true if the last update changed one of their modes
  Vector3<Pack> r, n;   // r: lever from the point of the body's twist to the contact point; n: normal off the
                        // surface
  Pack d_0;
  Vector3<Pack> v_xi;
  // mode
  Pack active;  // 1 if active, else 0
  Pack eta_t;
  Vector3<Pack> u;  // direction of the slip if linearised by its tangent, else zero
  Pack f_slip;      // friction along u
  // solution
  Vector3<Pack> v, F;
  Pack v_n_0;  // normal velocity of the previous iteration
};
using InitialMemoryPack = InitialMemoryOf<Pack>;

/// Initialises contacts: xi_W and n_W on the side of their body, r from the point of its twist. F: predicted
/// forces.
inline void set_contacts(const StageLawOf<Pack>& law, const InitialMemoryPack& initial, const Pack& side,
                         const Vector3<Pack>& n_W, const Vector3<Pack>& r, const Pack& d_0, const Pack& v_n,
                         Real h, ContactPack& pack) noexcept {
  pack.r = r;
  pack.n = n_W * side;
  pack.v_xi = slip_by_stretch(initial.sticking, initial.contact.xi_W) * side;
  pack.d_0 = d_0;
  static_cast<NormalForceOf<Pack>&>(pack) = normal_force<Pack>(law, d_0, initial.contact.e, v_n, h);
  static_cast<FrictionOf<Pack>&>(pack) = friction_of(law);
  // normal force of the previous stage; for a new contact, that at the predicted velocities. Colliding bodies
  // slow down within the step, so at predicted velocities too many contacts are active, too hard.
  const Pack F_before = initial.contact.F_n;
  const Pack F_n = select(F_before < 0, max(pack.F_0 - pack.eta_n * v_n, Pack(0)), F_before);
  pack.F = pack.n * F_n;
}

/// Returns 1 for active contacts with this normal force, 0 for inactive ones.
inline Pack mode_of(const Pack& F_n) noexcept { return select(F_n > 0, Pack(1), Pack(0)); }
inline bool differ(const Pack& a, const Pack& b) noexcept { return any(a < b) || any(b < a); }

/// Deviation of an iteration's forces from the law, and the largest normal force.
struct ContactResidual {
  Pack normal_residual = 0, friction_residual_sq = 0, normal_force = 0;

  Real normal() const noexcept { return largest(normal_residual); }
  Real friction() const noexcept { return std::sqrt(largest(friction_residual_sq)); }
  Real worst() const noexcept { return std::max(normal(), friction()); }
  Real F_n() const noexcept { return largest(normal_force); }
};

/// Computes the velocities of the contact points at the twist V of the body's anchor.
inline void move(ContactPack& c, const SpatialVector& V) noexcept {
  const Vector3<Pack> V_w(V.w.all<0>(), V.w.all<1>(), V.w.all<2>());
  const Vector3<Pack> V_v(V.v.all<0>(), V.v.all<1>(), V.v.all<2>());
  c.v = V_v + V_w.cross(c.r);
}

/// Velocity of each contact point, for contacts that share no body, as those of nodes. number: index of the
/// pack.
struct PackVelocity {
  Vector3<Pack> v;
  std::size_t number = 0;
};
inline void move(ContactPack& c, const PackVelocity& V) noexcept { c.v = V.v; }

/// Replaces zero speeds by the smallest positive number, for divisions; a contact at this speed sticks.
inline Pack above_zero(const Pack& speed) noexcept {
  return max(speed, Pack(std::numeric_limits<Real>::min()));
}
/// Returns the slip speed, above zero, for divisions.
inline Pack speed_of(const Vector3<Pack>& s) noexcept { return above_zero(sqrt(s.squaredNorm())); }

/// Linearises slipping contacts by their tangents. s: slip, F_n: normal forces.
inline void set_tangents(ContactPack& c, const Vector3<Pack>& s, const Pack& speed,
                         const Pack& F_n) noexcept {
  const Pack slips = select(c.eta_t < c.max_eta_t, Pack(1), Pack(0));
  c.u = s * (slips / speed);
  c.f_slip = slips * slipping_friction<Pack>(c, F_n);
}

/// True if friction linearised along the slip does work on one of the contacts.
inline bool is_slip_reversed(const ContactPack& c) noexcept { return any(c.u.dot(c.v + c.v_xi) < 0); }

/// Selects the slip speed after the iteration for friction.
struct CurrentSpeed {};

/// Evaluates contact forces at the current velocities, accumulates the residual, and selects each contact's
/// mode for the next iteration.
/// tangents: some contacts may be linearised by their tangents, as in add(). Without tangents, friction
/// changes below F_small are skipped to keep the factor.
/// ahead: CurrentSpeed, or ahead(pack, slip, its speed, normal forces), the slip speeds for friction, above
/// zero.
template <bool tangents, class SlipPrediction = CurrentSpeed>
void update_modes(ContactPack& c, Pass next, Real F_small, ContactResidual& residual,
                  [[maybe_unused]] const SlipPrediction& ahead = {}) noexcept {
  const Pack v_n = c.n.dot(c.v);
  const Vector3<Pack> s = c.v - c.n * v_n + c.v_xi;
  const Pack speed = speed_of(s);
  const Pack F_n = c.F_0 - c.eta_n * v_n;
  const Pack law_n = max(F_n, Pack(0));
  const Pack law_eta = friction<Pack>(c, speed, law_n);
  Vector3<Pack> F_t = s * -c.eta_t;
  if constexpr (tangents) F_t += c.u * (c.eta_t * c.u.dot(s) - c.f_slip);
  c.F = c.n * (c.active * F_n) + F_t;
  residual.normal_residual = max(residual.normal_residual, abs(law_n - c.active * F_n));
  residual.friction_residual_sq = max(residual.friction_residual_sq, (s * -law_eta - F_t).squaredNorm());
  residual.normal_force = max(residual.normal_force, law_n);
  const Pack active = mode_of(law_n), eta_before = c.eta_t;
  c.changed = differ(c.active, active);
  c.active = active;
  Pack slip_eta = law_eta;
  if constexpr (!std::is_same_v<SlipPrediction, CurrentSpeed>)
    slip_eta = friction<Pack>(c, ahead(c, s, speed, law_n), law_n);
  // if friction reversed the slip, iterations would alternate: the contact sticks, or slips the other way
  // from there
  if constexpr (tangents) slip_eta = select(c.u.dot(s) < 0, c.active * c.max_eta_t, slip_eta);
  else slip_eta = select(abs(law_eta - c.eta_t) * speed < F_small, c.active * c.eta_t, slip_eta);
  c.eta_t = next == Pass::unchanged ? c.active * c.eta_t : slip_eta;
  c.changed = c.changed || differ(c.eta_t, eta_before);
  if constexpr (tangents) {
    if (next == Pass::by_tangent) {
      set_tangents(c, s, speed, law_n);
    } else {
      c.u.setConstant(Pack(0));
      c.f_slip = 0;
    }
  }
}

/// Selects the modes of the first iteration, at the normal forces predicted by c.F and the velocities of the
/// contact points. A previous solve of the stage (47) may leave forces that pull: their friction would drive.
template <bool tangents, class Velocity>
void predict(ContactPack& c, const Velocity& V) noexcept {
  move(c, V);
  const Pack F_n = max(c.n.dot(c.F), Pack(0));
  const Vector3<Pack> s = c.v - c.n * c.n.dot(c.v) + c.v_xi;
  const Pack speed = speed_of(s);
  c.active = mode_of(F_n);
  c.eta_t = friction<Pack>(c, speed, F_n);
  if constexpr (tangents) set_tangents(c, s, speed, F_n);
}

/// Sums over the contacts of a body or a pair, for its A and b.
struct ContactSums {
  // sums of W, [r]x W and -[r]x W [r]x, with W = h (eta_t (1 - u u^T) + (eta_n - eta_t) n n^T)
  Pack vv[6] = {0, 0, 0, 0, 0, 0}, wv[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0}, ww[6] = {0, 0, 0, 0, 0, 0};
  Vector3<Pack> b_w = Vector3<Pack>::Constant(Pack(0)), b_v = Vector3<Pack>::Constant(Pack(0));
};

/// Adds contacts to the sums. tangents: some contacts may be linearised by their tangents.
template <bool tangents>
void add(const ContactPack& c, Real h, ContactSums& sums) noexcept {
  const Pack a = h * c.eta_t, b = h * (c.active * c.eta_n - c.eta_t);
  const Vector3<Pack>&r = c.r, &n = c.n, &u = c.u;
  const Vector3<Pack> m = r.cross(n), ar = r * a, bn = n * b, bm = m * b;
  const Pack a_rr = ar.dot(r);
  const Pack turn[9] = {0, ar.z(), -ar.y(), -ar.z(), 0, ar.x(), ar.y(), -ar.x(), 0};  // a [r]x by columns
  Vector3<Pack> F = n * (h * c.active * c.F_0) - c.v_xi * a;
  int k = 0;
  for (int col = 0; col < 3; ++col) {
    for (int row = 0; row < 3; ++row) sums.wv[3 * col + row] += bm[row] * n[col] + turn[3 * col + row];
    for (int row = 0; row <= col; ++row, ++k) {
      sums.vv[k] += bn[row] * n[col];
      sums.ww[k] += bm[row] * m[col] - ar[row] * r[col];
      if (row == col) {
        sums.vv[k] += a;
        sums.ww[k] += a_rr;
      }
    }
  }
  if constexpr (tangents) {
    const Vector3<Pack> q = r.cross(u), au = u * a, aq = q * a;
    k = 0;
    for (int col = 0; col < 3; ++col) {
      for (int row = 0; row < 3; ++row) sums.wv[3 * col + row] -= aq[row] * u[col];
      for (int row = 0; row <= col; ++row, ++k) {
        sums.vv[k] -= au[row] * u[col];
        sums.ww[k] -= aq[row] * q[col];
      }
    }
    F += u * (a * u.dot(c.v_xi) - h * c.f_slip);
  }
  sums.b_v += F;
  sums.b_w += r.cross(F);
}

/// Returns the sum over the lanes of each of three packs.
inline Column sum(const Pack& x, const Pack& y, const Pack& z) noexcept {
  const Pack xy = shuffled<0, 4, 2, 6>(x, y) + shuffled<1, 5, 3, 7>(x, y);
  const Pack zz = z + shuffled<1, 0, 3, 2>(z, z);
  return Column(shuffled<0, 1, 4, 5>(xy, zz) + shuffled<2, 3, 6, 7>(xy, zz));
}

inline SymmetricSpatialMatrix total(const ContactSums& s) noexcept {
  return {.ww = {{sum(s.ww[0], s.ww[1], s.ww[3]), sum(s.ww[1], s.ww[2], s.ww[4]),
                  sum(s.ww[3], s.ww[4], s.ww[5])}},
          .wv = {{sum(s.wv[0], s.wv[1], s.wv[2]), sum(s.wv[3], s.wv[4], s.wv[5]),
                  sum(s.wv[6], s.wv[7], s.wv[8])}},
          .vv = {{sum(s.vv[0], s.vv[1], s.vv[3]), sum(s.vv[1], s.vv[2], s.vv[4]),
                  sum(s.vv[3], s.vv[4], s.vv[5])}}};
}
/// Returns torque and force times h.
inline SpatialVector total_impulse(const ContactSums& s) noexcept {
  return {.w = sum(s.b_w[0], s.b_w[1], s.b_w[2]), .v = sum(s.b_v[0], s.b_v[1], s.b_v[2])};
}

}  // namespace godobject
