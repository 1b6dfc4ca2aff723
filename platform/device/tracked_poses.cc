#include "platform/device/tracked_poses.h"

#include <algorithm>
#include <cmath>

#include "core/device/holding.h"

namespace godobject {

TrackedPoses::TrackedPoses(std::vector<std::unique_ptr<TrackerLink>> links)
    : links_(std::move(links)), reports_(links_.size()) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const TrackerParams& params = links_[i]->params();
    for (std::size_t k = 0; k < params.tools.size(); ++k) {
      tools_.push_back({.tracker = i,
                        .index = k,
                        .X_WT = params.X_WT,
                        .X_TH = params.tools[k].X_TH,
                        .filter = OneEuro({.min_cutoff_hz = params.min_cutoff_hz,
                                           .cutoff_slope_s_per_m = params.cutoff_slope_s_per_m}),
                        .track = PoseTrack(to_ns(params.stale_after_s))});
      poses_.push_back({.body = params.tools[k].body, .target = {}});
    }
  }
}

void TrackedPoses::update(Nanoseconds now, double motion_time) noexcept {
  for (const std::unique_ptr<TrackerLink>& link : links_) link->begin_cycle(now, motion_time);
  for (std::size_t i = 0; i < links_.size(); ++i) static_cast<void>(links_[i]->try_read(reports_[i], now));
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    Tool& tool = tools_[i];
    const ToolSample& sample = reports_[tool.tracker].tools[tool.index];
    if (sample.state == ToolState::valid && sample.number != tool.number) take(tool, sample, now);
    const PoseTrack::Played played = tool.track.at(now);
    TrackedPose& pose = poses_[i];
    pose.age = played.age;
    pose.valid = played.valid && sample.state == ToolState::valid;
    pose.state = played.valid || sample.state != ToolState::valid ? sample.state : ToolState::stale;
    if (pose.valid) {
      pose.target = played.target;
      pose.seen = true;
    } else {
      pose.target.V_WD = {};
    }
  }
}

void TrackedPoses::take(Tool& tool, const ToolSample& sample, Nanoseconds now) noexcept {
  const double dt = tool.number == 0 ? 0 : 1e-9 * static_cast<double>(sample.t_ns - tool.t);
  if (dt > links_[tool.tracker]->params().stale_after_s) tool.filter.reset();
  tool.number = sample.number;
  tool.t = sample.t_ns;
  const Pose X_WD = composed(tool.X_WT, composed(sample.X_TH, tool.X_TH));
  tool.track.push(tool.filter.filter(X_WD, dt), sample.t_ns, now);
}

bool TrackedPoses::ready() const noexcept {
  return std::ranges::all_of(
      reports_, [](const TrackerReport& report) { return report.state == TrackerState::tracking; });
}

}  // namespace godobject
