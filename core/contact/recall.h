// Initial data of contacts in a stage, from their memory, and their memory at its end: rest penetration (35),
// stretch (51), energy (38).
#pragma once

#include "core/contact/anchors.h"
#include "core/contact/contact.h"
#include "core/contact/memory.h"

namespace godobject {

/// Memory of one or four contacts. A new contact has no normal.
template <class T>
struct ContactPastOf {
  AnchorsOf<T> anchors;
  Vector3<T> n_W, slip_dot_W;
  T e, pressed, F_n;
};
inline ContactPastOf<Pack> gathered(const std::array<const ContactMemory*, 4>& of) noexcept {
  const auto vectors = [&](auto member) noexcept {
    return in_lanes(of[0]->*member, of[1]->*member, of[2]->*member, of[3]->*member);
  };
  const auto numbers = [&](auto member) noexcept {
    return Pack(of[0]->*member, of[1]->*member, of[2]->*member, of[3]->*member);
  };
  return {.anchors = {.c_a = vectors(&ContactMemory::c_a),
                      .c_b = vectors(&ContactMemory::c_b),
                      .n_a = vectors(&ContactMemory::n_a),
                      .n_b = vectors(&ContactMemory::n_b),
                      .xi_a = vectors(&ContactMemory::xi_a),
                      .xi_b = vectors(&ContactMemory::xi_b)},
          .n_W = vectors(&ContactMemory::n_W),
          .slip_dot_W = vectors(&ContactMemory::slip_dot_W),
          .e = numbers(&ContactMemory::e),
          .pressed = numbers(&ContactMemory::pressed),
          .F_n = numbers(&ContactMemory::F_n)};
}

/// Contacts as found for a stage.
template <class T>
struct ContactStartOf {
  const ContactPlacesOf<T>& at;  // places of the bodies at the predicted end
  Vector3<T> n_W, v_W;           // v_W: predicted velocity of the contact point of a against b, m/s
  T rho;                         // m, radius that rolls (51)
  T d_0 = 0;                     // depth at the start, m
  T approach = 0;                // approach by extrapolation, m: 0 if the stage starts at the end of another
};

/// Initial data of contacts in a stage.
template <class T>
struct InitialContactOf {
  Vector3<T> xi_W;        // stretch, m: at the end of the stage xi_W + h v_t, if the contact point sticks
  Vector3<T> slip_dot_W;  // rate of slip before the stage, m/s
  T e;                    // rest penetration: the offset of the contact spring, m
  T F_n;                  // normal force of the previous stage, N; < 0: new contact
  T found;  // J, (38): energy of its spring at the start of the stage in excess of that at the end of
            // the previous one
};

/// True for jointed bodies in contact with bodies, without nets: second-order steps also check for
/// unexplained penetration (35).
template <class Contacts>
inline constexpr bool checks_penetration_jumps = requires {
  requires Contacts::between_bodies && Contacts::jointed && !Contacts::has_net;
};

/// Finds contacts with unexplained penetration (35): after an extrapolation, deeper by more than `most` than
/// their motion explains. v_n: opening speed, m/s. If the normal has turned round a corner, the contact is a
/// new one.
template <class T>
auto are_penetration_jumps(const ContactStage& stage, const ContactPastOf<T>& past,
                           const ContactStartOf<T>& start, const T& v_n, const T& most) noexcept {
  return (T(0) < past.n_W.dot(past.n_W)) &
         ((past.n_W.dot(start.n_W) < T(same_contact)) |
          (most < start.d_0 + T(stage.extrapolated) * v_n - (past.e + past.pressed)));
}

/// Returns the initial data of contacts in a stage of length h, from the memory of the previous one. If the
/// normal has turned round a corner, the contact is a new one.
template <class T>
InitialContactOf<T> recalled(const StageLawOf<T>& law, const ContactStage& stage, Real h,
                             const ContactPastOf<T>& past, const ContactStartOf<T>& start) noexcept {
  const auto known = T(same_contact) <= past.n_W.dot(start.n_W);
  const Vector3<T> none = Vector3<T>::Constant(T(0));
  // linear from the predicted end of the stage, as the depth is
  const StretchOf<T> seen = stretch(past.anchors, start.at, start.n_W, start.rho);
  const Vector3<T> v_t = start.v_W - start.n_W * start.n_W.dot(start.v_W);
  Vector3<T> beyond = seen.change_W - past.slip_dot_W * T(stage.extrapolated) - v_t * T(h);
  // a point that has slipped farther than its place is in error has no place to keep
  if (stage.is_joined())
    beyond *= select(past.slip_dot_W.squaredNorm() * T(h * h) < beyond.squaredNorm(), T(1), T(0));
  const Vector3<T> xi = seen.before_W + beyond;
  T offset = relax_offset(law, past.e, start.d_0);
  if (stage.is_joined()) offset += max(start.d_0 - past.e - past.pressed - law.max_stored_penetration, T(0));
  const T relaxed = select(T(0) < past.pressed, past.pressed + past.e - offset, T(0));
  const T now = stage.is_joined() ? T(max(start.d_0 - offset, T(0))) : relaxed;
  const T e_new = max(start.d_0 - start.approach - law.max_stored_penetration, T(0));
  const T now_new = min(max(start.d_0 - e_new, T(0)), law.max_stored_penetration);
  return {.xi_W = select(known, xi, none),
          .slip_dot_W = select(known, past.slip_dot_W, none),
          .e = select(known, offset, e_new),
          .F_n = select(known, max(past.F_n, T(0)), T(-1)),
          .found = select(known, spring_energy_change(law, past.pressed, now),
                          spring_energy_change(law, T(0), now_new))};
}

/// Contact data from the start of the stage needed to update the memory at its end.
template <class T>
struct InitialMemoryOf {
  InitialContactOf<T> contact;
  Vector3<T> v_W;  // predicted velocity of the contact point, m/s
  StickingOf<T> sticking;
};

/// Contacts at the end of a stage of length h.
template <class T>
struct ContactEndOf {
  const ContactPlacesOf<T>& at;  // places of the bodies at the predicted end
  Vector3<T> c_W, n_W;           // contact point, m, and normal
  Vector3<T> s_W;                // slip s of (24), m/s
  Vector3<T> F_W;                // contact force on a, N
  T d;                           // depth, m
};

/// Returns the contact memory at the end. The points of the anchors meet where the linear stage ends, and lie
/// apart at its predicted end.
template <class T>
ContactPastOf<T> carried_over(const InitialMemoryOf<T>& initial, const ContactStage& stage, Real h,
                              const ContactEndOf<T>& end) noexcept {
  const Vector3<T>&n_W = end.n_W, &xi_0 = initial.contact.xi_W;
  const T F_n = n_W.dot(end.F_W);
  const Vector3<T> none = Vector3<T>::Constant(T(0));
  const Vector3<T> xi =
      select(T(0) < F_n, stretch_at_end<T>(initial.sticking, xi_0, end.F_W - n_W * F_n), none);
  const Vector3<T> v_t = end.s_W - slip_by_stretch(initial.sticking, xi_0);
  const Vector3<T> slip_dot = v_t - (xi - xi_0) * T(1 / h);
  const Vector3<T> beyond = v_t - initial.v_W;
  return {
      .anchors = anchored<T>(end.at, end.c_W, n_W, xi, (n_W * n_W.dot(beyond) - beyond) * T(h)),
      .n_W = n_W,
      .slip_dot_W = initial.contact.slip_dot_W * T(stage.slip_before) + slip_dot * T(1 - stage.slip_before),
      .e = initial.contact.e,
      .pressed = max(end.d - initial.contact.e, T(0)),
      .F_n = F_n};
}

}  // namespace godobject
