// The far ends of a scene's trackers: their tools are moved by the scene's motion, their faults played.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/fault/target.h"
#include "platform/session/motion.h"
#include "sim/tracker/tracker.h"

namespace godobject {

/// Measurements per second of a simulated tracker: those of a Polaris (60 Hz) and a Fastrak with one station (120 Hz).
constexpr double simulated_rate_hz(TrackerProtocol protocol) noexcept {
  return protocol == TrackerProtocol::ndi ? 60 : 120;
}

/// Which of the motion's targets a tool is: index in driven_bodies().
std::size_t driven_by_tool(const SceneConfig& scene, const TrackedToolParams& tool);

class SimTrackers {
 public:
  /// Faults that are active or wait at the same time, besides those of the scene.
  static constexpr std::size_t capacity = 64;

  struct Active {
    SimTrackerFault fault;
    std::optional<Nanoseconds> t_end_ns;  // none: to the end
  };

  /// far: one per tracker of the scene's device, in its order. All of it outlives this. Allocates; nothing later does.
  SimTrackers(const SceneConfig& scene, const Motion& motion, std::vector<SimTracker*> far);

  /// Moves the tools to where they are at motion_time, begins and ends faults. At least once per measurement, before
  /// the trackers' advance(now).
  void run(Nanoseconds now, double motion_time) noexcept;

  /// From the next run() on, in which its motion time has come. False when full.
  [[nodiscard]] bool schedule(const SimTrackerFault& fault) noexcept;
  /// Ends all that is active and forgets all that waits.
  void clear() noexcept;
  std::span<const Active> active() const noexcept { return active_; }
  std::uint64_t begun() const noexcept { return begun_; }

 private:
  void play_faults(Nanoseconds now, double motion_time) noexcept;
  SimTrackerFaults faults_of(std::size_t tracker) const noexcept;
  void apply() noexcept;

  struct Tool {
    std::size_t tracker, index;
    std::size_t target;  // of the motion
  };

  std::vector<TrackerParams> params_;
  const Motion& motion_;
  std::vector<SimTracker*> far_;
  std::vector<Tool> tools_;
  std::vector<SimTrackerFault> waiting_;
  std::vector<Active> active_;
  std::uint64_t begun_ = 0;
};

}  // namespace godobject
