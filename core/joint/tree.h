// A tool of bodies on joints: the articulated part of a scene.
//
// Joints are evaluated at the end of the stage: L and g at the pose predicted from the base's velocity V^, so
// that
//
//   (18)  L V+ = L V^ - g / h
//
// leaves a violation of the order of the square of h (V+ - V^), not of h V. The direction of the joint forces
// is of second order for the same reason.
#pragma once

#include <limits>

#include "core/body/implicit_stage.h"
#include "core/composition.h"
#include "core/joint/geometric_stiffness.h"
#include "core/joint/list.h"
#include "core/joint/prescribed.h"
#include "core/joint/stabilisation.h"
#include "core/joint/stops.h"
#include "core/joint/tree_solve.h"
#include "core/math/simd4.h"
#include "core/tuning.h"

namespace godobject {

/// Joints part of a scene: one joint for each body, to a body before it or the world.
/// Stops: JointStops or None. Prescribed: PrescribedJoints or None.
template <class Stops_ = None, class Prescribed_ = None, class Stabilisation_ = AtPrediction>
struct TreeJoints {
  using Stops = Stops_;
  using Prescribed = Prescribed_;
  using Stabilisation = Stabilisation_;
  struct Params : JointParams {
    [[no_unique_address]] Slot<typename Stops::Params, 5> stop;
    [[no_unique_address]] Slot<typename Prescribed::Params, 6> motion;
    bool driven = true;  // true if the device has a motor on this link; otherwise its feedback goes to the
                         // parent (9)
  };
  /// Coordinates are state if the joints have stops.
  struct State : Prescribed::State, std::conditional_t<uses<Stops>, typename Stops::State, Absent<26>> {
    Wrench F_C;  // wrench of the joint in the last step
  };
  using Input = typename Prescribed::Input;
  struct Output {
    Wrench F_C;  // wrench of the joint on the child about its anchor, world axes, mean over the step
  };
};

/// Calls f(kind, motion) for joint i. motion(X): allowed motion at frames X, none for a prescribed joint.
template <class Joints, class PrescribedCoordinates, class F>
void with_motion(const typename Joints::Params& par,
                 [[maybe_unused]] const PrescribedCoordinates& prescribed_q, [[maybe_unused]] std::size_t i,
                 F f) noexcept {
  with_joint(par.kind, [&](auto kind) {
    using Kind = decltype(kind);
    if constexpr (uses<typename Joints::Prescribed> &&
                  requires { Kind::at(JointFrames{}, prescribed_q[i]); }) {
      if (par.motion.prescribed)
        return f(kind,
                 [&](const JointFrames& X) { return FixedJoint::motion(Kind::at(X, prescribed_q[i])); });
    }
    f(kind, [](const JointFrames& X) { return Kind::motion(X); });
  });
}

/// Place and velocity of a body of the tree.
template <class T>
struct TreePlaceOf {
  Vector3<T> p_W = Vector3<T>::Zero();
  Matrix3<T> R_WB = Matrix3<T>::Identity();
  Vector3<T> a_W = Vector3<T>::Zero();  // position of the anchor of the body's joint
  TwistOf<T> V;                         // twist at that anchor, world axes
};
using TreePlace = TreePlaceOf<Real>;

/// Returns the place of a body with its anchor at p_C, body axes.
template <class T>
TreePlaceOf<T> place(const Vector3<T>& p_C, const RigidBodyStateOf<T>& x) noexcept {
  const Matrix3<T> R = x.X_WB.q.toRotationMatrix();
  const Vector3<T> r = R * p_C, w = R * x.w_B;
  return {.p_W = x.X_WB.p, .R_WB = R, .a_W = x.X_WB.p + r, .V = {.w = w, .v = x.v_W + w.cross(r)}};
}

template <class T>
TreePlace lane(const TreePlaceOf<T>& at, std::size_t j) noexcept {
  return {.p_W = lane(at.p_W, j),
          .R_WB = lane(at.R_WB, j),
          .a_W = lane(at.a_W, j),
          .V = {.w = lane(at.V.w, j), .v = lane(at.V.v, j)}};
}

/// Body of the tree during a stage; default: the world. Undefined between steps, except the joint's wrench.
struct TreeNode {
  TreePlace at;          // place at the predicted end of the stage
  ArticulatedBody body;  // articulated inertia and bias at the anchor of its joint
  Column d;              // vector from the parent's anchor to the body's
  SpatialVector beta;    // (5)
  std::array<EliminatedAxis, 2> axis;
  SpatialVector V;  // solution
  Wrench F_C;
};

/// Per-stage inputs and flags of the joints. Undefined between steps.
template <std::size_t N, class Joints>
struct JointsInStage {
  using Coordinates =
      std::conditional_t<uses<typename Joints::Stops>, std::array<JointCoordinates, N>, Absent<27>>;

