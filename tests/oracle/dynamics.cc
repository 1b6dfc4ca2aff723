#include "tests/oracle/dynamics.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "tests/oracle/joint/system.h"
#include "tests/oracle/target.h"

namespace godobject::oracle {

namespace {

/// Force and torque in world axes about the body's origin.
struct Wrench {
  ScalarVector3 f = ScalarVector3::Zero();    // N
  ScalarVector3 tau = ScalarVector3::Zero();  // N m
};

/// (2): F = g_t e_t' + k_t e_t, T = g_r (W_target - W) + k_r alpha u.
Wrench coupling_wrench(const Coupling& c, Scalar t, const BodyState& x) {
  const RigidState D = c.target->at(static_cast<double>(t));
  const ScalarVector3 e_t = D.p.cast<Scalar>() - x.p;
  const ScalarVector3 alpha_u = rotation_vector(D.q.cast<Scalar>() * x.q.conjugate());
  return {c.g_t * (D.v.cast<Scalar>() - x.v) + c.k_t * e_t,
          c.g_r * (D.w.cast<Scalar>() - x.w) + c.k_r * alpha_u};
}

/// A point on a body, or of the world.
struct Point {
  ScalarVector3 r = ScalarVector3::Zero();  // from the body's origin, world axes
  ScalarVector3 p, v = ScalarVector3::Zero();

  Point(const BodyState& x, const Vector3d& p_B)
      : r(x.q * p_B.cast<Scalar>()), p(x.p + r), v(x.v + x.w.cross(r)) {}
  explicit Point(const Vector3d& p_W) : p(p_W.cast<Scalar>()) {}

  /// Returns the point of the same body x that coincides with `other`.
  Point at(const BodyState& x, const Point& other) const {
    Point there = *this;
    there.p = other.p;
    there.r = other.p - x.p;
    there.v = x.v + x.w.cross(there.r);
    return there;
  }
};

void add_force(const Point& at, const ScalarVector3& f, Wrench& B) {
  B.f += f;
  B.tau += at.r.cross(f);
}

/// (36), on b.
ScalarVector3 spring_force(const Spring& spring, const Point& a, const Point& b) {
  const ScalarVector3 x = b.p - a.p, v = b.v - a.v;
  if (spring.l_0 == 0) return -spring.k * x - spring.g * v;
  const Scalar l = x.norm();
  const ScalarVector3 u = x / l;
  return -(spring.k * (l - spring.l_0) + spring.g * u.dot(v)) * u;
}

/// Returns the lowest point of a sphere from the body's origin, world axes, m.
ScalarVector3 lowest_point(const FloorSphere& sphere, const BodyState& body) {
  return body.q * sphere.p_B.cast<Scalar>() - sphere.radius * ScalarVector3::UnitZ();
}

/// Returns the wrenches on the bodies, without joints and gyroscopic torques.
std::vector<Wrench> wrenches_on(const Case& problem, Scalar t, const std::vector<BodyState>& x) {
  std::vector<Wrench> B(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Body& body = problem.bodies[i];
    if (body.coupling) B[i] = coupling_wrench(*body.coupling, t, x[i]);
    B[i].f += body.m * problem.gravity.cast<Scalar>();
  }
  for (const Spring& spring : problem.springs) {
    const Point a = spring.a ? Point(x[*spring.a], spring.p_A) : Point(spring.p_A);
    const Point b(x[spring.b], spring.p_B);
    if (spring.is_anchor && spring.a) {
      const Point there = a.at(x[*spring.a], b);
      const ScalarVector3 f = -spring.k * (b.p - a.p) - spring.g * (b.v - there.v);
      add_force(b, f, B[spring.b]);
      add_force(there, -f, B[*spring.a]);
      continue;
    }
    const ScalarVector3 f = spring_force(spring, a, b);
    add_force(b, f, B[spring.b]);
    if (spring.a) add_force(a, -f, B[*spring.a]);
  }
  for (const FloorSphere& sphere : problem.on_floor) {
    const ScalarVector3 f = floor_force(sphere, x[sphere.body]) * ScalarVector3::UnitZ();
    B[sphere.body].f += f;
    B[sphere.body].tau += lowest_point(sphere, x[sphere.body]).cross(f);
  }
  return B;
}

}  // namespace

Scalar floor_force(const FloorSphere& sphere, const BodyState& body) {
  const ScalarVector3 r = lowest_point(sphere, body);
  const Scalar d = -(body.p + r).z(), v_z = (body.v + body.w.cross(r)).z();
  return d > 0 ? std::max(Scalar(0), sphere.k * d - sphere.c * v_z) : Scalar(0);
}

ScalarVector3 rotation_vector(const ScalarQuaternion& q) {
  const ScalarVector3 n = q.w() < 0 ? ScalarVector3(-q.vec()) : ScalarVector3(q.vec());  // u sin(alpha / 2)
  const Scalar c = std::abs(q.w());
  const Scalar s = n.norm();
  // alpha / sin(alpha / 2); the series leaves out s^4, below rounding at this bound.
  const Scalar scale = s < Scalar(1e-5) * c ? 2 / c * (1 - s * s / (3 * c * c)) : 2 * std::atan2(s, c) / s;
  return scale * n;
}

/// (7), tendency: A_t = M^-1 B, per body a and w'. Without joints it is the acceleration.
ScalarVector Dynamics::tendency(Scalar t, const std::vector<BodyState>& x) const {
  ScalarVector A_t(6 * x.size());
  const std::vector<Wrench> wrenches = wrenches_on(case_, t, x);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Body& body = case_.bodies[i];
    // B of (4) and (6): applied wrench and, in body axes, the gyroscopic torque (I W) x W.
    const Wrench& B = wrenches[i];
    const ScalarMatrix3 R_WB = x[i].q.toRotationMatrix();
    const ScalarMatrix3 I_B = body.I_B.cast<Scalar>();
    const ScalarVector3 w_B = R_WB.transpose() * x[i].w;
    const ScalarVector3 tau_B = R_WB.transpose() * B.tau + (I_B * w_B).cross(w_B);
    A_t.segment<6>(6 * static_cast<Eigen::Index>(i)) << B.f / body.m, R_WB * (I_B.inverse() * tau_B);
  }
  return A_t;
}

