// Bricks on joints that touch each other: chains, and a gripper.
#pragma once

#include "core/compiled_step.h"
#include "tests/core/contact/bodies/bricks.h"
#include "tests/core/joint/random_tool.h"

namespace godobject {

using AllJoints = TreeJoints<JointStops, PrescribedJoints>;
template <class I>
struct Jointed {
  static constexpr std::size_t max_bodies = 8;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = AllJoints;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = BodyContacts<96, 10, 288>;
};
static_assert(Scene<Jointed<ImplicitEuler>> && Scene<Jointed<TrBdf2>>);
extern GODOBJECT_STEP_OF(Jointed<ImplicitEuler>);
extern GODOBJECT_STEP_OF(Jointed<TrBdf2>);

inline const Vec3 y_axis = Vec3::UnitY(), z_axis = Vec3::UnitZ();

/// A frame whose z is this axis of its body.
inline JointFrame frame(const Vec3& p, const Vec3& axis = z_axis) {
  return {.p = p, .R = turn_from_z(axis).toRotationMatrix()};
}

template <class I>
class JointedPileOf : public Pile<Jointed<I>> {
 public:
  using Pile<Jointed<I>>::par, Pile<Jointed<I>>::x, Pile<Jointed<I>>::out;
  using Pile<Jointed<I>>::at, Pile<Jointed<I>>::p, Pile<Jointed<I>>::add_brick;

  /// Hangs body i on another, where that one is.
  void join(std::size_t i, JointKind kind, std::size_t parent, const JointFrame& P, const JointFrame& C,
            const JointMove& m = {}) {
    auto& joint = par.bodies[i].joint;
    joint.kind = kind;
    joint.parent = parent;
    joint.P = P;
    joint.C = C;
    place(x, i, joined(par, x, i, m));
  }
  /// `links` bricks, each hinged about y to the end of the one before along x; the first is at `start`.
  void add_chain(std::size_t links, const Start& start, JointKind kind = JointKind::hinge) {
    const Vec3 end(brick_half.x() + 0.001, 0, 0);
    for (std::size_t k = 0; k < links; ++k) {
      const std::size_t i = add_brick(start);
      if (k > 0) join(i, kind, i - 1, frame(end, y_axis), frame(-end, y_axis));
    }
  }
  /// Returns the sum of weight, coupling, contact and joint wrenches of a body, about its centre of mass.
  Wrench unbalanced(std::size_t i) const {
    Wrench F = coupling_at(par, x, i).F_WB;
    F.f += par.bodies[i].body.m * par.gravity_W + out.bodies[i].contact.F_W.f;
    F.tau += out.bodies[i].contact.F_W.tau;
    for (std::size_t c = i; c < par.num_bodies; ++c) {
      const auto& joint = par.bodies[c].joint;
      if (joint.kind == JointKind::free || (c != i && joint.parent != i)) continue;
      const Real sign = c == i ? 1 : -1;
      const Wrench& F_C = out.bodies[c].joint.F_C;
      const Vec3 r = at(c).X_WB.p + at(c).X_WB.q * joint.C.p - p(i);
      F.f += sign * F_C.f;
      F.tau += sign * (F_C.tau + r.cross(F_C.f));
    }
    return F;
  }
  Vec3 momentum() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < par.num_bodies; ++i) sum += par.bodies[i].body.m * at(i).v_W;
    return sum;
  }
  Drift joints_apart() const { return drift(par, x); }
};
using JointedPile = JointedPileOf<ImplicitEuler>;

/// Two plates hinged to a body that the device holds, turned against a brick between them by their couplings.
template <class I>
class GripperOf : public JointedPileOf<I> {
 public:
  using Base = JointedPileOf<I>;
  using Base::par, Base::add_brick, Base::hold_at, Base::join, Base::p;
  static constexpr Real height = 0.2;
  static constexpr std::size_t palm = 0, brick = 3;

  GripperOf() {
    par.gravity_W = Vec3(0, 0, -earth_gravity);
    add_brick({.X_WB = at(Vec3(0, 0, height)), .V_WB = {}}, 0.05, Vec3(0.03, 0.01, 0.005));
    hold_at(palm, Base::at(palm).X_WB, spring(par.bodies[palm].body, 2000, 1));
    for (const Real side : {-1.0, 1.0}) {
      const std::size_t jaw = add_brick({}, 0.01, Vec3(0.003, 0.008, 0.02));
      join(jaw, JointKind::hinge, palm, frame(Vec3(0.019 * side, 0, -0.02), y_axis),
           frame(Vec3(0, 0, 0.018), y_axis));
      hold_at(jaw, at(p(jaw), Vec3(0, 0.15 * side, 0)), {.k = 0, .g = 0, .k_r = 0.1, .g_r = 1e-3});
    }
    add_brick({.X_WB = at(Vec3(0, 0, height - 0.05)), .V_WB = {}});
  }
  using Base::at;
  static Pose at(const Vec3& p, const Vec3& turn = Vec3::Zero()) { return godobject::at(p, turn); }
};
using Gripper = GripperOf<ImplicitEuler>;

}  // namespace godobject
