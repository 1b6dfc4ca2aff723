// A tracker and its simulated far end in one process: the loop reads it as it reads one on a serial line. Time passes
// when it is read.
#pragma once

#include <memory>

#include "hal/tracker/link.h"
#include "sim/tracker/tracker.h"

namespace godobject {

class SimTrackerLink final : public TrackerLink {
 public:
  SimTrackerLink(std::unique_ptr<Tracker> tracker, std::unique_ptr<SimTracker> far)
      : tracker_(std::move(tracker)), far_(std::move(far)) {}

  [[nodiscard]] bool try_read(TrackerReport& out, Nanoseconds now) noexcept override;
  const TrackerParams& params() const noexcept override { return tracker_->params(); }
  /// Poses are set and faults are made here.
  SimTracker& far() noexcept { return *far_; }

 private:
  std::unique_ptr<Tracker> tracker_;
  std::unique_ptr<SimTracker> far_;
  bool opened_ = false;
};

/// The scene's tracker with a far end that measures at this rate; null with errors. A tool's definition file is not
/// read: any will do for the simulated one.
std::unique_ptr<SimTrackerLink> make_sim_tracker_link(const TrackerParams& params, double rate_hz,
                                                      std::uint64_t seed, std::vector<std::string>& errors);

/// The tool's pose in the tracker's frame that puts its target there: what the far end is to measure.
Pose tool_pose_for(const TrackerParams& params, std::size_t tool, const Pose& X_WD) noexcept;

}  // namespace godobject
