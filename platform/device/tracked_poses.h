// What trackers tell of the bodies of a scene, ready for every step of the core: the samples of each tool, filtered where
// the scene asks for it, in the world, and played back without stairs (hal/tracker/pose_track.h).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/base/one_euro.h"
#include "hal/tracker/link.h"
#include "hal/tracker/pose_track.h"

namespace godobject {

/// The target of one body in this cycle.
struct TrackedPose {
  std::string body;    // name
  Target target;       // when not valid: the last one that was, at rest
  bool valid = false;  // the tool is seen, and its newest sample young enough
  bool seen = false;   // it has been valid
  ToolState state = ToolState::unseen;
  Nanoseconds age = 0;  // of the newest sample
};

class TrackedPoses {
 public:
  /// Allocates; nothing later does. The order of poses() is that of the trackers and their tools.
  explicit TrackedPoses(std::vector<std::unique_ptr<TrackerLink>> links);

  /// Once per cycle, before poses(). `now`: of the clock that the links' reports are in. motion_time: s, of a simulated
  /// hand.
  void update(Nanoseconds now, double motion_time = 0) noexcept;
  std::span<const TrackedPose> poses() const noexcept { return poses_; }

  /// Every tracker is tracking. A tool that is not seen does not count: it is not a fault.
  bool ready() const noexcept;
  std::size_t num_trackers() const noexcept { return links_.size(); }
  const TrackerParams& params(std::size_t i) const noexcept { return links_[i]->params(); }
  const TrackerReport& report(std::size_t i) const noexcept { return reports_[i]; }

 private:
  struct Tool {
    std::size_t tracker = 0, index = 0;  // in its reports
    Pose X_WT, X_TH;                     // of the tracker, and of the target on the tool
    OneEuro filter;
    PoseTrack track;
    std::uint32_t number = 0;  // of the sample that was taken last
    Nanoseconds t = 0;         // its time
  };

  void take(Tool& tool, const ToolSample& sample, Nanoseconds now) noexcept;

  std::vector<std::unique_ptr<TrackerLink>> links_;
  std::vector<TrackerReport> reports_;
  std::vector<Tool> tools_;
  std::vector<TrackedPose> poses_;
};

}  // namespace godobject
