// The far ends of a scene's trackers: their tools are moved by the hand, their faults played.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/rig/simulation.h"
#include "sim/fault/target.h"
#include "sim/hand.h"
#include "sim/tracker/tracker.h"

namespace godobject {

/// Measurements per second of a simulated tracker: those of a Polaris (60 Hz) and a Fastrak with one station (120 Hz).
constexpr double simulated_rate_hz(TrackerProtocol protocol) noexcept {
  return protocol == TrackerProtocol::ndi ? 60 : 120;
}

struct SimTrackersConfig {
  std::vector<TrackerParams> trackers;
  std::vector<FaultConfig> faults;                // those that name no tracker are not for trackers
  std::vector<std::vector<std::size_t>> targets;  // of the hand: what each tool of each tracker is
};

class SimTrackers {
 public:
  /// Faults that are active or wait at the same time, besides those of the config.
  static constexpr std::size_t capacity = 64;

  struct Active {
    SimTrackerFault fault;
    std::optional<Nanoseconds> t_end_ns;  // none: to the end
  };

  /// far: one per tracker, in their order; they outlive this. Allocates; nothing later does.
  SimTrackers(const SimTrackersConfig& config, std::shared_ptr<const Hand> hand,
              std::vector<SimTracker*> far);

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
    std::size_t target;  // of the hand
  };

  std::vector<TrackerParams> params_;
  std::shared_ptr<const Hand> hand_;
  std::vector<SimTracker*> far_;
  std::vector<Tool> tools_;
  std::vector<SimTrackerFault> waiting_;
  std::vector<Active> active_;
  std::uint64_t begun_ = 0;
};

}  // namespace godobject
