// Error against run time of a scene: runs with each integrator and step, compared with a far shorter step.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "platform/motion/motion.h"
#include "platform/session/record.h"

namespace godobject {

/// Largest differences between two runs.
struct RunDifferences {
  double position_m = 0, rotation_rad = 0, force_N = 0;
};

/// State of a scene at a time of comparison.
struct AccuracySample {
  std::vector<Pose> X_WB{};
  std::vector<Vec3> nodes_W{}, force_W{};  // nodes of nets; displayed forces
};

/// A finished run of the scene.
struct AccuracyRun {
  std::string integrator{};
  double step_s = 0;
  std::vector<AccuracySample> samples{};
  double step_ns = 0;            // median compute time of a step
  double first_order_share = 0;  // share of steps that TR-BDF2 took as implicit Euler steps
  Fault fault = Fault::none;

  double compute_ms_per_s() const { return 1e-6 * step_ns / step_s; }
};

/// Span of a comparison: samples at whole multiples of the interval.
struct AccuracySpan {
  double from_s = 0, end_s = 0, interval_s = 0;

  /// Returns the number of samples up to the end.
  std::uint64_t num_intervals() const {
    return static_cast<std::uint64_t>(std::floor(end_s / interval_s + 1e-9));
  }
};

struct AccuracyPlan {
  std::vector<double> steps_s{};       // each divides the longest; empty: from four scene steps to an eighth
  std::optional<double> from_s{};      // begin of the comparison; none: after the ramp of engaging
  std::optional<double> duration_s{};  // of the comparison; none: 1 s
};

/// Results of all runs.
struct Accuracy {
  std::vector<AccuracyRun> runs{};
  std::vector<RunDifferences> errors{};  // one for each run
  AccuracyRun reference{};
  RunDifferences of_reference{};  // error of the reference itself
  AccuracySpan span{};

  /// True if no other run is both as accurate and as quick.
  bool is_on_front(std::size_t i) const;
  /// Returns the number of the quickest run within the tolerance, without a fault; none if there is none.
  std::optional<std::size_t> quickest_within(double tolerance_m) const;
  /// True if the reference is no more accurate than the runs: bodies that collide may part at any step.
  bool is_unresolved() const;
};

/// Runs the scene without a device, with this motion, for each integrator and step. Returns the errors, which
/// name the option of the plan.
std::vector<std::string> measure_accuracy(const SceneConfig& scene, const Motion& motion,
                                          const AccuracyPlan& plan, Accuracy& accuracy);

}  // namespace godobject
