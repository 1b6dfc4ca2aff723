// Contact memory carried from step to step, found by keys of both sides.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/math/block.h"

namespace godobject {

/// Memory of one contact. Spheres and surfaces of a scene are numbered.
struct ContactMemory {
  std::uint64_t key = 0;
  std::uint32_t on = 0;  // touched element, as in NearContact
  Real e = 0;            // rest penetration: the offset of the contact spring, m
  Real pressed = 0;      // compression of the spring at the end of the last stage, m
  Real F_n = 0;          // normal force in the last stage, N; 0: inactive
  Column c_a, c_b;       // anchors (51)
  Column n_a, n_b, n_W;  // normal
  Column xi_a, xi_b;     // stretch
  Column slip_dot_W;     // rate at which the contact point slips, m/s
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
    while (i < m.size && m.list[i].F_n == 0) ++i;
    return i;
  };
  std::size_t i = next_active(a, 0), j = next_active(b, 0);
  for (; i < a.size && j < b.size && a.list[i].key == b.list[j].key; i = next_active(a, i + 1))
    j = next_active(b, j + 1);
  return i == a.size && j == b.size;
}

/// Contact memories in a stage: at the end of the previous stage, and at its own end. num: lists, three with
/// substeps.
template <std::size_t max_contacts, std::size_t num>
class StageMemories {
 public:
  using List = ContactMemories<max_contacts>;
  const List& before() const noexcept { return *before_; }
  const List& after() const noexcept { return lists_[after_]; }
  List& after() noexcept { return lists_[after_]; }

  /// Begins the first stage of a step, after the memories of the previous step.
  void start(const List& of_step) noexcept {
    before_ = of_stage_ = &of_step;
    choose();
  }
  /// Begins a stage or a substep at the end of the previous one.
  void next_stage() noexcept {
    before_ = of_stage_ = &lists_[after_];
    choose();
  }
  void next_substep() noexcept {
    before_ = &lists_[after_];
    choose();
  }
  /// Begins the stage again, with the memories of before its first substep.
  void restart() noexcept {
    before_ = of_stage_;
    choose();
  }

 private:
  void choose() noexcept {
    after_ = 0;
    while (before_ == &lists_[after_] || of_stage_ == &lists_[after_]) ++after_;
  }

  std::array<List, num> lists_;
  const List *before_ = nullptr, *of_stage_ = nullptr;
  std::size_t after_ = 0;
};

/// True if the same contacts are active at the end of a stage and of that before it.
template <std::size_t max_contacts, std::size_t num>
bool have_same_active_contacts(const StageMemories<max_contacts, num>& stage) noexcept {
  return have_same_active_contacts(stage.before(), stage.after());
}

/// Initialisation of a stage's contacts from the memories at the end of the previous stage.
struct ContactStage {
  Real relaxation_time = 0;  // s, duration of the relaxation of e
  Real extrapolated = 0;     // s: extrapolation from the end of the previous stage to the start of this one
  Real swept = 0;  // s, before the start: smooth stages sweep the motion since the start of the step
  // weight of the previous rate of slip in the stored one: a half for the mean, by which TR-BDF2 extrapolates
  Real slip_before = 0;
  Real found = 0;               // sum of ContactReport::found over the previous stages of the step, J
  bool continues_step = false;  // true after another stage of the step

  bool is_joined() const noexcept { return extrapolated == 0; }
};

}  // namespace godobject
