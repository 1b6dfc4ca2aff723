// Protocol of a drive. A new protocol is one file that implements DriveLink and one line in link.cc
// (docs/new-device.md).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/nonblocking.h"
#include "hal/can/filter.h"
#include "hal/canopen/canopen.h"
#include "hal/drive/params.h"

namespace godobject {

/// State of a drive, independent of its protocol.
enum class MotorState : std::uint8_t {
  unknown,  // not reported yet
  off,      // no torque; DriveGoal::enable leads out of it
  enabled,  // follows torque commands
  fault,    // no torque because of an error, which DriveGoal::enable resets
};

/// State to which the rig commands a drive.
enum class DriveGoal : std::uint8_t {
  off,         // power stage off, immediately
  hold,        // stay enabled; one that is not enabled stays off
  enable,      // towards enabled, resetting errors
  quick_stop,  // fastest stop of the drive itself
};

struct DriveOrder {
  DriveGoal goal = DriveGoal::off;
  double torque_Nm = 0;  // torque at the motor shaft; finite
};

/// Last values reported by a drive.
struct DriveTelemetry {
  std::uint32_t position_counts = 0;  // two's complement if signed
  double velocity_counts_per_s = 0;   // measured by the drive; 0 until reported
  double torque_Nm = 0;               // torque at the motor shaft; 0 until reported
  MotorState state = MotorState::unknown;
  bool internal_limit = false;   // the drive itself limits
  std::uint32_t error_code = 0;  // drive-specific; 0: none
  std::uint32_t own_state = 0;   // protocol-specific state for BusProtocol::state_text
  bool has_own_state = false;    // own_state was received
  bool powered = false;          // the power stage is on, whether or not the drive follows
};

/// Content of one frame for a drive.
struct DriveMessage {
  ParseResult result = ParseResult::other_message;
  bool position = false;  // contains a new position: the answer to SYNC or to the request
  bool alive = false;     // supervises the drive, for drives that are no CANopen nodes
};

/// A frame to send, if any. step: protocol-specific, passed back to DriveLink::sent.
struct DriveFrame {
  std::optional<CanFrame> frame{};
  std::uint16_t step = 0;
};

/// Counts per motor turn for drives that report turns instead of counts.
inline constexpr double counts_per_motor_turn = 1e5;

/// A cyclic message of a drive's protocol.
struct CyclicMessage {
  const char* what;
  CanFrame frame;  // data are ignored, only the size counts
  double period_s = 0;
};

class DriveLink {
 public:
  virtual ~DriveLink() = default;

  /// Decodes a frame of this drive's node. Changes `out` on ok only.
  [[nodiscard]] virtual DriveMessage decode(const CanFrame& frame,
                                            DriveTelemetry& out) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Returns the request sent at the beginning of the cycle; none if SYNC requests the answer. order: last
  /// order.
  virtual std::optional<CanFrame> request(const DriveOrder& order) const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Returns the frame sent at the end of the cycle; none if nothing is to be sent or the next request
  /// carries it.
  virtual DriveFrame command(const DriveOrder& order,
                             Nanoseconds now) const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Called once `command` has been sent, or needs no frame.
  virtual void sent(const DriveFrame& command, Nanoseconds now) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Returns the cyclic messages of the enabled drive and its host, without CANopen heartbeats.
  /// event_period_s: period of event-timer messages, s; 0: none. Set-up only: allocates.
  virtual std::vector<CyclicMessage> messages(double cycle_s, double event_period_s) const = 0;
};

/// Text of a frame of a drive's protocol.
struct DriveText {
  std::uint8_t node = 0;                          // sender or receiver; 0: not a message of the protocol
  std::string name;                               // name of the message, such as "torque command"
  std::optional<std::int64_t> position_counts{};  // as in DriveTelemetry
  std::string value{};                            // remaining content
};

/// Mechanism that removes the torque of a drive after the host has died, without a profile of the drive.
struct ProtocolWatchdog {
  // watchdog time set by this program, s; null: it sets none
  double (*time_s)(double cycle_s) noexcept = nullptr;
  const char* mechanism = nullptr;  // name of the mechanism, or how to set one up
};

/// Properties of a bus that follow from the protocol of its drives.
struct BusProtocol {
  bool canopen = true;       // SYNC, NMT and heartbeats; encoders and buttons are possible
  bool fd = false;           // requires a data_bit_rate
  bool answers_only = true;  // positions are sent as answers only; false: their delay is not measured
  std::uint8_t max_node_id = canopen::max_node_id;
  // largest torque that a command can encode, per rated torque; none: any
  std::optional<double> max_torque_per_rated{};
  /// Returns the sending node, 1..127; 0: no node of this protocol.
  std::uint8_t (*sender)(const CanFrame&) noexcept GODOBJECT_NONBLOCKING = nullptr;
  /// Returns the drive that a host's command addresses; 0 if the frame is no such command.
  std::uint8_t (*commanded)(const CanFrame&) noexcept GODOBJECT_NONBLOCKING = nullptr;
  /// Returns filters for all frames from and to a node. Allocates.
  std::vector<CanFilter> (*filters)(std::uint8_t node) = nullptr;
  /// Identifier of the command that a newer one may replace before it is sent; null: no command with 11-bit
  /// identifier.
  std::uint32_t (*command_id)(std::uint8_t node) noexcept = nullptr;
  /// Makes a command without effect; null: none exists, another host is detected by SYNC and heartbeats.
  CanFrame (*idle_command)(std::uint8_t node) noexcept = nullptr;
  /// Null: set up by the node's profile.
  const ProtocolWatchdog* watchdog = nullptr;
  /// Returns the text of any frame; allocates. Null: the messages are those of CANopen.
  DriveText (*describe)(const CanFrame&) = nullptr;
  /// Returns the text of DriveTelemetry::own_state; allocates.
  std::string (*state_text)(const DriveParams&, std::uint32_t own_state) = nullptr;
  /// Returns the text of DriveTelemetry::error_code, not 0. own_state: state received with it. Allocates.
  std::string (*error_text)(std::uint32_t error_code, std::uint32_t own_state) = nullptr;
};

BusProtocol bus_protocol(DriveProtocol protocol) noexcept;

/// Returns the largest torque_max_Nm that the commands of this drive can encode, N m; infinity if any.
double max_encodable_torque_Nm(const DriveParams& drive) noexcept;

/// Makes the link of a drive. params: constant and outliving the link. Allocates: set-up only.
std::unique_ptr<DriveLink> make_drive_link(const DriveParams& params, double cycle_s);

}  // namespace godobject
