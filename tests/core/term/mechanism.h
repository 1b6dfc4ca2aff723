// Mechanisms of bodies on joints with terms: links, loops, springs and gears, and drawn chains of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/core/contact/contact_scene.h"

namespace godobject {

/// Rod from p to q in world axes, its x axis along it.
inline Pose rod(const Vec3& p, const Vec3& q) {
  // FromTwoVectors is not of unit length for nearly opposite vectors
  return {.p = (p + q) / 2, .q = Quat::FromTwoVectors(Vec3::UnitX(), q - p).normalized()};
}
inline JointFrame frame_on(const Pose& X_WB, const Pose& X_WJ) {
  return {.p = to_body(X_WB.q, X_WJ.p - X_WB.p), .R = (X_WB.q.conjugate() * X_WJ.q).toRotationMatrix()};
}

/// Appends a body at X_WB on a joint to the parent, with both frames at X_WJ.
template <class S>
std::uint32_t add_link(Running<S>& run, Real m, const Mat3& I_B, const Pose& X_WB, JointKind kind,
                       std::size_t parent, const Pose& X_WJ) {
  const std::size_t i = run.par.num_bodies++;
  run.par.bodies[i].body = rigid_body(m, I_B);
  place(run.x, i, {.X_WB = X_WB, .V_WB = {}});
  auto& joint = run.par.bodies[i].joint;
  joint.kind = kind;
  joint.parent = parent;
  joint.P = frame_on(parent == world ? Pose{} : run.x.bodies[parent].x.X_WB, X_WJ);
  joint.C = frame_on(X_WB, X_WJ);
  return static_cast<std::uint32_t>(i);
}
/// Closes a loop by a joint with both frames at X_WJ. list: of loop joints among the terms of the scene.
template <std::size_t list = 0, class S>
void close_loop(Running<S>& run, JointKind kind, std::uint32_t a, std::uint32_t b, const Pose& X_WJ) {
  auto& loops = run.par.terms.template of<list>();
  const Pose X_WA = a == TermEnds::on_world ? Pose{} : run.x.bodies[a].x.X_WB;
  loops.list[loops.size++] = {
      .kind = kind, .a = a, .b = b, .P = frame_on(X_WA, X_WJ), .C = frame_on(run.x.bodies[b].x.X_WB, X_WJ)};
}

/// Appends a body on a joint about or along the z axes of the frames at X_W, at rest at coordinate q.
template <class S>
void add_body(Running<S>& run, Real m, const Mat3& I_B, JointKind kind, std::size_t parent, const Pose& X_WJ,
              Real q = 0) {
  const std::size_t i = run.par.num_bodies++;
  run.par.bodies[i].body = rigid_body(m, I_B);
  auto& joint = run.par.bodies[i].joint;
  joint.kind = kind;
  joint.parent = parent;
  const Pose X_WP = parent == world ? Pose{} : run.x.bodies[parent].x.X_WB;
  joint.P = {.p = to_body(X_WP.q, X_WJ.p - X_WP.p), .R = (X_WP.q.conjugate() * X_WJ.q).toRotationMatrix()};
  Pose X_WB = X_WJ;
  if (kind == JointKind::slider) X_WB.p += q * to_world(X_WJ.q, Vec3::UnitZ());
  else X_WB.q = X_WJ.q * exp_so3(Vec3(0, 0, q));
  place(run.x, i, {.X_WB = X_WB, .V_WB = {}});
}

/// list: of springs among the terms of the scene.
template <std::size_t list = 0, class S>
CoordinateSpringParams& add_spring(Running<S>& run, const CoordinateSpringParams& spring) {
  auto& springs = run.par.terms.template of<list>();
  springs.list[springs.size] = spring;
  return springs.list[springs.size++];
}
inline CoordinateSpringParams gear(std::uint32_t a, std::uint32_t b, Real ratio, Real offset = 0) {
  return {.of = {{{.body = a, .c = 0, .ratio = -ratio}, {.body = b, .c = 0, .ratio = 1}}},
          .size = 2,
          .y_0 = offset,
          .is_rigid = true};
}
inline CoordinateSpringParams joint_spring(std::uint32_t i, Real k, Real g, Real q_0 = 0) {
  return {.of = {{{.body = i}, {}}}, .size = 1, .y_0 = q_0, .k = k, .g = g};
}

/// Draws a chain of six bodies on hinges and sliders, with springs on its coordinates, one rigid and one
/// elastic gear.
template <std::size_t list = 0, class S>
void draw_gears(Running<S>& run, Random& random) {
  run.par.num_bodies = 0;
  run.par.gravity_W = 9.81 * random.direction();
  Pose X;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const Real m = random.log_uniform(1e-3, 1), size = random.log_uniform(0.01, 0.1);
    const Vec3 moments = m * size * size * Vec3(0.3, 0.4, random.uniform(0.2, 0.6));
    const JointKind kind = random.integer(0, 2) == 0 ? JointKind::slider : JointKind::hinge;
    const std::size_t parent = i == 0 || random.integer(0, 3) == 0 ? world : i - 1;
    X = {.p = X.p + 0.05 * random.vector(), .q = random.rotation()};
    add_body(run, m, random.inertia(moments), kind, parent, X);
    run.x.bodies[i].x.X_WB.p = X.p;
  }
  for (std::uint32_t i = 0; i < 6; ++i)
    add_spring<list>(run, joint_spring(i, random.log_uniform(1e-3, 1e4), random.integer(0, 1) * 1e-3));
  for (int n = 0; n < 2; ++n) {
    const auto a = static_cast<std::uint32_t>(random.integer(0, 5)),
               b = (a + 1 + 2 * static_cast<std::uint32_t>(n)) % 6;
    CoordinateSpringParams& one = add_spring<list>(run, gear(a, b, random.uniform(-3, 3)));
    one.is_rigid = n == 0;
    one.k = random.log_uniform(1, 1e6);
  }
}

