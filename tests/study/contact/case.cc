#include "tests/study/contact/case.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/oracle/scenes.h"
#include "tests/oracle/target.h"

namespace godobject::study {
namespace {

using oracle::RigidState;

/// Case of sim/scenes/reference/press.toml.
bench::ContactScene press() {
  oracle::Body tool;
  tool.name = "tool";
  tool.m = 0.1;
  tool.I_B = Vec3(0.000346666666667, 0.000346666666667, 2.66666666667e-05).asDiagonal();
  tool.start.p = Vec3(0, 0, 0.03);
  tool.start.w = Vec3(0, 0.942477796077, 0);
  tool.coupling = {.k_t = 1000, .g_t = 14, .k_r = 1, .g_r = 0.026066581415, .target = oracle::press_device()};

  bench::ContactScene scene;
  scene.name = "press";
  scene.problem.bodies = {tool};
  scene.duration = 2;
  scene.centres = {Vec3(-0.08, 0, 0), Vec3(0.08, 0, 0)};
  scene.radius = 0.01;
  scene.law = {.k = 20000, .c = 20};
  return scene;
}

/// Case of sim/scenes/reference/bounce.toml.
bench::ContactScene bounce() {
  oracle::Body ball;
  ball.name = "ball";
  ball.m = 0.1;
  ball.I_B = Vec3(4e-6, 4e-6, 4e-6).asDiagonal();
  ball.start.p = Vec3(0, 0, 0.05);

  bench::ContactScene scene;
  scene.name = "bounce";
  scene.problem.gravity = Vec3(0, 0, -9.81);
  scene.problem.bodies = {ball};
  scene.duration = 1;
  scene.centres = {Vec3::Zero()};
  scene.radius = 0.01;
  scene.law = {.k = 5000, .c = 2};
  return scene;
}

/// Returns the height above the contact of the ball, m.
double height(const bench::ContactScene& scene, const RigidState& x) { return x.p.z() - scene.radius; }

}  // namespace

std::vector<ContactCase> contact_cases() {
  std::vector<ContactCase> cases;
  for (bench::ContactScene scene : {press(), bounce()}) {
    oracle::Case problem = scene.problem;
    for (const Vec3& centre : scene.centres)
      problem.on_floor.push_back({.p_B = centre, .radius = scene.radius, .k = scene.law.k, .c = scene.law.c});
    const double interval = scene.problem.bodies.front().coupling ? 10e-3 : 2.5e-3;
    oracle::Solution exact = oracle::solve(problem, oracle::uniform_times(scene.duration, interval));
    cases.push_back({std::move(scene), std::move(exact)});
  }
  return cases;
}

double penetration(const bench::ContactScene& scene, const RigidState& x) {
  double deepest = 0;
  for (const Vec3& centre : scene.centres)
    deepest = std::max(deepest, scene.radius - (x.p + x.q * centre).z());
  return deepest;
}

double mechanical_energy(const bench::ContactScene& scene, const RigidState& x, double t) {
  const oracle::Body& body = scene.problem.bodies.front();
  const Vec3 w_B = x.q.conjugate() * x.w;
  double E = body.m * (x.v.squaredNorm() / 2 - scene.problem.gravity.dot(x.p)) + w_B.dot(body.I_B * w_B) / 2;
  for (const Vec3& centre : scene.centres) {
    const double depth = std::max(scene.radius - (x.p + x.q * centre).z(), 0.0);
    E += scene.law.k * depth * depth / 2;
  }
  if (!body.coupling) return E;
  const RigidState D = body.coupling->target->at(t);
  const double angle = x.q.angularDistance(D.q);
  return E + (body.coupling->k_t * (D.p - x.p).squaredNorm() + body.coupling->k_r * angle * angle) / 2;
}

std::vector<Flight> flights(const bench::ContactScene& scene, const oracle::Solution& solution) {
  const double g = -scene.problem.gravity.z();
  std::vector<Flight> all;
  Flight current;
  for (std::size_t n = 0; n < solution.times.size(); ++n) {
    const RigidState& x = solution.states[n].front();
    const double z = height(scene, x);
    if (z > 0) {
      current.apex = z + x.v.z() * x.v.z() / (2 * g);
      current.landing = solution.times[n] + (x.v.z() + std::sqrt(2 * g * current.apex)) / g;
    } else if (current.landing > 0) {
      all.push_back(current);
      current = {};
    }
  }
  return all;
}

double restitution(const std::vector<Flight>& flights) {
  return flights.size() < 2 ? 0 : std::sqrt(flights[1].apex / flights[0].apex);
}

double worst_flight_error(const std::vector<Flight>& flights, const std::vector<Flight>& exact) {
  if (flights.size() < exact.size()) return std::numeric_limits<double>::infinity();
  double worst = 0;
  for (std::size_t i = 0; i < exact.size(); ++i)
    worst = std::max({worst, std::abs(flights[i].apex / exact[i].apex - 1),
                      std::abs(flights[i].landing / exact[i].landing - 1)});
  return worst;
}

}  // namespace godobject::study
