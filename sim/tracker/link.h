// A tracker and its simulated far end in one process, with the interface of one on a serial line. Time
// advances when it is read.
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
  /// Returns the far end, where poses and faults are set.
  SimTracker& far() noexcept { return *far_; }

 private:
  std::unique_ptr<Tracker> tracker_;
  std::unique_ptr<SimTracker> far_;
  bool opened_ = false;
};

/// Makes the scene's tracker with a simulated far end; null with errors. rate_hz: measurements per second.
/// Tool definition files are not read, because the simulated tracker accepts any.
std::unique_ptr<SimTrackerLink> make_sim_tracker_link(const TrackerParams& params, double rate_hz,
                                                      std::uint64_t seed, std::vector<std::string>& errors);

/// Returns the tool pose in the tracker's frame for which its target is at X_WD; input of the far end.
Pose tool_pose_for(const TrackerParams& params, std::size_t tool, const Pose& X_WD) noexcept;

}  // namespace godobject
