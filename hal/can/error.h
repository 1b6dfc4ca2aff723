// The error frames of Linux's CAN drivers (<linux/can/error.h>) as changes of a bus's state and counters.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "hal/can/bus.h"

namespace godobject {

/// What one error frame says. A restart is an error with the new state error_active; bus-off is a state only.
struct CanErrorReport {
  BusError error = BusError::none;  // the most telling one, when the frame names several
  std::optional<BusState> state;    // the controller's new state
  struct ErrorCounters {
    std::uint8_t transmit = 0;  // TEC
    std::uint8_t receive = 0;   // REC
  };
  std::optional<ErrorCounters> counters;
};

/// error_class: the identifier without CAN_ERR_FLAG; data: up to 8 bytes, missing ones count as 0. Any input
/// gives a report. Pure.
CanErrorReport decode_can_error(std::uint32_t error_class, std::span<const std::uint8_t> data) noexcept;

/// One report on top of what was known. A bus that is closed, down or gone stays so.
void apply(const CanErrorReport& report, BusState& state, BusCounters& counters) noexcept;

/// Values of <linux/can/error.h>, repeated because hal includes no header of an operating system.
namespace can_error {
inline constexpr std::uint32_t transmit_timeout = 0x1, lost_arbitration = 0x2, controller = 0x4,
                               protocol = 0x8, transceiver = 0x10, no_acknowledge = 0x20, bus_off = 0x40,
                               bus_error = 0x80, restarted = 0x100, error_counters = 0x200;
// data[1]
inline constexpr std::uint8_t receive_overflow = 0x01, transmit_overflow = 0x02, warning = 0x0C,
                              passive = 0x30, active = 0x40;
// data[2]; the location in data[3]
inline constexpr std::uint8_t bit = 0x01, form = 0x02, stuff = 0x04, bit_dominant = 0x08,
                              bit_recessive = 0x10;
inline constexpr std::uint8_t location_crc_sequence = 0x08, location_crc_delimiter = 0x18,
                              location_acknowledge = 0x19;
}  // namespace can_error

}  // namespace godobject
