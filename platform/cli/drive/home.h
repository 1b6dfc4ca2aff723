// Homing of one drive (CiA 402 mode 6), started and supervised by SDO.
#pragma once

#include <atomic>
#include <optional>

#include "hal/drive/cia402_homing.h"
#include "platform/cli/drive/dialogue.h"

namespace godobject {

struct HomeOptions {
  int method = cia402::homing_at_current_position;  // 6098h
  std::optional<std::uint32_t> switch_speed;        // counts/s, 6099h:01; none: unchanged
  std::optional<std::uint32_t> zero_speed;          // counts/s, 6099h:02
  std::optional<std::uint32_t> acceleration;        // counts/s^2, 609Ah
  std::optional<std::int32_t> offset;               // counts, 607Ch: the position at home
  double within = 30;                               // s
};

/// True if the method takes the present position as home, so that nothing moves.
constexpr bool stands_still(int method) noexcept {
  constexpr int older_current_position = 35;
  return method == cia402::homing_at_current_position || method == older_current_position;
}

/// Powers the drive, homes it and turns it off; prints the position. Ends early if `stop` is set or an error
/// occurs, which it prints to stderr.
ExitCode home_drive(DriveDialogue& drive, const HomeOptions& options, const std::atomic<bool>& stop);

}  // namespace godobject
