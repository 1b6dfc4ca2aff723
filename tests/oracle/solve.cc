#include "tests/oracle/solve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/oracle/dynamics.h"
#include "tests/oracle/extrapolation.h"
#include "tests/oracle/target.h"
#include "tests/oracle/validate.h"

namespace godobject::oracle {

namespace {

/// Returns the times at which steps must end: the requested times, and every kink of a target or prescribed
/// joint between them.
std::vector<double> stops_of(const Case& problem, std::span<const double> times) {
  std::vector<double> stops(times.begin(), times.end());
  const auto add = [&](std::span<const double> knots) {
    for (const double t : knots) {
      if (t > 0 && t < times.back()) stops.push_back(t);
    }
  };
  for (const Body& body : problem.bodies) {
    if (body.coupling) add(body.coupling->target->knots());
  }
  for (const Joint& joint : problem.joints) {
    if (joint.imposed) add(joint.imposed->knots);
  }
  std::sort(stops.begin(), stops.end());
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  return stops;
}

}  // namespace

Solution solve(const Case& problem, std::span<const double> times, double tolerance) {
  validate(problem);
  if (!std::is_sorted(times.begin(), times.end())) throw std::invalid_argument("the times must ascend");
  Solution solution;
  if (times.empty()) return solution;
  if (!(times.front() >= 0 && std::isfinite(times.back()))) {
    throw std::invalid_argument("the times must be finite and not negative");
  }

  std::vector<RigidState> states;
  for (const Body& body : problem.bodies) states.push_back(body.start);
  ScalarVector y = pack(states);
  const Dynamics dynamics(problem);
  dynamics.project(0, y);
  ExtrapolationIntegrator integrator(dynamics, tolerance);
  double t = 0;
  std::size_t next = 0;
  for (const double stop : stops_of(problem, times)) {
    integrator.advance(t, stop, y);
    t = stop;
    normalise(y);
    solution.joint_drift = std::max(dynamics.project(t, y), solution.joint_drift);
    for (; next < times.size() && times[next] == t; ++next) {
      solution.times.push_back(t);
      solution.states.push_back(unpack(y));
      solution.reactions.push_back(dynamics.reactions(t, y));
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
