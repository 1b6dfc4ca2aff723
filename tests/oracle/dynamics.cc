#include "tests/oracle/dynamics.h"

#include <cmath>

#include <Eigen/LU>

#include "tests/oracle/target.h"

namespace godobject::oracle {

namespace {

/// One body's part of the state vector.
struct BodyState {
  ScalarVector3 p;
  ScalarQuaternion q;
  ScalarVector3 v;
  ScalarVector3 w;
};

/// Force and torque in world axes about the body's origin.
struct Wrench {
  ScalarVector3 f = ScalarVector3::Zero();    // N
  ScalarVector3 tau = ScalarVector3::Zero();  // N m
};

Eigen::Index offset_of(std::size_t body) { return state_size * static_cast<Eigen::Index>(body); }

Eigen::Matrix<Scalar, 4, 1> wxyz(const ScalarQuaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

BodyState body_state(const ScalarVector& y, std::size_t body) {
  const Eigen::Matrix<Scalar, state_size, 1> x = y.segment<state_size>(offset_of(body));
  return {x.segment<3>(0), ScalarQuaternion(x[3], x[4], x[5], x[6]), x.segment<3>(7), x.segment<3>(10)};
}

/// (2): F = g_t e_t' + k_t e_t, T = g_r (W_target - W) + k_r alpha u.
Wrench coupling_wrench(const Coupling& c, Scalar t, const BodyState& x) {
  const RigidState D = c.target->at(static_cast<double>(t));
  const ScalarVector3 e_t = D.p.cast<Scalar>() - x.p;
  const ScalarVector3 alpha_u = rotation_vector(D.q.cast<Scalar>() * x.q.conjugate());
  return {c.g_t * (D.v.cast<Scalar>() - x.v) + c.k_t * e_t,
          c.g_r * (D.w.cast<Scalar>() - x.w) + c.k_r * alpha_u};
}

}  // namespace

ScalarVector pack(const std::vector<RigidState>& states) {
  ScalarVector y(offset_of(states.size()));
  for (std::size_t i = 0; i < states.size(); ++i) {
    const RigidState& x = states[i];
    y.segment<state_size>(offset_of(i)) << x.p.cast<Scalar>(), wxyz(x.q.cast<Scalar>()), x.v.cast<Scalar>(),
        x.w.cast<Scalar>();
  }
  normalise(y);
  return y;
}

std::vector<RigidState> unpack(const ScalarVector& y) {
  std::vector<RigidState> states(static_cast<std::size_t>(y.size() / state_size));
  for (std::size_t i = 0; i < states.size(); ++i) {
    const BodyState x = body_state(y, i);
    states[i] = {x.p.cast<double>(), x.q.normalized().cast<double>(), x.v.cast<double>(), x.w.cast<double>()};
  }
  return states;
}

void normalise(ScalarVector& y) {
  for (Eigen::Index q = 3; q < y.size(); q += state_size) y.segment<4>(q).normalize();
}

ScalarVector3 rotation_vector(const ScalarQuaternion& q) {
  const ScalarVector3 n = q.w() < 0 ? ScalarVector3(-q.vec()) : ScalarVector3(q.vec());  // u sin(alpha / 2)
  const Scalar c = std::abs(q.w());
  const Scalar s = n.norm();
  // alpha / sin(alpha / 2); the series leaves out s^4, below rounding at this bound.
  const Scalar scale = s < Scalar(1e-5) * c ? 2 / c * (1 - s * s / (3 * c * c)) : 2 * std::atan2(s, c) / s;
  return scale * n;
}

void Dynamics::operator()(Scalar t, const ScalarVector& y, ScalarVector& dy_dt) const {
  for (std::size_t i = 0; i < case_.bodies.size(); ++i) {
    const Body& body = case_.bodies[i];
    BodyState x = body_state(y, i);
    // q' = 1/2 W q is linear in q: its direction, the attitude, does not depend on the norm of the integrated
    // q.
    const Eigen::Matrix<Scalar, 4, 1> qd =
        wxyz(ScalarQuaternion(0, x.w.x() / 2, x.w.y() / 2, x.w.z() / 2) * x.q);
    x.q.normalize();

    // B of (4) and (6): gravity, coupling and, in body axes, the gyroscopic torque (I W) x W.
    Wrench B;
    B.f = body.m * case_.gravity.cast<Scalar>();
    if (body.coupling) {
      const Wrench pull = coupling_wrench(*body.coupling, t, x);
      B.f += pull.f;
      B.tau += pull.tau;
    }
    const ScalarMatrix3 R_WB = x.q.toRotationMatrix();
    const ScalarMatrix3 I_B = body.I_B.cast<Scalar>();
    const ScalarVector3 w_B = R_WB.transpose() * x.w;
    const ScalarVector3 tau_B = R_WB.transpose() * B.tau + (I_B * w_B).cross(w_B);

    // (7), tendency: A_t = M^-1 B. Without joints it is the acceleration.
    const ScalarVector3 a = B.f / body.m;
    const ScalarVector3 wd = R_WB * (I_B.inverse() * tau_B);
    dy_dt.segment<state_size>(offset_of(i)) << x.v, qd, a, wd;
  }
}

}  // namespace godobject::oracle
