// Conversion of targets, parameters and states of single bodies to those of a group of bodies, one per lane.
#pragma once

#include "core/body/coupling.h"
#include "core/body/rigid_body.h"
#include "core/body/target.h"
#include "core/math/lanes.h"

namespace godobject {

template <class F>
requires std::is_same_v<Gathered<F>, Target> TargetOf<Pack> gathered(const Group<Pack>& group, F of)
noexcept {
  return {.X_WD = gathered(group, [&](std::size_t i) -> const Pose& { return of(i).X_WD; }),
          .V_WD = gathered(group, [&](std::size_t i) -> const Twist& { return of(i).V_WD; })};
}
template <class F>
requires std::is_same_v<Gathered<F>, SpringParams> SpringParamsOf<Pack> gathered(const Group<Pack>& group,
                                                                                 F of)
noexcept {
  const std::array<SpringParams, 4> s{of(group.bodies[0]), of(group.bodies[1]), of(group.bodies[2]),
                                      of(group.bodies[3])};
  return {.k = {s[0].k, s[1].k, s[2].k, s[3].k},
          .g = {s[0].g, s[1].g, s[2].g, s[3].g},
          .k_r = {s[0].k_r, s[1].k_r, s[2].k_r, s[3].k_r},
          .g_r = {s[0].g_r, s[1].g_r, s[2].g_r, s[3].g_r}};
}
template <class F>
requires std::is_same_v<Gathered<F>, RigidBodyParams> RigidBodyParamsOf<Pack> gathered(
    const Group<Pack>& group, F of)
noexcept {
  return {.m = gathered(group, [&](std::size_t i) { return of(i).m; }),
          .I_B = gathered(group, [&](std::size_t i) -> const Mat3& { return of(i).I_B; }),
          .anisotropy = gathered(group, [&](std::size_t i) { return of(i).anisotropy; })};
}
template <class F>
requires std::is_same_v<Gathered<F>, RigidBodyState> RigidBodyStateOf<Pack> gathered(const Group<Pack>& group,
                                                                                     F of)
noexcept {
  return {.X_WB = gathered(group, [&](std::size_t i) -> const Pose& { return of(i).X_WB; }),
          .v_W = gathered(group, [&](std::size_t i) -> const Vec3& { return of(i).v_W; }),
          .w_B = gathered(group, [&](std::size_t i) -> const Vec3& { return of(i).w_B; })};
}

/// Returns body j of a group.
template <class T>
RigidBodyState lane(const RigidBodyStateOf<T>& x, std::size_t j) noexcept {
  return {.X_WB = lane(x.X_WB, j), .v_W = lane(x.v_W, j), .w_B = lane(x.w_B, j)};
}

}  // namespace godobject
