#include "tests/oracle/scenes.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "tests/oracle/target.h"

namespace godobject::oracle {

namespace {

struct Signal {
  double value;
  double rate;  // 1/s
};

/// amplitude * sin(2 pi frequency t + phase)
Signal sine(double t, double amplitude, double frequency_Hz, double phase) {
  const double omega = 2 * std::numbers::pi * frequency_Hz;
  return {amplitude * std::sin(omega * t + phase), amplitude * omega * std::cos(omega * t + phase)};
}

Quaterniond turn(const Vector3d& axis, double angle) { return Quaterniond(Eigen::AngleAxisd(angle, axis)); }

/// Returns J_l(r) r_d, the angular velocity of the turn by r: J_l = I + (1 - cos a) / a^2 [r]x
/// + (a - sin a) / a^3 [r]x^2, a = |r|.
Vector3d rate_of_turn(const Vector3d& r, const Vector3d& r_d) {
  const double a = r.norm(), half = std::sin(a / 2), a_sq = a * a;
  // the series where the differences cancel
  const double first = a < 1e-3 ? 0.5 - a_sq / 24 : 2 * half * half / a_sq;
  const double second = a < 0.05 ? 1.0 / 6 - a_sq / 120 + a_sq * a_sq / 5040 : (a - std::sin(a)) / (a_sq * a);
  const Vector3d across = r.cross(r_d);
  return r_d + first * across + second * r.cross(across);
}

}  // namespace

RigidState scene_s1_target(double t) {
  const Signal x = sine(t, 0.10, 0.5, 0);
  const Signal y = sine(t, 0.08, 0.7, 0.5);
  const Signal z = sine(t, 0.06, 1.1, 1.1);
  const Signal yaw = sine(t, 1.0, 0.4, 0.7);
  const Signal pitch = sine(t, 0.6, 0.9, 0.3);
  const Signal roll = sine(t, 0.8, 0.6, 0);
  const Quaterniond qz(Eigen::AngleAxisd(yaw.value, Vector3d::UnitZ()));
  const Quaterniond qy(Eigen::AngleAxisd(pitch.value, Vector3d::UnitY()));
  const Quaterniond qx(Eigen::AngleAxisd(roll.value, Vector3d::UnitX()));

  RigidState D;
  D.p = {x.value, y.value, z.value};
  D.v = {x.rate, y.rate, z.rate};
  D.q = qz * qy * qx;
  // Each turn's rate is about its own axis, carried by the turns before it.
  D.w = yaw.rate * Vector3d::UnitZ() +
        qz * (pitch.rate * Vector3d::UnitY() + qy * (roll.rate * Vector3d::UnitX()));
  return D;
}

Case scene_s1() {
  Body tool;
  tool.name = "tool";
  tool.m = 0.1;
  tool.I_B = Vector3d(3.4667e-4, 3.4667e-4, 2.6667e-5).asDiagonal();
  tool.start = scene_s1_target(0);

  Coupling coupling;
  coupling.k_t = 1000;
  coupling.g_t = 1.4 * std::sqrt(tool.m * coupling.k_t);
  coupling.k_r = 1;
  coupling.g_r = 1.4 * std::sqrt(coupling.k_r * 3.4667e-4);
  coupling.target = std::make_shared<FunctionTarget>(scene_s1_target);
  tool.coupling = coupling;

  Case scene;
  scene.bodies = {tool};
  return scene;
}

RigidState lissajous_device(double t) {
  const Signal x = sine(t, 0.05, 1, 0), y = sine(t, 0.05, 1.3, 0.4), z = sine(t, 0.03, 0.7, 0);
  const Signal r_x = sine(t, 0.6, 1, 0), r_y = sine(t, 0.5, 1.1, 0), yaw = sine(t, 1.2, 0.9, 0);
  const Vector3d r(r_x.value, r_y.value, 0), r_d(r_x.rate, r_y.rate, 0);
  const Quaterniond qz = turn(Vector3d::UnitZ(), yaw.value);
  const double angle = r.norm();

  RigidState D;
  D.p = {x.value, y.value, z.value};
  D.v = {x.rate, y.rate, z.rate};
  D.q = angle > 0 ? qz * turn(r / angle, angle) : qz;
  D.w = yaw.rate * Vector3d::UnitZ() + qz * rate_of_turn(r, r_d);
  return D;
}

std::shared_ptr<const Target> press_device() {
  constexpr double lowered_by = 0.04, within = 0.5;  // m, s
  const auto motion = [](double t) {
    const double s = std::min(t / within, 1.0);
    const Signal rock = sine(t, 0.15, 1, 0);
    RigidState D;
    D.p.z() = 0.03 - lowered_by * s * s * (3 - 2 * s);
    D.v.z() = -lowered_by / within * 6 * s * (1 - s);
    D.q = turn(Vector3d::UnitY(), rock.value);
    D.w.y() = rock.rate;
    return D;
  };
  return std::make_shared<FunctionTarget>(motion, std::vector{within});
}

RigidState grasper_device(std::size_t body, double t) {
  const double pi = std::numbers::pi;
  const Vector3d X = Vector3d::UnitX(), Y = Vector3d::UnitY(), Z = Vector3d::UnitZ();
  const Signal pitch = sine(t, pi / 6, 1, 0), yaw = sine(t, pi / 6, 0.7, 0), roll = sine(t, pi / 3, 0.9, 0);
  const Signal insertion = sine(t, 0.04, 0.5, 0);  // about 0.15 m
  const Signal jaw = sine(t, pi / 9, 1, -pi / 2);  // about pi / 9

  RigidState D;  // the trocar
  D.q = turn(X, pitch.value) * turn(Y, yaw.value);
  D.w = pitch.rate * X + turn(X, pitch.value) * (yaw.rate * Y);
  if (body == 0) return D;

  // The tube slides along z of the trocar; its tip is 0.15 m from its centre.
  const Vector3d z = D.q * Z, zd = D.w.cross(z);
  D.p = insertion.value * z;
  D.v = insertion.rate * z + insertion.value * zd;
  D.w += roll.rate * z;
  D.q = D.q * turn(Z, roll.value);
  if (body == 1) return D;

  const double side = body == 2 ? 1 : -1;
  D.w += D.q * (side * jaw.rate * X);
  D.q = D.q * turn(X, side * (pi / 9 + jaw.value));
  const Vector3d to_centre = 0.01 * (D.q * Z);
  D.p += 0.15 * z + to_centre;
  D.v += 0.15 * zd + D.w.cross(to_centre);
  return D;
}

}  // namespace godobject::oracle
