// Rig: texts of its faults.
#include <iomanip>
#include <sstream>

#include "hal/base/format.h"
#include "hal/rig/rig.h"

namespace godobject {

namespace {

std::string device_text(const RigParams& params, const RigNode& node) {
  switch (node.kind) {
    case NodeKind::encoder: return "encoder of " + params.encoders[node.device].joint;
    case NodeKind::drive: return "drive of " + params.drives[node.device].joint;
    case NodeKind::button: break;
  }
  return "button";
}

const char* why_text(ParseResult why) {
  switch (why) {
    case ParseResult::too_short: return ", which is too short";
    case ParseResult::too_long: return ", which is too long";
    case ParseResult::bad_value: return ", which contains an undefined value";
    case ParseResult::ok:
    case ParseResult::other_message: break;
  }
  return "";
}

const char* nmt_text(std::uint8_t state) {
  switch (static_cast<canopen::NmtState>(state)) {
    case canopen::NmtState::boot_up: return "has not left its boot-up state";
    case canopen::NmtState::stopped: return "is stopped (NMT)";
    case canopen::NmtState::operational: return "is operational";
    case canopen::NmtState::pre_operational: break;
  }
  return "is pre-operational";
}

/// Returns how far the boot of a node got; begins with a comma.
std::string boot_text(const NodeEvidence& seen, const RigNode& node) {
  const char* const heartbeat = node.canopen ? "heartbeat" : "supervision message";
  if (!seen.heard && !seen.answered && seen.malformed == 0) return ", no frame of it was received";
  std::string text;
  if (!seen.heard) text += std::string(", no ") + heartbeat + " was received";
  else if (node.canopen) text += std::string(", it ") + nmt_text(seen.nmt_state);
  if (seen.heard && seen.silent) text += std::string(", its ") + heartbeat + " is missing";
  const char* const answer = !node.canopen                   ? "answer to a request"
                             : node.kind == NodeKind::button ? "TPDO1 with its inputs"
                             : node.kind == NodeKind::drive  ? "TPDO1 with its status"
                                                             : "TPDO1 with its position";
  if (!seen.answered) text += std::string(", no ") + answer + " was received";
  else if (seen.delay_unknown)
    text += std::string(", its answers came without requests or later than stale_after") +
            (node.canopen ? ": set TPDO1's transmission type to 1" : "");
  return text;
}

/// Returns state and error of a drive in the terms of its protocol; begins with a comma.
std::string drive_text(const NodeEvidence& seen, const DriveParams& drive) {
  const BusProtocol protocol = bus_protocol(drive.protocol);
  std::string text;
  if (seen.has_own_state) text += ", " + protocol.state_text(drive, seen.own_state);
  if (seen.error_code != 0) text += ", " + protocol.error_text(seen.error_code, seen.own_state);
  return text;
}

}  // namespace

std::string homing_request(const RigParams& rig) {
  std::string joints, buttons;
  for (const DeviceJoint& joint : rig.tree.joints) {
    if (!is_incremental(rig, joint.name)) continue;
    joints += (joints.empty() ? "" : ", ") + joint.name + format(" %g", sensor_of(rig, joint.name)->home);
    joints += is_rotary(rig, joint.name) ? " rad" : " m";
  }
  for (const ButtonParams& button : rig.buttons) {
    if (button.use != ButtonUse::home) continue;
    buttons += (buttons.empty() ? "" : " or ") + rig.buses[button.bus].name +
               format(" node %d, input %d", int{button.node_id}, button.bit + 1);
  }
  return "put the device into its home pose (" + joints + "), keep it at rest, then press the button of " +
         buttons;
}

std::string Rig::fault_text() const {
  std::ostringstream out;
  for (const RigFaultRecord& record : fault_log_.records()) {
    const RigFaultText& text = text_of(record.place.fault);
    out << text.name << " (" << place_text(record) << "): " << text.meaning << "; " << text.remedy << ".\n";
  }
  if (fault_log_.left_out() > 0) out << "and at " << fault_log_.left_out() << " more places.\n";
  return out.str();
}

/// Returns the evidence, beginning with a comma, or an empty text. Depends on the parameters and the record
/// only.
std::string Rig::evidence_text(const RigFaultRecord& record) const {
  const RigNode* const node = node_at(record.place);
  const RigFault fault = record.place.fault;
  constexpr RigFault of_boot = RigFault::boot_timeout;
  constexpr RigFault of_drives = RigFault::drive_not_enabled | RigFault::drive_error;
  constexpr RigFault of_samples = RigFault::sample_stale | RigFault::drive_silent | RigFault::heartbeat_lost;
  if (node == nullptr || !any(fault & (of_boot | of_drives | of_samples))) return "";
  const NodeEvidence& seen = record.evidence;
  std::string text;
  if (fault == of_boot) text += boot_text(seen, *node);
  if (node->kind == NodeKind::drive && any(fault & (of_boot | of_drives)))
    text += drive_text(seen, params_.drives[node->device]);
  if (seen.malformed == 0 || any(fault & of_drives)) return text;
  const MalformedFrame& last = seen.last_malformed;
  text += format(", %llu of its frames were invalid, the last %03X of %d bytes",
                 static_cast<unsigned long long>(seen.malformed), last.identifier, int{last.size});
  return text + why_text(last.why);
}

std::string Rig::place_text(const RigFaultRecord& record) const {
  const RigFaultPlace& place = record.place;
  std::ostringstream out;
  out << (place.bus ? params_.buses[*place.bus].name : "host");
  if (place.bus && place.node_id != 0) {
    out << " node " << int{place.node_id} << ", " << device_text(params_, *node_at(place));
  }
  if (place.fault == RigFault::drive_error && place.drive_code != 0) out << ", code " << place.drive_code;
  out << evidence_text(record);
  out << std::hex;
  if (place.fault == RigFault::emergency) out << ", code 0x" << place.emcy_code;
  if (place.fault == RigFault::second_host)
    out << ", identifier 0x" << std::setw(3) << std::setfill('0') << record.identifier;
  return out.str();
}

}  // namespace godobject
