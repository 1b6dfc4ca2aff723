// Error counters of one CAN node and the resulting states (ISO 11898-1, fault confinement).
#pragma once

#include <algorithm>

#include "hal/can/bus.h"

namespace godobject {

class FaultConfinement {
 public:
  /// Counts an error as transmitter: TEC + 8.
  void transmit_failed() noexcept { transmit_errors_ = static_cast<std::uint16_t>(transmit_errors_ + 8); }
  /// Counts a transmitted frame: TEC - 1, not below 0.
  void transmitted() noexcept {
    if (transmit_errors_ > 0) --transmit_errors_;
  }
  /// Counts an error as receiver: REC + 1. The register has eight bits.
  void receive_failed() noexcept {
    if (receive_errors_ < 255) ++receive_errors_;
  }
  /// Counts a received frame: REC - 1, not below 0; from above 127 to 127 (the standard permits 119..127).
  void received() noexcept {
    if (receive_errors_ > 127) receive_errors_ = 127;
    else if (receive_errors_ > 0) --receive_errors_;
  }
  void reset() noexcept { transmit_errors_ = receive_errors_ = 0; }
  /// Enters bus-off at once, as a controller that detects its own failure.
  void give_up() noexcept { transmit_errors_ = 256; }

  std::uint16_t transmit_errors() const noexcept { return transmit_errors_; }
  std::uint16_t receive_errors() const noexcept { return receive_errors_; }

  /// Returns error_active, error_warning, error_passive or bus_off.
  BusState state() const noexcept {
    if (transmit_errors_ > 255) return BusState::bus_off;
    const std::uint16_t worse = std::max(transmit_errors_, receive_errors_);
    if (worse > 127) return BusState::error_passive;
    return worse >= 96 ? BusState::error_warning : BusState::error_active;
  }
  bool is_bus_off() const noexcept { return state() == BusState::bus_off; }
  bool is_passive() const noexcept { return state() == BusState::error_passive; }

 private:
  std::uint16_t transmit_errors_ = 0;  // TEC
  std::uint16_t receive_errors_ = 0;   // REC
};

}  // namespace godobject
