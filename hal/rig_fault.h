// What can go wrong with a rig: bits, names, and what the user reads about them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

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
};
inline constexpr std::size_t num_rig_faults = 14;

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

/// Where and how often a fault came up.
struct RigFaultRecord {
  std::uint64_t count = 0;         // times raised since construction
  std::optional<std::size_t> bus;  // of the latest; none: the fault is of the host, not of a bus
  std::uint8_t node_id = 0;        // of the latest; 0: no single node
  std::uint16_t emcy_code = 0;     // of the latest emergency
  std::uint32_t drive_code = 0;    // of the latest drive_error, in the drive's own numbers
};

/// The sticky bits and their records.
class RigFaultLog {
 public:
  /// Sets a single bit; counted when it was not set yet. True then.
  bool raise(RigFault fault, std::optional<std::size_t> bus, std::uint8_t node_id = 0,
             std::uint16_t emcy_code = 0, std::uint32_t drive_code = 0) noexcept;
  /// Clears the bits; the counts stay.
  void clear() noexcept { faults_ = RigFault::none; }

  RigFault faults() const noexcept { return faults_; }
  /// fault: a single bit.
  const RigFaultRecord& record(RigFault fault) const noexcept;

 private:
  RigFault faults_ = RigFault::none;
  std::array<RigFaultRecord, num_rig_faults> records_{};
};

}  // namespace godobject
