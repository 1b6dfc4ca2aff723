// A CAN bus as the rest of the system sees it. A backend is one file that implements this class.
//
// The room: frame.h, error.h and timing.h of CAN itself, filter.h and transmit_slots.h for what comes in and goes out,
// candump.h and slcan.h, its texts. Which protocol is spoken on it is in canopen/ and drive/.
#pragma once

#include <string_view>

#include "hal/can/frame.h"

namespace godobject {

enum class BusState : std::uint8_t {
  closed,
  error_active,   // normal: both error counters below 96
  error_warning,  // a counter at 96 or more
  error_passive,  // a counter above 127
  bus_off,        // transmit error counter above 255: sends nothing until it has recovered
  down,           // the interface is down; it is used again by itself once it is up
  gone,           // unplugged or removed: close(), and open() once it is back
};

/// Whether nothing can be sent or received in this state.
constexpr bool is_cut_off(BusState state) noexcept {
  return state == BusState::closed || state >= BusState::bus_off;
}

/// What a controller last complained about.
enum class BusError : std::uint8_t {
  none,
  acknowledge,  // nobody acknowledged a frame: no other node, or none at this bit rate
  bit,          // read back another bit than it sent
  stuff,        // six equal bits in a row
  form,         // a fixed bit was wrong
  crc,
  lost_arbitration,  // no fault by itself
  receive_overflow,  // the controller's own buffer was full
  transmit_overflow,
  transmit_timeout,  // the driver gave the controller up for stuck
  transceiver,       // a short or a broken wire
  restarted,         // no fault by itself: back from bus-off
  other,
};

/// name_of: as in logs; text_of: what it means and what to do.
std::string_view name_of(BusState state) noexcept;
std::string_view name_of(BusError error) noexcept;
std::string_view text_of(BusError error) noexcept;

enum class SendResult : std::uint8_t {
  queued,   // accepted; it leaves when it wins arbitration
  full,     // no room in the transmit queue: the frame is NOT queued
  off,      // bus-off: the frame is NOT queued
  down,     // closed, interface down or gone: the frame is NOT queued
  invalid,  // identifier or size out of range: the frame is NOT queued
};

struct BusCounters {
  std::uint64_t sent = 0;          // own frames seen completed on the wire
  std::uint64_t received = 0;      // frames handed to the receiver
  std::uint64_t send_refused = 0;  // try_send calls not answered with queued
  std::uint64_t send_dropped = 0;  // answered with queued, but replaced or expired before they could leave
  std::uint64_t receive_overflow = 0;  // frames lost because the receive queue was full
  std::uint64_t error_frames = 0;
  std::uint64_t bus_off_events = 0;
  std::uint64_t restarts = 0;                // returns from bus-off
  BusError last_error = BusError::none;      // stays until the next one
  std::uint16_t transmit_error_counter = 0;  // TEC
  std::uint16_t receive_error_counter = 0;   // REC
};

/// All calls return at once: none of them waits, allocates or throws. One thread at a time.
class CanBus {
 public:
  virtual ~CanBus() = default;

  [[nodiscard]] virtual bool open() noexcept = 0;
  virtual void close() noexcept = 0;
  [[nodiscard]] virtual SendResult try_send(const CanFrame& frame) noexcept = 0;
  /// The oldest frame not yet read; false when there is none. Own frames are not returned.
  [[nodiscard]] virtual bool try_receive(ReceivedFrame& out) noexcept = 0;
  virtual BusState state() const noexcept = 0;
  virtual BusCounters counters() const noexcept = 0;
  /// False for a log: its nodes answered another host, so leaving out a SYNC has no effect.
  virtual bool is_live() const noexcept { return true; }
};

}  // namespace godobject
