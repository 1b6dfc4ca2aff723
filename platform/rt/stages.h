// Stages of a cycle, and the watch that measures the time spent in each.
#pragma once

#include <array>
#include <cstdint>
#include <numeric>
#include <string_view>
#include <utility>

#include "core/nonblocking.h"
#include "hal/can/frame.h"

namespace godobject {

/// Clock of devices and stages, called in the loop.
using LoopClock = Nanoseconds (*)() noexcept GODOBJECT_NONBLOCKING;

enum class Stage : std::uint8_t {
  wait,     // for the answers of the device; a simulated device is computed in this stage
  receive,  // frames from the buses
  decode,   // frames to samples of the bodies, supervised and checked
  step,     // the engine's step alone
  limit,    // wrenches to display
  encode,   // wrenches to limited torques and their frames
  send,     // frames to the buses, SYNC included
  observe,  // record, statistics and views
};
inline constexpr std::array<std::string_view, 8> stage_names{"wait",  "receive", "decode", "step",
                                                             "limit", "encode",  "send",   "observe"};
using StageTimes = std::array<Nanoseconds, stage_names.size()>;

/// Returns the time of all stages but the wait for the device.
inline Nanoseconds compute_time(const StageTimes& times) noexcept {
  return std::accumulate(times.begin(), times.end(), -times[static_cast<std::size_t>(Stage::wait)]);
}

/// Measures the times of the stages of one cycle. Each change of the stage reads the clock once. Real-time.
class StageWatch {
 public:
  /// Sets the clock. Without one all times are 0.
  void set_clock(LoopClock now) noexcept { clock_ = now; }
  /// Starts a cycle in this stage.
  void start(Stage stage) noexcept {
    times_ = {};
    stage_ = stage;
    since_ = clock_();
  }
  /// Ends the present stage and enters another. Returns the stage that ended.
  Stage enter(Stage stage) noexcept {
    const Nanoseconds now = clock_();
    times_[static_cast<std::size_t>(stage_)] += now - since_;
    since_ = now;
    return std::exchange(stage_, stage);
  }
  /// Returns the time of a stage that has ended.
  Nanoseconds spent(Stage stage) const noexcept { return times_[static_cast<std::size_t>(stage)]; }
  /// Ends the present stage. Returns the times of all.
  const StageTimes& stop() noexcept {
    static_cast<void>(enter(stage_));
    return times_;
  }

 private:
  LoopClock clock_ = []() noexcept GODOBJECT_NONBLOCKING { return Nanoseconds{0}; };
  StageTimes times_{};
  Stage stage_ = Stage::wait;
  Nanoseconds since_ = 0;
};

/// Enters a stage until the end of its scope, then the stage before again.
class InStage {
 public:
  InStage(StageWatch& watch, Stage stage) noexcept : watch_(watch), before_(watch.enter(stage)) {}
  ~InStage() { static_cast<void>(watch_.enter(before_)); }
  InStage(const InStage&) = delete;
  InStage& operator=(const InStage&) = delete;

 private:
  StageWatch& watch_;
  Stage before_;
};

}  // namespace godobject
