// What contacts carry over from step to step, found again by what touches what.
#pragma once

#include <algorithm>
#include <limits>

#include "core/contact/contact.h"
#include "core/tuning.h"

namespace godobject {

/// What one contact carries over. The spheres of a scene are numbered, and so is what they touch.
struct ContactMemory {
  std::uint64_t key = 0;
  Vec3 xi_W = Vec3::Zero();      // how far the contact point has been dragged since it stuck, m
  Vec3 xi_dot_W = Vec3::Zero();  // how fast it was, m/s
  Real e = 0;                    // rest penetration: the offset of the contact spring, m
  Real pressed = 0;              // by which it was deeper than e where the last stage ended, m
  Vec3 F_W = Vec3::Zero();       // force in the last stage, N
  Vec3 n_W = Vec3::Zero();       // normal
};

/// In the order of the keys.
template <std::size_t max_contacts>
struct ContactMemories {
  std::array<ContactMemory, max_contacts> list;
  std::size_t size = 0;

  void assign(const ContactMemories& other) noexcept {
    size = other.size;
    std::copy_n(other.list.begin(), size, list.begin());
  }
};

/// Looks keys up that come in rising order.
template <std::size_t max_contacts>
class Recall {
 public:
  explicit Recall(const ContactMemories<max_contacts>& of) noexcept : of_(of) {}
  /// Null: there was no such contact.
  const ContactMemory* find(std::uint64_t key) noexcept {
    while (at_ < of_.size && of_.list[at_].key < key) ++at_;
    return at_ < of_.size && of_.list[at_].key == key ? &of_.list[at_] : nullptr;
  }

 private:
  const ContactMemories<max_contacts>& of_;
  std::size_t at_ = 0;
};

/// The same contacts bear a force.
template <std::size_t max_contacts>
bool touch_alike(const ContactMemories<max_contacts>& a, const ContactMemories<max_contacts>& b) noexcept {
  const auto next_touching = [](const ContactMemories<max_contacts>& m, std::size_t i) noexcept {
    while (i < m.size && !(m.list[i].F_W.squaredNorm() > 0)) ++i;
    return i;
  };
  std::size_t i = next_touching(a, 0), j = next_touching(b, 0);
  for (; i < a.size && j < b.size && a.list[i].key == b.list[j].key; i = next_touching(a, i + 1))
    j = next_touching(b, j + 1);
  return i == a.size && j == b.size;
}

/// Where a stage starts from: the memories of the step and those of the stage before in it, and how far in time.
struct ContactStage {
  Real t_0 = 0, t_1 = 0;  // s: xi is that of the step + t_0 its rate + t_1 that of the stage before
  Real relaxing = 0;      // s, for which e is relaxed
  Real found = 0;         // J, by the stages of the step before it: ContactReport
  bool goes_on =
      false;  // after another stage of the step; otherwise that one's memories are none of this step
  bool follows = false;   // it starts where that stage has ended
  bool is_euler = false;  // likewise, but (35) is asked between steps alone
  Real ahead = 0;         // s: an extrapolation has led so far on from where the last stage ended

