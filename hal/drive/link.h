// What a drive speaks: the part of a drive that differs from protocol to protocol. A new protocol is one file
// that implements DriveLink and one line in link.cc (docs/new-device.md).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/can/filter.h"
#include "hal/canopen/canopen.h"
#include "hal/rig/params.h"

namespace godobject {

/// What a drive can do for us now, whatever its own states are.
enum class MotorState : std::uint8_t {
  unknown,  // it has not said
  off,      // makes no torque; DriveGoal::enable leads out of it
  enabled,  // follows torque commands
  fault,    // makes no torque because of an error, which DriveGoal::enable resets
};

/// Where the rig wants a drive.
enum class DriveGoal : std::uint8_t {
  off,         // power stage off, now
  hold,        // stay enabled; one that is not enabled is left off
  enable,      // towards enabled, errors reset on the way
  quick_stop,  // the fastest stop the drive itself has
};

struct DriveOrder {
  DriveGoal goal = DriveGoal::off;
  double torque_Nm = 0;  // at the motor shaft; finite
};

/// What a drive last said.
struct DriveTelemetry {
  std::uint32_t position_counts = 0;  // two's complement where signed
  double velocity_counts_per_s = 0;   // as the drive measures it; 0 until it says
  double torque_Nm = 0;               // at the motor shaft; 0 until it says
  MotorState state = MotorState::unknown;
  bool internal_limit = false;   // the drive itself limits
  std::uint32_t error_code = 0;  // in the drive's own numbers; 0: none
  std::uint32_t own_state = 0;   // in the protocol's own numbers, for BusProtocol::state_text
  bool has_own_state = false;    // it has come
  bool powered = false;          // its power stage is on, whether it follows or not
};

/// What one frame was for a drive.
struct DriveMessage {
  ParseResult result = ParseResult::other_message;
  bool position = false;  // holds a new position: the answer to SYNC or to the request
  bool alive = false;     // is what the drive is supervised by, where it is no CANopen node
};

/// A frame to send, if any; `step` is the protocol's own and comes back in DriveLink::sent.
struct DriveFrame {
  std::optional<CanFrame> frame{};
  std::uint16_t step = 0;
};

/// Drives that report turns instead of counts have this many counts per turn of the motor.
inline constexpr double counts_per_motor_turn = 1e5;

/// A message that a drive's protocol puts on the bus again and again.
struct CyclicMessage {
  const char* what;
  CanFrame frame;  // of its size; the data do not matter
  double period_s = 0;
};

class DriveLink {
 public:
  virtual ~DriveLink() = default;

  /// A frame of this drive's node. `out` changes on ok only.
  [[nodiscard]] virtual DriveMessage decode(const CanFrame& frame, DriveTelemetry& out) noexcept = 0;
  /// Goes out at the beginning of the cycle, where a drive has to be asked; none where SYNC asks it.
  /// order: the last one given.
  virtual std::optional<CanFrame> request(const DriveOrder& order) const noexcept = 0;
  /// Goes out at the end of the cycle; none where nothing is to be said, or the next request says it.
  virtual DriveFrame command(const DriveOrder& order, Nanoseconds now) const noexcept = 0;
  /// That frame has left.
  virtual void sent(const DriveFrame& command, Nanoseconds now) noexcept = 0;
  /// What the enabled drive and its host send, without heartbeats of CANopen. event_period_s: of messages that
  /// an event timer sends; 0: there are none. Set-up only: allocates.
  virtual std::vector<CyclicMessage> messages(double cycle_s, double event_period_s) const = 0;
};

/// A frame of a drive's protocol in words, for people.
struct DriveText {
  std::uint8_t node = 0;                          // from or to; 0: no message of the protocol
  std::string name;                               // "torque command"
  std::optional<std::int64_t> position_counts{};  // as DriveTelemetry's
  std::string value{};                            // what else it says
};

/// What takes the torque of a drive of this protocol away when the host has died, without a profile of the drive's.
struct ProtocolWatchdog {
  double (*time_s)(double cycle_s) noexcept = nullptr;  // set by this program; null: it sets none
  const char* mechanism = nullptr;                      // what does it, or how to get one
};

/// What the drives of a bus make of it.
struct BusProtocol {
  bool canopen = true;       // SYNC, NMT and heartbeats; encoders and buttons can be on it
  bool fd = false;           // needs a data_bit_rate
  bool answers_only = true;  // positions come as answers alone; false: their delay is not measured
  std::uint8_t max_node_id = canopen::max_node_id;
  /// Node id 1..127, 0: no node of this protocol.
  std::uint8_t (*sender)(const CanFrame&) noexcept = nullptr;
  /// The drive that a frame commands, which none but its host sends; 0: it is no command.
  std::uint8_t (*commanded)(const CanFrame&) noexcept = nullptr;
  /// All frames from and to a node. Allocates.
  std::vector<CanFilter> (*filters)(std::uint8_t node) = nullptr;
  /// Identifier of the command that a newer one may replace before it has left; null: there is none of 11 bits.
  std::uint32_t (*command_id)(std::uint8_t node) noexcept = nullptr;
  /// A frame that commands a node and makes it do nothing; null: there is none, SYNC and heartbeats show another host.
  CanFrame (*idle_command)(std::uint8_t node) noexcept = nullptr;
  /// Null: as the node's profile sets it up.
  const ProtocolWatchdog* watchdog = nullptr;
  /// Says any frame in words; allocates. Null: the messages are those of CANopen.
  DriveText (*describe)(const CanFrame&) = nullptr;
  /// DriveTelemetry::own_state of a drive in words; allocates.
  std::string (*state_text)(const DriveParams&, std::uint32_t own_state) = nullptr;
  /// DriveTelemetry::error_code, not 0, in words; own_state: as it came with it. Allocates.
  std::string (*error_text)(std::uint32_t error_code, std::uint32_t own_state) = nullptr;
};

BusProtocol bus_protocol(DriveProtocol protocol) noexcept;

/// The protocol of a bus is that of its drives; CANopen where it has none. All drives of a bus speak the same (validate).
DriveProtocol protocol_of_bus(const RigParams& rig, std::size_t bus) noexcept;

/// Allocates: for set-up.
std::unique_ptr<DriveLink> make_drive_link(const DriveParams& params, double cycle_s);

}  // namespace godobject
