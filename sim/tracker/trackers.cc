#include "sim/tracker/trackers.h"

#include <algorithm>

#include "sim/tracker/link.h"

namespace godobject {

SimTrackers::SimTrackers(const SimTrackersConfig& config, std::shared_ptr<const Hand> hand,
                         std::vector<SimTracker*> far)
    : params_(config.trackers), hand_(std::move(hand)), far_(std::move(far)) {
  for (std::size_t i = 0; i < params_.size(); ++i)
    for (std::size_t k = 0; k < params_[i].tools.size(); ++k)
      tools_.push_back({.tracker = i, .index = k, .target = config.targets[i][k]});
  for (const FaultConfig& fault : config.faults)
    if (const TrackerFaultResult found = resolve(fault, params_); found.fault)
      waiting_.push_back(*found.fault);
  active_.reserve(waiting_.size() + capacity);
  waiting_.reserve(waiting_.size() + capacity);
}

void SimTrackers::run(Nanoseconds now, double motion_time) noexcept {
  play_faults(now, motion_time);
  for (const Tool& tool : tools_) {
    const Pose X_WD = hand_->target(tool.target, motion_time).X_WD;
    far_[tool.tracker]->set_pose(tool.index, tool_pose_for(params_[tool.tracker], tool.index, X_WD));
  }
}

bool SimTrackers::schedule(const SimTrackerFault& fault) noexcept {
  if (waiting_.size() + active_.size() >= active_.capacity() || waiting_.size() == waiting_.capacity())
    return false;
  waiting_.push_back(fault);
  return true;
}

void SimTrackers::clear() noexcept {
  waiting_.clear();
  active_.clear();
  apply();
}

void SimTrackers::play_faults(Nanoseconds now, double motion_time) noexcept {
  const std::size_t ended = std::erase_if(
      active_, [&](const Active& active) { return active.t_end_ns && *active.t_end_ns <= now; });
  const std::size_t begun = std::erase_if(waiting_, [&](const SimTrackerFault& fault) {
    if (fault.at > motion_time) return false;
    active_.push_back({.fault = fault, .t_end_ns = std::nullopt});
    if (fault.duration_ns) active_.back().t_end_ns = now + *fault.duration_ns;
    return true;
  });
  begun_ += begun;
  if (ended + begun > 0) apply();
}

void SimTrackers::apply() noexcept {
  for (std::size_t i = 0; i < far_.size(); ++i) far_[i]->faults = faults_of(i);
}

SimTrackerFaults SimTrackers::faults_of(std::size_t tracker) const noexcept {
  SimTrackerFaults faults;
  for (const Active& active : active_) {
    const SimTrackerFault& fault = active.fault;
    if (fault.tracker != tracker) continue;
    switch (fault.verb) {
      case FaultVerb::missing: faults.missing[fault.tool] = true; break;
      case FaultVerb::disabled: faults.disabled[fault.tool] = true; break;
      case FaultVerb::drop: faults.drop_probability = fault.value; break;
      case FaultVerb::corrupt: faults.corrupt_probability = fault.value; break;
      case FaultVerb::delay: faults.delay = static_cast<Nanoseconds>(1e9 * fault.value); break;
      case FaultVerb::unplug: faults.silent = true; break;
      default: break;  // resolve() accepts no other verb for a tracker
    }
  }
  return faults;
}

}  // namespace godobject
