// Trackers as the device: each tool's tracked pose is a target. The samples of each tool are filtered if the
// scene requires it, transformed to the world and interpolated (hal/tracker/pose_track.h).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/base/one_euro.h"
#include "hal/tracker/link.h"
#include "hal/tracker/pose_track.h"
#include "platform/device/hand_device.h"

namespace godobject {

/// Target of one body in this cycle.
struct TrackedPose {
  std::string body;    // name
  Target target;       // while invalid: the last valid one, at rest
  bool valid = false;  // true if the tool is visible and its newest sample is young enough
  bool seen = false;   // true once it was valid
  ToolState state = ToolState::unseen;
  Nanoseconds age = 0;  // age of the newest sample, ns
};

class TrackedPoses {
 public:
  /// Allocates; the other functions do not. poses() are in the order of the trackers and their tools.
  explicit TrackedPoses(std::vector<std::unique_ptr<TrackerLink>> links);

  /// Updates all poses; to be called once per cycle, before poses().
  /// now: time on the clock of the links' reports, ns. motion_time: time of a simulated hand, s.
  void update(Nanoseconds now, double motion_time = 0) noexcept;
  std::span<const TrackedPose> poses() const noexcept { return poses_; }

  /// True if every tracker is tracking. An invisible tool does not matter, because it is no fault.
  bool ready() const noexcept;
  std::size_t num_trackers() const noexcept { return links_.size(); }
  const TrackerParams& params(std::size_t i) const noexcept { return links_[i]->params(); }
  const TrackerReport& report(std::size_t i) const noexcept { return reports_[i]; }

 private:
  struct Tool {
    std::size_t tracker = 0, index = 0;  // tracker, and index of the tool in its reports
    Pose X_WT, X_TH;                     // poses of the tracker, and of the target on the tool
    OneEuro filter;
    PoseTrack track;
    std::uint32_t number = 0;  // number of the last sample that was used
    Nanoseconds t = 0;         // its time
  };

  void take(Tool& tool, const ToolSample& sample, Nanoseconds now) noexcept;

  std::vector<std::unique_ptr<TrackerLink>> links_;
  std::vector<TrackerReport> reports_;
  std::vector<Tool> tools_;
  std::vector<TrackedPose> poses_;
};

class TrackerDevice final : public HandDevice {
 public:
  /// Allocates; the other functions do not. links: one for each tracker of the scene's device, in their
  /// order.
  /// clock: clock of the links, used if no rig sets the time; null: one step per period.
  TrackerDevice(const SceneConfig& scene, std::vector<std::unique_ptr<TrackerLink>> links, LoopClock clock);

  std::optional<double> boot_limit_s() const noexcept override;
  void boot(Period& period) noexcept override { update(period); }
  bool ready() const noexcept override { return poses_.ready(); }
  bool failed() const noexcept override;
  void read(Period& period, std::span<BodySample> samples) noexcept override;

  const TrackedPoses& poses() const noexcept { return poses_; }

 private:
  void update(Period& period) noexcept;

  std::vector<std::size_t> bodies_;  // one per pose
  LoopClock clock_;
  TrackedPoses poses_;
};

}  // namespace godobject