  std::conditional_t<uses<typename Joints::Prescribed>, std::array<JointCoordinates, N>, Absent<8>>
      prescribed_q;
  [[no_unique_address]] Coordinates q;  // coordinates at the start of the stage, turns counted
  bool is_stiff = false;   // true if a stop or joint force may have reversed a motion within the last stage
  bool stop_acts = false;  // true if a coordinate was within a stop in the last stage
  bool stop_changes = false;  // true if a coordinate changed its branch of a stop (19) in the last stage
};

/// Nodes of the bodies, then of the world.
template <std::size_t N, class Joints>
struct Tree : JointsInStage<N, Joints> {
  std::array<TreeNode, N> nodes;
  TreeNode ground;
  // places at the start of the stage
  std::conditional_t<Joints::Stabilisation::uses_base, std::array<TreePlace, N + 1>, Absent<7>> bases;

  TreeNode& parent(const JointParams& par) noexcept {
    return par.parent == world ? ground : nodes[par.parent];  // cppcheck-suppress returnTempReference
  }
};

/// Returns the body moved by the velocities of the base for a time h, s.
template <class T>
RigidBodyStateOf<T> predicted(const RigidBodyStateOf<T>& base, Real h, Real max_turn) noexcept {
  const T turn_sq = h * h * base.w_B.squaredNorm();
  const T move = select(turn_sq <= max_turn * max_turn, T(1), T(0));
  return {.X_WB = moved<T>(base.X_WB, base.v_W, base.w_B, move * h),
          .v_W = move * base.v_W,
          .w_B = move * base.w_B};
}

/// Returns the joint's frames and the velocity of its child against its parent.
inline JointAt joint_at(const JointParams& par, const TreePlace& P, const TreePlace& C) noexcept {
  const Vec3 V_P = P.V.v + P.V.w.cross(C.a_W - P.a_W);
  return {.X = {.R_WP = P.R_WB * par.P.R, .R_WC = C.R_WB * par.C.R, .d_W = C.a_W - P.p_W - P.R_WB * par.P.p},
          .V = {.w = C.V.w - P.V.w, .v = C.V.v - V_P}};
}

/// Eliminates a joint and its child (7): adds the child's articulated inertia and bias to the parent.
/// q: predicted coordinates, for stops. on_slide: effective mass on the rate of a slide (40), kg.
template <class Joints, class Motion>
void eliminate(const typename Joints::Params& par, const Motion& m, const JointCoordinates& q,
               const AxisTerms& on_slide, Real h, TreeNode& child, TreeNode& parent, bool& is_stiff,
               bool& stop_acts) noexcept {
  ArticulatedBody& a = child.body;
  const bool has_parent = par.parent != world;
  const Twist beta = {.w = child.beta.w.vec(), .v = child.beta.v.vec()};
  if constexpr (Motion::num_turns == 3) {
    add_shift_bias(a, child.beta.v);  // valid for any rotation, because beta has none
    eliminate_turns(a);
    if (has_parent) add_mass_to_parent(a, child.d, parent.body);
  } else {
    add_bias(a, child.beta);
    std::size_t c = 0;
    constexpr std::size_t last = Motion::num_turns + Motion::num_slides - 1;
    const auto axis = [&]<bool turns>(std::bool_constant<turns>, const Vec3& s) noexcept {
      AxisTerms along;
      if constexpr (uses<typename Joints::Stops>)
        along =
            stop_terms(par.stop.stops[c], q[static_cast<Eigen::Index>(c)], s.dot(turns ? beta.w : beta.v), h);
      const Real of_stop = along.D;
      if constexpr (!turns) along = {.D = along.D + on_slide.D, .tau = along.tau + on_slide.tau};
      eliminate_axis<turns>(a, Column(s), along, child.axis[c], has_parent || c < last);
      if constexpr (uses<typename Joints::Stops>) {
        is_stiff |= of_stop * child.axis[c].D_inverse > stiff_stop_share;
        stop_acts |= of_stop > 0;
      }
      ++c;
    };
    for (const Vec3& s : m.turn) axis(std::true_type{}, s);
    for (const Vec3& s : m.slide) axis(std::false_type{}, s);
    if (has_parent) add_to_parent(a, child.d, parent.body);
  }
}

/// Computes the twist of a child and the wrench of its joint, F = A_a X V_parent - b_a.
template <class Motion>
void solve_back(bool has_parent, Real h, const TreeNode& parent, TreeNode& child) noexcept {
  const ArticulatedBody& a = child.body;
  const SpatialVector V_P = shifted(parent.V, child.d);
  SpatialVector V = V_P, F;
  if constexpr (Motion::num_turns == 3) {
    V.w = a.b.w - a.A.wv * V_P.v;
    F.v = a.A.vv * V_P.v - a.b.v;
  } else {
    constexpr int turns = Motion::num_turns, slides = Motion::num_slides;
    for (int c = turns + slides; c-- > 0;) {
      const EliminatedAxis& j = child.axis[static_cast<std::size_t>(c)];
      (c < turns ? V.w : V.v) += j.s * rate(j, V);
    }
    F = {.w = -a.b.w, .v = -a.b.v};
    if (has_parent) {
      F.w += a.A.ww * V_P.w + a.A.wv * V_P.v;
      F.v += a.A.vw * V_P.w + a.A.vv * V_P.v;
    }
  }
  child.V = {.w = V.w + child.beta.w, .v = V.v + child.beta.v};
  child.F_C = {.tau = (F.w * (1 / h)).vec(), .f = (F.v * (1 / h)).vec()};
}

/// Eliminates joint i and its child, children before parents. f_C: force of the joint in the previous step,
/// N.
template <class Joints, std::size_t N>
void eliminate(const typename Joints::Params& par, std::size_t i, const Wrench& F_C, Real h,
               Tree<N, Joints>& tree) noexcept {
  TreeNode& child = tree.nodes[i];
  TreeNode& parent = tree.parent(par);
  with_motion<Joints>(par, tree.prescribed_q, i, [&](auto kind, auto motion) {
    const JointAt joint = joint_at(par, parent.at, child.at);
    child.d = Column(Vec3(child.at.a_W - parent.at.a_W));
    const auto m = motion(joint.X);
    using Motion = std::remove_const_t<decltype(m)>;
    using Stabilisation = typename Joints::Stabilisation;
    Twist beta;
    if constexpr (Stabilisation::uses_base) {
      const std::size_t p = par.parent == world ? N : par.parent;
      const JointAt base = joint_at(par, tree.bases[p], tree.bases[i]);
      beta = Stabilisation::beta(m, joint.V, h, motion(base.X), base.V);
    } else {
      beta = Stabilisation::beta(m, joint.V, par.C.p.squaredNorm(), h);
    }
    if constexpr (Motion::num_turns == 3) beta.w.setZero();
    child.beta = {.w = Column(beta.w), .v = Column(beta.v)};
    JointCoordinates q = JointCoordinates::Zero();
    if constexpr (uses<typename Joints::Stops>) {
      if constexpr (requires { kind.coordinates(joint.X); }) {
        q = counted<decltype(kind)>(joint.X, joint.V.w, tree.q[i], h);
        tree.stop_changes |= !on_same_branches(par.stop.stops, q, tree.q[i]);
      }
    }
    const bool has_parent = par.parent != world;
    ArticulatedBody &a = child.body, &p = parent.body;
    const StiffenedBody<Block> on_child{a.A.ww, a.A.vv, a.b, child.at.V},
        on_parent{p.A.ww, p.A.vv, p.b, parent.at.V};
    const Real K_slide = stiffen<Motion>(child.d, child.at.p_W - child.at.a_W, F_C, h, has_parent, on_parent,
                                         on_child, tree.is_stiff);
    AxisTerms on_slide;
    if constexpr (Motion::num_slides > 0)
      on_slide = {.D = K_slide, .tau = K_slide * m.slide[0].dot(joint.V.v - beta.v)};
    eliminate<Joints>(par, m, q, on_slide, h, child, parent, tree.is_stiff, tree.stop_acts);
  });
}

/// Computes the velocity of body i, parents before children.
template <class Joints, std::size_t N>
StageVelocity solve_back(const typename Joints::Params& par, std::size_t i, Real h,
                         Tree<N, Joints>& tree) noexcept {
  TreeNode& node = tree.nodes[i];
  if (par.kind == JointKind::free) node.V = solved(node.body.A, node.body.b);
  with_motion<Joints>(par, tree.prescribed_q, i, [&](auto, auto motion) {
    solve_back<decltype(motion(JointFrames{}))>(par.parent != world, h, tree.parent(par), node);
  });
  const Vec3 w_W = node.V.w.vec();
  return {.v_W = node.V.v.vec() + w_W.cross(node.at.p_W - node.at.a_W),
          .w_B = node.at.R_WB.transpose() * w_W};
}

}  // namespace godobject
