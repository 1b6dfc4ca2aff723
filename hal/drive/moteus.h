// moteus motor controllers: registers read and written in sub-frames of CAN FD frames with bit-rate switch.
//
// id = source << 8 | destination, extended above 7FFh; bit 7 of the source requests a reply. The host is 0. A
// frame is a sequence of sub-frames, padded with 50h. A sub-frame has one byte for kind, type and count, then
// the first register and, for a write or reply, the values, little-endian. Integers are multiples of a
// quantum that depends on type and register; the most negative one is NaN.
#pragma once

#include <algorithm>
#include <cmath>

#include "hal/drive/link.h"

namespace godobject::moteus {

enum Register : std::uint32_t {
  mode = 0x000,
  position = 0x001,            // rev
  velocity = 0x002,            // rev/s
  torque = 0x003,              // N m
  voltage = 0x00D,             // V
  temperature = 0x00E,         // degC
  fault = 0x00F,               // meaning in mode 1; 96..105: the active output limit
  command_position = 0x020,    // rev
  command_velocity = 0x021,    // rev/s
  feedforward_torque = 0x022,  // N m
  kp_scale = 0x023,            // 0..1
  kd_scale = 0x024,            // 0..1
  max_torque = 0x025,          // N m
  watchdog_timeout = 0x027,    // s; after this time without a command the mode is 11
};

// Values of `mode`.
inline constexpr int mode_stopped = 0;
inline constexpr int mode_fault = 1;
inline constexpr int mode_position = 10;
inline constexpr int mode_timeout = 11;  // stays until a stop command

inline constexpr int first_limit_code = 96, last_limit_code = 105;

enum class ValueType : std::uint8_t { int8, int16, int32, real };  // codes on the wire

enum class SubframeKind : std::uint8_t {
  write = 0,
  read = 1,
  reply = 2,
};

struct Subframe {
  SubframeKind kind = SubframeKind::read;
  ValueType type = ValueType::int8;
  std::uint32_t first = 0;  // register
  std::uint32_t count = 0;
  std::span<const std::uint8_t> bytes{};  // bytes of the values; empty for a read

  /// Returns the value in the register's unit; may be NaN. index: below count, of a write or reply.
  double value(std::uint32_t index) const noexcept;
};

/// Iterates over the sub-frames of a frame. Each lies within the frame's bytes.
class SubframeReader {
 public:
  explicit SubframeReader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  /// Returns false at the end and at the first byte that is no read, write, reply or padding.
  bool next(Subframe& out) noexcept;
  /// False if it stopped before the end.
  bool ok() const noexcept { return ok_; }

 private:
  bool take_varuint(std::uint32_t& value) noexcept;

  std::span<const std::uint8_t> bytes_;
  bool ok_ = true;
};

/// Writes consecutive sub-frames into a frame; full() if one did not fit.
class SubframeWriter {
 public:
  void read(ValueType type, Register first, std::uint8_t count) noexcept;
  /// Writes values of one byte each, in the quanta of their registers.
  void write(std::span<const std::uint8_t> values, Register first) noexcept;
  void write(float value, Register reg) noexcept;
  /// Writes values of registers with the same quantum, saturated; NaN as encoded by the type.
  void reply(ValueType type, Register first, std::span<const double> values) noexcept;

  bool full() const noexcept { return full_; }
  /// Returns the frame, padded to a valid FD size.
  CanFrame frame(std::uint32_t id) const noexcept;

 private:
  void put(std::span<const std::uint8_t> bytes) noexcept;
  void head(SubframeKind kind, ValueType type, Register first, std::uint8_t count) noexcept;

