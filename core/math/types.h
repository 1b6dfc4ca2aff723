// Scalars, vectors, poses, twists and wrenches. SI units. Frames are letters: W world, B body (origin =
// centre of mass), D device target.
//
// Operations applied to every body alike are templates of a number type T: Real, or a Pack of several bodies'
// numbers (core/math/simd4.h). Names without a T are those of Real, the default T.
//
// Independent of bodies, devices and contacts.
#pragma once

#include <type_traits>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace godobject {

#ifdef GODOBJECT_REAL  // float, for processors without double precision
using Real = GODOBJECT_REAL;
#else
using Real = double;
#endif

// T is not deduced from these, so that expressions convert to them.
template <class T>
using Vector3 = std::type_identity_t<Eigen::Matrix<T, 3, 1>>;
template <class T>
using Matrix3 = std::type_identity_t<Eigen::Matrix<T, 3, 3>>;
template <class T>
using Quaternion = std::type_identity_t<Eigen::Quaternion<T, Eigen::DontAlign>>;

using Vec3 = Vector3<Real>;
using Mat3 = Matrix3<Real>;
using Quat = Quaternion<Real>;  // unit, (w, x, y, z) in every file and trace

/// Pose X_WB: position (m) and attitude of frame B in frame W; p_W = p + q * p_B.
template <class T>
struct PoseOf {
  Vector3<T> p = Vector3<T>::Zero();
  Quaternion<T> q = Quaternion<T>::Identity();
};
using Pose = PoseOf<Real>;

/// Twist V_WB in world axes, angular part first: w (rad/s), v (m/s) of the origin of B.
template <class T>
struct TwistOf {
  Vector3<T> w = Vector3<T>::Zero();
  Vector3<T> v = Vector3<T>::Zero();
};
using Twist = TwistOf<Real>;

/// Wrench F in world axes about the origin of the body that it acts on: torque tau (N m), force f (N).
struct Wrench {
  Vec3 tau = Vec3::Zero();
  Vec3 f = Vec3::Zero();
};

}  // namespace godobject
