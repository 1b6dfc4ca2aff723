// Contact memory carried from step to step, found by keys of both sides.
#pragma once

#include <algorithm>
#include <limits>

#include "core/contact/contact.h"
#include "core/math/lanes.h"
#include "core/tuning.h"

namespace godobject {

/// Memory of one contact. Spheres and surfaces of a scene are numbered.
struct ContactMemory {
  std::uint64_t key = 0;
  Real e = 0;        // rest penetration: the offset of the contact spring, m
  Real pressed = 0;  // compression of the spring at the end of the last stage, m
  Column xi_W;       // drag of the contact point since it stuck, m
  Column xi_dot_W;   // rate of the drag, m/s
  Column F_W;        // force in the last stage, N
  Column n_W;        // normal
};

/// Memories in the order of the keys.
template <std::size_t max_contacts>
struct ContactMemories {
  std::array<ContactMemory, max_contacts> list;
  std::size_t size = 0;

  void assign(const ContactMemories& other) noexcept {
    size = other.size;
    std::copy_n(other.list.begin(), size, list.begin());
  }
};

/// Looks up keys in rising order.
template <std::size_t max_contacts>
class Recall {
 public:
  explicit Recall(const ContactMemories<max_contacts>& of) noexcept : of_(of) {}
  /// Returns the memory of a key; null if there is none.
  const ContactMemory* find(std::uint64_t key) noexcept {
    while (at_ < of_.size && of_.list[at_].key < key) ++at_;
    return at_ < of_.size && of_.list[at_].key == key ? &of_.list[at_] : nullptr;
  }
  /// Returns the memory of a key; one without a normal if there is none.
  const ContactMemory* find_or_empty(std::uint64_t key) noexcept {
    const ContactMemory* const found = find(key);
    return found != nullptr ? found : &none_;
  }

 private:
  const ContactMemory none_{};
  const ContactMemories<max_contacts>& of_;
  std::size_t at_ = 0;
};

/// True if both have the same active contacts.
template <std::size_t max_contacts>
bool have_same_active_contacts(const ContactMemories<max_contacts>& a,
                               const ContactMemories<max_contacts>& b) noexcept {
  const auto next_active = [](const ContactMemories<max_contacts>& m, std::size_t i) noexcept {
    while (i < m.size && !(dot(m.list[i].F_W, m.list[i].F_W) > 0)) ++i;
    return i;
  };
  std::size_t i = next_active(a, 0), j = next_active(b, 0);
  for (; i < a.size && j < b.size && a.list[i].key == b.list[j].key; i = next_active(a, i + 1))
    j = next_active(b, j + 1);
  return i == a.size && j == b.size;
}

/// Initialisation of a stage's contacts: from the memory of the previous step or stage, extrapolated by t_0
/// and t_1.
struct ContactStage {
  Real t_0 = 0, t_1 = 0;     // s: xi is extrapolated by t_0 times the rate of the step, plus t_1 times that
                             // of the previous stage
  Real relaxation_time = 0;  // s, duration of the relaxation of e
  Real found = 0;            // sum of ContactReport::found over the previous stages of the step, J
  bool continues_step =
      false;  // true after another stage of the step; otherwise the stage memory is of another step
  bool follows = false;   // true if it starts at the end of the previous stage
  bool is_euler = false;  // as `follows`, but the rest penetration (35) is updated at step boundaries only
  Real extrapolated_time = 0;  // s: extrapolation from the end of the previous stage to the start of this one

