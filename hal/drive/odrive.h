// ODrive motor drives: CAN Simple, firmware 0.6.
//
// id = node << 5 | command, 11 bits, classic frames, numbers little-endian, reals IEEE 32 bits. Firmware 0.5
// has the same layout of the messages used here, with these exceptions. Its heartbeat has other error bits;
// the bytes after the axis state are flags of motor, encoder and controller, whose errors the axis error
// omits. Clear_Errors has no data. Position messages in counts, 03h, 04h, 1Ch and 1Dh differ. A CAN Simple
// bus carries no CANopen: 080h, SYNC there, is node 4's Get_Version here.
#pragma once

#include "hal/canopen/canopen.h"
#include "hal/drive/link.h"

namespace godobject::odrive {

inline constexpr std::uint8_t max_node_id = 62;    // 63: not addressed
inline constexpr double heartbeat_period_s = 0.1;  // heartbeat_msg_rate_ms as shipped
inline constexpr double torques_period_s = 0.01;   // torques_msg_rate_ms as set in docs/new-device.md

enum class Command : std::uint8_t {
  heartbeat = 0x01,
  estop = 0x02,
  set_axis_state = 0x07,
  encoder_estimates = 0x09,
  set_controller_mode = 0x0B,
  set_input_torque = 0x0E,
  torques = 0x1C,
  clear_errors = 0x18,
};

inline constexpr std::uint32_t axis_idle = 1;
inline constexpr std::uint32_t axis_closed_loop = 8;
inline constexpr std::uint32_t control_torque = 1;      // Set_Controller_Mode
inline constexpr std::uint32_t input_pass_through = 1;  // Set_Controller_Mode

// Bits of the heartbeat's error.
inline constexpr std::uint32_t error_watchdog = 0x0100'0000;
inline constexpr std::uint32_t error_estop = 0x0200'0000;

struct Heartbeat {
  std::uint32_t error = 0;
  std::uint8_t axis_state = 0;
  // 0.6: procedure result, trajectory done, 0; 0.5: motor, encoder, controller.
  std::array<std::uint8_t, 3> flags{};
};

/// Packs bytes 4 to 7 of the heartbeat: DriveTelemetry::own_state.
constexpr std::uint32_t own_state(const Heartbeat& heartbeat) noexcept {
  return std::uint32_t{heartbeat.axis_state} | std::uint32_t{heartbeat.flags[0]} << 8 |
         std::uint32_t{heartbeat.flags[1]} << 16 | std::uint32_t{heartbeat.flags[2]} << 24;
}

/// True for firmware 0.5 from 0.5.4 on: its last byte holds the controller's flags. Bit 7 of it, trajectory
/// done, is set while no trajectory runs. Firmware 0.6 sends 0 there.
constexpr bool is_firmware_0_5(const Heartbeat& heartbeat) noexcept { return heartbeat.flags[2] != 0; }

/// True if firmware 0.5 reports an error of motor, encoder or controller.
constexpr bool has_flagged_error(const Heartbeat& heartbeat) noexcept {
  const auto& [motor, encoder, controller] = heartbeat.flags;
  return is_firmware_0_5(heartbeat) && ((motor | encoder | controller) & 1u) != 0;
}

struct EncoderEstimates {
  float position_rev = 0;
  float velocity_rev_per_s = 0;
};

struct Torques {
  float target_Nm = 0;
  float estimate_Nm = 0;
};

constexpr std::uint32_t frame_id(std::uint8_t node, Command command) noexcept {
  return std::uint32_t{node} << 5 | static_cast<std::uint32_t>(command);
}

/// Returns the sending node, 1..62; 0: none, or node 0, which is not used here.
constexpr std::uint8_t sender(const CanFrame& frame) noexcept GODOBJECT_NONBLOCKING {
  const std::uint32_t node = frame.id >> 5;
  const bool classic = !frame.extended && !frame.fd && !frame.remote;
  return classic && node <= max_node_id ? static_cast<std::uint8_t>(node) : std::uint8_t{0};
}

/// Returns the node that a frame commands or configures; 0: none. An e-stop may come from any node.
constexpr std::uint8_t commanded(const CanFrame& frame) noexcept GODOBJECT_NONBLOCKING {
  switch (static_cast<Command>(frame.id & 0x1Fu)) {
    case Command::set_axis_state:
    case Command::set_controller_mode:
    case Command::set_input_torque:
    case Command::clear_errors: return sender(frame);
    default: return 0;
  }
}

/// Filters all frames of a node, with any command.
inline std::vector<CanFilter> filters(std::uint8_t node) {
  return {{.id = std::uint32_t{node} << 5, .mask = 0x7E0}};
}

constexpr std::uint32_t command_id(std::uint8_t node) noexcept {
  return frame_id(node, Command::set_input_torque);
}

inline constexpr ProtocolWatchdog watchdog{
    .mechanism =
        "CAN Simple has no message that sets one: set axis0.config.enable_watchdog = True and "
        "watchdog_timeout = 0.02 on the drive, and watchdog = \"drive\" in the scene"};

/// Implemented in odrive_text.cc.
DriveText describe(const CanFrame& frame);
std::string state_text(const DriveParams& params, std::uint32_t own_state);
std::string error_text(std::uint32_t error_code, std::uint32_t own_state);

/// Makes a request for one message that the drive otherwise sends cyclically: a remote frame of its size.
constexpr CanFrame make_request(std::uint8_t node, Command command) noexcept {
  return {.id = frame_id(node, command), .remote = true, .size = 8};
}

/// Makes a message of one or two 32-bit numbers.
template <class... Numbers>
constexpr CanFrame make_message(std::uint8_t node, Command command, Numbers... numbers) noexcept {
  CanFrame frame{.id = frame_id(node, command), .size = static_cast<std::uint8_t>(4 * sizeof...(numbers))};
  ByteWriter writer(frame.data);
  (writer.put(numbers), ...);
  return frame;
}

constexpr CanFrame make_set_axis_state(std::uint8_t node, std::uint32_t state) noexcept {
  return make_message(node, Command::set_axis_state, state);
}
constexpr CanFrame make_torque_mode(std::uint8_t node) noexcept {
  return make_message(node, Command::set_controller_mode, control_torque, input_pass_through);
}
constexpr CanFrame make_input_torque(std::uint8_t node, float torque_Nm) noexcept {
  return make_message(node, Command::set_input_torque, torque_Nm);
}
constexpr CanFrame make_idle_command(std::uint8_t node) noexcept { return make_input_torque(node, 0); }
/// Makes Clear_Errors with one byte; firmware 0.5 accepts it with and without the byte.
constexpr CanFrame make_clear_errors(std::uint8_t node) noexcept {
  return {.id = frame_id(node, Command::clear_errors), .size = 1};
}

constexpr CanFrame make_heartbeat(std::uint8_t node, const Heartbeat& heartbeat) noexcept {
  CanFrame frame{.id = frame_id(node, Command::heartbeat), .size = 8};
  ByteWriter(frame.data).put(heartbeat.error).put(own_state(heartbeat));
  return frame;
}
constexpr CanFrame make_encoder_estimates(std::uint8_t node, const EncoderEstimates& estimates) noexcept {
  return make_message(node, Command::encoder_estimates, estimates.position_rev, estimates.velocity_rev_per_s);
}
constexpr CanFrame make_torques(std::uint8_t node, const Torques& torques) noexcept {
  return make_message(node, Command::torques, torques.target_Nm, torques.estimate_Nm);
}

/// Checks for a data frame with this command, of this node and size.
[[nodiscard]] constexpr ParseResult check(const CanFrame& frame, std::uint8_t node, Command command,
                                          std::size_t size) noexcept {
  if (sender(frame) != node || frame.id != frame_id(node, command)) return ParseResult::other_message;
  return check_size(frame.size, size);
}

[[nodiscard]] constexpr ParseResult parse_heartbeat(const CanFrame& frame, std::uint8_t node,
                                                    Heartbeat& out) noexcept {
  const ParseResult result = check(frame, node, Command::heartbeat, 8);
  if (result != ParseResult::ok) return result;
  ByteReader(frame.bytes()).get(out.error).get(out.axis_state);
  std::copy_n(frame.data.begin() + 5, out.flags.size(), out.flags.begin());
  return result;
}

/// Parses two reals; returns bad_value unless both are finite.
[[nodiscard]] ParseResult parse_reals(const CanFrame& frame, std::uint8_t node, Command command, float& first,
                                      float& second) noexcept;

[[nodiscard]] inline ParseResult parse_encoder_estimates(const CanFrame& frame, std::uint8_t node,
                                                         EncoderEstimates& out) noexcept {
  return parse_reals(frame, node, Command::encoder_estimates, out.position_rev, out.velocity_rev_per_s);
}
[[nodiscard]] inline ParseResult parse_torques(const CanFrame& frame, std::uint8_t node,
                                               Torques& out) noexcept {
  return parse_reals(frame, node, Command::torques, out.target_Nm, out.estimate_Nm);
}

}  // namespace godobject::odrive

