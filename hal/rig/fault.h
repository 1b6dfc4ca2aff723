// Faults of a rig: bits, names and texts for the user.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/base/codec.h"
#include "hal/base/nanoseconds.h"
#include "hal/rig/supervisor.h"

namespace godobject {

/// Sticky bits; several can be set. rig_fault_texts() has meaning and remedy of each.
enum class RigFault : std::uint32_t {
  none = 0,
  boot_timeout = 1u << 0,
  heartbeat_lost = 1u << 1,
  node_restarted = 1u << 2,
  emergency = 1u << 3,
  sample_stale = 1u << 4,
  sample_implausible = 1u << 5,
  drive_silent = 1u << 6,
  drive_not_enabled = 1u << 7,
  bus_down = 1u << 8,
  send_refused = 1u << 9,
  command_not_finite = 1u << 10,
  drive_error = 1u << 11,
  quick_stop = 1u << 12,
  sensors_disagree = 1u << 13,
  second_host = 1u << 14,
  deadlines_missed = 1u << 15,
  force_oscillates = 1u << 16,
  energy_gained = 1u << 17,
  joint_beyond_range = 1u << 18,
};
inline constexpr std::size_t num_rig_faults = 19;

constexpr RigFault operator|(RigFault a, RigFault b) noexcept {
  return static_cast<RigFault>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
constexpr RigFault operator&(RigFault a, RigFault b) noexcept {
  return static_cast<RigFault>(static_cast<std::uint32_t>(a) & static_cast<std::uint32_t>(b));
}
constexpr bool any(RigFault faults) noexcept { return faults != RigFault::none; }

struct RigFaultText {
  RigFault fault;
  std::string_view name;
  std::string_view meaning;
  std::string_view remedy;
};

/// Returns the event of a fault in the table of states. fault: a single bit.
constexpr RigEvent event_of(RigFault fault) noexcept {
  return fault == RigFault::quick_stop ? RigEvent::quick_stop : RigEvent::fault;
}

/// Faults after which --rearm auto does not arm: every emergency stop, and faults that would recur.
inline constexpr RigFault never_rearmed = [] {
  RigFault faults = RigFault::force_oscillates | RigFault::energy_gained | RigFault::joint_beyond_range;
  for (std::size_t i = 0; i < num_rig_faults; ++i) {
    const auto fault = static_cast<RigFault>(1u << i);
    if (event_of(fault) == RigEvent::quick_stop) faults = faults | fault;
  }
  return faults;
}();

/// Returns the texts in the order of the bits.
std::span<const RigFaultText, num_rig_faults> rig_fault_texts() noexcept;
/// Returns the text of a fault. fault: a single bit.
const RigFaultText& text_of(RigFault fault) noexcept;

/// Place of a fault.
struct RigFaultPlace {
  RigFault fault = RigFault::none;   // a single bit
  std::optional<std::size_t> bus{};  // none: fault of the host, not of a bus
  std::uint8_t node_id = 0;          // 0: no single node
  std::uint16_t emcy_code = 0;       // code of an emergency
  std::uint32_t drive_code = 0;      // code of a drive_error, drive-specific

  bool operator==(const RigFaultPlace&) const = default;
};

/// A frame of a node that could not be used.
struct MalformedFrame {
  std::uint32_t identifier = 0;
  std::uint8_t size = 0;  // bytes
  ParseResult why = ParseResult::ok;
};

/// State of a node as received by the host.
struct NodeEvidence {
  bool heard = false;   // a heartbeat, or the message that replaces it, was received
  bool silent = false;  // none for heartbeat_timeout
  std::uint8_t nmt_state = 0;
  bool answered = false;                        // its PDO or an answer to a request was received
  bool delay_unknown = false;                   // SYNCs left out were not seen in its answers
  std::uint32_t own_state = 0, error_code = 0;  // DriveTelemetry of a drive
  bool has_own_state = false;
  std::uint64_t malformed = 0;  // frames since the rig began
  MalformedFrame last_malformed{};
};

/// A place and the first evidence of the fault there.
struct RigFaultRecord {
  RigFaultPlace place;
  Nanoseconds t_ns = 0;          // bus time
  std::uint32_t identifier = 0;  // identifier of the frame, for a second_host
  NodeEvidence evidence{};       // evidence for the place's node, if any
};

/// Sticky bits, and every place at which they were raised since the last clear. Of fixed size.
class RigFaultLog {
 public:
  /// Suffices for all devices of two buses with 32 nodes each, failing in two ways.
  static constexpr std::size_t capacity = 128;

  /// Sets the bit and records the place. Returns false if the place was recorded already.
  bool raise(const RigFaultPlace& place, Nanoseconds now, std::uint32_t identifier = 0,
             const NodeEvidence& evidence = {}) noexcept;
  /// Clears bits and places; keeps the counts.
  void clear() noexcept;

  RigFault faults() const noexcept { return faults_; }
  /// Returns the records in the order in which they were raised: a cause before its consequences.
  std::span<const RigFaultRecord> records() const noexcept { return std::span(records_).first(num_records_); }
  /// Returns the first record of a single bit; an empty one if the bit is not set.
  RigFaultRecord first(RigFault fault) const noexcept;
  /// Returns the number of places dropped at full capacity.
  std::uint64_t left_out() const noexcept { return left_out_; }
  /// Returns how often a single bit was set since construction.
  std::uint64_t count(RigFault fault) const noexcept;

 private:
  RigFault faults_ = RigFault::none;
  std::array<std::uint64_t, num_rig_faults> counts_{};
  std::array<RigFaultRecord, capacity> records_{};
  std::size_t num_records_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace godobject
