// Homing of one drive (CiA 402 mode 6), begun and watched by SDO.
#pragma once

#include <atomic>
#include <optional>

#include "hal/drive/cia402_homing.h"
#include "platform/cli/drive/dialogue.h"

namespace godobject {

struct HomeOptions {
  int method = cia402::homing_at_current_position;  // 6098h
  std::optional<std::uint32_t> switch_speed;        // counts/s, 6099h:01; none: as the drive has it
  std::optional<std::uint32_t> zero_speed;          // counts/s, 6099h:02
  std::optional<std::uint32_t> acceleration;        // counts/s^2, 609Ah
  std::optional<std::int32_t> offset;               // counts, 607Ch: the position at home
  double within = 30;                               // s
};

/// A method that takes the position where it stands: nothing moves.
constexpr bool stands_still(int method) noexcept {
  constexpr int older_current_position = 35;
  return method == cia402::homing_at_current_position || method == older_current_position;
}

/// From power off by way of the homing to power off; prints where the drive then is. Ends early, with power off,
/// when `stop` is set and when anything goes wrong; reports that to stderr.
ExitCode home_drive(DriveDialogue& drive, const HomeOptions& options, const std::atomic<bool>& stop);

}  // namespace godobject
