// Mechanisms whose joints close loops, of any number of bodies.
#pragma once

#include <array>
#include <cmath>
#include <memory>

#include "tests/core/contact/contact_scene.h"

namespace godobject {

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

/// Rod from p to q in world axes, its x axis along it.
inline Pose rod(const Vec3& p, const Vec3& q) {
  return {.p = (p + q) / 2, .q = Quat::FromTwoVectors(Vec3::UnitX(), q - p)};
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
template <class S>
void close(Running<S>& run, JointKind kind, std::uint32_t a, std::uint32_t b, const Pose& X_WJ) {
  auto& loops = run.par.terms.template of<0>();
  const Pose X_WA = a == TermEnds::on_world ? Pose{} : run.x.bodies[a].x.X_WB;
  loops.list[loops.size++] = {
      .kind = kind, .a = a, .b = b, .P = frame_on(X_WA, X_WJ), .C = frame_on(run.x.bodies[b].x.X_WB, X_WJ)};
}

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