namespace godobject {

/// A remote frame requests the encoder estimates in every cycle, so that the sample has the time of the
/// cycle. The drive's own cyclic sending (encoder_msg_rate_ms) must be off. Input_Torque is sent in every
/// cycle, zero unless the drive is enabled, and feeds its watchdog (axis.config.enable_watchdog must be on).
///
/// Enabled means: axis state 8 without an error, after this host has set torque control. The heartbeat (100
/// ms by default) reports axis state and error and supervises the drive.
class OdriveLink final : public DriveLink {
 public:
  OdriveLink(const DriveParams& params, double /*cycle_s*/) noexcept : node_(params.node_id) {}

  DriveMessage decode(const CanFrame& frame, DriveTelemetry& out) noexcept override;
  std::optional<CanFrame> request(const DriveOrder&) const noexcept override {
    return odrive::make_request(node_, odrive::Command::encoder_estimates);
  }
  DriveFrame command(const DriveOrder& order, Nanoseconds now) const noexcept override;
  void sent(const DriveFrame& command, Nanoseconds now) noexcept override;
  std::vector<CyclicMessage> messages(double cycle_s, double event_period_s) const override;

 private:
  enum Step : std::uint16_t { nothing, waiting, torque_mode, closed_loop, clear_errors };

  bool enabled() const noexcept;
  bool has_error() const noexcept { return heartbeat_.error != 0 || odrive::has_flagged_error(heartbeat_); }
  Step next_step(Nanoseconds now) const noexcept;

  std::uint8_t node_;
  odrive::Heartbeat heartbeat_;
  bool heard_ = false;
  bool torque_mode_sent_ = false;
  Step last_step_ = nothing;  // last step on the way to enabled
  Nanoseconds t_last_step_ns_ = 0;
};

}  // namespace godobject
