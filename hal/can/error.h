// Decodes error frames of Linux CAN drivers (<linux/can/error.h>) into changes of bus state and counters.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "hal/can/bus.h"

namespace godobject {

/// Content of an error frame. A restart is an error with new state error_active; bus-off is a state only.
struct CanErrorReport {
  BusError error = BusError::none;  // the most specific error, if the frame names several
  std::optional<BusState> state;    // new state of the controller
  struct ErrorCounters {
    std::uint8_t transmit = 0;  // TEC
    std::uint8_t receive = 0;   // REC
  };
  std::optional<ErrorCounters> counters;
};

/// Decodes an error frame; accepts any input. Pure. error_class: identifier without CAN_ERR_FLAG. data: up to
/// 8 bytes; missing bytes count as 0.
CanErrorReport decode_can_error(std::uint32_t error_class, std::span<const std::uint8_t> data) noexcept;

/// Applies a report to state and counters. A bus that is closed, down or gone keeps its state.
void apply(const CanErrorReport& report, BusState& state, BusCounters& counters) noexcept;

/// Copies of constants of <linux/can/error.h>, because this layer includes no OS headers.
namespace can_error {
inline constexpr std::uint32_t transmit_timeout = 0x1, lost_arbitration = 0x2, controller = 0x4,
                               protocol = 0x8, transceiver = 0x10, no_acknowledge = 0x20, bus_off = 0x40,
                               bus_error = 0x80, restarted = 0x100, error_counters = 0x200;
// data[1]
inline constexpr std::uint8_t receive_overflow = 0x01, transmit_overflow = 0x02, warning = 0x0C,
                              passive = 0x30, active = 0x40;
// data[2]; location in data[3]
inline constexpr std::uint8_t bit = 0x01, form = 0x02, stuff = 0x04, bit_dominant = 0x08,
                              bit_recessive = 0x10;
inline constexpr std::uint8_t location_crc_sequence = 0x08, location_crc_delimiter = 0x18,
                              location_acknowledge = 0x19;
}  // namespace can_error

}  // namespace godobject