  std::array<std::uint8_t, 64> bytes_{};
  std::uint8_t size_ = 0;
  bool full_ = false;
};

/// Host to controller.
constexpr std::uint32_t request_id(std::uint8_t node) noexcept { return 0x8000u | node; }
constexpr std::uint32_t command_id(std::uint8_t node) noexcept { return node; }
/// Controller to host.
constexpr std::uint32_t reply_id(std::uint8_t node) noexcept { return std::uint32_t{node} << 8; }

/// Returns the node, 1..127, that sent a frame to the host; 0 for any other frame.
constexpr std::uint8_t sender(const CanFrame& frame) noexcept GODOBJECT_NONBLOCKING {
  const bool to_host = frame.fd && (frame.id & ~0x7F00u) == 0;
  return to_host ? static_cast<std::uint8_t>(frame.id >> 8) : std::uint8_t{0};
}

/// Returns the node, 1..127, that a host (source 0) addresses; 0: none.
constexpr std::uint8_t commanded(const CanFrame& frame) noexcept GODOBJECT_NONBLOCKING {
  const bool from_host = frame.fd && (frame.id & ~0x807Fu) == 0;
  return from_host ? static_cast<std::uint8_t>(frame.id & 0x7Fu) : std::uint8_t{0};
}

/// Filters all frames from and to a node. Identifiers above 11 bits are extended, also those of the host that
/// request a reply.
std::vector<CanFilter> filters(std::uint8_t node);

/// Implemented in moteus_text.cc.
DriveText describe(const CanFrame& frame);
std::string state_text(const DriveParams& params, std::uint32_t own_state);
std::string error_text(std::uint32_t error_code, std::uint32_t own_state);

/// Makes a query for the contents of Reply: a frame of 8 bytes.
CanFrame make_query(std::uint8_t node) noexcept;
/// Makes a torque command with query: position mode with both gains scaled to zero. 24 bytes.
CanFrame make_torque(std::uint8_t node, float torque_Nm, float watchdog_s) noexcept;
/// Returns the watchdog time, s: 20 ms or four cycles, the larger. It bridges a few lost frames and is too
/// short for a hand to notice.
double watchdog_s(double cycle_s) noexcept;
inline constexpr ProtocolWatchdog watchdog{.time_s = watchdog_s,
                                           .mechanism = "register 027h, with each command"};
/// Makes a stop command: mode 0, 8 bytes.
CanFrame make_stop(std::uint8_t node, bool with_query) noexcept;

struct Reply {
  int mode = mode_stopped;
  double position_rev = 0;
  double velocity_rev_per_s = 0;
  double torque_Nm = 0;
  int fault = 0;
};

/// Parses any reply with mode, position, velocity and torque. Returns bad_value if one is missing or NaN.
[[nodiscard]] ParseResult parse_reply(const CanFrame& frame, std::uint8_t node, Reply& out) noexcept;
/// Makes the answer of a controller to make_query: 24 bytes.
CanFrame make_reply(std::uint8_t node, const Reply& reply) noexcept;

}  // namespace godobject::moteus

namespace godobject {

/// One frame per cycle commands the torque of the previous cycle and requests the state. The torque thus
/// takes effect at the beginning of the cycle, as with synchronous RPDOs. The frame also sets the watchdog:
/// the motor stops soon after the frames do. A drive that has not answered for this time may have lost its
/// power. It then receives queries alone, because a torque command would enable it again.
class MoteusLink final : public DriveLink {
 public:
  MoteusLink(const DriveParams& params, double cycle_s) noexcept
      : node_(params.node_id),
        watchdog_s_(static_cast<float>(moteus::watchdog_s(cycle_s))),
        max_cycles_silent_(static_cast<int>(std::lround(moteus::watchdog_s(cycle_s) / cycle_s))) {}

  DriveMessage decode(const CanFrame& frame, DriveTelemetry& out) noexcept override;
  std::optional<CanFrame> request(const DriveOrder& order) const noexcept override;
  DriveFrame command(const DriveOrder& order, Nanoseconds now) const noexcept override;
  void sent(const DriveFrame&, Nanoseconds) noexcept override {
    cycles_silent_ = std::min(cycles_silent_, max_cycles_silent_) + 1;
  }
  std::vector<CyclicMessage> messages(double cycle_s, double event_period_s) const override;

 private:
  std::uint8_t node_;
  float watchdog_s_;
  int max_cycles_silent_;  // time of the watchdog
  int cycles_silent_ = 0;  // since the last answer
  int mode_ = moteus::mode_stopped;
  bool heard_ = false;
};

}  // namespace godobject
