// Rotations: exponential and logarithm on SO(3) by polynomials. No libm, no data-dependent branches, and
// identical bits from every compiler (docs/theory/so3.md).
#pragma once

#include <cmath>

#include "core/math/polynomial.h"
#include "core/tuning.h"

namespace godobject {

inline constexpr Real pi = 3.14159265358979323846;

/// Returns [a]x, so that [a]x b = a x b.
template <class T = Real>
Matrix3<T> skew(const Vector3<T>& a) noexcept {
  Matrix3<T> s;
  // clang-format off
  s << 0, -a.z(), a.y(),
       a.z(), 0, -a.x(),
      -a.y(), a.x(), 0;
  // clang-format on
  return s;
}

/// Returns r scaled so that q * r has unit length, for r of exactly unit length. Corrects the rounding of the
/// previous step off the critical path. Lengths stay within 1e-15 of 1 for any number of products.
template <class T = Real>
Quaternion<T> renormalizing(const Quaternion<T>& r, const Quaternion<T>& q) noexcept {
  const T s = Real(0.5) * (3 - q.coeffs().squaredNorm());
  Quaternion<T> scaled;
  scaled.coeffs() = s * r.coeffs();
  return scaled;
}

/// Returns q scaled to unit length by one Newton step of 1/sqrt; an error d of the length becomes 3/2 d^2.
template <class T = Real>
Quaternion<T> renormalized(const Quaternion<T>& q) noexcept {
  return renormalizing<T>(q, q);
}

// Coefficients of the polynomials below. At namespace scope, because clang counts a static local variable as
// one that may block (core/nonblocking.h).
// clang-format off
inline constexpr std::array<Real, 9> sinc_terms{
    1.0, -1.66666666666666657e-01, 8.33333333333318577e-03,
    -1.98412698412086760e-04, 2.75573192112296060e-06, -2.50521068905695199e-08,
    1.60589408784865599e-10, -7.64302655797163249e-13, 2.72157494229834434e-15};
inline constexpr std::array<Real, 10> cosine_terms{
    1.0, -0.5, 4.16666666666666574e-02,
    -1.38888888888885295e-03, 2.48015873014926406e-05, -2.75573192096544720e-07,
    2.08767556665789035e-09, -1.14706701653232714e-11, 4.77687224914480734e-14,
    -1.51198278342179951e-16};
inline constexpr std::array<Real, 22> log_factor_terms{
    2.0, 6.66666666666718144e-01, 2.66666666658868790e-01,
    1.14285714754220669e-01, 5.07936359054453890e-02, 2.30883124299150790e-02,
    1.06522602484840009e-02, 5.00711858010079430e-03, 2.10971634114808263e-03,
    2.27602238395325108e-03, -4.02379526149470538e-03, 1.40906026655062463e-02,
    -3.29667869218435092e-02, 6.25276835789015800e-02, -9.30524852639761368e-02,
    1.08882673966894675e-01, -9.88075670278243529e-02, 6.82303529571215012e-02,
    -3.46663497996787875e-02, 1.22456057377414856e-02, -2.69314503802673940e-03,
    2.79750027617877599e-04};
// clang-format on

/// Returns exp: the rotation by |a| <= pi about a. Relative error below 1e-15.
template <class T = Real>
Quaternion<T> exp_so3(const Vector3<T>& a) noexcept {
  // x = (|a|/2)^2 in [0, pi^2/4]:  q = (cos sqrt(x), a/2 sin sqrt(x) / sqrt(x))
  const T x = Real(0.25) * a.squaredNorm();
  const T s = Real(0.5) * polynomial<T>(sinc_terms, x);
  return {polynomial<T>(cosine_terms, x), s * a.x(), s * a.y(), s * a.z()};
}

/// Returns f(w) = alpha / sin(alpha/2) of a rotation by alpha with w = cos(alpha/2) in [-0.06, 1]:
/// log q = f(w) vec(q). Relative error below 1e-15. Two at zero angle.
template <class T = Real>
T log_factor(const std::type_identity_t<T>& w) noexcept {
  return polynomial<T>(log_factor_terms, 1 - w);
}

/// Returns R(q)^T a: a world vector in the axes of the body with attitude q.
template <class T = Real>
Vector3<T> to_body(const Quaternion<T>& q, const Vector3<T>& a) noexcept {
  const Vector3<T> u = q.vec();
  const Vector3<T> t = Real(2) * a.cross(u);
  return a + q.w() * t + t.cross(u);
}

/// Returns R(q) a: a body vector in world axes.
template <class T = Real>
Vector3<T> to_world(const Quaternion<T>& q, const Vector3<T>& a) noexcept {
  const Vector3<T> u = q.vec();
  const Vector3<T> t = Real(2) * u.cross(a);
  return a + q.w() * t + u.cross(t);
}

/// Returns the shortest rotation of z to an axis; half a turn about x for -z. Same bits as Eigen's
/// FromTwoVectors, which decomposes a matrix for opposite vectors and costs 10 s of each compilation.
inline Quat turn_from_z(const Vec3& axis) noexcept {
  // q = (c/2, z x u / c),  c = sqrt(2 (1 + z.u)) = 2 cos(alpha/2)
  const Vec3 u = axis.normalized();
  if (u.z() < rounding_share - 1) return {0, 1, 0, 0};
  const Real c = std::sqrt(2 * (1 + u.z())), inv_c = 1 / c;
  return {c / 2, -u.y() * inv_c, u.x() * inv_c, 0};
}

/// Returns asin(s) / s - 1 by its series. s_sq: s^2, of a turn well below a right angle.
template <class T>
T arc_per_sine_beyond_one(const T& s_sq) noexcept {
  T sum = T(231.0 / 13312);
  for (const Real next : {63.0 / 2816, 35.0 / 1152, 5.0 / 112, 3.0 / 40, 1.0 / 6}) sum = sum * s_sq + T(next);
  return sum * s_sq;
}

}  // namespace godobject
