// Far ends of a scene's trackers: moves their tools with the hand and injects their faults.
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

/// Measurements per second of a simulated tracker: as a Polaris (60 Hz) and a Fastrak with one station (120
/// Hz).
constexpr double simulated_rate_hz(TrackerProtocol protocol) noexcept {
  return protocol == TrackerProtocol::polhemus ? 120 : 60;
}

struct SimTrackersConfig {
  std::vector<TrackerParams> trackers;
  std::vector<FaultConfig> faults;                // entries that name no tracker are ignored
  std::vector<std::vector<std::size_t>> targets;  // target of the hand for each tool of each tracker
};

class SimTrackers {
 public:
  /// Maximum number of simultaneously active or waiting faults, besides those of the config.
  static constexpr std::size_t capacity = 64;

  struct Active {
    SimTrackerFault fault;
    std::optional<Nanoseconds> t_end_ns;  // none: until the end
  };

  /// far: one per tracker, in their order; they outlive this. Allocates; no other function does.
  SimTrackers(const SimTrackersConfig& config, std::shared_ptr<const Hand> hand,
              std::vector<SimTracker*> far);

  /// Moves the tools to their poses at motion_time, begins and ends faults. Call it at least once per
  /// measurement, before the trackers' advance(now).
  void run(Nanoseconds now, double motion_time) noexcept;

  /// Schedules a fault from the next run() on whose motion time has reached its `at`. Returns false if full.
  [[nodiscard]] bool schedule(const SimTrackerFault& fault) noexcept;
  /// Ends all active faults and drops all waiting ones.
  void clear() noexcept;
  std::span<const Active> active() const noexcept { return active_; }
  std::uint64_t begun() const noexcept { return begun_; }

 private:
  void play_faults(Nanoseconds now, double motion_time) noexcept;
  SimTrackerFaults faults_of(std::size_t tracker) const noexcept;
  void apply() noexcept;

  struct Tool {
    std::size_t tracker, index;
    std::size_t target;  // target of the hand
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
