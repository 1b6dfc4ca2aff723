#include "platform/cli/drive/drive.h"

#include <cstdio>

#include "platform/rt/cyclic.h"

namespace godobject {

using cia402::DriveState;
using cia402::OperationMode;

namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr Nanoseconds mode_timeout_ns = 1000 * ms;
constexpr Nanoseconds enable_timeout_ns = 3000 * ms;  // brakes and charging included
constexpr Nanoseconds poll_period_ns = 5 * ms;
constexpr Nanoseconds to_take_effect_ns = 20 * ms;

bool has_no_power(DriveState state) noexcept {
  return state == DriveState::switch_on_disabled || state == DriveState::ready_to_switch_on ||
         state == DriveState::fault || state == DriveState::not_ready_to_switch_on;
}

ExitCode refuse(const NodeDialogue& node, const std::string& why) {
  std::fprintf(stderr, "node %d: %s\n", node.node(), why.c_str());
  return ExitCode::fault;
}

}  // namespace

ExitCode DriveDialogue::open() {
  if (const ExitCode code = node_.open(); code != ExitCode::ok) return code;
  const std::optional<std::int64_t> type = node_.read(drive_object::device_type);
  if (!type) return node_.report();
  constexpr unsigned profile = 402;
  const auto found = static_cast<unsigned>(*type & 0xFFFF);
  if (found == profile) return ExitCode::ok;
  return refuse(node_, "is not a CiA 402 drive: its profile (1000h) is " + std::to_string(found));
}

std::optional<std::uint16_t> DriveDialogue::statusword() {
  const std::optional<std::int64_t> word = node_.read(drive_object::statusword);
  if (!word) return std::nullopt;
  return static_cast<std::uint16_t>(*word);
}

std::optional<DriveState> DriveDialogue::state() {
  const std::optional<std::uint16_t> word = statusword();
  if (!word) return std::nullopt;
  return cia402::decode_state(*word);
}

bool DriveDialogue::command(std::uint16_t controlword) {
  return node_.write(drive_object::controlword, controlword);
}

ExitCode PoweredDrive::check(OperationMode mode) {
  NodeDialogue& node = drive_.node();
  if (!node.host_seen().empty())
    return refuse(node, "a host runs this bus (" + node.host_seen() +
                            "): stop the host first, because a drive has one master");
  const std::optional<DriveState> state = drive_.state();
  if (!state) return node.report();
  if (*state == DriveState::fault || *state == DriveState::fault_reaction_active) {
    const std::optional<std::int64_t> error = node.read(drive_object::error_code);
    return refuse(node, "is in fault (" + (error ? error_code_text(*error) : node.failure()) +
                            "): reset it with godobject drive ... reset");
  }
  if (!has_no_power(*state))
    return refuse(node, std::string("was already enabled by another program, which must disable it first: ") +
                            name_of(*state));
  const std::optional<std::int64_t> modes = node.read(drive_object::supported_modes);
  if (!modes && !node.was_absent()) return node.report();
  if (modes && !cia402::supports(static_cast<std::uint32_t>(*modes), mode))
    return refuse(node, std::string("has no mode ") + name_of(mode) + ", by its 6502h");
  return ExitCode::ok;
}

ExitCode PoweredDrive::prepare(OperationMode mode) {
  if (const ExitCode code = check(mode); code != ExitCode::ok) return code;
  prepared_ = true;
  last_resort_.emplace(
      std::vector{drive_.node().last_words(drive_object::controlword, cia402::disable_voltage)});
  drive_.node().command(canopen::NmtCommand::enter_pre_operational);
  watch_this_program();
  return set_mode(mode);
}

