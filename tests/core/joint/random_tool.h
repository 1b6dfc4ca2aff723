// Tools of random bodies on random joints of every kind, joined exactly.
#pragma once

#include "tests/core/one_body.h"
#include "tests/study/joint/tool.h"

namespace godobject {

/// How one joint stands and moves: coordinates about or along its axes, turns of a ball as a vector.
struct JointMove {
  Vec3 q = Vec3::Zero();
  Vec3 q_dot = Vec3::Zero();
};

/// Attitude R_PC, anchor shift and relative twist of the child, in axes P, at coordinates of the joint.
struct ChildInParent {
  Mat3 R = Mat3::Identity();
  Vec3 d = Vec3::Zero();
  Twist V;
};

inline ChildInParent child_in_parent(JointKind kind, const JointMove& m) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const auto turn = [](const Vec3& a) -> Mat3 { return exp_so3(a).toRotationMatrix(); };
  ChildInParent c;
  switch (kind) {
    case JointKind::free:
    case JointKind::fixed: break;
    case JointKind::ball:
      c.R = turn(m.q);
      c.V.w = m.q_dot;
      break;
    case JointKind::hinge:
      c.R = turn(m.q[0] * z);
      c.V.w = m.q_dot[0] * z;
      break;
    case JointKind::slider:
      c.d = m.q[0] * z;
      c.V.v = m.q_dot[0] * z;
      break;
    case JointKind::cylindrical:
      c = {.R = turn(m.q[0] * z), .d = m.q[1] * z, .V = {.w = m.q_dot[0] * z, .v = m.q_dot[1] * z}};
      break;
    case JointKind::universal:
      c.R = turn(m.q[0] * x) * turn(m.q[1] * y);
      c.V.w = m.q_dot[0] * x + turn(m.q[0] * x) * (m.q_dot[1] * y);
      break;
  }
  return c;
}

/// Returns the place of body i with its joint at m, for a placed parent.
template <Scene S>
Start joined(const Params<S>& par, const State<S>& x, std::size_t i, const JointMove& m) {
  const JointParams& joint = par.bodies[i].joint;
  const TreePlace P = place_of(par, x, joint.parent);
  const ChildInParent c = child_in_parent(joint.kind, m);
  const Mat3 R_WP = P.R_WB * joint.P.R;
  const Mat3 R_WB = R_WP * c.R * joint.C.R.transpose();
  const Vec3 anchor = P.p_W + P.R_WB * joint.P.p + R_WP * c.d;
  const Vec3 w = P.V.w + R_WP * c.V.w;
  const Vec3 v_anchor = P.V.v + P.V.w.cross(anchor - P.a_W) + R_WP * c.V.v;
  const Vec3 to_centre = -(R_WB * joint.C.p);
  const Eigen::Quaternion<Real> q(R_WB);
  return {.X_WB = {.p = anchor + to_centre, .q = Quat(q.w(), q.x(), q.y(), q.z())},
          .V_WB = {.w = w, .v = v_anchor + w.cross(to_centre)}};
}

inline JointFrame random_frame(Random& random, Real size) {
  return {.p = size * random.vector(), .R = random.rotation().toRotationMatrix()};
}

inline constexpr std::array joint_kinds{JointKind::fixed,  JointKind::ball,        JointKind::hinge,
                                        JointKind::slider, JointKind::cylindrical, JointKind::universal};

/// Adds a body and its joint to a random body before it. The root is a child of the world, or free one time
/// in four.
template <Scene S>
void add_random_body(Params<S>& par, std::size_t i, Real size, Random& random) {
  BodyParams<S>& body = par.bodies[i];
  const Real m = random.log_uniform(1e-2, 10);
  const Vec3 radii(random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1));
  const Vec3 r = size * radii;
  const Vec3 moments =
      0.2 * m *
      Vec3(r.y() * r.y() + r.z() * r.z(), r.z() * r.z() + r.x() * r.x(), r.x() * r.x() + r.y() * r.y());
  body.body = rigid_body(m, random.inertia(moments));
  body.device = {.rise = 0, .lost = 0.02};
  JointParams& joint = body.joint;
  joint.kind = joint_kinds[static_cast<std::size_t>(random.integer(0, 5))];
  joint.parent = i == 0 ? world : static_cast<std::size_t>(random.integer(0, static_cast<int>(i) - 1));
  if (i == 0 && random.integer(0, 3) == 0) joint.kind = JointKind::free;
  joint.P = random_frame(random, size);
  joint.C = random_frame(random, size);
}

/// Bodies at random coordinates of their joints with random rates: turns at `rate` rad/s, slides at
/// `rate * size` m/s.
template <Scene S>
void place_randomly(const Params<S>& par, State<S>& x, Real size, Real rate, Random& random) {
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    JointMove m{.q = random.vector(), .q_dot = rate * random.vector()};
    const JointKind kind = par.bodies[i].joint.kind;
    const int slide = kind == JointKind::slider ? 0 : kind == JointKind::cylindrical ? 1 : -1;
    if (slide >= 0) m.q[slide] *= size, m.q_dot[slide] *= size;
    m.q *= std::min(Real(1), pi / m.q.norm());
    Start start = joined(par, x, i, m);
    if (kind == JointKind::free)
      start = {.X_WB = {.p = size * random.vector(), .q = random.rotation()},
               .V_WB = {.w = rate * random.vector(), .v = rate * size * random.vector()}};
    place<S>(x, i, start);
  }
}

}  // namespace godobject
