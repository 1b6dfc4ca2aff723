// Conversion of numbers, vectors, poses and twists of single bodies to those of a group, one per lane.
#pragma once

#include "core/math/simd4.h"

namespace godobject {

/// Numbers of the bodies in the lanes of a T; unused lanes repeat the last body.
template <class T>
struct Group {
  std::array<std::size_t, num_lanes<T>> bodies;

  constexpr Group(std::size_t g, std::size_t num_bodies) noexcept {
    for (std::size_t j = 0; j < num_lanes<T>; ++j) bodies[j] = std::min(g * num_lanes<T> + j, num_bodies - 1);
  }
};

/// Group of the numbers 0 to 3.
inline constexpr Group<Pack> lanes_of_four(0, 4);

template <class F>
using Gathered = std::decay_t<std::invoke_result_t<F, std::size_t>>;

/// Returns of(i) for the bodies i of a group; of(i) itself for a group of one.
template <class F>
decltype(auto) gathered(const Group<Real>& group, F of) noexcept {
  return of(group.bodies[0]);
}

template <class F>
requires std::is_same_v<Gathered<F>, Real> Pack gathered(const Group<Pack>& group, F of)
noexcept { return {of(group.bodies[0]), of(group.bodies[1]), of(group.bodies[2]), of(group.bodies[3])}; }
template <class F>
requires std::is_base_of_v<Eigen::MatrixBase<Gathered<F>>, Gathered<F>>
auto gathered(const Group<Pack>& group, F of) noexcept {
  const Gathered<F>&a = of(group.bodies[0]), &b = of(group.bodies[1]), &c = of(group.bodies[2]),
        &d = of(group.bodies[3]);
  Eigen::Matrix<Pack, Gathered<F>::RowsAtCompileTime, Gathered<F>::ColsAtCompileTime> all;
  for (Eigen::Index k = 0; k < all.size(); ++k)
    all.data()[k] = Pack(a.data()[k], b.data()[k], c.data()[k], d.data()[k]);
  return all;
}
template <class F>
requires std::is_same_v<Gathered<F>, Quat> Quaternion<Pack> gathered(const Group<Pack>& group, F of)
noexcept {
  Quaternion<Pack> q;
  q.coeffs() = gathered(group, [&](std::size_t i) -> decltype(auto) { return (of(i).coeffs()); });
  return q;
}
template <class F>
requires std::is_same_v<Gathered<F>, Pose> PoseOf<Pack> gathered(const Group<Pack>& group, F of)
noexcept {
  return {.p = gathered(group, [&](std::size_t i) -> const Vec3& { return of(i).p; }),
          .q = gathered(group, [&](std::size_t i) -> const Quat& { return of(i).q; })};
}
template <class F>
requires std::is_same_v<Gathered<F>, Twist> TwistOf<Pack> gathered(const Group<Pack>& group, F of)
noexcept {
  return {.w = gathered(group, [&](std::size_t i) -> const Vec3& { return of(i).w; }),
          .v = gathered(group, [&](std::size_t i) -> const Vec3& { return of(i).v; })};
}

}  // namespace godobject
