#include "tests/study/peer/work_precision.h"

#include <algorithm>
#include <cmath>

#include "tests/study/peer/own.h"

namespace godobject::study {
namespace {

using Kind = Reading::Kind;

/// Interpolates linearly between logarithms.
double between(double x, double x_0, double y_0, double x_1, double y_1) {
  return y_0 * std::pow(y_1 / y_0, std::log(x / x_0) / std::log(x_1 / x_0));
}

/// Returns the reading as a multiple of a value.
Reading over(Reading a, double b) {
  a.value /= b;
  return a;
}

/// Returns a value as a multiple of a reading: a bound changes its side.
Reading over(double a, Reading b) {
  b.value = a / b.value;
  if (b.kind == Kind::at_most) b.kind = Kind::at_least;
  else if (b.kind == Kind::at_least) b.kind = Kind::at_most;
  return b;
}

/// Keeps the peer with the smaller ratio.
void keep_best(std::optional<BestPeer>& best, const std::string& engine, const Reading& ratio) {
  if (ratio.kind == Kind::none) return;
  if (!best || ratio.value < best->ratio.value) best = BestPeer{.engine = engine, .ratio = ratio};
}

/// Keeps a peer that reaches the error before those that do not at any of their steps.
void keep_reached(std::optional<BestPeer>& best, const std::string& engine, const Reading& ratio) {
  const bool is_reached = ratio.kind != Kind::at_least;
  const bool best_is_reached = best && best->ratio.kind != Kind::at_least;
  if (best && is_reached && !best_is_reached) best.reset();
  if (is_reached || !best_is_reached) keep_best(best, engine, ratio);
}

std::optional<WorkPoint> point_at(const PeerResults& results, const std::string& scene,
                                  const std::string& engine, ErrorColumn column) {
  const PeerError* const row = find_row(results.errors, scene, engine, compared_step);
  if (row == nullptr || !row->native_us || !std::isfinite(row->*column)) return std::nullopt;
  return WorkPoint{.time = 1e-6 * *row->native_us / row->h, .error = row->*column};
}

WorkComparison compared(const PeerResults& results, const std::string& scene, const std::string& integrator,
                        const char* quantity, ErrorColumn column) {
  WorkComparison result{.scene = scene,
                        .integrator = integrator,
                        .quantity = quantity,
                        .error_in_our_time = {},
                        .error_in_its_time = {},
                        .time_to_our_error = {},
                        .time_to_its_error = {}};
  const std::optional<WorkPoint> own = point_at(results, scene, integrator, column);
  const WorkCurve own_curve = curve_of(results, scene, integrator, column);
  if (!own) return result;
  for (const std::string& engine : engines_of(results)) {
    if (is_ours(engine)) continue;
    const WorkCurve curve = curve_of(results, scene, engine, column);
    keep_best(result.error_in_our_time, engine, over(curve.error_at(own->time), own->error));
    keep_reached(result.time_to_our_error, engine, over(curve.time_to(own->error), own->time));
    if (const auto its = point_at(results, scene, engine, column)) {
      keep_best(result.error_in_its_time, engine, over(its->error, own_curve.error_at(its->time)));
      keep_best(result.time_to_its_error, engine, over(its->time, own_curve.time_to(its->error)));
    }
  }
  return result;
}

}  // namespace

WorkCurve::WorkCurve(std::vector<WorkPoint> points) : points_(std::move(points)) {
  std::erase_if(points_, [](const WorkPoint& p) {
    return !(p.time > 0 && p.error > 0 && std::isfinite(p.time) && std::isfinite(p.error));
  });
  std::ranges::sort(points_, {}, [](const WorkPoint& p) { return std::pair(p.time, p.error); });
  double best = INFINITY;
  std::erase_if(points_, [&](const WorkPoint& p) {
    if (p.error >= best) return true;
    best = p.error;
    return false;
  });
}

Reading WorkCurve::error_at(double time) const {
  if (points_.empty() || time < points_.front().time) return {};
  const auto next = std::ranges::upper_bound(points_, time, {}, &WorkPoint::time);
  const WorkPoint& at = *std::prev(next);
  if (at.time == time) return {.kind = Kind::exact, .value = at.error};
  if (next == points_.end()) return {.kind = Kind::at_most, .value = at.error};
  return {.kind = Kind::exact, .value = between(time, at.time, at.error, next->time, next->error)};
}

Reading WorkCurve::time_to(double error) const {
  if (points_.empty()) return {};
  const auto reached = std::ranges::find_if(points_, [&](const WorkPoint& p) { return p.error <= error; });
  if (reached == points_.end()) return {.kind = Kind::at_least, .value = points_.back().time};
  if (reached->error == error) return {.kind = Kind::exact, .value = reached->time};
  if (reached == points_.begin()) return {.kind = Kind::at_most, .value = reached->time};
  const WorkPoint& at = *std::prev(reached);
  return {.kind = Kind::exact, .value = between(error, at.error, at.time, reached->error, reached->time)};
}

WorkCurve curve_of(const PeerResults& results, const std::string& scene, const std::string& engine,
                   ErrorColumn column) {
  std::vector<WorkPoint> points;
  for (const PeerError& r : results.errors)
    if (r.scene == scene && r.engine == engine && r.native_us)
      points.push_back({.time = 1e-6 * *r.native_us / r.h, .error = r.*column});
  return WorkCurve(std::move(points));
}

std::vector<WorkComparison> compare_work(const PeerResults& results) {
  std::vector<WorkComparison> all;
  for (const std::string& scene : scenes_of(results))
    for (const char* integrator : {ImplicitEuler::name, TrBdf2::name}) {
      if (curve_of(results, scene, integrator, &PeerError::position).points().empty()) continue;
      all.push_back(compared(results, scene, integrator, "position", &PeerError::position));
      all.push_back(compared(results, scene, integrator, "rotation", &PeerError::rotation));
    }
  return all;
}

}  // namespace godobject::study
