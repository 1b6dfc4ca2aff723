#include "tests/oracle/solve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>

#include "tests/oracle/dynamics.h"
#include "tests/oracle/extrapolation.h"
#include "tests/oracle/target.h"

namespace godobject::oracle {

namespace {

void require(bool holds, const std::string& rule) {
  if (!holds) throw std::invalid_argument(rule);
}

void validate(const Body& body) {
  const std::string name = "body '" + body.name + "': ";
  require(body.m > 0 && std::isfinite(body.m), name + "the mass must be positive");
  require(body.I_B.isApprox(body.I_B.transpose(), 1e-14), name + "the inertia must be symmetric");
  require(body.I_B.llt().info() == Eigen::Success, name + "the inertia must be positive definite");
  require(std::abs(body.start.q.norm() - 1) < 1e-9, name + "the orientation must be a unit quaternion");
  require(!body.coupling || body.coupling->target, name + "the coupling needs a target");
}

/// Where steps must end: the wanted times and every kink of a target between them.
std::vector<double> stops_of(const Case& problem, std::span<const double> times) {
  std::vector<double> stops(times.begin(), times.end());
  for (const Body& body : problem.bodies) {
    if (!body.coupling) continue;
    for (const double t : body.coupling->target->knots()) {
      if (t > 0 && t < times.back()) stops.push_back(t);
    }
  }
  std::sort(stops.begin(), stops.end());
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  return stops;
}

}  // namespace

Solution solve(const Case& problem, std::span<const double> times, double tolerance) {
  for (const Body& body : problem.bodies) validate(body);
  require(std::is_sorted(times.begin(), times.end()), "the times must ascend");
  Solution solution;
  if (times.empty()) return solution;
  require(times.front() >= 0 && std::isfinite(times.back()), "the times must be finite and not negative");

  std::vector<RigidState> states;
  for (const Body& body : problem.bodies) states.push_back(body.start);
  ScalarVector y = pack(states);
  ExtrapolationIntegrator integrator(Dynamics(problem), tolerance);
  double t = 0;
  std::size_t next = 0;
  for (const double stop : stops_of(problem, times)) {
    integrator.advance(t, stop, y);
    t = stop;
    normalise(y);
    for (; next < times.size() && times[next] == t; ++next) {
      solution.times.push_back(t);
      solution.states.push_back(unpack(y));
    }
  }
  return solution;
}

std::vector<double> uniform_times(double duration, double step) {
  const auto count = static_cast<std::size_t>(std::floor(duration / step * (1 + 1e-12) + 1e-9)) + 1;
  std::vector<double> times(count);
  for (std::size_t i = 0; i < count; ++i) times[i] = static_cast<double>(i) * step;
  return times;
}

}  // namespace godobject::oracle
