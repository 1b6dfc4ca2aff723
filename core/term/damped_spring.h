// Term: springs with dampers between points of bodies or the world.
#pragma once

#include "core/joint/tree.h"
#include "core/math/spatial.h"
#include "core/term/pair.h"

namespace godobject {

/// Point on a body or of the world.
struct SpringEnd {
  std::uint32_t on = TermEnds::on_world;
  Vec3 p = Vec3::Zero();  // place from the centre of mass in body axes, or in the world, m
};

/// Parameters of a spring. With the ends x apart, l = |x|, u = x / l, the force on b, opposite to that on a,
/// is
///
///   (36)  F = -k (l - l_0) u - g (u . x') u;   of no rest length, -k x - g x'
struct DampedSpringParams {
  SpringEnd a, b;  // a may be a point of the world
  Real k = 0;      // N/m
  Real g = 0;      // N s/m
  Real l_0 = 0;    // rest length, m
};

template <class Scene>
bool is_valid(const DampedSpringParams& par, const Scene& scene) noexcept {
  const auto is_number = [](Real x) noexcept { return x >= 0 && x - x == 0; };
  const Real p = par.a.p.sum() + par.b.p.sum();
  return (par.a.on == TermEnds::on_world || scene.exists(par.a.on)) && scene.exists(par.b.on) &&
         par.a.on != par.b.on && p - p == 0 && is_number(par.k) && is_number(par.g) && is_number(par.l_0);
}

/// Kind of term with a capacity for springs. In a stage (37) K = h (h K_s + G), stiffness and damping at the
/// predicted end. The negative part of the stiffness, k (1 - l_0 / l) across a spring shorter than l_0, is
/// left out.
template <std::size_t max_>
struct DampedSprings : PairTerm {
  static constexpr std::size_t max = max_;
  using Param = DampedSpringParams;

  /// Linearises a spring.
  template <class OfStage>
  static void begin(const Param& par, const OfStage& stage, const Wrench&, Stage& w) noexcept {
    const Real h = stage.h;
    Vec3 r_a, r_b, v_a, v_b;
    const Vec3 p_a = point(par.a, stage.at, r_a, v_a), p_b = point(par.b, stage.at, r_b, v_b);
    const Vec3 x = p_b - p_a;
    const Vec3 x_0 = x - h * (v_b - v_a);
    Mat3 K_s = par.k * Mat3::Identity(), G = par.g * Mat3::Identity();
    Vec3 F = -par.k * x, F_0 = -par.k * x_0;
    if (par.l_0 > 0) {
      const Real l = x.norm();
      const Vec3 u = l > 0 ? Vec3(x / l) : Vec3(Vec3::UnitZ());
      const Mat3 along = u * u.transpose();
      const Real across = l > par.l_0 ? 1 - par.l_0 / l : 0;
      K_s = par.k * (across * (Mat3::Identity() - along) + along);
      G = par.g * along;
      F = -par.k * (l - par.l_0) * u;
      const Real start = x_0.norm();
      F_0 *= start > 0 ? 1 - par.l_0 / start : 0;  // without length there is no direction
    }
    const Mat3 K = h * (h * K_s + G);
    w = {.a = par.a.on, .b = par.b.on, .r_a = Column(r_a), .r_b = Column(r_b), .F_0 = Column(F_0)};
    w.K.vv = block_of(K);
    w.J.v = Column(Vec3(h * (F + h * K_s * (v_b - v_a))));
  }

  /// Returns the energy, J. at.point(u, p): position of the point p of u, m.
  template <class At>
  static Real energy(const Param& par, const At& at) noexcept {
    const Real stretch = (at.point(par.b.on, par.b.p) - at.point(par.a.on, par.a.p)).norm() - par.l_0;
    return Real(0.5) * par.k * stretch * stretch;
  }

 private:
  template <class Places>
  static Vec3 point(const SpringEnd& end, const Places& at, Vec3& r, Vec3& v) noexcept {
    r = v = Vec3::Zero();
    if (end.on == TermEnds::on_world) return end.p;
    const TreePlace& place = at[end.on];
    r = place.R_WB * end.p;
    v = place.V.v + place.V.w.cross(place.p_W + r - place.a_W);
    return place.p_W + r;
  }
};

}  // namespace godobject
