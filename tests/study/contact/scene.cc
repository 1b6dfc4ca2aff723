#include "tests/study/contact/scene.h"

#include <cmath>
#include <memory>
#include <numbers>

#include "tests/oracle/target.h"

namespace godobject::bench {
namespace {

using oracle::Quaterniond;
using oracle::RigidState;

/// A value with its rate.
struct Signal {
  double value, rate;
};
Signal operator*(double a, const Signal& x) { return {a * x.value, a * x.rate}; }
Signal operator*(const Signal& a, const Signal& b) {
  return {a.value * b.value, a.rate * b.value + a.value * b.rate};
}

double omega(double frequency_Hz) { return 2 * std::numbers::pi * frequency_Hz; }
Signal sine(double frequency_Hz, double t) {
  const double w = omega(frequency_Hz);
  return {std::sin(w * t), w * std::cos(w * t)};
}
Signal cosine(double frequency_Hz, double t) {
  const double w = omega(frequency_Hz);
  return {std::cos(w * t), -w * std::sin(w * t)};
}

/// Smoothed step: from 0 to 1 in the first second, a cubic.
Signal eased(double t) {
  if (t <= 0) return {0, 0};
  if (t >= 1) return {1, 0};
  return {t * t * (3 - 2 * t), 6 * t * (1 - t)};
}

Quaterniond turn(const Vec3& axis, double angle) { return Quaterniond(Eigen::AngleAxisd(angle, axis)); }

/// Returns a target at x, y, z, rotated by yaw from attitude q.
RigidState target_at(const Signal& x, const Signal& y, const Signal& z, const Signal& yaw,
                     const Quaterniond& q) {
  RigidState D;
  D.p = {x.value, y.value, z.value};
  D.v = {x.rate, y.rate, z.rate};
  D.q = turn(Vec3::UnitZ(), yaw.value) * q;
  D.w = yaw.rate * Vec3::UnitZ();
  return D;
}

RigidState target_s2(double t) {
  const double u = t - 1.5;
  const Signal drag = eased(u), press = eased(t);
  return target_at(drag * (0.10 * sine(0.5, u)), drag * (0.08 * sine(0.3, u)),
                   {0.07 * (1 - press.value), -0.07 * press.rate}, drag * (0.5 * sine(0.4, u)),
                   turn(Vec3::UnitY(), std::numbers::pi / 2));
}

RigidState target_s4(double t) {
  const Signal lift = cosine(0.3, t);
  return target_at(-0.22 * cosine(0.2, t), 0.035 * sine(0.37, t),
                   {0.007 + 0.004 * (1 - lift.value), -0.004 * lift.rate}, 0.6 * sine(0.25, t),
                   Quaterniond::Identity());
}

/// inertia: moment of inertia for the damping of rotations, kg m^2.
oracle::Coupling coupling(double m, double inertia, double k, double k_r, RigidState (*target)(double)) {
  return {.k_t = k,
          .g_t = 1.4 * std::sqrt(m * k),
          .k_r = k_r,
          .g_r = 1.4 * std::sqrt(k_r * inertia),
          .target = std::make_shared<oracle::FunctionTarget>(target)};
}

oracle::Body brick(const Vec3& half_extents, const Vec3& p) {
  oracle::Body body;
  body.m = 2.5e-3;
  const Vec3 sq = half_extents.cwiseAbs2();
  body.I_B = (body.m / 3 * Vec3(sq.y() + sq.z(), sq.z() + sq.x(), sq.x() + sq.y())).asDiagonal();
  body.start.p = p;
  return body;
}

/// Returns the start of brick b: the first pile column by column. Further piles are beside it and are not
/// dragged.
Vec3 place_in_pile(std::size_t b) {
  constexpr std::size_t in_pile = 63;
  const std::size_t column = b % in_pile / 9, layer = b % 9 / 3, of_pile = b / in_pile;
  const auto i = static_cast<double>(column), l = static_cast<double>(layer), j = static_cast<double>(b % 3),
             pile = static_cast<double>(of_pile);
  return {(i - 3) * 0.036 + (l == 1 ? 0.004 : 0), (j - 1) * 0.019 + 0.15 * pile, 0.005 + 0.0102 * l};
}

/// Returns sphere centres at the corners of a brick, tangent to its faces.
std::vector<Vec3> at_corners(const Vec3& half_extents, double radius) {
  const Vec3 inset = half_extents - Vec3::Constant(radius);
  std::vector<Vec3> centres;
  for (const double x : {-1, 1})
    for (const double y : {-1, 1})
      for (const double z : {-1, 1}) centres.push_back(inset.cwiseProduct(Vec3(x, y, z)));
  return centres;
}

}  // namespace

ContactScene scene_s2(double k) {
  oracle::Body tool;
  tool.m = 0.1;
  tool.I_B = Vec3(3.4667e-4, 3.4667e-4, 2.6667e-5).asDiagonal();
  tool.start.p = target_s2(0).p;
  tool.start.q = target_s2(0).q;
  tool.coupling = coupling(tool.m, tool.I_B(0, 0), k, 1e-3 * k, target_s2);

  ContactScene scene;
  scene.name = "S2/1e" + std::to_string(std::lround(std::log10(k)));
  scene.problem.bodies = {tool};
  scene.duration = 10;
  for (int i = 0; i < 10; ++i) scene.centres.emplace_back(0, 0, -0.09 + 0.02 * i);
  scene.radius = 0.02;
  scene.law = {.k = 2e5, .c = 200, .mu = 0.3, .k_t = 2e5, .c_t = 200};
  return scene;
}

ContactScene scene_s4(std::size_t num_bricks, double duration) {
  const Vec3 half_extents(0.016, 0.008, 0.005);
  ContactScene scene;
  scene.name = "S4/" + std::to_string(num_bricks);
  scene.problem.gravity = {0, 0, -9.81};
  scene.problem.bodies = {brick(half_extents, target_s4(0).p)};
  oracle::Body& dragged = scene.problem.bodies.front();
  dragged.coupling = coupling(dragged.m, dragged.I_B(1, 1), 200, 0.05, target_s4);
  for (std::size_t b = 0; b + 1 < num_bricks; ++b)
    scene.problem.bodies.push_back(brick(half_extents, place_in_pile(b)));
  scene.duration = duration;

  scene.half_extents = half_extents;
  scene.radius = 2e-4;
  scene.centres = at_corners(half_extents, scene.radius);
  // four such contacts under a brick are critically damped: 4 c = 2 sqrt(m 4 k)
  scene.law = {.k = 2e4, .c = 7, .mu = 0.3, .k_t = 2e4, .c_t = 7};
  return scene;
}

}  // namespace godobject::bench
