#include "platform/cli/bus/messages.h"

#include <algorithm>
#include <cstdio>

#include "hal/base/format.h"
#include "hal/canopen/cia406.h"
#include "hal/canopen/sdo/sdo.h"
#include "hal/drive/cia402.h"
#include "hal/drive/cia402_text.h"

namespace godobject {
namespace {

const char* nmt_name(canopen::NmtState state) {
  switch (state) {
    case canopen::NmtState::boot_up: return "boot-up";
    case canopen::NmtState::stopped: return "stopped";
    case canopen::NmtState::operational: return "operational";
    case canopen::NmtState::pre_operational: return "pre-operational";
  }
  return "";
}

const char* nmt_name(canopen::NmtCommand command) {
  switch (command) {
    case canopen::NmtCommand::start: return "start";
    case canopen::NmtCommand::stop: return "stop";
    case canopen::NmtCommand::enter_pre_operational: return "enter pre-operational";
    case canopen::NmtCommand::reset_node: return "reset node";
    case canopen::NmtCommand::reset_communication: return "reset communication";
  }
  return "";
}

std::string decode_nmt(const CanFrame& frame) {
  canopen::Nmt nmt;
  if (canopen::parse_nmt(frame, nmt) != ParseResult::ok) return "not an NMT command";
  return std::string(nmt_name(nmt.command)) +
         (nmt.node == 0 ? ": all nodes" : ": node " + std::to_string(nmt.node));
}

std::string decode_sync(const CanFrame& frame) {
  std::uint8_t counter = 0;
  if (canopen::parse_sync(frame, counter) != ParseResult::ok) return "too long";
  return frame.size == 0 ? "" : "counter " + std::to_string(counter);
}

std::string decode_emergency(const CanFrame& frame) {
  canopen::Emergency emergency;
  if (canopen::parse_emergency(frame, emergency) != ParseResult::ok) return "not 8 bytes";
  return format("%04Xh %s, register %02Xh", static_cast<unsigned>(emergency.error_code),
                emergency_text(emergency.error_code), static_cast<unsigned>(emergency.error_register));
}

std::string decode_heartbeat(const CanFrame& frame) {
  canopen::Heartbeat heartbeat;
  if (canopen::parse_heartbeat(frame, heartbeat) != ParseResult::ok) return "not a heartbeat: node guarding?";
  return nmt_name(heartbeat.state);
}

std::string object_of(const sdo::Message& message) {
  const canopen::ObjectAddress address = sdo::address_of(message);
  return format("%04Xh:%02X", static_cast<unsigned>(address.index), static_cast<unsigned>(address.sub));
}

/// Returns " = 0x1234" for an expedited transfer, else the number of bytes that follow.
std::string data_of(const sdo::Message& message) {
  const sdo::Initiation initiation = sdo::initiation_of(message);
  if (!initiation.expedited)
    return initiation.size_given ? ", " + std::to_string(initiation.size) + " bytes" : "";
  std::uint32_t value = 0;
  const std::span<const std::uint8_t> data = sdo::expedited_data(message);
  for (std::size_t i = data.size(); i-- > 0;) value = value << 8 | data[i];
  return format(" = 0x%0*X", static_cast<int>(2 * data.size()), value);
}

std::string decode_sdo(const CanFrame& frame, bool is_request) {
  sdo::Message message{};
  const std::size_t shortest = is_request ? message.size() : 1;  // some servers omit bytes
  const bool is_one = canopen::is_canopen(frame) && frame.size >= shortest && frame.size <= message.size();
  if (!is_one) return "not 8 bytes";
  std::copy_n(frame.data.begin(), frame.size, message.begin());
  const std::uint8_t command = sdo::command_of(message);
  if (command == static_cast<std::uint8_t>(sdo::Request::abort)) {
    const sdo::AbortCode code = sdo::abort_code_of(message);
    return format("%s abort %08X: %s", object_of(message).c_str(), static_cast<unsigned>(code),
                  sdo::text_of(code));
  }
  if (is_request) {
    if (command == static_cast<std::uint8_t>(sdo::Request::initiate_download))
      return "write " + object_of(message) + data_of(message);
    if (command == static_cast<std::uint8_t>(sdo::Request::initiate_upload))
      return "read " + object_of(message);
  } else {
    if (command == static_cast<std::uint8_t>(sdo::Response::initiate_download))
      return object_of(message) + " written";
    if (command == static_cast<std::uint8_t>(sdo::Response::initiate_upload))
      return object_of(message) + data_of(message);
  }
  return "segment";
}

/// Returns the counts as shown. Counts of a sensor that wraps are unsigned; others are in two's complement.
long long shown_counts(std::uint32_t counts, const Calibration& calibration) {
  return calibration.modulus_counts == 0 ? static_cast<std::int32_t>(counts) : static_cast<long long>(counts);
}

constexpr double ns = 1e-9;

std::string hexadecimal(const CanFrame& frame) {
  if (frame.remote) return "remote";
  constexpr std::size_t max_shown = 16;  // bytes that fit into a line
  std::string text;
  std::array<char, 4> byte{};
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.size, max_shown); ++i) {
    std::snprintf(byte.data(), byte.size(), i == 0 ? "%02X" : " %02X", static_cast<unsigned>(frame.data[i]));
    text += byte.data();
  }
  return frame.size > max_shown ? text + " .." : text;
}

}  // namespace

