#include "hal/rig/validate.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "hal/base/format.h"
#include "hal/canopen/canopen.h"
#include "hal/drive/link.h"
#include "hal/joint/kinematic_tree.h"

namespace godobject {

namespace {

class Checker {
 public:
  Checker(const RigParams& rig, double cycle_s) : rig_(rig), cycle_s_(cycle_s) {}

  std::vector<std::string> run() {
    check_timing();
    check_joints();
    check_handles();
    for (const std::string& error : validate(rig_.transmissions, rig_.tree.joints))
      errors_.push_back("transmission: " + error);
    for (const EncoderParams& encoder : rig_.encoders) check_encoder(encoder);
    for (const DriveParams& drive : rig_.drives) check_drive(drive);
    for (const ButtonParams& button : rig_.buttons) check_button(button);
    for (const DeviceJoint& joint : rig_.tree.joints) check_sensors_of(joint);
    for (const std::string& error : homing_errors(rig_)) errors_.push_back(error);
    return std::move(errors_);
  }

 private:
  template <class... Parts>
  void require(bool holds, const Parts&... parts) {
    if (holds) return;
    std::ostringstream text;
    (text << ... << parts);
    errors_.push_back(text.str());
  }

  void require_positive(double value, const std::string& where, const char* key) {
    require(std::isfinite(value) && value > 0, where, key, " is ", value, ", must be > 0");
  }

  void check_timing() {
    require_positive(cycle_s_, "", "step");
    require(rig_.stale_after_s >= cycle_s_, "stale_after is ", rig_.stale_after_s,
            ", must be at least step (", cycle_s_, ")");
    require_positive(rig_.lost_after_s, "", "lost_after");
    require_positive(rig_.boot_timeout_s, "", "boot_timeout");
    require_positive(rig_.heartbeat_timeout_s, "", "heartbeat_timeout");
    require_positive(rig_.heartbeat_period_s, "", "heartbeat_period");
    require(rig_.host_node_id >= 1 && rig_.host_node_id <= canopen::max_node_id, "host_node_id is ",
            int{rig_.host_node_id}, ", must be 1..127");
    require(!rig_.buses.empty() && rig_.buses.size() <= max_buses, "the rig has ", rig_.buses.size(),
            " buses, must be 1..", max_buses);
    for (const BusParams& bus : rig_.buses) check_bus(bus);
  }

  void check_bus(const BusParams& bus) {
    const std::string where = "bus '" + bus.name + "': ";
    require_positive(bus.bit_rate, where, "bit_rate");
    require(bus.data_bit_rate == 0 || (bus.data_bit_rate >= bus.bit_rate && bus.data_bit_rate <= 8e6), where,
            "data_bit_rate is ", bus.data_bit_rate, ", must be bit_rate..8e6, or 0 for a classic bus");
  }

  void check_joints() {
    const auto& joints = rig_.tree.joints;
    require(!joints.empty() && joints.size() <= max_joints, "the device has ", joints.size(),
            " joints, must be 1..", max_joints);
    check_pose(rig_.tree.X_WB, "base pose");
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const DeviceJoint& joint = joints[i];
      const std::string where = "joint '" + joint.name + "': ";
      require(std::abs(joint.axis_J.norm() - 1) < 1e-9, where, "axis must have unit length");
      check_pose(joint.X_PJ, where + "pose");
      require(!joint.name.empty() && std::ranges::count(joints, joint.name, &DeviceJoint::name) == 1, where,
              "name must be given and unique");
      require(joint.name != base_name, where, "is the reserved name of the base: choose another name");
      require(parent_link(joints, i).has_value(), where, "parent is '", joint.parent,
              "', must be an earlier joint or '", base_name, "'");
    }
  }

  void check_handles() {
    const auto& handles = rig_.tree.handles;
    require(!handles.empty() && handles.size() <= max_handles, "the device has ", handles.size(),
            " handles, must be 1..", max_handles);
    for (const HandleParams& handle : handles) {
      const std::string where = "handle of body '" + handle.body + "': ";
      check_pose(handle.X_LH, where + "pose");
      require(!handle.body.empty() && std::ranges::count(handles, handle.body, &HandleParams::body) == 1,
              where, "body must be given and unique");
      require(has_joint(handle.joint), where, "the device has no joint '", handle.joint, "'");
    }
  }

  bool has_joint(const std::string& name) const {
    return std::ranges::find(rig_.tree.joints, name, &DeviceJoint::name) != rig_.tree.joints.end();
  }

