// Base of terms between a point of a and a point of b: springs, closing joints and constant forces.
#pragma once

#include "core/term/term.h"

namespace godobject {

/// Term between two points in a stage (37): the impulse J - K V on b at its point. V is the twist of b
/// against a there, at the end of the stage.
struct PairStage {
  std::uint32_t a = TermEnds::on_world, b = 0;
  Column r_a{}, r_b{};  // levers from the centres of mass, world axes
  Column F_0{};         // force on b of (21)
  SymmetricSpatialMatrix K{.ww = Block::zero(), .wv = Block::zero(), .vv = Block::zero()};
  SpatialVector J = SpatialVector::zero();
};

/// Members that such kinds of terms have in common.
struct PairTerm {
  static constexpr std::size_t max_ends = 2;
  static constexpr bool on_coordinates = false, is_joint = false;
  using Stage = PairStage;

  static TermEnds ends(const Stage& w) noexcept {
    TermEnds ends;
    if (is_between(w)) ends.add(w.a);
    ends.add(w.b);
    return ends;
  }
  /// Calls f(u, r, force at r on u of (21)).
  template <class F>
  static void each_force(const Stage& w, F f) noexcept {
    f(w.b, w.r_b, w.F_0);
    if (is_between(w)) f(w.a, w.r_a, -w.F_0);
  }
  /// Makes the velocities of the term relative to V.
  template <class Twists>
  static void shift(const Twists& V, Stage& w) noexcept {
    w.J -= w.K * twist_of(V, w);
  }
  template <class System>
  static void load(const Stage& w, const TermEntries& entries, System& system) noexcept {
    const auto add = [&](std::uint32_t u, const Column& r, const SpatialVector& J) noexcept {
      SymmetricSpatialMatrix A{.ww = Block::zero(), .wv = Block::zero(), .vv = Block::zero()};
      add_to_parent(w.K, r, A);
      system.add(u, A);
      system.add_impulse(u, moved_wrench(J, r));
    };
    add(w.b, w.r_b, w.J);
    if (!is_between(w)) return;
    add(w.a, w.r_a, w.J * Real(-1));
    system.add_coupling(entries[0], shifted(coupling(w.K, w.r_a), w.r_b));
  }
  /// Calls f(u, impulse on u about its centre of mass) at the twists V.
  template <class Twists, class F>
  static void each_impulse(const Twists& V, const Stage& w, F f) noexcept {
    each_impulse_of(force(V, w), w, f);
  }
  /// Returns the impulse on b at its point.
  template <class Twists>
  static SpatialVector force(const Twists& V, const Stage& w) noexcept {
    return w.J - w.K * twist_of(V, w);
  }

  /// Calls f(u, impulse on u about its centre of mass) for the impulse J on b at its point.
  template <class F>
  static void each_impulse_of(const SpatialVector& J, const Stage& w, F f) noexcept {
    f(w.b, moved_wrench(J, w.r_b));
    if (is_between(w)) f(w.a, moved_wrench(J * Real(-1), w.r_a));
  }
  /// Returns K V.
  template <class Twists>
  static SpatialVector stiff_impulse(const Twists& V, const Stage& w) noexcept {
    return w.K * twist_of(V, w);
  }

 private:
  static bool is_between(const Stage& w) noexcept { return w.a != TermEnds::on_world; }
  /// Returns the twist of b against a at the point of b.
  template <class Twists>
  static SpatialVector twist_of(const Twists& V, const Stage& w) noexcept {
    const SpatialVector V_b = shifted(V[w.b], w.r_b);
    return is_between(w) ? V_b - shifted(V[w.a], w.r_a) : V_b;
  }
};

}  // namespace godobject