MessageDecoder::MessageDecoder(const RigParams& rig, std::size_t bus)
    : rig_(&rig), host_(rig.host_node_id), describe_(bus_protocol(protocol_of_bus(rig, bus)).describe) {
  const auto add = [&](const auto& devices, auto member) {
    for (const auto& device : devices)
      if (device.bus == bus && device.node_id <= canopen::max_node_id)
        nodes_[device.node_id].*member = &device;
  };
  add(rig.encoders, &Node::encoder);
  add(rig.drives, &Node::drive);
  add(rig.buttons, &Node::button);
}

std::string MessageDecoder::node_name(std::uint8_t id) const {
  const Node& node = nodes_[id];
  if (node.encoder) return node.encoder->joint + " encoder";
  if (node.drive) return node.drive->joint + " drive";
  if (node.button) return "button node " + std::to_string(id);
  return id == host_ ? "host" : "node " + std::to_string(id);
}

/// Computes q = home + sign (counts - offset) / counts_per_unit, with the difference wrapped to half a
/// modulus, as Encoder does. Counts without a modulus wrap at 2^32.
std::string MessageDecoder::coordinate(std::int64_t counts, const Calibration& calibration,
                                       const std::string& joint) const {
  if (calibration.incremental) return "zero unknown: incremental";
  std::int64_t difference = counts - calibration.offset_counts;
  constexpr std::int64_t counts_of_32_bits = std::int64_t{1} << 32;
  const std::int64_t modulus = calibration.modulus_counts == 0
                                   ? counts_of_32_bits
                                   : static_cast<std::int64_t>(calibration.modulus_counts);
  difference = (difference % modulus + modulus) % modulus;
  if (difference >= modulus - modulus / 2) difference -= modulus;
  const double q =
      calibration.home + calibration.sign * static_cast<double>(difference) / calibration.counts_per_unit;
  const char* unit = "rad";
  for (const DeviceJoint& j : rig_->tree.joints)
    if (j.name == joint && j.kind == DeviceJointKind::slider) unit = "m";
  return format("%+.5f %s", q, unit);
}

std::string MessageDecoder::decode_drive(const CanFrame& frame, int number, const DriveParams& drive) const {
  cia402::Status status;
  cia402::Event event;
  if (number == 1 && cia402::parse_status(frame, drive.node_id, status) == ParseResult::ok)
    return format("%s, %s, torque %+.4f Nm", name_of(cia402::decode_state(status.statusword)),
                  coordinate(status.position_counts, drive.calibration, drive.joint).c_str(),
                  cia402::torque_from_per_mille(status.actual_torque_per_mille, drive.torque_rated_Nm));
  if (number == 2 && cia402::parse_event(frame, drive.node_id, event) == ParseResult::ok)
    return format("velocity %d counts/s, mode %d, error code %04Xh",
                  static_cast<int>(event.velocity_counts_per_s), static_cast<int>(event.mode),
                  static_cast<unsigned>(event.error_code));
  return "";
}

std::string MessageDecoder::decode_tpdo(const CanFrame& frame, int number, std::uint8_t id) const {
  const Node& node = nodes_[id];
  std::uint32_t counts = 0;
  if (node.encoder && number == 1 && cia406::parse_position(frame, id, counts) == ParseResult::ok)
    return format("%lld counts, %s", shown_counts(counts, node.encoder->calibration),
                  coordinate(counts, node.encoder->calibration, node.encoder->joint).c_str());
  if (node.drive) return decode_drive(frame, number, *node.drive);
  if (node.button && number == 1 && frame.size >= 1)
    return format("inputs %02Xh", static_cast<unsigned>(frame.data[0]));
  return "";
}

