// Stage operations of joints for the integrators: bodies of a scene in the tree of its joints.
#pragma once

#include "core/joint/tree.h"
#include "core/math/lanes.h"
#include "core/scene.h"

namespace godobject {

/// Returns the place of body i of a scene, or of the world.
template <Scene S>
TreePlace place_of(const Params<S>& par, const State<S>& x, std::size_t i) noexcept {
  return i == world ? TreePlace{} : place<Real>(par.bodies[i].joint.C.p, x.bodies[i].x);
}

/// Loads the stage equations of a group of bodies into the tree: world axes at the predicted attitude, about
/// the joints' anchors.
template <Scene S, class T>
void load(const Params<S>& par, std::size_t g, const RigidBodyStateOf<T>& base,
          const TranslationSystemOf<T>& translation, const RotationSystemOf<T>& rotation,
          const Vector3<T>& F_W, Real h, Real max_turn,
          Tree<S::max_bodies, typename S::Joints>& tree) noexcept {
  const Group<T> group(g, num_bodies(par));
  const Vector3<T>& p_C =
      gathered(group, [&](std::size_t i) -> const Vec3& { return par.bodies[i].joint.C.p; });
  const TreePlaceOf<T> at = place<T>(p_C, predicted(base, h, max_turn));
  const Matrix3<T>& R = at.R_WB;

  // about the anchor; the centre of mass is r away and moves with v + w x r
  const Vector3<T> r = at.p_W - at.a_W;
  const Vector3<T> Mr = translation.M * r;
  Matrix3<T> A_ww = R * rotation.A_B * R.transpose() - Mr * r.transpose();
  A_ww.diagonal().array() += Mr.dot(r);
  Vector3<T> b_w = R * rotation.b_B + r.cross(translation.b_W);
  // second-order stages diverge if A lacks its skew part; implicit Euler tolerates that, and drifts less
  stiffen<S::Integrator::order == 2, T>(r, h * h * F_W, at.V.w, A_ww, b_w);

  const T zero = 0;
  const auto A_0 = columns(A_ww.col(0).eval()), A_1 = columns(A_ww.col(1).eval()),
             A_2 = columns(A_ww.col(2).eval());
  const auto Mr_0 = columns(Vector3<T>(zero, Mr.z(), -Mr.y())),
             Mr_1 = columns(Vector3<T>(-Mr.z(), zero, Mr.x())),
             Mr_2 = columns(Vector3<T>(Mr.y(), -Mr.x(), zero));
  const auto b_0 = columns(b_w), b_1 = columns(translation.b_W);
  for (std::size_t j = 0; j < num_lanes<T> && g * num_lanes<T> + j < num_bodies(par); ++j) {
    TreeNode& node = tree.nodes[g * num_lanes<T> + j];
    node.at = lane(at, j);
    node.body = {.A = {.ww = {{A_0[j], A_1[j], A_2[j]}},
                       .wv = {{Mr_0[j], Mr_1[j], Mr_2[j]}},
                       .vw = {{-Mr_0[j], -Mr_1[j], -Mr_2[j]}},
                       .vv = Block::identity() * lane(translation.M, j)},
                 .b = {.w = b_0[j], .v = b_1[j]}};
    if constexpr (S::Joints::Stabilisation::uses_base)
      tree.bases[g * num_lanes<T> + j] = lane(place<T>(p_C, base), j);
  }
}

}  // namespace godobject