  void check_pose(const Pose& X, const std::string& what) {
    require(X.p.allFinite() && std::abs(X.q.norm() - 1) < 1e-9, what,
            " must be finite, with a unit quaternion");
  }

  void check_encoder(const EncoderParams& encoder) {
    const std::string where = "encoder of joint '" + encoder.joint + "': ";
    check_joint(encoder.joint, where);
    check_node(encoder.bus, encoder.node_id, where);
    check_canopen(encoder.bus, where);
    check_calibration(encoder.calibration, "sign", encoder.max_speed, where);
  }

  void check_drive(const DriveParams& drive) {
    const std::string where = "drive of joint '" + drive.joint + "': ";
    check_joint(drive.joint, where);
    check_node(drive.bus, drive.node_id, where);
    check_protocol(drive, where);
    check_calibration(drive.calibration, "counts_sign", drive.max_speed, where);
    require_positive(drive.torque_rated_Nm, where, "torque_rated_Nm");
    require_positive(drive.torque_max_Nm, where, "torque_max_Nm");
    require_positive(drive.torque_rate_Nm_per_s, where, "torque_rate_Nm_per_s");
    require_positive(drive.joint_per_motor_rad, where, "joint_per_motor_rad");
    require(drive.sign == 1 || drive.sign == -1, where, "sign is ", drive.sign, ", must be 1 or -1");
    const double max_slip = drive.max_slip.value_or(0);
    require(std::isfinite(max_slip) && max_slip >= 0, where, "max_slip is ", max_slip, ", must be >= 0");
    require(max_slip == 0 || std::ranges::count(rig_.encoders, drive.joint, &EncoderParams::joint) > 0, where,
            "max_slip needs an encoder on its joint: add one, or set max_slip = 0");
    require(drive.watchdog_ms > 0, where, "watchdog_ms is 0, must be > 0");
    require(drive.status_every_nth_sync >= 1 && drive.status_every_nth_sync <= 240, where,
            "status_every_nth_sync is ", int{drive.status_every_nth_sync}, ", must be 1..240");
  }

  // Checks the requirements of a drive's protocol on the drive and its bus.
  void check_protocol(const DriveParams& drive, const std::string& where) {
    const double max_Nm = max_encodable_torque_Nm(drive);
    require(drive.torque_max_Nm <= max_Nm, where, "torque_max_Nm is ", drive.torque_max_Nm,
            ", must be at most ", max_Nm, " with this torque_rated_Nm");
    const BusProtocol protocol = bus_protocol(drive.protocol);
    require(protocol.canopen || drive.status_every_nth_sync == 1, where, "status_every_nth_sync is ",
            int{drive.status_every_nth_sync}, ", must be 1: it answers every request");
    const char* name = drive_protocol_names[static_cast<std::size_t>(drive.protocol)];
    require(drive.node_id <= protocol.max_node_id, where, "node_id is ", int{drive.node_id}, ", must be 1..",
            int{protocol.max_node_id}, " with protocol ", name);
    if (drive.bus >= rig_.buses.size()) return;
    const BusParams& bus = rig_.buses[drive.bus];
    require(!protocol.fd || bus.data_bit_rate > 0, where, "bus '", bus.name,
            "' has no data_bit_rate: protocol ", name, " needs CAN FD");
    require(drive.protocol == protocol_of_bus(rig_, drive.bus), where, "bus '", bus.name,
            "' has drives of another protocol: use one bus per protocol");
  }

  void check_canopen(std::size_t bus, const std::string& where) {
    require(bus >= rig_.buses.size() || bus_protocol(protocol_of_bus(rig_, bus)).canopen, where,
            "its bus has drives that are no CANopen nodes: move them to another bus");
  }

  void check_joint(const std::string& joint, const std::string& where) {
    require(has_joint(joint), where, "the device has no such joint");
  }

  // Checks a button. Buttons may share a node as bits; any other device has its own node.
  void check_button(const ButtonParams& button) {
    const std::string where = "button of node " + std::to_string(button.node_id) + ": ";
    require(button.bit <= 7, where, "bit is ", int{button.bit}, ", must be 0..7");
    const auto same_bit = [&](const ButtonParams& other) {
      return other.bus == button.bus && other.node_id == button.node_id && other.bit == button.bit;
    };
    require(std::ranges::count_if(rig_.buttons, same_bit) == 1, where, "bit ", int{button.bit},
            " is used by another button");
    const auto on_node = [&](const ButtonParams& other) {
      return other.bus == button.bus && other.node_id == button.node_id;
    };
    if (&*std::ranges::find_if(rig_.buttons, on_node) != &button) return;
    check_node(button.bus, button.node_id, where);
    check_canopen(button.bus, where);
  }

