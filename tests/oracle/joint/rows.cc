#include "tests/oracle/joint/rows.h"

#include <cmath>

namespace godobject::oracle {

namespace {

/// F or K. Its accelerations are those of a point fixed to its body, plus the biases.
struct JointFrame {
  ScalarVector3 r;           // from the body's origin
  ScalarVector3 p, v, w;     // world axes
  ScalarMatrix3 axes;        // columns: the joint's axis and two normals n1, n2, in world axes
  ScalarVector3 a_bias;      // p'' = a + w' x r + a_bias
  ScalarVector3 alpha_bias;  // angular acceleration = w' + alpha_bias
};

/// Right-handed and orthonormal, the first column along `axis`.
ScalarMatrix3 triad(const ScalarVector3& axis) {
  ScalarMatrix3 E;
  E.col(0) = axis.normalized();
  E.col(1) = E.col(0).unitOrthogonal();
  E.col(2) = E.col(0).cross(E.col(1));
  return E;
}

JointFrame attached(const BodyState& body, const ScalarVector3& anchor_B, const ScalarMatrix3& axes_B) {
  const ScalarMatrix3 R = body.q.toRotationMatrix();
  JointFrame frame;
  frame.r = R * anchor_B;
  frame.p = body.p + frame.r;
  frame.v = body.v + body.w.cross(frame.r);
  frame.w = body.w;
  frame.axes = R * axes_B;
  frame.a_bias = body.w.cross(body.w.cross(frame.r));
  frame.alpha_bias.setZero();
  return frame;
}

/// Moves F along the prescribed coordinate, which makes the joint a fixed one.
void impose(JointType type, const JointCoordinate& x, const BodyState& parent, JointFrame& F) {
  const ScalarVector3 axis = F.axes.col(0);
  const Scalar value = x.value, d1 = x.d1, d2 = x.d2;
  if (type == JointType::slider) {
    const ScalarVector3 shift = value * axis;
    F.r += shift;
    F.p += shift;
    F.v += parent.w.cross(shift) + d1 * axis;
    F.a_bias += parent.w.cross(parent.w.cross(shift)) + 2 * d1 * parent.w.cross(axis) + d2 * axis;
  } else {
    const ScalarVector3 n1 = F.axes.col(1), n2 = F.axes.col(2);
    F.axes.col(1) = std::cos(value) * n1 + std::sin(value) * n2;
    F.axes.col(2) = std::cos(value) * n2 - std::sin(value) * n1;
    F.w += d1 * axis;
    F.alpha_bias = d1 * parent.w.cross(axis) + d2 * axis;
  }
}

/// g = n . d with d = p_K - p_F and n' = w_F x n, so
/// g'' = n . (d'' - alpha_F x d - 2 w_F x d' + w_F x (w_F x d)).
void add_distance(const JointFrame& F, const JointFrame& K, const ScalarVector3& n, Eigen::Index row,
                  JointRows& rows) {
  const ScalarVector3 d = K.p - F.p, dd = K.v - F.v;
  rows.g[row] = n.dot(d);
  rows.rate[row] = n.dot(dd - F.w.cross(d));
  rows.bias[row] =
      n.dot(K.a_bias - F.a_bias - F.alpha_bias.cross(d) - 2 * F.w.cross(dd) + F.w.cross(F.w.cross(d)));
  rows.L_child.row(row) << n.transpose(), K.r.cross(n).transpose();
  rows.L_parent.row(row) << -n.transpose(), -(F.r + d).cross(n).transpose();
}

/// g = u . b with u' = w_F x u and b' = w_K x b, so g' = c . (w_K - w_F) with c = b x u.
void add_square_angle(const JointFrame& F, const JointFrame& K, const ScalarVector3& u,
                      const ScalarVector3& b, Eigen::Index row, JointRows& rows) {
  const ScalarVector3 c = b.cross(u), w_FK = K.w - F.w;
  const ScalarVector3 cd = K.w.cross(b).cross(u) + b.cross(F.w.cross(u));
  rows.g[row] = u.dot(b);
  rows.rate[row] = c.dot(w_FK);
  rows.bias[row] = cd.dot(w_FK) - c.dot(F.alpha_bias);
  rows.L_child.row(row) << ScalarVector3::Zero().transpose(), c.transpose();
  rows.L_parent.row(row) << ScalarVector3::Zero().transpose(), -c.transpose();
}

bool may_shift(const Joint& joint) {
  return joint.type == JointType::cylindrical || (joint.type == JointType::slider && !joint.imposed);
}

bool holds_axis(const Joint& joint) {
  return joint.type != JointType::ball && joint.type != JointType::universal;
}

bool may_turn_about_axis(const Joint& joint) {
  return joint.type == JointType::cylindrical || (joint.type == JointType::hinge && !joint.imposed);
}

}  // namespace

Eigen::Index num_rows(const Joint& joint) {
  const Eigen::Index distances = may_shift(joint) ? 2 : 3;
  if (joint.type == JointType::ball) return distances;
  if (joint.type == JointType::universal) return distances + 1;
  return distances + (may_turn_about_axis(joint) ? 2 : 3);
}

JointRows joint_rows(const Joint& joint, Scalar t, const BodyState& parent, const BodyState& child) {
  const ScalarMatrix3 axes_P = triad(joint.axis_P.cast<Scalar>());
  const ScalarMatrix3 axes_C = joint.q_PC.cast<Scalar>().normalized().conjugate() * axes_P;
  JointFrame F = attached(parent, joint.anchor_P.cast<Scalar>(), axes_P);
  const JointFrame K = attached(child, joint.anchor_C.cast<Scalar>(), axes_C);
  if (joint.imposed) impose(joint.type, joint.imposed->at(static_cast<double>(t)), parent, F);

  JointRows rows;
  const Eigen::Index count = num_rows(joint);
  for (JointRows::Column* column : {&rows.g, &rows.rate, &rows.bias}) column->resize(count);
  rows.L_parent.resize(count, 6);
  rows.L_child.resize(count, 6);
  Eigen::Index row = 0;
  for (int i = may_shift(joint) ? 1 : 0; i < 3; ++i) add_distance(F, K, F.axes.col(i), row++, rows);
  if (holds_axis(joint)) {
    for (int i = 1; i < 3; ++i) add_square_angle(F, K, F.axes.col(i), K.axes.col(0), row++, rows);
    rows.reversed = !(F.axes.col(0).dot(K.axes.col(0)) > 0);
    if (!may_turn_about_axis(joint)) {
      add_square_angle(F, K, F.axes.col(1), K.axes.col(2), row++, rows);
      rows.reversed = rows.reversed || !(F.axes.col(1).dot(K.axes.col(1)) > 0);
    }
  } else if (joint.type == JointType::universal) {
    const ScalarVector3 axis_C = child.q * joint.axis_C.cast<Scalar>().normalized();
    add_square_angle(F, K, F.axes.col(0), axis_C, row++, rows);
  }
  return rows;
}

}  // namespace godobject::oracle
