// Work-precision curves: error over the compute time of a simulated second, one point for each step length.
#pragma once

#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/study/peer/study.h"

namespace godobject::study {

struct WorkPoint {
  double time = 0;   // s of compute time per simulated second
  double error = 0;  // m or rad
};

/// A number read from a curve, or a bound where the curve ends.
struct Reading {
  enum class Kind { exact, at_most, at_least, none };
  Kind kind = Kind::none;
  double value = 0;
};

/// The curve of an engine: its points of which none is both slower and less accurate than another.
class WorkCurve {
 public:
  /// points: in any order; those without a finite positive time and error are left out.
  explicit WorkCurve(std::vector<WorkPoint> points);

  const std::vector<WorkPoint>& points() const { return points_; }  // ascending time, descending error

  /// Returns the error within a compute time. At most that of the slowest point beyond it; none before the
  /// fastest.
  Reading error_at(double time) const;

  /// Returns the time to an error. At most that of the fastest point for larger errors; at least that of the
  /// slowest point for errors that the engine did not reach. None for an empty curve.
  Reading time_to(double error) const;

 private:
  std::vector<WorkPoint> points_;
};

/// Error of position or rotation.
using ErrorColumn = double PeerError::*;

/// Returns the curve of an engine on a scene, by its native times; empty without any.
WorkCurve curve_of(const PeerResults& results, const std::string& scene, const std::string& engine,
                   ErrorColumn column);

/// The best native peer beside one of our integrators. Ratios are above 1 where ours is better.
struct BestPeer {
  std::string engine;
  Reading ratio;
};

struct WorkComparison {
  std::string scene, integrator;
  const char* quantity = "";
  std::optional<BestPeer> error_in_our_time;  // its error within the time of our step of 1 ms, over ours
  std::optional<BestPeer> error_in_its_time;  // its error at its step of 1 ms over ours within that time
  std::optional<BestPeer> time_to_our_error;  // its time to the error of our step of 1 ms, over ours
  std::optional<BestPeer> time_to_its_error;  // its time at a step of 1 ms over ours to that error
};

/// Returns the comparisons in which a peer is better by 5 % or more; empty if there is none.
std::string peers_better_in_equal_time(const PeerResults& results);

/// Writes the table of the report, and all comparisons as a result file.
void write_work(std::ostream& out, const PeerResults& results);
void write_work_csv(const std::filesystem::path& file, const PeerResults& results);

/// Compares both integrators with all native peers, on all scenes with native times.
std::vector<WorkComparison> compare_work(const PeerResults& results);

}  // namespace godobject::study
