#include "platform/device/trackers.h"

#include <algorithm>
#include <cmath>

#include "core/math/pose.h"

namespace godobject {
namespace {

/// Time for the last attempt, s, which may outlast the tracker's limit and reports the reason of the failure.
constexpr double last_try_s = 2;

}  // namespace

// ---- poses ----------------------------------------------------------------------------------------

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
  const Pose X_WD = tool.X_WT * (sample.X_TH * tool.X_TH);
  tool.track.push(tool.filter.filter(X_WD, dt), sample.t_ns, now);
}

bool TrackedPoses::ready() const noexcept {
  return std::ranges::all_of(
      reports_, [](const TrackerReport& report) { return report.state == TrackerState::tracking; });
}

// ---- device ---------------------------------------------------------------------------------------

TrackerDevice::TrackerDevice(const SceneConfig& scene, std::vector<std::unique_ptr<TrackerLink>> links,
                             LoopClock clock)
    : clock_(clock), poses_(std::move(links)) {
  const std::vector<std::size_t> driven = driven_bodies(scene);
  for (const TrackerParams& tracker : scene.device->trackers)
    for (const TrackedToolParams& tool : tracker.tools)
      bodies_.push_back(driven[driven_by_tool(scene, tool)]);
}

std::optional<double> TrackerDevice::boot_limit_s() const noexcept {
  double slowest_s = 0;
  for (std::size_t i = 0; i < poses_.num_trackers(); ++i)
    slowest_s = std::max(slowest_s, poses_.params(i).boot_timeout_s + last_try_s);
  return slowest_s;
}

void TrackerDevice::update(Period& period) noexcept {
  period.begin_by(clock_);
  poses_.update(period.now, period.t);
}

bool TrackerDevice::failed() const noexcept {
  for (std::size_t i = 0; i < poses_.num_trackers(); ++i)
    if (poses_.report(i).state == TrackerState::failed) return true;
  return false;
}

/// Writes the poses into the samples. A body with a tool that was never visible is not engaged.
void TrackerDevice::read(Period& period, std::span<BodySample> samples) noexcept {
  update(period);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const TrackedPose& pose = poses_.poses()[i];
    BodySample& sample = samples[bodies_[i]];
    sample.target = pose.target;
    sample.valid = pose.valid;
    sample.engaged = sample.engaged && pose.seen;
  }
}

}  // namespace godobject