/// Scene type of mechanisms with loops.
template <class I, std::size_t N = 6, std::size_t num_loops = 4>
struct Looped {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = None;
  using Joints = TreeJoints<JointStops>;
  using Coupling = None;
  using Feedback = None;
  using Contacts = BodyContacts<4, 2, 16>;
  using Terms = TermList<LoopJoints<num_loops>, DampedSprings<4>>;
};
template <class I>
using Mechanism = Running<Looped<I>>;

/// Violation of all loops, m.
template <class S>
Real apart(Running<S>& run) {
  Real most = 0;
  const auto& loops = run.par.terms.template of<0>();
  for (std::size_t t = 0; t < loops.size; ++t) {
    const LoopJointParams& loop = loops.list[t];
    const TermPlaces<S> at{run.x};
    most = std::max(most, (at.point(loop.b, loop.C.p) - at.point(loop.a, loop.P.p)).norm());
  }
  return most;
}

/// Returns the coordinate at time t of a mechanism of one coordinate, M q'' = -M' q'^2 / 2 - V', by Runge and
/// Kutta. M, V: inertia and potential at a coordinate. q, v: coordinate and rate at t = 0.
template <class Inertia, class Potential>
Real coordinate_at(Real t, const Inertia& M, const Potential& V, Real q, Real v = 0) {
  const auto a = [&](Real at, Real rate) {
    const Real e = 1e-4;
    const Real dM = (M(at + e) - M(at - e)) / (2 * e), dV = (V(at + e) - V(at - e)) / (2 * e);
    return (-dM * rate * rate / 2 - dV) / M(at);
  };
  constexpr int steps = 8000;
  const Real h = t / steps;
  for (int n = 0; n < steps; ++n) {
    const Real k1 = v, l1 = a(q, v);
    const Real k2 = v + h / 2 * l1, l2 = a(q + h / 2 * k1, k2);
    const Real k3 = v + h / 2 * l2, l3 = a(q + h / 2 * k2, k3);
    const Real k4 = v + h * l3, l4 = a(q + h * k3, k4);
    q += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    v += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
  }
  return q;
}

}  // namespace godobject
