// Homing of a CiA 402 drive (mode 6): the drive finds its zero; the host starts and supervises it.
#pragma once

#include "hal/drive/cia402_modes.h"

namespace godobject::cia402 {

// 6098h, i8. Negative methods are vendor-specific (maxon -1..-4: hard stop).
inline constexpr std::int8_t homing_at_index_negative = 33;
inline constexpr std::int8_t homing_at_index_positive = 34;
inline constexpr std::int8_t homing_at_current_position = 37;  // method 35 in older issues of the standard

// Bits with this meaning in mode 6 only.
inline constexpr std::uint16_t control_start_homing = 1u << 4;
inline constexpr std::uint16_t status_target_reached = 1u << 10;
inline constexpr std::uint16_t status_homing_attained = 1u << 12;
inline constexpr std::uint16_t status_homing_error = 1u << 13;

enum class HomingState : std::uint8_t {
  in_progress,
  not_running,       // not started, or interrupted
  attained,          // homed, the drive still moves to its target
  complete,          // homed, the drive is at rest
  failed_in_motion,  // error, not yet at rest
  failed,            // error, at rest: see 603Fh, then restart
};

/// Decodes the statusword in mode 6, state Operation Enabled (CiA 402-2, homing mode: bits 13, 12, 10).
constexpr HomingState decode_homing(std::uint16_t statusword) noexcept {
  const bool reached = (statusword & status_target_reached) != 0;
  if ((statusword & status_homing_error) != 0)
    return reached ? HomingState::failed : HomingState::failed_in_motion;
  if ((statusword & status_homing_attained) != 0)
    return reached ? HomingState::complete : HomingState::attained;
  return reached ? HomingState::not_running : HomingState::in_progress;
}

/// Returns the statusword bits of a homing state, the inverse of decode_homing.
constexpr std::uint16_t encode_homing(HomingState state) noexcept {
  switch (state) {
    case HomingState::in_progress: break;
    case HomingState::not_running: return status_target_reached;
    case HomingState::attained: return status_homing_attained;
    case HomingState::complete: return status_homing_attained | status_target_reached;
    case HomingState::failed_in_motion: return status_homing_error;
    case HomingState::failed: return status_homing_error | status_target_reached;
  }
  return 0;
}

/// One homing, one step per cycle until finished(): statusword in, controlword out. Before the first step,
/// 6098h and 6099h must be written, and 6060h and 6061h be 6. The drive stays enabled afterwards; change its
/// mode only while it is disabled.
class Homing {
 public:
  /// timeout_ns: limit from the first step to the end, ns.
  explicit constexpr Homing(Nanoseconds timeout_ns) noexcept : timeout_ns_(timeout_ns) {}

  enum class Result : std::uint8_t { running, complete, failed, timed_out };

  constexpr std::uint16_t step(std::uint16_t statusword, Nanoseconds now) noexcept {
    if (!begun_) t_begin_ns_ = now;
    begun_ = true;
    const DriveState state = decode_state(statusword);
    if (result_ != Result::running) return controlword_ = finish(state);
    if (now - t_begin_ns_ > timeout_ns_) result_ = Result::timed_out;
    else if (started_ && state != DriveState::operation_enabled) result_ = Result::failed;
    else if (started_) watch(statusword);
    if (result_ != Result::running) return controlword_ = finish(state);
    if (state != DriveState::operation_enabled)
      return controlword_ = next_controlword(state, controlword_, true);
    // Sent without the start bit first, because the drive acts on its rising edge.
    const bool ready = controlword_ == enable_operation;
    started_ = started_ || ready;
    return controlword_ = started_ ? enable_operation | control_start_homing : enable_operation;
  }

  constexpr Result result() const noexcept { return result_; }
  constexpr bool finished() const noexcept { return result_ != Result::running; }

 private:
  // Evaluates the statusword once it refers to this homing: after in_progress was seen, or after
  // max_steps_without_progress. Earlier values may be of a previous homing.
  constexpr void watch(std::uint16_t statusword) noexcept {
    const HomingState state = decode_homing(statusword);
    if (state == HomingState::in_progress) seen_in_progress_ = true;
    const bool fresh = seen_in_progress_ || ++steps_since_start_ > max_steps_without_progress;
    if (!fresh) return;
    if (state == HomingState::complete) result_ = Result::complete;
    if (state == HomingState::failed) result_ = Result::failed;
  }

  static constexpr std::uint16_t finish(DriveState state) noexcept {
    return state == DriveState::operation_enabled ? enable_operation : disable_voltage;
  }

  static constexpr int max_steps_without_progress = 10;  // some drives finish before they report in_progress

  Nanoseconds timeout_ns_;
  Nanoseconds t_begin_ns_ = 0;
  bool begun_ = false;
  bool started_ = false;
  bool seen_in_progress_ = false;
  int steps_since_start_ = 0;
  std::uint16_t controlword_ = disable_voltage;
  Result result_ = Result::running;
};

}  // namespace godobject::cia402