void Dynamics::operator()(Scalar t, const ScalarVector& y, ScalarVector& dy_dt) const {
  std::vector<BodyState> x = body_states(y);
  for (std::size_t i = 0; i < x.size(); ++i) {
    // q' = 1/2 W q is linear in q: its direction, the attitude, does not depend on the norm of the integrated
    // q.
    const ScalarQuaternion half_w(0, x[i].w.x() / 2, x[i].w.y() / 2, x[i].w.z() / 2);
    dy_dt.segment<7>(offset_of(i)) << x[i].v, wxyz(half_w * x[i].q);
    x[i].q.normalize();
  }
  ScalarVector A = tendency(t, x);
  if (!case_.joints.empty()) {
    const JointSystem joints(case_, t, x);
    A += joints.correction(joints.multipliers(A));
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    dy_dt.segment<6>(offset_of(i) + 7) = A.segment<6>(6 * static_cast<Eigen::Index>(i));
  }
}

double Dynamics::project(Scalar t, ScalarVector& y) const {
  if (case_.joints.empty()) return 0;
  normalise(y);
  std::vector<BodyState> x = body_states(y);
  const Scalar error = JointSystem(case_, t, x).error().cwiseAbs().maxCoeff();
  for (int iteration = 0; iteration < 2; ++iteration) {
    const JointSystem joints(case_, t, x);
    const ScalarVector dx = joints.displacement(-joints.error());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Eigen::Matrix<Scalar, 6, 1> d = dx.segment<6>(6 * static_cast<Eigen::Index>(i));
      x[i].p += d.head<3>();
      x[i].q = (ScalarQuaternion(1, d[3] / 2, d[4] / 2, d[5] / 2) * x[i].q).normalized();
    }
  }
  const JointSystem joints(case_, t, x);
  const ScalarVector dV = joints.displacement(-joints.rate());
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i].v += dV.segment<3>(6 * static_cast<Eigen::Index>(i));
    x[i].w += dV.segment<3>(6 * static_cast<Eigen::Index>(i) + 3);
  }
  y = pack(x);
  return static_cast<double>(error);
}

std::vector<JointWrench> Dynamics::reactions(Scalar t, const ScalarVector& y) const {
  if (case_.joints.empty()) return {};
  std::vector<BodyState> x = body_states(y);
  for (BodyState& body : x) body.q.normalize();
  const JointSystem joints(case_, t, x);
  return joints.wrenches(joints.multipliers(tendency(t, x)));
}

}  // namespace godobject::oracle