  void check_node(std::size_t bus, std::uint8_t node_id, const std::string& where) {
    require(bus < rig_.buses.size(), where, "bus index is ", bus, ", the rig has ", rig_.buses.size(),
            " buses");
    require(node_id >= 1 && node_id <= canopen::max_node_id, where, "node_id is ", int{node_id},
            ", must be 1..127");
    require(node_id != rig_.host_node_id, where, "node_id ", int{node_id}, " is the host's own");
    require(std::ranges::find(nodes_, std::pair(bus, node_id)) == nodes_.end(), where, "node_id ",
            int{node_id}, " is taken by another device on the same bus");
    nodes_.emplace_back(bus, node_id);
  }

  void check_calibration(const Calibration& calibration, const char* sign_key, double max_speed,
                         const std::string& where) {
    require_positive(calibration.counts_per_unit, where, "counts_per_unit");
    require(calibration.sign == 1 || calibration.sign == -1, where, sign_key, " is ", calibration.sign,
            ", must be 1 or -1");
    require(std::isfinite(calibration.home), where, "home is ", calibration.home, ", must be finite");
    require(!calibration.incremental || calibration.offset_counts == 0, where,
            "offset_counts has no meaning with incremental = true, because homing measures it: remove it");
    constexpr std::uint64_t counts_of_32_bits = std::uint64_t{1} << 32;
    require(calibration.modulus_counts <= counts_of_32_bits && calibration.modulus_counts != 1, where,
            "modulus_counts is ", calibration.modulus_counts, ", must be 2..2^32, or 0 for none");
    require_positive(max_speed, where, "max_speed");
    // a travel of half the modulus is indistinguishable from the opposite turn
    const std::uint64_t modulus =
        calibration.modulus_counts == 0 ? counts_of_32_bits : calibration.modulus_counts;
    const double reach_counts = max_speed * calibration.counts_per_unit * rig_.stale_after_s;
    require(2 * reach_counts < static_cast<double>(modulus), where,
            "at max_speed the joint travels half of modulus_counts within stale_after: lower one of them");
  }

  void check_sensors_of(const DeviceJoint& joint) {
    const auto on_joint = [&](const auto& device) { return device.joint == joint.name; };
    const auto encoders = std::ranges::count_if(rig_.encoders, on_joint);
    const auto drives = std::ranges::count_if(rig_.drives, on_joint);
    const std::string where = "joint '" + joint.name + "': ";
    require(encoders + drives > 0, where, "has no sensor: add an encoder or a drive");
    require(encoders <= 1, where, "has ", encoders, " encoders, at most one is allowed");
    require(drives <= 1, where, "has ", drives, " drives, at most one is allowed");
  }

  const RigParams& rig_;
  double cycle_s_;
  std::vector<std::string> errors_;
  std::vector<std::pair<std::size_t, std::uint8_t>> nodes_;  // bus, node id
};

}  // namespace

std::vector<std::string> homing_errors(const RigParams& rig) {
  std::vector<std::string> errors;
  const bool has_button = std::ranges::count(rig.buttons, ButtonUse::home, &ButtonParams::use) > 0;
  bool has_homed_joint = false;
  for (const DeviceJoint& joint : rig.tree.joints) {
    if (!is_incremental(rig, joint.name)) continue;
    has_homed_joint = true;
    const std::string where = "joint '" + joint.name + "': ";
    if (!has_button)
      errors.push_back(where +
                       "its sensor is incremental, so the user must confirm the home pose: add a "
                       "[[device.button]] with use = \"home\"");
    const double home = sensor_of(rig, joint.name)->home;
    const bool is_within = !joint.lower || !joint.upper || (home >= *joint.lower && home <= *joint.upper);
    if (!is_within && !is_coupled(rig, joint.name))
      errors.push_back(where + format("home of its sensor is %g, must be within lower and upper", home));
  }
  if (has_button && !has_homed_joint)
    errors.emplace_back(
        "a button has use = \"home\", but no joint is measured by an incremental sensor: give its encoder or "
        "drive incremental = true, or remove the button");
  return errors;
}

std::vector<std::string> validate(const RigParams& rig, double cycle_s) {
  return Checker(rig, cycle_s).run();
}

}  // namespace godobject
