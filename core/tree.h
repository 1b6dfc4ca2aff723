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

#include "core/joint_imposed.h"
#include "core/joint_list.h"
#include "core/joint_stops.h"
#include "core/scene.h"
#include "core/stabilisation.h"
#include "core/tree_solve.h"

namespace godobject {

/// The joints part of a scene: one joint for each body, to a body before it or the world. Stops: JointStops or None.
/// Imposed: ImposedJoints or None.
template <class Stops_ = None, class Imposed_ = None, class Stabilisation_ = AtPrediction>
struct TreeJoints {
  using Stops = Stops_;
  using Imposed = Imposed_;
  using Stabilisation = Stabilisation_;
  struct Params : JointParams {
    [[no_unique_address]] Slot<typename Stops::Params, 5> stop;
    [[no_unique_address]] Slot<typename Imposed::Params, 6> lead;
  };
  using State = typename Imposed::State;
  using Input = typename Imposed::Input;
  struct Output {
    Wrench F_C;  // of the joint on the child at its anchor, world axes, mean of the step's last stage
  };
};

/// Where a body of the tree is, and how it moves.
struct TreePlace {
  Vec3 p_W = Vec3::Zero();
  Mat3 R_WB = Mat3::Identity();
  Twist V;  // of the centre of mass, world axes
};

/// A body of the tree during a stage. Worthless between steps, but for the joint's wrench. As it stands: the world.
struct TreeNode {
  TreePlace at;                // predicted end of the stage
  Vec3 r_C = Vec3::Zero();     // from the centre of mass to the anchor of the body's joint, world axes
  ArticulatedBody body;        // at that anchor
  Vec3 d_W = Vec3::Zero();     // from the parent's anchor to the body's
  Twist beta;                  // (5)
  std::array<EliminatedAxis, 2> axis;
  Twist V;  // solution, of the anchor
  Wrench F_C;

  Vec3 a_W() const noexcept { return at.p_W + r_C; }
};

/// Nodes of the bodies, then of the world.
template <std::size_t N, class Joints>
struct Tree {
  std::array<TreeNode, N> nodes;
  TreeNode ground;
  // places where the stage starts
  std::conditional_t<Joints::Stabilisation::uses_base, std::array<TreePlace, N + 1>, Absent<7>> bases;
  std::conditional_t<uses<typename Joints::Imposed>, std::array<JointCoordinates, N>, Absent<8>> led;

