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

/// True per sphere that presses on the floor.
std::vector<bool> presses(const Case& problem, const ScalarVector& y) {
  std::vector<BodyState> x = body_states(y);
  for (BodyState& body : x) body.q.normalize();
  std::vector<bool> all;
  for (const FloorSphere& sphere : problem.on_floor) all.push_back(floor_force(sphere, x[sphere.body]) > 0);
  return all;
}

/// Advances y from t to t_end. Steps end where a sphere touches or leaves the floor, since the integrator
/// requires smooth equations. It does not see a jump between its last evaluation and the end of its step.
void advance(const Case& problem, ExtrapolationIntegrator& integrator, Scalar t, Scalar t_end,
             ScalarVector& y) {
  if (problem.on_floor.empty()) return integrator.advance(t, t_end, y);
  constexpr Scalar longest = 1e-4L, resolution = 1e-15L;  // s
  ScalarVector y_end;
  while (t < t_end) {
    const std::vector<bool> before = presses(problem, y);
    Scalar end = std::min(t + longest, t_end);
    integrator.advance(t, end, y_end = y);
    if (presses(problem, y_end) != before) {
      while (end - t > resolution) {
        const Scalar middle = (t + end) / 2;
        ScalarVector y_middle = y;
        integrator.advance(t, middle, y_middle);
        if (presses(problem, y_middle) != before) {
          end = middle;
          y_end.swap(y_middle);
        } else {
          t = middle;
          y.swap(y_middle);
        }
      }
    }
    t = end;
    y.swap(y_end);
  }
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
    advance(problem, integrator, t, stop, y);
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
