#include "platform/device/trackers.h"

#include <algorithm>

namespace godobject {
namespace {

/// Time for the last attempt, s, which may outlast the tracker's limit and reports the reason of the failure.
constexpr double last_try_s = 2;

}  // namespace

TrackerDevice::TrackerDevice(const SceneConfig& scene, std::vector<std::unique_ptr<TrackerLink>> links,
                             Nanoseconds (*clock)() noexcept)
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