  /// It starts where another stage has ended, of this step or the one before.
  bool starts_at_an_end() const noexcept { return follows || (t_0 == 0 && !goes_on); }
  bool is_joined() const noexcept { return starts_at_an_end() || is_euler; }
};

/// (35)  Largest penetration stored without measured approach, m: its spring holds the energy
/// that the lighter body, of mass m, has at the depenetration velocity. More would drive where stiff bodies are found
/// deep in each other since they turned where nothing foresaw it.
inline Real max_stored_penetration(const ContactLaw& law, Real m) noexcept {
  return law.k > 0 ? law.push_out * std::sqrt(m / law.k) : std::numeric_limits<Real>::infinity();
}

/// e a while later, in which it would fall by `by` if the depth d followed; most: by which d may be behind.
inline Real relax_offset(Real e, Real d, Real by, Real most) noexcept {
  return std::max(std::min(e, std::max(e - by, d - most)), Real(0));
}

/// A contact where a stage starts.
struct ContactStart {
  Real d_0 = 0;    // depth, m
  Real e_new = 0;  // the rest penetration if the contact is new; less than zero: none
  Real max_relaxed = std::numeric_limits<Real>::infinity();  // by which e may fall, m
  Real most = std::numeric_limits<Real>::infinity();  // by which e may be behind the depth when it falls, m
  Real max_stored_penetration =
      std::numeric_limits<Real>::infinity();  // by which it may be deeper than it was left, m
};

/// What a stage knows of a contact where it begins.
struct BegunContact {
  Vec3 xi_W = Vec3::Zero();  // how far it has been dragged along the surface, m
  Real e = 0;                // rest penetration: the offset of the contact spring, m
  Real F_n = -1;             // normal force of the stage before, N; < 0: the contact is new
  Real found = 0;            // J, (38): in its spring where the stage starts, beyond what it was left with
};

/// (38)  Of a contact spring that was pressed by `before` where a stage ended, and is by `now` where the next one starts.
inline Real found_energy(const ContactLaw& law, Real before, Real now) noexcept {
  return law.k > 0 ? Real(0.5) * law.k * (now * now - before * before) : 0;
}

/// (35)  Scenes in which it is asked in steps of second order too: bodies on joints among bodies.
template <class Contacts>
inline constexpr bool asks_found = requires {
  requires Contacts::between_bodies && Contacts::jointed && !Contacts::has_net;
};

/// (35)  Whether an extrapolation has led a contact of normal n, which opens at v_n, deeper than it moves by more than `most`. One whose
/// normal has turned round a corner is another one.
inline bool is_found_deeper(const ContactStage& stage, const ContactMemory* last, const Vec3& n_W, Real d_0,
                            Real v_n, Real most) noexcept {
  if (!(stage.ahead > 0) || last == nullptr) return false;
  return last->n_W.dot(n_W) < same_contact || d_0 + stage.ahead * v_n - last->e - last->pressed > most;
}

/// What a stage begins a contact of normal n with, from the memories of the step and of the stage before. Where the normal has turned round a
/// corner the contact is another one.
inline BegunContact recalled(const ContactLaw& law, const ContactStage& stage, const ContactMemory* of_step,
                             const ContactMemory* of_stage, const Vec3& n_W,
                             const ContactStart& start) noexcept {
  const auto is_other = [&](const ContactMemory& before) noexcept {
    return before.n_W.dot(n_W) < same_contact;
  };
  if (!stage.goes_on || (of_stage != nullptr && is_other(*of_stage))) of_stage = nullptr;
  if (of_step != nullptr && is_other(*of_step)) of_step = nullptr;
  BegunContact c;
  if (of_step == nullptr && of_stage == nullptr) {
    c.e = std::max(start.e_new, Real(0));
    c.found = found_energy(law, 0, std::clamp(start.d_0 - c.e, Real(0), start.max_stored_penetration));
    return c;
  }
  Vec3 xi = Vec3::Zero();
  if (of_step != nullptr) xi = of_step->xi_W + stage.t_0 * of_step->xi_dot_W;
  if (of_stage != nullptr) xi += stage.t_1 * of_stage->xi_dot_W;
  // that stage's rate is of its last part alone, where it was parted (39)
  if (of_stage != nullptr && (stage.follows || stage.is_euler)) xi = of_stage->xi_W;
  const ContactMemory& last = of_stage != nullptr ? *of_stage : *of_step;
  c.e =
      relax_offset(last.e, start.d_0, std::min(stage.relaxing * law.push_out, start.max_relaxed), start.most);
  if (stage.starts_at_an_end())
    c.e += std::max(start.d_0 - last.e - last.pressed - start.max_stored_penetration, Real(0));
  // what was apart in the stage before was not pressed
  const Real before = stage.goes_on && of_stage == nullptr ? 0 : last.pressed;
  const Real relaxed = before > 0 ? before + last.e - c.e : 0;
  c.found = found_energy(law, before, stage.is_joined() ? std::max(start.d_0 - c.e, Real(0)) : relaxed);
  c.xi_W = xi - n_W * n_W.dot(xi);
  c.F_n = std::max(last.n_W.dot(last.F_W), Real(0));
  return c;
}

/// How far the contact point is dragged at the end of a stage, the friction being F_t: spring and damper of (23) move
/// with it, and what they do not follow has slipped.
inline Vec3 dragged(const ContactLaw& law, const Vec3& xi, const Vec3& F_t, Real h) noexcept {
  const Real eta = h * law.k_t + law.c_t;
  return eta > 0 ? Vec3((law.c_t * xi - h * F_t) * (1 / eta)) : Vec3(Vec3::Zero());
}

}  // namespace godobject
