#include "hal/can/error.h"

namespace godobject {
namespace {

using namespace can_error;

std::optional<BusState> state_of(std::uint32_t error_class, std::uint8_t status) noexcept {
  if ((error_class & bus_off) != 0) return BusState::bus_off;
  if ((error_class & restarted) != 0) return BusState::error_active;
  if ((error_class & controller) == 0) return std::nullopt;
  // Returns the worse state of both directions. The kernel sets the bits of both if they are equal.
  if ((status & passive) != 0) return BusState::error_passive;
  if ((status & warning) != 0) return BusState::error_warning;
  if ((status & active) != 0) return BusState::error_active;
  return std::nullopt;
}

/// Returns the protocol violation. Some controllers report no location, others the location only.
BusError protocol_error(std::uint8_t type, std::uint8_t location) noexcept {
  if (location == location_crc_sequence || location == location_crc_delimiter) return BusError::crc;
  if (location == location_acknowledge) return BusError::acknowledge;
  if ((type & (bit | bit_dominant | bit_recessive)) != 0) return BusError::bit;
  if ((type & stuff) != 0) return BusError::stuff;
  if ((type & form) != 0) return BusError::form;
  return BusError::other;
}

/// Returns the error to report. slcan sets the protocol flag in each report, also without a named violation.
BusError error_of(std::uint32_t error_class, std::uint8_t status, std::uint8_t type,
                  std::uint8_t location) noexcept {
  const auto has = [error_class](std::uint32_t flag) { return (error_class & flag) != 0; };
  if (has(restarted)) return BusError::restarted;
  if (has(no_acknowledge)) return BusError::acknowledge;
  const BusError violation = has(protocol) ? protocol_error(type, location) : BusError::none;
  if (violation != BusError::none && violation != BusError::other) return violation;
  if (has(controller) && (status & receive_overflow) != 0) return BusError::receive_overflow;
  if (has(controller) && (status & transmit_overflow) != 0) return BusError::transmit_overflow;
  if (has(transmit_timeout)) return BusError::transmit_timeout;
  if (has(transceiver)) return BusError::transceiver;
  if (has(lost_arbitration)) return BusError::lost_arbitration;
  return has(bus_error | protocol) ? BusError::other : BusError::none;
}

}  // namespace

CanErrorReport decode_can_error(std::uint32_t error_class, std::span<const std::uint8_t> data) noexcept {
  const auto at = [data](std::size_t i) { return i < data.size() ? data[i] : std::uint8_t{0}; };
  CanErrorReport report{.error = error_of(error_class, at(1), at(2), at(3)),
                        .state = state_of(error_class, at(1)),
                        .counters = std::nullopt};
  if ((error_class & error_counters) != 0) report.counters = {.transmit = at(6), .receive = at(7)};
  return report;
}

void apply(const CanErrorReport& report, BusState& state, BusCounters& counters) noexcept {
  ++counters.error_frames;
  if (report.error != BusError::none) counters.last_error = report.error;
  if (report.error == BusError::restarted) ++counters.restarts;
  if (report.error == BusError::receive_overflow) ++counters.receive_overflow;  // at least one
  if (report.state == BusState::bus_off && state != BusState::bus_off) ++counters.bus_off_events;
  if (report.counters) {
    counters.transmit_error_counter = report.counters->transmit;
    counters.receive_error_counter = report.counters->receive;
  }
  const bool present = state != BusState::closed && state != BusState::down && state != BusState::gone;
  if (present && report.state) state = *report.state;
}

}  // namespace godobject
