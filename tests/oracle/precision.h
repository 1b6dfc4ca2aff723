// Number types inside the integrator. Inputs and outputs are double.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace godobject::oracle {

/// 64-bit mantissa on x86. A body that tumbles about its intermediate axis amplifies rounding errors a
/// million times within the 4 s of the reference case. With double they end near 1e-9 (measured), with this
/// below 1e-12.
using Scalar = long double;

using ScalarVector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
using ScalarMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
using ScalarVector3 = Eigen::Matrix<Scalar, 3, 1>;
using ScalarMatrix3 = Eigen::Matrix<Scalar, 3, 3>;
using ScalarQuaternion = Eigen::Quaternion<Scalar>;

}  // namespace godobject::oracle
