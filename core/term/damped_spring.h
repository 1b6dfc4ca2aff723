// Term: springs with dampers between points of bodies, nodes or the world.
#pragma once

#include "core/joint/tree.h"
#include "core/math/spatial.h"
#include "core/term/term.h"

namespace godobject {

/// Point on a body, on a node (p is zero then), or of the world.
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

/// Spring in a stage (37): the impulse J - K x' on b, with x' at the end of the stage. K = h (h K_s + G),
/// stiffness and damping at the predicted end. The negative part of the stiffness, k (1 - l_0 / l) across a
/// spring shorter than l_0, is left out.
struct SpringStage {
  std::uint32_t a = TermEnds::on_world, b = 0;
  Column r_a, r_b;  // levers from the centres of mass, world axes
  Column F_0;       // force on b at the start of the stage
  Column J;
  Block K;
};

/// Kind of term with a capacity for springs.
template <std::size_t max_>
struct DampedSprings {
  static constexpr std::size_t max = max_, max_ends = 2;
  static constexpr bool on_coordinates = false, is_joint = false;
  using Param = DampedSpringParams;
  using Stage = SpringStage;

  static TermEnds ends(const Stage& w) noexcept {
    TermEnds ends;
    if (is_between(w)) ends.add(w.a);
    ends.add(w.b);
    return ends;
  }

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
    w = {.a = par.a.on,
         .b = par.b.on,
         .r_a = Column(r_a),
         .r_b = Column(r_b),
         .F_0 = Column(F_0),
         .J = Column(Vec3(h * (F + h * K_s * (v_b - v_a)))),
         .K = {{Column(Vec3(K.col(0))), Column(Vec3(K.col(1))), Column(Vec3(K.col(2)))}}};
  }

  /// Calls f(u, r, force at r on u at the start of the stage).
  template <class F>
  static void each_force(const Stage& w, F f) noexcept {
    f(w.b, w.r_b, w.F_0);
    if (is_between(w)) f(w.a, w.r_a, -w.F_0);
  }

  /// Makes the velocities of the term relative to V.
  template <class Twists>
  static void shift(const Twists& V, Stage& w) noexcept {
    w.J -= w.K * extension_rate(V, w);
  }

  template <class System>
  static void load(const Stage& w, const TermEntries& entries, System& system) noexcept {
    const SymmetricSpatialMatrix at_end{.ww = Block::zero(), .wv = Block::zero(), .vv = w.K};
    const auto add = [&](std::uint32_t u, const Column& r, const Column& J) noexcept {
      SymmetricSpatialMatrix A{.ww = Block::zero(), .wv = Block::zero(), .vv = Block::zero()};
      add_to_parent(at_end, r, A);
      system.add(u, A);
      system.add_impulse(u, moved_wrench({.w = Column(Pack(0)), .v = J}, r));
    };
    add(w.b, w.r_b, w.J);
    if (!is_between(w)) return;
    add(w.a, w.r_a, -w.J);
    system.add_coupling(entries[0], shifted(coupling(at_end, w.r_a), w.r_b));
  }

  /// Calls f(u, impulse on u about its centre of mass) at the twists V.
  template <class Twists, class F>
  static void each_impulse(const Twists& V, const Stage& w, F f) noexcept {
    const SpatialVector J = force(V, w);
    f(w.b, moved_wrench(J, w.r_b));
    if (is_between(w)) f(w.a, moved_wrench(J * Real(-1), w.r_a));
  }
  /// Returns the impulse on b at its point.
  template <class Twists>
  static SpatialVector force(const Twists& V, const Stage& w) noexcept {
    return {.w = Column(Pack(0)), .v = w.J - w.K * extension_rate(V, w)};
  }

  /// Returns the energy, J. at.point(u, p): position of the point p of u, m.
  template <class At>
  static Real energy(const Param& par, const At& at) noexcept {
    const Real stretch = (at.point(par.b.on, par.b.p) - at.point(par.a.on, par.a.p)).norm() - par.l_0;
    return Real(0.5) * par.k * stretch * stretch;
  }

 private:
  static bool is_between(const Stage& w) noexcept { return w.a != TermEnds::on_world; }
  template <class Places>
  static Vec3 point(const SpringEnd& end, const Places& at, Vec3& r, Vec3& v) noexcept {
    r = v = Vec3::Zero();
    if (end.on == TermEnds::on_world) return end.p;
    const TreePlace& place = at[end.on];
    r = place.R_WB * end.p;
    v = place.V.v + place.V.w.cross(place.p_W + r - place.a_W);
    return place.p_W + r;
  }
  /// Returns x' at the twists V.
  template <class Twists>
  static Column extension_rate(const Twists& V, const Stage& w) noexcept {
    const Column v_b = shifted(V[w.b], w.r_b).v;
    return is_between(w) ? v_b - shifted(V[w.a], w.r_a).v : v_b;
  }
};

}  // namespace godobject
