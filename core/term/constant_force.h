// Term: a constant force at a point of a body, in world axes.
#pragma once

#include "core/term/damped_spring.h"

namespace godobject {

struct ConstantForceParams {
  SpringEnd at;             // point of a body or node
  Vec3 F_W = Vec3::Zero();  // N
};

template <class Scene>
bool is_valid(const ConstantForceParams& par, const Scene& scene) noexcept {
  const Real sum = par.F_W.sum() + par.at.p.sum();
  return scene.exists(par.at.on) && sum - sum == 0;
}

struct ConstantForceStage {
  std::uint32_t on = 0;
  Column r;  // lever from the centre of mass, world axes
  Column J;  // impulse
  Column F;
};

/// Kind of term with a capacity for constant forces. Each is a potential, -F . p.
template <std::size_t max_>
struct ConstantForces {
  static constexpr std::size_t max = max_, max_ends = 1;
  static constexpr bool on_coordinates = false, is_joint = false;
  using Param = ConstantForceParams;
  using Stage = ConstantForceStage;

  static TermEnds ends(const Stage& w) noexcept {
    TermEnds ends;
    ends.add(w.on);
    return ends;
  }

  template <class OfStage>
  static void begin(const Param& par, const OfStage& stage, const Wrench&, Stage& w) noexcept {
    w = {.on = par.at.on,
         .r = Column(Vec3(stage.at[par.at.on].R_WB * par.at.p)),
         .J = Column(Vec3(stage.h * par.F_W)),
         .F = Column(par.F_W)};
  }
  /// Calls f(u, r, force at r on u).
  template <class F>
  static void each_force(const Stage& w, F f) noexcept {
    f(w.on, w.r, w.F);
  }
  template <class Twists>
  static void shift(const Twists&, Stage&) noexcept {}
  template <class System>
  static void load(const Stage& w, const TermEntries&, System& system) noexcept {
    system.add_impulse(w.on, moved_wrench({.w = Column(Pack(0)), .v = w.J}, w.r));
  }
  template <class Twists, class F>
  static void each_impulse(const Twists& V, const Stage& w, F f) noexcept {
    f(w.on, moved_wrench(force(V, w), w.r));
  }
  template <class Twists>
  static SpatialVector force(const Twists&, const Stage& w) noexcept {
    return {.w = Column(Pack(0)), .v = w.J};
  }
  /// Returns the energy, J, zero at the origin.
  template <class At>
  static Real energy(const Param& par, const At& at) noexcept {
    return -par.F_W.dot(at.point(par.at.on, par.at.p));
  }
};

}  // namespace godobject