ExitCode PoweredDrive::set_mode(OperationMode mode) {
  NodeDialogue& node = drive_.node();
  former_mode_ = node.read(drive_object::mode);
  if (!former_mode_) return node.report();
  const auto wanted = static_cast<std::int64_t>(mode);
  if (!node.write(drive_object::mode, wanted)) return node.report();
  const Nanoseconds t_end_ns = MonotonicClock().now() + mode_timeout_ns;
  for (;;) {
    const std::optional<std::int64_t> shown = node.read(drive_object::mode_display);
    if (!shown) return node.report();
    if (*shown == wanted) return ExitCode::ok;
    if (MonotonicClock().now() >= t_end_ns)
      return refuse(node, "6061h stays " + std::to_string(*shown) + " for 1 s after 6060h <- " +
                              std::to_string(wanted) +
                              ": see its manual for the states in which it changes its mode");
    node.wait(poll_period_ns);
  }
}

void PoweredDrive::watch_this_program() {
  constexpr std::int64_t patience_ms = 500, disable_voltage_option = 2;  // 6007h, CiA 402-2
  NodeDialogue& node = drive_.node();
  former_consumer_ = node.read(drive_object::heartbeat_consumer);
  if (former_consumer_) former_abort_connection_ = node.read(drive_object::abort_connection);
  if (former_abort_connection_ && node.write(drive_object::abort_connection, disable_voltage_option) &&
      node.write(drive_object::heartbeat_consumer, std::int64_t{node.host_node()} << 16 | patience_ms)) {
    // The supervision of a drive starts with the first heartbeat, which must therefore arrive before the
    // power.
    node.send_heartbeats(true);
    node.wait(to_take_effect_ns);
    return;
  }
  std::fprintf(stderr,
               "node %d: does not supervise this program (%s): if the program or the cable fails, the drive "
               "keeps its last command\n",
               node.node(), node.failure().c_str());
}

ExitCode PoweredDrive::enable() {
  NodeDialogue& node = drive_.node();
  const Nanoseconds t_end_ns = MonotonicClock().now() + enable_timeout_ns;
  for (std::uint16_t last = cia402::disable_voltage;;) {
    const std::optional<DriveState> state = drive_.state();
    if (!state) return node.report();
    if (*state == DriveState::operation_enabled) return ExitCode::ok;
    if (*state == DriveState::fault || MonotonicClock().now() >= t_end_ns) {
      const std::optional<std::int64_t> error = node.read(drive_object::error_code);
      return refuse(node, std::string("does not reach Operation Enabled; it is in ") + name_of(*state) +
                              (error ? ", " + error_code_text(*error) : "") +
                              ": check its power supply, safe torque off and enable input");
    }
    last = cia402::next_controlword(*state, last, false);
    if (!drive_.command(last)) return node.report();
    node.wait(poll_period_ns);
  }
}

ExitCode PoweredDrive::off() {
  if (!prepared_) return ExitCode::ok;
  prepared_ = false;
  const bool confirmed = confirm_off();
  if (confirmed) restore();
  drive_.node().send_heartbeats(false);
  last_resort_.reset();
  if (confirmed) return ExitCode::ok;
  std::fprintf(stderr, "node %d: NOT CONFIRMED that the motor is off (%s): cut its power\n",
               drive_.node().node(), drive_.node().failure().c_str());
  return ExitCode::fault;
}

bool PoweredDrive::confirm_off() {
  constexpr int attempts = 3;
  for (int i = 0; i < attempts; ++i) {
    if (!drive_.command(cia402::disable_voltage)) continue;
    drive_.node().wait(poll_period_ns);
    const std::optional<DriveState> state = drive_.state();
    if (state && has_no_power(*state)) return true;
  }
  return false;
}

// Restores the settings. A failure is harmless, because the drive is off and a run commissions it again.
void PoweredDrive::restore() {
  NodeDialogue& node = drive_.node();
  const auto put_back = [&node](const TypedObject& object, const std::optional<std::int64_t>& value) {
    if (value && !node.write(object, *value)) static_cast<void>(node.report());
  };
  put_back(drive_object::heartbeat_consumer, former_consumer_);
  put_back(drive_object::abort_connection, former_abort_connection_);
  put_back(drive_object::mode, former_mode_);
}

}  // namespace godobject
