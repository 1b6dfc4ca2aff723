// Anchors of a contact on both of its bodies, and the stretch between them as a function of poses.
//
// A contact stores, in the axes of both bodies, the points c_a, c_b that met, the normal n and the stretch xi
// of the sticking spring (23). At any other poses the stored values are seen as c_a, c_b, a, b, xi_a, xi_b.
// With the normal n there the stretch is
//
//   (51)  xi = |xi| u / |u| + P (c_a - c_b) + rho (arc(a, n) - arc(b, n)) - (u_b x u_a) x w / (2 |xi|^2),
//         u = u_a + u_b,  u_a = Q(a, n) xi_a,  u_b = Q(b, n) xi_b
//
// P projects into the tangent plane, and Q(a, n) turns a into n the shortest way. So xi turns about the
// normal with the mean of both bodies. arc(a, n) is the arc on the unit sphere minus its chord in the tangent
// plane, and rho the radius that rolls. w is the chord on the round body, times rho. A sphere that also
// pivots, as in a valley, rolls along a curve: the last term turns w back by half the pivot, from u_b to u_a.
// Bodies that move as one, and spheres that roll on a plane, have no change of xi at any size of the motion.
// Spheres that roll and pivot by an angle of order h have a change of order h^3.
#pragma once

#include <cmath>
#include <limits>

#include "core/math/lanes.h"
#include "core/math/so3.h"
#include "core/tuning.h"

namespace godobject {

/// Attitudes and centres of mass of the two bodies of contacts. b: the touched body, or the world.
template <class T>
struct ContactPlacesOf {
  Matrix3<T> R_a = Matrix3<T>::Identity(), R_b = Matrix3<T>::Identity();
  Vector3<T> p_a = Vector3<T>::Zero(), p_b = Vector3<T>::Zero();
};

/// Anchors of one or four contacts, in the axes of body a or b, points from its centre of mass.
template <class T>
struct AnchorsOf {
  Vector3<T> c_a, c_b;    // points that met, m
  Vector3<T> n_a, n_b;    // normal off b; zero without a contact
  Vector3<T> xi_a, xi_b;  // stretch, m: of the point of a, against that of b
};

/// Returns the anchors of a contact that is now at c_W, with normal n_W and stretch xi_W. apart_W: way from
/// the anchor of b to that of a, m.
template <class T>
AnchorsOf<T> anchored(const ContactPlacesOf<T>& at, const Vector3<T>& c_W, const Vector3<T>& n_W,
                      const Vector3<T>& xi_W, const Vector3<T>& apart_W) noexcept {
  const Matrix3<T> to_a = at.R_a.transpose(), to_b = at.R_b.transpose();
  return {.c_a = to_a * (c_W + apart_W * T(0.5) - at.p_a),
          .c_b = to_b * (c_W - apart_W * T(0.5) - at.p_b),
          .n_a = to_a * n_W,
          .n_b = to_b * n_W,
          .xi_a = to_a * xi_W,
          .xi_b = to_b * xi_W};
}

/// Returns Q(a, n) u for u normal to a. a_n: cosine of the angle between a and n.
template <class T>
Vector3<T> turned(const Vector3<T>& u, const Vector3<T>& a, const Vector3<T>& n, const T& a_n) noexcept {
  return u - (a + n) * (u.dot(n) / (T(1) + max(a_n, T(0))));
}

/// Returns arc(a, n).
template <class T>
Vector3<T> arc_beyond_chord(const Vector3<T>& a, const Vector3<T>& n, const T& a_n) noexcept {
  const Vector3<T> chord = n * a_n - a;
  return chord * arc_per_sine_beyond_one(chord.squaredNorm());
}

/// Stretch of contacts at other places (51): turned with the bodies, and its change by their motion.
template <class T>
struct StretchOf {
  Vector3<T> before_W, change_W;  // m
};

/// Returns the stretch (51) at the places `at` with the normal n_W. Zero if a body has turned so far about an
/// axis in the tangent plane that no path of the contact point is known.
template <class T>
StretchOf<T> stretch(const AnchorsOf<T>& of, const ContactPlacesOf<T>& at, const Vector3<T>& n_W,
                     const T& rho) noexcept {
  using std::sqrt;
  const Vector3<T> a = at.R_a * of.n_a, b = at.R_b * of.n_b;
  const T a_n = a.dot(n_W), b_n = b.dot(n_W);
  const Vector3<T> u_a = turned<T>(at.R_a * of.xi_a, a, n_W, a_n),
                   u_b = turned<T>(at.R_b * of.xi_b, b, n_W, b_n), u = u_a + u_b;
  const T u_sq = max(u.squaredNorm(), T(std::numeric_limits<Real>::min()));
  const Vector3<T> apart = (at.p_a - at.p_b) + (at.R_a * of.c_a - at.R_b * of.c_b);
  const Vector3<T> way = (n_W * a_n - a) * max(rho, T(0)) + (n_W * b_n - b) * min(rho, T(0));
  const T xi_sq = max(T(of.xi_a.squaredNorm()), T(std::numeric_limits<Real>::min()));
  const Vector3<T> rolled = (arc_beyond_chord<T>(a, n_W, a_n) - arc_beyond_chord<T>(b, n_W, b_n)) * rho -
                            u_b.cross(u_a).cross(way) * (T(0.5) / xi_sq);
  const T known = select(T(same_contact) <= min(a_n, b_n), T(1), T(0));
  return {.before_W = u * (known * sqrt(of.xi_a.squaredNorm() / u_sq)),
          .change_W = (apart - n_W * n_W.dot(apart) + rolled) * known};
}

}  // namespace godobject
