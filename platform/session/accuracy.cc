#include "platform/session/accuracy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/base/format.h"
#include "platform/rt/cyclic.h"
#include "platform/session/session.h"

namespace godobject {
namespace {

constexpr int reference_ratio = 8;   // shortest step over that of the reference
constexpr double settling_s = 0.25;  // couplings converge within it after the ramp of engaging

/// Returns how often a goes into b; 0 unless it does so a whole number of times.
std::uint64_t times_within(double a, double b) {
  const double n = std::round(b / a);
  return n >= 1 && std::abs(b / a - n) < 1e-6 * n ? static_cast<std::uint64_t>(n) : 0;
}

AccuracySample sample_of(const CycleRecord& record) {
  AccuracySample sample;
  for (const BodyView& body : record.bodies) {
    sample.X_WB.push_back(body.X_WB);
    sample.force_W.push_back(body.feedback_D.f);
  }
  sample.nodes_W = record.net_nodes;
  return sample;
}

RunDifferences between(const AccuracyRun& a, const AccuracyRun& b) {
  RunDifferences d;
  for (std::size_t n = 0; n < std::min(a.samples.size(), b.samples.size()); ++n) {
    const AccuracySample &x = a.samples[n], &y = b.samples[n];
    for (std::size_t i = 0; i < x.X_WB.size(); ++i) {
      const PoseError error = godobject::between(x.X_WB[i], y.X_WB[i]);
      d.position_m = std::max(d.position_m, error.m);
      d.rotation_rad = std::max(d.rotation_rad, error.rad);
      d.force_N = std::max(d.force_N, (x.force_W[i] - y.force_W[i]).norm());
    }
    for (std::size_t i = 0; i < x.nodes_W.size(); ++i)
      d.position_m = std::max(d.position_m, (x.nodes_W[i] - y.nodes_W[i]).norm());
  }
  return d;
}

/// Runs the scene with this integrator and step. Returns the errors.
std::vector<std::string> run_scene(SceneConfig scene, const Motion& motion, const AccuracySpan& span,
                                   AccuracyRun& run) {
  scene.integrator = run.integrator;
  scene.step = run.step_s;
  Session::Made made = Session::make(std::move(scene), motion);
  if (!made.session) return made.errors;
  Session& session = *made.session;
  session.set_stage_clock([]() noexcept GODOBJECT_NONBLOCKING { return MonotonicClock{}.now(); });
  if (!session.engine().nets().nodes.empty()) session.list_net_nodes();
  CycleRecord record = session.at_start();
  const std::uint64_t every = times_within(run.step_s, span.interval_s);
  std::vector<Nanoseconds> step_ns;
  std::uint64_t num_first_order = 0;
  session.start(0);
  for (std::uint64_t n = 1; n <= every * span.num_intervals() && session.advance(record); ++n) {
    run.fault |= record.fault;
    if (record.t < span.from_s) continue;
    step_ns.push_back(record.step_ns);
    num_first_order += has(record.limited, Limited::first_order) ? 1 : 0;
    if (n % every == 0) run.samples.push_back(sample_of(record));
  }
  if (step_ns.empty()) return {};
  std::ranges::nth_element(step_ns, step_ns.begin() + static_cast<std::ptrdiff_t>(step_ns.size() / 2));
  run.step_ns = static_cast<double>(step_ns[step_ns.size() / 2]);
  run.first_order_share = static_cast<double>(num_first_order) / static_cast<double>(step_ns.size());
  return {};
}

std::vector<std::string> check_steps(const std::vector<double>& steps_s, const AccuracySpan& span) {
  std::vector<std::string> errors;
  for (const double step_s : steps_s)
    if (times_within(step_s, span.interval_s) == 0)
      errors.push_back("--steps: " + shortest(step_s) + " s does not divide the longest step, " +
                       shortest(span.interval_s) + " s: give steps that do, e.g. 0.004,0.002,0.001");
  if (span.end_s - span.from_s < span.interval_s)
    errors.push_back("--duration: " + shortest(span.end_s - span.from_s) +
                     " s is shorter than the longest step");
  return errors;
}

/// Returns the time at which the tool has followed the device's ramp, s.
double after_ramp(const SceneConfig& scene) {
  const double ramp_s = scene.device ? scene.device->limits.ramp : 0;
  return ramp_s > 0 ? ramp_s + settling_s : 0;
}

}  // namespace

bool Accuracy::is_on_front(std::size_t i) const {
  for (std::size_t j = 0; j < runs.size(); ++j)
    if (j != i && errors[j].position_m <= errors[i].position_m &&
        runs[j].compute_ms_per_s() <= runs[i].compute_ms_per_s())
      return false;
  return true;
}

std::optional<std::size_t> Accuracy::quickest_within(double tolerance_m) const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (!any(runs[i].fault) && errors[i].position_m <= tolerance_m &&
        (!best || runs[i].compute_ms_per_s() < runs[*best].compute_ms_per_s()))
      best = i;
  return best;
}

bool Accuracy::is_unresolved() const {
  double least = errors.front().position_m;
  for (const RunDifferences& e : errors) least = std::min(least, e.position_m);
  return 2 * of_reference.position_m > least && least > 0;
}

std::vector<std::string> measure_accuracy(const SceneConfig& scene, const Motion& motion,
                                          const AccuracyPlan& plan, Accuracy& accuracy) {
  std::vector<double> steps_s = plan.steps_s;
  if (steps_s.empty())
    for (const double ratio : {4.0, 2.0, 1.0, 0.5, 0.25, 0.125}) steps_s.push_back(ratio * scene.step);
  std::ranges::sort(steps_s, std::greater());
  const double from_s = plan.from_s.value_or(after_ramp(scene));
  accuracy.span = {from_s, from_s + plan.duration_s.value_or(1), steps_s.front()};
  if (std::vector<std::string> errors = check_steps(steps_s, accuracy.span); !errors.empty()) return errors;
  const double finest_s = steps_s.back() / reference_ratio;
  accuracy.reference = {.integrator = "tr-bdf2", .step_s = finest_s};
  AccuracyRun coarser{.integrator = "tr-bdf2", .step_s = 2 * finest_s};
  for (const char* integrator : integrator_names)
    for (const double step_s : steps_s) accuracy.runs.push_back({.integrator = integrator, .step_s = step_s});
  std::vector<AccuracyRun*> all{&accuracy.reference, &coarser};
  for (AccuracyRun& run : accuracy.runs) all.push_back(&run);
  for (AccuracyRun* run : all)
    if (std::vector<std::string> errors = run_scene(scene, motion, accuracy.span, *run); !errors.empty()) {
      for (std::string& error : errors) error = "with a step of " + shortest(run->step_s) + " s: " + error;
      return errors;
    }
  accuracy.of_reference = between(accuracy.reference, coarser);
  for (const AccuracyRun& run : accuracy.runs) accuracy.errors.push_back(between(run, accuracy.reference));
  return {};
}

}  // namespace godobject
