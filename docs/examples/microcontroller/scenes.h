// Three scenes without files: the rigid tool S1 (sim/scenes/s1.toml), and the reference cases `grasper` and
// `press` (sim/scenes/reference). Motions of the targets are in closed form.
#pragma once

#include "core/godobject.h"

namespace scenes {

using namespace godobject;

/// A tool that follows a pose, without force feedback.
struct Follower {
  static constexpr std::size_t max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = None;
};
static_assert(Scene<Follower>);

/// A trocar, a tube in it, and two jaws.
struct Grasper : Follower {
  static constexpr std::size_t max_bodies = 4;
  using Joints = TreeJoints<>;
};
static_assert(Scene<Grasper>);

/// A tool of two spheres over a plane.
struct Press : Follower {
  using Contacts = FixedContacts<2, 1, 2>;
};
static_assert(Scene<Press>);

/// Value of a coordinate, and its rate, 1/s.
struct Signal {
  Real value, rate;
};
inline Signal sine(Real t, Real amplitude, Real frequency_Hz, Real phase) {
  const Real omega = 2 * pi * frequency_Hz;
  return {amplitude * std::sin(omega * t + phase), amplitude * omega * std::cos(omega * t + phase)};
}
inline Quat turn(const Vec3& axis, Real angle) {
  const Vec3 v = std::sin(angle / 2) * axis;
  return {std::cos(angle / 2), v.x(), v.y(), v.z()};
}

/// Target of S1: sums of no two equal frequencies in all six degrees of freedom.
inline Target motion(const Params<Follower>&, std::size_t, Real t) {
  const Signal x = sine(t, 0.10, 0.5, 0), y = sine(t, 0.08, 0.7, 0.5), z = sine(t, 0.06, 1.1, 1.1);
  const Signal yaw = sine(t, 1.0, 0.4, 0.7), pitch = sine(t, 0.6, 0.9, 0.3), roll = sine(t, 0.8, 0.6, 0);
  const Quat q_z = turn(Vec3::UnitZ(), yaw.value), q_y = turn(Vec3::UnitY(), pitch.value);
  const Vec3 w_y = pitch.rate * Vec3::UnitY() + q_y * (roll.rate * Vec3::UnitX());
  return {.X_WD = {.p = {x.value, y.value, z.value}, .q = q_z * q_y * turn(Vec3::UnitX(), roll.value)},
          .V_WD = {.w = yaw.rate * Vec3::UnitZ() + q_z * w_y, .v = {x.rate, y.rate, z.rate}}};
}

/// Target of a body of `grasper`: pitch, yaw, roll, insertion and jaws are sines.
inline Target motion(const Params<Grasper>&, std::size_t body, Real t) {
  const Vec3 X = Vec3::UnitX(), Y = Vec3::UnitY(), Z = Vec3::UnitZ();
  const Signal pitch = sine(t, pi / 6, 1, 0), yaw = sine(t, pi / 6, 0.7, 0), roll = sine(t, pi / 3, 0.9, 0);
  const Signal insertion = sine(t, 0.04, 0.5, 0);  // about 0.15 m
  const Signal jaw = sine(t, pi / 9, 1, -pi / 2);  // about pi / 9

  Target D;
  const Quat q_x = turn(X, pitch.value);
  D.X_WD.q = q_x * turn(Y, yaw.value);
  D.V_WD.w = pitch.rate * X + q_x * (yaw.rate * Y);
  if (body == 0) return D;

  const Vec3 z = D.X_WD.q * Z, z_dot = D.V_WD.w.cross(z);
  D.X_WD.p = insertion.value * z;
  D.V_WD.v = insertion.rate * z + insertion.value * z_dot;
  D.V_WD.w += roll.rate * z;
  D.X_WD.q = D.X_WD.q * turn(Z, roll.value);
  if (body == 1) return D;

  const Real side = body == 2 ? 1 : -1;
  D.V_WD.w += D.X_WD.q * (side * jaw.rate * X);
  D.X_WD.q = D.X_WD.q * turn(X, side * (pi / 9 + jaw.value));
  const Vec3 to_centre = Real(0.01) * (D.X_WD.q * Z);
  D.X_WD.p += Real(0.15) * z + to_centre;
  D.V_WD.v += Real(0.15) * z_dot + D.V_WD.w.cross(to_centre);
  return D;
}

/// Target of `press`: 1 cm below the plane within 0.5 s, rocking about y.
inline Target motion(const Params<Press>&, std::size_t, Real t) {
  const Real s = std::min(2 * t, Real(1));
  const Signal rock = sine(t, 0.15, 1, 0);
  return {.X_WD = {.p = {0, 0, Real(0.03) - Real(0.04) * s * s * (3 - 2 * s)},
                   .q = turn(Vec3::UnitY(), rock.value)},
          .V_WD = {.w = {0, rock.rate, 0}, .v = {0, 0, s < 1 ? Real(-0.48) * s * (1 - s) : 0}}};
}

inline RigidBodyParams body(Real m, Real I_x, Real I_y, Real I_z) {
  return rigid_body(m, Vec3(I_x, I_y, I_z).asDiagonal());
}

inline void set_parts(Params<Follower>& par) {
  par.bodies[0].body = body(0.1, 3.4667e-4, 3.4667e-4, 2.6667e-5);
  par.bodies[0].coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 2.606670758728e-2};
}
inline void set_parts(Params<Grasper>& par) {
  par.num_bodies = 4;
  auto& [trocar, tube, left, right] = par.bodies;
  trocar.body = body(0.05, 1.41666666667e-5, 1.41666666667e-5, 7.5e-6);
  trocar.coupling = {.k = 1000, .g = 9.89949493661, .k_r = 0.02, .g_r = 7.45206906391e-4};
  trocar.joint.kind = JointKind::universal;
  tube.body = body(0.08, 6.00666666667e-4, 6.00666666667e-4, 1.33333333333e-6);
  tube.coupling = {.k = 1000, .g = 12.521980674, .k_r = 1, .g_r = 3.43119026967e-2};
  tube.joint.kind = JointKind::cylindrical;
  tube.joint.parent = 0;
  left.body = body(0.005, 1.77083333333e-7, 1.77083333333e-7, 2.08333333333e-8);
  left.coupling = {.k = 1000, .g = 3.1304951685, .k_r = 3e-4, .g_r = 1.0204165816e-5};
  left.joint.kind = JointKind::hinge;  // about z of its frames, which is x of the bodies
  left.joint.parent = 1;
  left.joint.P.p = Vec3(0, 0, 0.15);
  left.joint.C.p = Vec3(0, 0, -0.01);
  // exact, because frames must be orthonormal within 1e-9, which rounding to float exceeds
  left.joint.P.R << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  left.joint.C.R = left.joint.P.R;
  right = left;
}
inline void set_parts(Params<Press>& par) {
  par.bodies[0].body = body(0.1, 3.46666666667e-4, 3.46666666667e-4, 2.66666666667e-5);
  par.bodies[0].coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 2.6066581415e-2};
  auto& contacts = par.contacts;
  contacts.num_spheres = 2;
  contacts.spheres[0] = {.p_B = {-0.08, 0, 0}, .radius = 0.01};
  contacts.spheres[1] = {.p_B = {0.08, 0, 0}, .radius = 0.01};
  contacts.num_surfaces = 1;  // the plane z = 0
  contacts.laws[0][0] = {.k = 20000, .c = 20};
}

/// A scene with all its memory.
template <Scene S>
struct Run {
  Params<S> par;
  State<S> x;
  Scratch<S> w;
  Input<S> in;
  Output<S> out;

  /// Places the bodies at their targets, engaged and moving with them.
  void begin() {
    set_parts(par);
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      par.bodies[i].device.rise = 0;
      const Target D = motion(par, i, 0);
      place(x, i, {.X_WB = D.X_WD, .V_WB = D.V_WD});
      engage_at(x, i, D);
    }
  }
  /// Sets the samples of the devices at the end of a step.
  void sample(int number) {
    for (std::size_t i = 0; i < num_bodies(par); ++i)
      in.devices[i].target = motion(par, i, static_cast<Real>(number) * par.h);
  }
};

}  // namespace scenes
