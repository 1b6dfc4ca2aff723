// Term: springs and gears on coordinates of joints. A spring of one coordinate is a joint spring; one of two
// coordinates is a gear.
#pragma once

#include "core/math/spatial.h"
#include "core/term/term.h"
#include "core/tuning.h"

namespace godobject {

/// Share of a coordinate in a deviation.
struct CoordinateShare {
  std::uint32_t body = 0;  // child of the joint
  int c = 0;               // number of the joint's coordinate, 0 or 1
  Real ratio = 1;          // 1, rad/m, m/rad
};

/// Parameters of a spring on the deviation y of one or two coordinates. A gear q_b = ratio q_a + offset has
/// y = q_b - ratio q_a - offset. The generalised force on coordinate i is
///
///   (61)  F_i = -ratio_i (k y + g y'),   y = sum ratio_i q_i - y_0
struct CoordinateSpringParams {
  std::array<CoordinateShare, 2> of;
  std::uint32_t size = 1;  // 1 or 2 coordinates
  Real y_0 = 0;            // rad or m
  Real k = 0;              // N m/rad or N/m
  Real g = 0;              // N m s/rad or N s/m
  bool is_rigid = false;   // true: y is held at zero, as a joint holds; k and g are unused
};

template <class Scene>
bool is_valid(const CoordinateSpringParams& par, const Scene& scene) noexcept {
  const auto is_number = [](Real x) noexcept { return x >= 0 && x - x == 0; };
  bool valid =
      par.size >= 1 && par.size <= 2 && par.y_0 - par.y_0 == 0 && is_number(par.k) && is_number(par.g);
  for (std::uint32_t i = 0; valid && i < par.size; ++i)
    valid = scene.has_coordinate(par.of[i].body, par.of[i].c) && par.of[i].ratio - par.of[i].ratio == 0;
  return valid && (par.size == 1 || par.of[0].body != par.of[1].body || par.of[0].c != par.of[1].c);
}

/// Returns the effective mass of a rate a . V of bodies on their own.
template <class Stages>
Real effective_mass(const TermEnds& ends, const std::array<SpatialVector, TermEnds::max>& a,
                    const Stages& stages) noexcept {
  Real inverse_mass = 0;
  for (std::uint32_t e = 0; e < ends.size; ++e) {
    const auto& stage = stages[ends.list[e]];
    inverse_mass += dot(a[e].w, inverse(stage.A_ww) * a[e].w) + dot(a[e].v, a[e].v) / stage.M;
  }
  return 1 / inverse_mass;
}

/// Spring in a stage (37): the impulse J - K y' along y, with y' at the end of the stage and K = h (h k + g).
/// A rigid one ends the stage at y = 0 like the joints (18). Its impulse is a multiplier, found by the method
/// of multipliers (62): the previous one, corrected by a large K.
struct CoordinateSpringStage {
  TermEnds ends;
  std::array<SpatialVector, TermEnds::max> a;  // y' = sum a . V over the ends
  Real K = 0, J = 0;
  SpatialVector along;  // force on the last coordinate by a unit along y, at its anchor
};

/// Kind of term with a capacity for springs on coordinates.
template <std::size_t max_>
struct CoordinateSprings {
  static constexpr std::size_t max = max_, max_ends = TermEnds::max;
  static constexpr bool on_coordinates = true, is_joint = false;
  using Param = CoordinateSpringParams;
  using Stage = CoordinateSpringStage;

  static TermEnds ends(const Stage& w) noexcept { return w.ends; }

  /// Linearises a spring at the predicted coordinates. F: its force in the previous solve.
  template <class OfStage>
  static void begin(const Param& par, const OfStage& stage, const Wrench& F, Stage& w) noexcept {
    w = {};
    w.a.fill(SpatialVector::zero());
    Real y = -par.y_0, rate = 0;
    for (std::uint32_t i = 0; i < par.size; ++i) {
      const CoordinateShare& share = par.of[i];
      const CoordinateAt q = stage.coordinate(share.body, share.c);
      const auto add = [&](std::uint32_t u, Real factor) noexcept {
        w.a[w.ends.add(u)] += q.row(stage.at[u].p_W) * factor;
      };
      add(q.child, share.ratio);
      if (q.parent != TermEnds::on_world) add(q.parent, -share.ratio);
      y += share.ratio * q.q;
      rate += share.ratio * q.rate;
      w.along = q.row(q.a_W) * share.ratio;
    }
    const Real h = stage.h;
    if (par.is_rigid) {
      w.K = rigid_mass_ratio * effective_mass(w.ends, w.a, stage.stages);
      const SpatialVector F_0{.w = Column(F.tau), .v = Column(F.f)};
      const Real along_sq = dot(w.along, w.along);
      const Real multiplier = along_sq > 0 ? dot(w.along, F_0) / along_sq : 0;
      w.J = h * multiplier - w.K * (y / h - rate);
    } else {
      w.K = h * (h * par.k + par.g);
      w.J = -h * par.k * (y - h * rate);
    }
  }
  template <class F>
  static void each_force(const Stage&, F) noexcept {}
  /// Makes the velocities of the term relative to V.
  template <class Twists>
  static void shift(const Twists& V, Stage& w) noexcept {
    w.J -= w.K * rate_of(V, w);
  }
  template <class System>
  static void load(const Stage& w, const TermEntries& entries, System& system) noexcept {
    for (std::uint32_t e = 0; e < w.ends.size; ++e) {
      const SpatialVector &a = w.a[e], Ka = a * w.K;
      system.add(w.ends.list[e], {.ww = outer(Ka.w, a.w), .wv = outer(Ka.w, a.v), .vv = outer(Ka.v, a.v)});
      system.add_impulse(w.ends.list[e], a * w.J);
    }
    std::size_t k = 0;
    w.ends.each_pair([&](std::uint32_t i, std::uint32_t j) noexcept {
      const SpatialVector Ka = w.a[i] * w.K, &a = w.a[j];
      system.add_coupling(
          entries[k++],
          {.ww = outer(Ka.w, a.w), .wv = outer(Ka.w, a.v), .vw = outer(Ka.v, a.w), .vv = outer(Ka.v, a.v)});
    });
  }
  template <class Twists, class F>
  static void each_impulse(const Twists& V, const Stage& w, F f) noexcept {
    const Real J = w.J - w.K * rate_of(V, w);
    for (std::uint32_t e = 0; e < w.ends.size; ++e) f(w.ends.list[e], w.a[e] * J);
  }
  /// Returns the impulse on the last coordinate, at its anchor.
  template <class Twists>
  static SpatialVector force(const Twists& V, const Stage& w) noexcept {
    return w.along * (w.J - w.K * rate_of(V, w));
  }
  /// Returns the energy, J. at.coordinate(i, c): coordinate c of the joint of body i.
  template <class At>
  static Real energy(const Param& par, const At& at) noexcept {
    return par.is_rigid ? 0 : Real(0.5) * par.k * deviation(par, at) * deviation(par, at);
  }
  /// Returns y (61).
  template <class At>
  static Real deviation(const Param& par, const At& at) noexcept {
    Real y = -par.y_0;
    for (std::uint32_t i = 0; i < par.size; ++i)
      y += par.of[i].ratio * at.coordinate(par.of[i].body, par.of[i].c);
    return y;
  }

 private:
  template <class Twists>
  static Real rate_of(const Twists& V, const Stage& w) noexcept {
    Real rate = 0;
    for (std::uint32_t e = 0; e < w.ends.size; ++e) rate += dot(w.a[e], V[w.ends.list[e]]);
    return rate;
  }
};

}  // namespace godobject
