// A tool of bodies on joints: the articulated part of a scene.
//
// Joints are taken where they will be at the end of the stage: L and g at the pose the base's velocity V^
// predicts, so that
//
//   (18)  L V+ = L V^ - g / h
//
// leaves a violation of the order of the square of h (V+ - V^), not of h V. The direction of the joint forces is
// second order for the same reason.
#pragma once

#include "core/implicit_stage.h"
#include "core/joint_list.h"
#include "core/scene.h"
#include "core/tree_solve.h"

namespace godobject {

/// The joints part of a scene: one joint for each body, to a body before it or the world.
struct TreeJoints {
  using Params = JointParams;
  using State = Empty;
  struct Output {
    Wrench F_C;  // of the joint on the child at its anchor, world axes
  };
};

/// A body of the tree during a stage. Worthless between steps, but for the joint's wrench.
struct TreeNode {
  ArticulatedBody body;
  EliminatedJoint joint;
  Vec3 p_W;     // predicted
  Mat3 R_WB;    // predicted
  Vec3 r_C;     // from the centre of mass to the joint's anchor, world axes
  Twist V_hat;  // with which it was predicted
  Twist V;      // solution
  Wrench F_C;
};

/// A stage turns a body by at most half a radian for its pose to be predicted.
inline constexpr Real max_predicted_turn = 0.5;

/// Puts a body's stage equations into the tree, in world axes at the predicted attitude.
inline void load(const RigidBodyState& base, const TranslationSystem& translation,
                 const RotationSystem& rotation, Real h, TreeNode& node) noexcept {
  const bool predict = h * h * base.w_B.squaredNorm() <= max_predicted_turn * max_predicted_turn;
  const Pose X = predict ? moved(base.X_WB, base.v_W, base.w_B, h) : base.X_WB;
  const Mat3 R = X.q.toRotationMatrix();
  node.p_W = X.p;
  node.R_WB = R;
  node.V_hat = {};
  if (predict) node.V_hat = {.w = R * base.w_B, .v = base.v_W};
  node.body.A_ww = R * rotation.A_B * R.transpose();
  node.body.A_wv.setZero();
  node.body.A_vw.setZero();
  node.body.A_vv = translation.M * Mat3::Identity();
  node.body.b_w = R * rotation.b_B;
  node.body.b_v = translation.b_W;
}

/// Joint i out of the system, children before parents.
inline void eliminate(const JointParams& par, std::size_t i, Real h, TreeNode* nodes) noexcept {
  TreeNode& child = nodes[i];
  const bool on_world = par.parent == world;
  const Vec3 p_P = on_world ? Vec3(Vec3::Zero()) : nodes[par.parent].p_W;
  const Mat3 R_P = on_world ? Mat3(Mat3::Identity()) : nodes[par.parent].R_WB;
  const Twist V_P = on_world ? Twist{} : nodes[par.parent].V_hat;
  child.r_C = child.R_WB * par.X_BC.p;
  const JointFrames X = {.R_WP = R_P * par.X_BP.q.toRotationMatrix(),
                         .R_WC = child.R_WB * par.X_BC.q.toRotationMatrix(),
                         .d_W = child.p_W + child.r_C - p_P - R_P * par.X_BP.p};
  with_joint(par.kind, [&](auto kind) {
    constexpr int D = decltype(kind)::dof;
    const JointMotion<D> m = kind.motion(X);
    EliminatedJoint& j = child.joint;
    j.d = child.p_W - p_P;
    // motion and correction of the centre of mass from those of the anchor
    if constexpr (D > 0) {
      for (int c = 0; c < D; ++c) {
        j.S_w.col(c) = m.S_w.col(c);
        j.S_v.col(c) = m.S_v.col(c) + child.r_C.cross(Vec3(m.S_w.col(c)));
      }
    }
    const Vec3 correction_w = -m.e_w / h;
    j.beta_w = child.V_hat.w - V_P.w + correction_w;
    j.beta_v = child.V_hat.v - V_P.v - V_P.w.cross(j.d) - m.e_v / h + child.r_C.cross(correction_w);
    godobject::eliminate<D>(child.body, j, on_world ? nullptr : &nodes[par.parent].body);
  });
}

/// Twist of body i, parents before children; and the wrench its joint needed.
inline StageVelocity solved(const JointParams& par, std::size_t i, Real h, TreeNode* nodes) noexcept {
  TreeNode& node = nodes[i];
  if (par.kind == JointKind::free) {
    node.V = solved(node.body);
  } else {
    const Twist V_P = par.parent == world ? Twist{} : nodes[par.parent].V;
    with_joint(par.kind, [&](auto kind) { node.V = solved<decltype(kind)::dof>(node.joint, V_P); });
    const ArticulatedBody& a = node.body;
    const Vec3 f = (a.A_vw * node.V.w + a.A_vv * node.V.v - a.b_v) / h;
    const Vec3 tau = (a.A_ww * node.V.w + a.A_wv * node.V.v - a.b_w) / h;
    node.F_C = {.tau = tau - node.r_C.cross(f), .f = f};
  }
  return {.v_W = node.V.v, .w_B = node.R_WB.transpose() * node.V.w};
}

}  // namespace godobject
