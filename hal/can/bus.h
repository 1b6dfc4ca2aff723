// CAN bus interface. A backend is one file that implements this class.
#pragma once

#include <string_view>

#include "core/nonblocking.h"
#include "hal/can/frame.h"

namespace godobject {

enum class BusState : std::uint8_t {
  closed,
  error_active,   // normal: both error counters below 96
  error_warning,  // a counter at 96 or more
  error_passive,  // a counter above 127
  bus_off,        // transmit error counter above 255: sends nothing until it recovers
  down,           // the interface is down; used again automatically once it is up
  gone,           // unplugged or removed: close(), then open() once it is back
};

/// True if nothing can be sent or received in this state.
constexpr bool is_cut_off(BusState state) noexcept {
  return state == BusState::closed || state >= BusState::bus_off;
}

/// Last error reported by a controller.
enum class BusError : std::uint8_t {
  none,
  acknowledge,  // no node acknowledged a frame: no other node, or none at this bit rate
  bit,          // read back another bit than it sent
  stuff,        // six equal bits in a row
  form,         // a fixed bit was wrong
  crc,
  lost_arbitration,  // not a fault
  receive_overflow,  // the controller's receive buffer was full
  transmit_overflow,
  transmit_timeout,  // the driver declared the controller stuck
  transceiver,       // short circuit or broken wire
  restarted,         // not a fault: returned from bus-off
  other,
};

/// name_of: name for logs. text_of: meaning and remedy.
std::string_view name_of(BusState state) noexcept;
std::string_view name_of(BusError error) noexcept;
std::string_view text_of(BusError error) noexcept;

enum class SendResult : std::uint8_t {
  queued,   // accepted; sent when it wins arbitration
  full,     // the transmit queue is full: the frame is NOT queued
  off,      // bus-off: the frame is NOT queued
  down,     // closed, interface down or gone: the frame is NOT queued
  invalid,  // identifier or size out of range: the frame is NOT queued
};

struct BusCounters {
  std::uint64_t sent = 0;              // own frames completed on the wire
  std::uint64_t received = 0;          // frames passed to the receiver
  std::uint64_t send_refused = 0;      // try_send calls with another result than queued
  std::uint64_t send_dropped = 0;      // frames queued, then replaced or expired before they were sent
  std::uint64_t receive_overflow = 0;  // frames lost because the receive queue was full
  std::uint64_t error_frames = 0;
  std::uint64_t bus_off_events = 0;
  std::uint64_t restarts = 0;                // returns from bus-off
  BusError last_error = BusError::none;      // last error; never reset to none
  std::uint16_t transmit_error_counter = 0;  // TEC
  std::uint16_t receive_error_counter = 0;   // REC
};

/// Non-blocking: no call waits, allocates or throws. For one thread at a time.
class CanBus {
 public:
  virtual ~CanBus() = default;

  [[nodiscard]] virtual bool open() noexcept = 0;
  virtual void close() noexcept = 0;
  [[nodiscard]] virtual SendResult try_send(const CanFrame& frame) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Returns the oldest unread frame; false if there is none. Own frames are not returned.
  [[nodiscard]] virtual bool try_receive(ReceivedFrame& out) noexcept GODOBJECT_NONBLOCKING = 0;
  virtual BusState state() const noexcept GODOBJECT_NONBLOCKING = 0;
  virtual BusCounters counters() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// False for a log: its nodes answered another host, so leaving out a SYNC has no effect.
  virtual bool is_live() const noexcept GODOBJECT_NONBLOCKING { return true; }
};

}  // namespace godobject
