// Term: a constant force at a point of a body, in world axes.
#pragma once

#include "core/term/damped_spring.h"

namespace godobject {

struct ConstantForceParams {
  SpringEnd at;             // point of a body
  Vec3 F_W = Vec3::Zero();  // N
};

template <class Scene>
bool is_valid(const ConstantForceParams& par, const Scene& scene) noexcept {
  const Real sum = par.F_W.sum() + par.at.p.sum();
  return scene.exists(par.at.on) && sum - sum == 0;
}

/// Kind of term with a capacity for constant forces. Each is a potential, -F . p.
template <std::size_t max_>
struct ConstantForces : PairTerm {
  static constexpr std::size_t max = max_, max_ends = 1;
  using Param = ConstantForceParams;

  template <class OfStage>
  static void begin(const Param& par, const OfStage& stage, const Wrench&, Stage& w) noexcept {
    w = {.b = par.at.on, .r_b = Column(Vec3(stage.at[par.at.on].R_WB * par.at.p)), .F_0 = Column(par.F_W)};
    w.J.v = Column(Vec3(stage.h * par.F_W));
  }
  /// Returns the energy, J, zero at the origin.
  template <class At>
  static Real energy(const Param& par, const At& at) noexcept {
    return -par.F_W.dot(at.point(par.at.on, par.at.p));
  }
};

}  // namespace godobject