MessageText MessageDecoder::decode_node_message(const CanFrame& frame, std::uint8_t node) const {
  const std::string of = " of " + node_name(node);
  const unsigned function = frame.id >> 7;
  switch (function) {
    case 0x1: return {"EMCY" + of, decode_emergency(frame)};
    case 0xB: return {"SDO answer" + of, decode_sdo(frame, false)};
    case 0xC: return {"SDO request" + of, decode_sdo(frame, true)};
    case 0xE: return {"heartbeat" + of, decode_heartbeat(frame)};
    default: break;
  }
  if (function < 3 || function > 0xA) return {};
  const int number = static_cast<int>(function - 1) / 2;
  const bool is_tpdo = function % 2 == 1;
  std::string name = (is_tpdo ? "TPDO" : "RPDO") + std::to_string(number) + of;
  if (is_tpdo) return {std::move(name), decode_tpdo(frame, number, node)};
  cia402::Command command;
  const DriveParams* const drive = nodes_[node].drive;
  if (number != 1 || !drive || cia402::parse_command(frame, node, command) != ParseResult::ok)
    return {std::move(name), ""};
  return {std::move(name),
          format("controlword %04Xh, torque %+.4f Nm", static_cast<unsigned>(command.controlword),
                 cia402::torque_from_per_mille(command.target_torque_per_mille, drive->torque_rated_Nm))};
}

MessageText MessageDecoder::decode_drive_protocol(const CanFrame& frame) const {
  const DriveText text = describe_(frame);
  if (text.node == 0) return {};
  std::string value = text.value;
  if (text.position_counts) {
    const DriveParams* const drive = nodes_[text.node].drive;
    value =
        (drive ? coordinate(*text.position_counts, drive->calibration, drive->joint)
               : format("%+.5f rev", static_cast<double>(*text.position_counts) / counts_per_motor_turn)) +
        ", " + value;
  }
  return {text.name + " of " + node_name(text.node), std::move(value)};
}

MessageText MessageDecoder::decode(const CanFrame& frame) const {
  if (describe_ != nullptr) return decode_drive_protocol(frame);
  if (!canopen::is_canopen(frame)) return {frame.remote ? "remote frame" : "", ""};
  switch (frame.id) {
    case canopen::nmt_cob_id: return {"NMT", decode_nmt(frame)};
    case canopen::sync_cob_id: return {"SYNC", decode_sync(frame)};
    case 0x100: return {"TIME", ""};
    case 0x7E4: return {"LSS answer", ""};
    case 0x7E5: return {"LSS request", ""};
    default: break;
  }
  const auto node = static_cast<std::uint8_t>(frame.id & canopen::max_node_id);
  return node == 0 ? MessageText{} : decode_node_message(frame, node);
}

void MessageStatistics::add(const ReceivedFrame& received) noexcept {
  if (count == 0) {
    first_ns = received.t_ns;
  } else {
    const Nanoseconds period = received.t_ns - last_ns;
    period_min_ns = count == 1 ? period : std::min(period_min_ns, period);
    period_max_ns = std::max(period_max_ns, period);
  }
  last_ns = received.t_ns;
  last = received.frame;
  ++count;
}

double MessageStatistics::period_s() const noexcept {
  return count < 2 ? 0 : ns * static_cast<double>(last_ns - first_ns) / static_cast<double>(count - 1);
}

double MonitoredBus::load_percent() const noexcept {
  return last_ns > first_ns ? 100 * static_cast<double>(on_wire_ns) / static_cast<double>(last_ns - first_ns)
                            : 0;
}

void MessageTable::add(std::size_t bus, const ReceivedFrame& received) {
  MonitoredBus& b = buses_[bus];
  if (b.count++ == 0) b.first_ns = received.t_ns;
  b.last_ns = received.t_ns;
  b.on_wire_ns += duration_ns(exact_bits(received.frame), b.bit_rates);
  const CanFrame& frame = received.frame;
  messages_[{bus, frame.extended, frame.id, frame.remote}].add(received);
}

std::vector<std::string> MessageTable::lines() const {
  std::vector<std::string> lines;
  std::array<char, 320> line{};
  std::snprintf(line.data(), line.size(), "%-8s %8s  %-34s %9s %9s %25s  %-24s %s", "bus", "id", "message",
                "count", "per s", "period ms min/mean/max", "data", "says");
  lines.emplace_back(line.data());
  for (const auto& [key, message] : messages_) {
    const auto& [bus, extended, id, remote] = key;
    const MessageText text = buses_[bus].decoder.decode(message.last);
    const double period_s = message.period_s();
    std::array<char, 40> period{};
    if (message.count > 1)
      std::snprintf(period.data(), period.size(), "%.3f %.3f %.3f",
                    1e-6 * static_cast<double>(message.period_min_ns), 1e3 * period_s,
                    1e-6 * static_cast<double>(message.period_max_ns));
    std::snprintf(line.data(), line.size(), "%-8s %8.*X  %-34s %9llu %9.1f %25s  %-24s ",
                  buses_[bus].name.c_str(), extended ? 8 : 3, static_cast<unsigned>(id), text.name.c_str(),
                  static_cast<unsigned long long>(message.count), period_s > 0 ? 1 / period_s : 0.0,
                  period.data(), hexadecimal(message.last).c_str());
    lines.push_back(std::string(line.data()) + text.value);
  }
  return lines;
}

}  // namespace godobject