  /// True if the stage starts at the end of another one, of this step or the previous.
  bool starts_at_stage_end() const noexcept { return follows || (t_0 == 0 && !continues_step); }
  bool is_joined() const noexcept { return starts_at_stage_end() || is_euler; }
};

/// Returns the largest penetration stored without measured approach (35), m. Its spring holds the energy of
/// the lighter body, of mass m, at the depenetration velocity. A larger one would drive stiff bodies apart
/// that rotated into each other unpredicted.
inline Real max_stored_penetration(const ContactLaw& law, Real m) noexcept {
  return law.k > 0 ? law.push_out * std::sqrt(m / law.k) : std::numeric_limits<Real>::infinity();
}

/// Memory of one or four contacts. A new contact has no normal.
template <class T>
struct ContactPastOf {
  Vector3<T> xi_W, xi_dot_W, F_W, n_W;
  T e, pressed;
};
inline ContactPastOf<Pack> gathered(const std::array<const ContactMemory*, 4>& of) noexcept {
  const auto vectors = [&](auto member) noexcept {
    return in_lanes(of[0]->*member, of[1]->*member, of[2]->*member, of[3]->*member);
  };
  const auto numbers = [&](auto member) noexcept {
    return Pack(of[0]->*member, of[1]->*member, of[2]->*member, of[3]->*member);
  };
  return {.xi_W = vectors(&ContactMemory::xi_W),
          .xi_dot_W = vectors(&ContactMemory::xi_dot_W),
          .F_W = vectors(&ContactMemory::F_W),
          .n_W = vectors(&ContactMemory::n_W),
          .e = numbers(&ContactMemory::e),
          .pressed = numbers(&ContactMemory::pressed)};
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

/// Contacts at the start of a stage.
template <class T>
struct ContactStartOf {
  Vector3<T> n_W;
  T d_0;       // depth, m
  T approach;  // approach by extrapolation, m: 0 if the stage starts at the end of another
};

/// Initial data of contacts in a stage.
template <class T>
struct InitialContactOf {
  Vector3<T> xi_W;  // drag along the surface, m
  T e;              // rest penetration: the offset of the contact spring, m
  T F_n;            // normal force of the previous stage, N; < 0: new contact
  T found;          // J, (38): energy of its spring at the start of the stage in excess of that at the end of
                    // the previous one
};

/// Returns the relaxed rest penetration (35): decreases by at most max_decrease, never below d - max_lag nor
/// below 0.
template <class T>
T relax_offset(const T& e, const T& d, const T& max_decrease, const T& max_lag) noexcept {
  return max(min(e, max(e - max_decrease, d - max_lag)), T(0));
}

/// Returns the change of energy of a contact spring (38), J. before: compression at the end of a stage, m.
/// now: compression at the start of the next.
template <class T>
T spring_energy_change(const T& k, const T& before, const T& now) noexcept {
  return T(0.5) * k * (now * now - before * before);
}

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
auto are_penetration_jumps(const ContactStage& stage, const ContactPastOf<T>& of_step,
                           const ContactPastOf<T>& of_stage, const ContactStartOf<T>& start, const T& v_n,
                           const T& most) noexcept {
  const auto was = [](const ContactPastOf<T>& past) noexcept { return T(0) < past.n_W.dot(past.n_W); };
  const auto by_stage = was(of_stage);
  const T turned = select(by_stage, of_stage.n_W.dot(start.n_W), of_step.n_W.dot(start.n_W)),
          end = select(by_stage, of_stage.e + of_stage.pressed, of_step.e + of_step.pressed);
  return (by_stage | was(of_step)) &
         ((turned < T(same_contact)) | (most < start.d_0 + T(stage.extrapolated_time) * v_n - end));
}

/// Returns the initial data of contacts, from the memories of the previous step and stage. If the normal has
/// turned round a corner, the contact is a new one.
template <class T>
InitialContactOf<T> recalled(const StageLawOf<T>& law, const ContactStage& stage,
                             const ContactPastOf<T>& of_step, const ContactPastOf<T>& of_stage,
                             const ContactStartOf<T>& start) noexcept {
  const auto is_same = [&](const ContactPastOf<T>& before) noexcept {
    return T(same_contact) <= before.n_W.dot(start.n_W);
  };
  const Vector3<T> none = Vector3<T>::Constant(T(0));
  const auto by_step = is_same(of_step);
  auto known = by_step;
  Vector3<T> xi = select(by_step, Vector3<T>(of_step.xi_W + of_step.xi_dot_W * T(stage.t_0)), none);
  T e = of_step.e, pressed = of_step.pressed, before = pressed, F_n = of_step.n_W.dot(of_step.F_W);
  if (stage.continues_step) {
    const auto by_stage = is_same(of_stage);
    known = known | by_stage;
    // after substeps (39), the previous stage's rate is only that of its last substep
    if (stage.follows || stage.is_euler) xi = select(by_stage, of_stage.xi_W, xi);
    else xi += select(by_stage, Vector3<T>(of_stage.xi_dot_W * T(stage.t_1)), none);
    e = select(by_stage, of_stage.e, e);
    pressed = select(by_stage, of_stage.pressed, pressed);
    before = select(by_stage, pressed, T(0));  // a contact open in the previous stage was not pressed
    F_n = select(by_stage, of_stage.n_W.dot(of_stage.F_W), F_n);
  }
  T offset = relax_offset(e, start.d_0, law.max_decrease, law.max_lag);
  if (stage.starts_at_stage_end()) offset += max(start.d_0 - e - pressed - law.max_stored_penetration, T(0));
  const T relaxed = select(T(0) < before, before + e - offset, T(0));
  const T now = stage.is_joined() ? T(max(start.d_0 - offset, T(0))) : relaxed;
  const T e_new = max(start.d_0 - start.approach - law.max_stored_penetration, T(0));
  const T now_new = min(max(start.d_0 - e_new, T(0)), law.max_stored_penetration);
  return {.xi_W = xi - start.n_W * start.n_W.dot(xi),
          .e = select(known, offset, e_new),
          .F_n = select(known, max(F_n, T(0)), T(-1)),
          .found = select(known, spring_energy_change(law.k, before, now),
                          spring_energy_change(law.k, T(0), now_new))};
}

/// Contact data from the start of the stage needed to update the memory at its end.
template <class T>
struct InitialMemoryOf {
  Vector3<T> xi_W;
  T e, kept, given;
  T F_n;  // normal force of the previous stage, N; < 0: new contact
};

/// Returns the contact memory at the end. d: depth, m. F_W: contact force, N.
template <class T>
ContactPastOf<T> carried_over(const InitialMemoryOf<T>& initial, Real h, const Vector3<T>& n_W, const T& d,
                              const Vector3<T>& F_W) noexcept {
  const T F_n = n_W.dot(F_W);
  const auto presses = T(0) < F_n;
  const Vector3<T> none = Vector3<T>::Constant(T(0));
  // spring and damper of (23) move with the contact point; the difference has slipped
  const Vector3<T> xi =
      select(presses, Vector3<T>(initial.xi_W * initial.kept - (F_W - n_W * F_n) * initial.given), none);
  return {.xi_W = xi,
          .xi_dot_W = select(presses, Vector3<T>((xi - initial.xi_W) * T(1 / h)), none),
          .F_W = F_W,
          .n_W = n_W,
          .e = initial.e,
          .pressed = max(d - initial.e, T(0))};
}

}  // namespace godobject