  TreeNode& parent(const JointParams& par) noexcept { return par.parent == world ? ground : nodes[par.parent]; }
};

/// A stage turns a body by at most half a radian for its pose to be predicted.
inline constexpr Real max_predicted_turn = 0.5;

inline TreePlace place(const RigidBodyState& x) noexcept {
  const Mat3 R = x.X_WB.q.toRotationMatrix();
  return {.p_W = x.X_WB.p, .R_WB = R, .V = {.w = R * x.w_B, .v = x.v_W}};
}

/// Puts a body's stage equations into the tree: world axes at the predicted attitude, about the joint's anchor.
inline void load(const JointParams& par, const RigidBodyState& base, const TranslationSystem& translation,
                 const RotationSystem& rotation, Real h, TreeNode& node) noexcept {
  const Real predict = h * h * base.w_B.squaredNorm() <= max_predicted_turn * max_predicted_turn ? 1 : 0;
  node.at = place({.X_WB = moved(base.X_WB, base.v_W, base.w_B, predict * h),
                   .v_W = predict * base.v_W,
                   .w_B = predict * base.w_B});
  const Mat3& R = node.at.R_WB;
  node.r_C = R * par.C.p;
  const Vec3 f = translation.b_W;
  // the centre of mass moves with v - w x r
  const Vec3 Mr = translation.M * node.r_C;
  ArticulatedBody& a = node.body;
  a.A_ww = R * rotation.A_B * R.transpose() - Mr * node.r_C.transpose();
  a.A_ww.diagonal().array() += Mr.dot(node.r_C);
  a.A_vw = skew(Mr);
  a.A_wv = skew(-Mr);
  a.A_vv = translation.M * Mat3::Identity();
  a.b_w = R * rotation.b_B - node.r_C.cross(f);
  a.b_v = f;
}

/// The joint's frames, and how its child moves against its parent.
inline JointAt joint_at(const JointParams& par, const TreePlace& P, const TreePlace& C) noexcept {
  const Vec3 a_W = C.p_W + C.R_WB * par.C.p;
  const Vec3 r_P = a_W - P.p_W;
  return {.X = {.R_WP = P.R_WB * par.P.R, .R_WC = C.R_WB * par.C.R, .d_W = r_P - P.R_WB * par.P.p},
          .V = {.w = C.V.w - P.V.w, .v = C.V.v + C.V.w.cross(a_W - C.p_W) - P.V.v - P.V.w.cross(r_P)}};
}

/// A joint out of the system: what is left of the child hangs on the parent. q: predicted coordinates, for stops.
template <class Joints, class Motion>
void eliminate(const typename Joints::Params& par, const Motion& m, const JointCoordinates& q, Real h,
               TreeNode& child, TreeNode& parent) noexcept {
  ArticulatedBody& a = child.body;
  const bool hangs = par.parent != world;
  set_off(a, child.beta);
  if constexpr (Motion::num_turns == 3) {
    eliminate_turns(a);
    if (hangs) hang_mass(a, child.d_W, parent.body);
  } else {
    int c = 0;
    constexpr int last = Motion::num_turns + Motion::num_slides - 1;
    const auto along = [&]([[maybe_unused]] Real rate) noexcept {
      if constexpr (uses<typename Joints::Stops>)
        return stop_terms(par.stop.stops[static_cast<std::size_t>(c)], q[c], rate, h);
      return AxisTerms{};
    };
    for (const Vec3& s : m.turn) {
      eliminate_turn(a, s, along(s.dot(child.beta.w)), child.axis[c], hangs || c < last);
      ++c;
    }
    for (const Vec3& s : m.slide) {
      eliminate_slide(a, s, along(s.dot(child.beta.v)), child.axis[c], hangs || c < last);
      ++c;
    }
    if (hangs) hang(a, child.d_W, parent.body);
  }
}

/// The twist of a child, and the wrench its joint needs, F = A_a X V_parent - b_a.
template <class Motion>
void solve_back(bool hangs, Real h, const TreeNode& parent, TreeNode& child) noexcept {
  const ArticulatedBody& a = child.body;
  const Twist V_P = shifted(parent.V, child.d_W);
  if constexpr (Motion::num_turns == 3) {
    child.V = {.w = a.b_w - a.A_wv * V_P.v + child.beta.w, .v = V_P.v + child.beta.v};
    child.F_C = {.tau = Vec3::Zero(), .f = (a.A_vv * V_P.v - a.b_v) * (1 / h)};
  } else {
    Twist V = V_P;
    constexpr int turns = Motion::num_turns, slides = Motion::num_slides;
    for (int c = turns + slides; c-- > 0;) {
      const EliminatedAxis& j = child.axis[c];
      const Vec3 motion = rate(j, V) * j.s;
      (c < turns ? V.w : V.v) += motion;
    }
    child.V = {.w = V.w + child.beta.w, .v = V.v + child.beta.v};
    child.F_C = {.tau = -a.b_w, .f = -a.b_v};
    if (hangs) {
      child.F_C.tau += a.A_ww * V_P.w + a.A_wv * V_P.v;
      child.F_C.f += a.A_vw * V_P.w + a.A_vv * V_P.v;
    }
    child.F_C = {.tau = child.F_C.tau * (1 / h), .f = child.F_C.f * (1 / h)};
  }
}

/// Joint i and its child out of the system, children before parents.
template <class Joints, std::size_t N>
void eliminate(const typename Joints::Params& par, std::size_t i, Real h, Tree<N, Joints>& tree) noexcept {
  TreeNode& child = tree.nodes[i];
  TreeNode& parent = tree.parent(par);
  with_joint(par.kind, [&](auto kind) {
    using Kind = decltype(kind);
    const JointAt joint = joint_at(par, parent.at, child.at);
    child.d_W = child.a_W() - parent.a_W();
    const auto with_motion = [&](auto motion_of) {
      const auto m = motion_of(joint.X);
      using Stabilisation = typename Joints::Stabilisation;
      if constexpr (Stabilisation::uses_base) {
        const std::size_t p = par.parent == world ? N : par.parent;
        const JointAt base = joint_at(par, tree.bases[p], tree.bases[i]);
        child.beta = Stabilisation::beta(m, joint.V, h, motion_of(base.X), base.V);
      } else {
        child.beta = Stabilisation::beta(m, joint.V, h);
      }
      JointCoordinates q = JointCoordinates::Zero();
      if constexpr (uses<typename Joints::Stops> && requires { Kind::coordinates(joint.X); })
        q = Kind::coordinates(joint.X);
      eliminate<Joints>(par, m, q, h, child, parent);
    };
    if constexpr (uses<typename Joints::Imposed> && requires { Kind::at(joint.X, tree.led[i]); }) {
      if (par.lead.imposed)
        return with_motion([&](const JointFrames& X) { return FixedJoint::motion(Kind::at(X, tree.led[i])); });
    }
    with_motion([](const JointFrames& X) { return Kind::motion(X); });
  });
}

/// Twist of body i, parents before children.
template <class Joints, std::size_t N>
StageVelocity solve_back(const typename Joints::Params& par, std::size_t i, Real h,
                         Tree<N, Joints>& tree) noexcept {
  TreeNode& node = tree.nodes[i];
  if (par.kind == JointKind::free) node.V = solved(node.body);
  with_joint(par.kind, [&](auto kind) {
    using Motion = decltype(kind.motion(JointFrames{}));
    const bool hangs = par.parent != world;
    if constexpr (uses<typename Joints::Imposed>) {
      if (par.lead.imposed) return solve_back<JointMotion<0, 0>>(hangs, h, tree.parent(par), node);
    }
    solve_back<Motion>(hangs, h, tree.parent(par), node);
  });
  const Vec3 v_W = node.V.v - node.V.w.cross(node.r_C);
  return {.v_W = v_W, .w_B = node.at.R_WB.transpose() * node.V.w};
}

}  // namespace godobject
