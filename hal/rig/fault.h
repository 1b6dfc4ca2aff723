// What can go wrong with a rig: bits, names, and what the user reads about them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/base/codec.h"
#include "hal/can/frame.h"

namespace godobject {

/// Sticky bits; several can be set. The one-line meaning and remedy of each are in rig_fault_texts().
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
};
inline constexpr std::size_t num_rig_faults = 18;

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

/// In the order of the bits.
std::span<const RigFaultText, num_rig_faults> rig_fault_texts() noexcept;
/// fault: a single bit.
const RigFaultText& text_of(RigFault fault) noexcept;

/// Where a fault came up.
struct RigFaultPlace {
  RigFault fault = RigFault::none;   // a single bit
  std::optional<std::size_t> bus{};  // none: the fault is of the host, not of a bus
  std::uint8_t node_id = 0;          // 0: no single node
  std::uint16_t emcy_code = 0;       // of an emergency
  std::uint32_t drive_code = 0;      // of a drive_error, in the drive's own numbers

  bool operator==(const RigFaultPlace&) const = default;
};

/// A frame of a node that could not be used.
struct MalformedFrame {
  std::uint32_t identifier = 0;
  std::uint8_t size = 0;  // bytes
  ParseResult why = ParseResult::ok;
};

/// A node as the host has heard it.
struct NodeEvidence {
  bool heard = false;   // a heartbeat, or the message that stands for it
  bool silent = false;  // none for heartbeat_timeout
  std::uint8_t nmt_state = 0;
  bool answered = false;                        // its PDO, or an answer to a request, has come
  std::uint32_t own_state = 0, error_code = 0;  // of a drive: DriveTelemetry
  bool has_own_state = false;
  std::uint64_t malformed = 0;  // frames since the rig began
  MalformedFrame last_malformed{};
};

/// A place, and what showed the fault there first.
struct RigFaultRecord {
  RigFaultPlace place;
  Nanoseconds t_ns = 0;          // bus time
  std::uint32_t identifier = 0;  // of the frame, of a second_host
  NodeEvidence evidence{};       // of the place's node, if it has one
};

/// The sticky bits, and every place at which they came up since they were cleared last. Of fixed size.
class RigFaultLog {
 public:
  /// No place is left out where all of a device with two buses of 32 nodes each fails in two ways.
  static constexpr std::size_t capacity = 128;

  /// Sets the bit and notes the place. False where that was known already.
  bool raise(const RigFaultPlace& place, Nanoseconds now, std::uint32_t identifier = 0,
             const NodeEvidence& evidence = {}) noexcept;
  /// Clears the bits and the places; the counts stay.
  void clear() noexcept;

  RigFault faults() const noexcept { return faults_; }
  /// In the order in which they came up: the cause before what follows from it.
  std::span<const RigFaultRecord> records() const noexcept { return std::span(records_).first(num_records_); }
  /// The first place at which a single bit came up; an empty one where it is not set.
  RigFaultRecord first(RigFault fault) const noexcept;
  /// Places for which there was no room.
  std::uint64_t left_out() const noexcept { return left_out_; }
  /// Times that a single bit was set, since construction.
  std::uint64_t count(RigFault fault) const noexcept;

 private:
  RigFault faults_ = RigFault::none;
  std::array<std::uint64_t, num_rig_faults> counts_{};
  std::array<RigFaultRecord, capacity> records_{};
  std::size_t num_records_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace godobject
