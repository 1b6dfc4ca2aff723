// Keys of nodes on the buses of the device: encoders, drives, buttons.
#pragma once

#include <numbers>
#include <set>

#include "hal/drive/link.h"
#include "platform/scene/keys/device_joint.h"

namespace godobject {

template <class V>
void visit_node(V& v, const RigNames& names, std::string_view id_meaning, std::size_t& bus,
                std::uint8_t& node_id) {
  v.one_of(Key{.name = "bus", .unit = "", .meaning = "", .required = true}, names.buses, bus);
  v.value(Key{"node_id", "", id_meaning, {1, 127}, true}, node_id);
}

template <class V>
void visit_sensor_node(V& v, const RigNames& names, std::string_view id_meaning, std::string& joint,
                       std::size_t& bus, std::uint8_t& node_id, std::string& profile,
                       unsigned& profile_line) {
  choose(v, Key{.name = "joint", .unit = "", .meaning = "", .required = true}, names.joints, joint);
  visit_node(v, names, id_meaning, bus, node_id);
  v.value(Key{"profile", "", "commissions a CANopen node (docs/canopen.md); empty: it is configured already"},
          profile);
  profile_line = v.line_of("profile");
}

template <class V>
void visit_scale(V& v, std::string_view sign_key, std::string_view counts_meaning, const RigNames& names,
                 const std::string& joint, Calibration& c) {
  v.either(Key{"counts_per_unit", "1/rad or 1/m", counts_meaning, positive, true},
           Key{"counts_per_turn", "", "of a hinge", positive}, 1 / (2 * std::numbers::pi), std::nullopt,
           c.counts_per_unit);
  const auto index = static_cast<std::size_t>(std::ranges::find(names.joints, joint) - names.joints.begin());
  const bool slider = index < names.kinds.size() && names.kinds[index] == DeviceJointKind::slider;
  v.check(!(slider && v.has("counts_per_turn")), "counts_per_turn",
          "has no meaning on a slider: give counts_per_unit in 1/m");
  visit_sign(v, Key{sign_key, "", "1 or -1: direction of rising counts", {-1, 1}}, c.sign);
}

template <class V>
void visit_zero(V& v, Calibration& c, double& max_speed) {
  v.value(Key{"offset_counts", "", "count at `home`", {-9007199254740992.0, 9007199254740992.0}},
          c.offset_counts);
  v.value(
      Key{"home", "rad or m", "coordinate at `offset_counts`, e.g. in a jig; incremental: in the home pose"},
      c.home);
  v.value(Key{"incremental", "",
              "it forgets its zero without power: each boot waits for the home pose "
              "([how to](how-to/calibrate.md#incremental-encoders))"},
          c.incremental);
  v.check(!c.incremental || c.offset_counts == 0, "offset_counts",
          "has no meaning with incremental = true, because homing measures it: remove it");
  v.value(Key{"modulus_counts", "", "counts wrap here; 0: never", {0, 4294967296.0}}, c.modulus_counts);
  v.value(Key{"max_speed", "rad/s or m/s", "largest plausible speed; faster samples are rejected", positive},
          max_speed);
}

template <class V>
void visit_encoder(V& v, const RigNames& names, EncoderParams& e) {
  visit_sensor_node(v, names, "CANopen node-ID", e.joint, e.bus, e.node_id, e.profile, e.profile_line);
  visit_scale(v, "sign", "counts per unit of the joint's coordinate", names, e.joint, e.calibration);
  visit_zero(v, e.calibration, e.max_speed);
}

template <class V>
void visit_watchdog(V& v, DriveParams& d) {
  choose(v,
         Key{"watchdog", "",
             "stops the motor when the host has died. host: set up by `profile` or protocol; a scene that "
             "displays force is refused if neither does. drive: set in the drive, as on an ODrive. none: no "
             "watchdog, by intent"},
         drive_watchdog_names, d.watchdog);
  v.value(Key{"watchdog_ms", "ms", "time of the watchdog set in the drive", {1, 65535}}, d.watchdog_ms);
}

template <class V>
void visit_drive(V& v, const RigNames& names, DriveParams& d) {
  visit_sensor_node(v, names, "CANopen node-ID; ODrive: 1 to 62; moteus: its id", d.joint, d.bus, d.node_id,
                    d.profile, d.profile_line);
  choose(v, Key{"protocol", "", "each requires a bus of its own (docs/new-device.md)"}, drive_protocol_names,
         d.protocol);
  const BusProtocol protocol = bus_protocol(d.protocol);
  v.check(protocol.canopen || d.profile.empty(), "profile", "has no meaning with this protocol: remove it");
  v.check(d.node_id <= protocol.max_node_id, "node_id",
          "must be at most " + std::to_string(protocol.max_node_id) + " with this protocol");
  v.value(Key{"torque_rated_Nm", "N m", "CiA 402: rated torque 6076h; targets are per mille of it", positive},
          d.torque_rated_Nm);
  v.value(Key{"torque_max_Nm", "N m", "bound of the command, at the motor's shaft", positive},
          d.torque_max_Nm);
  const double max_Nm = max_encodable_torque_Nm(d);
  v.check(d.torque_max_Nm <= max_Nm, "torque_max_Nm",
          format("must be at most %g N m: commands in per mille of torque_rated_Nm encode no more", max_Nm));
  v.value(Key{"torque_rate_Nm_per_s", "N m/s", "slew limit, at the motor's shaft", positive},
          d.torque_rate_Nm_per_s);
  v.value(Key{"joint_per_motor_rad", "rad/rad or m/rad", "joint coordinate per rad of the motor", positive},
          d.joint_per_motor_rad);
  visit_sign(v, Key{"sign", "", "1 or -1: joint torque of a positive motor torque", {-1, 1}}, d.sign);
  v.value(Key{"status_every_nth_sync", "", "CiA 402: TPDO1 at every n-th SYNC", {1, 240}},
          d.status_every_nth_sync);
  v.check(protocol.canopen || d.status_every_nth_sync == 1, "status_every_nth_sync",
          "must be 1 with this protocol: the drive answers every request");
  visit_scale(v, "counts_sign",
              "counts per unit of the joint's coordinate; ODrive, moteus: 100000 per turn of the motor",
              names, d.joint, d.calibration);
  if constexpr (requires { v.keys_of("", "", ""); })
    v.keys_of("[[device.encoder]]", "offset_counts", "max_speed");
  else visit_zero(v, d.calibration, d.max_speed);
  visit_watchdog(v, d);
  v.value(Key{"max_slip", "rad or m",
              "largest difference of drive and encoder once enabled, plus the travel in `stale_after`; "
              "beyond: fault `sensors_disagree`. 0: not compared, as without an encoder",
              not_negative, false, "0.05 rad or 0.005 m, and 2 counts of each sensor"},
          d.max_slip);
}

template <class V>
void visit_button(V& v, const RigNames& names, ButtonParams& b) {
  choose(
      v,
      Key{"use", "",
          "hold: presses grip the nearest body and release it in turn; clutch: closes a relative device's "
          "clutch while pressed; stop: emergency stop, best a contact that opens, active_low; home: confirms "
          "the home pose of incremental sensors"},
      button_use_names, b.use);
  visit_node(v, names, "CANopen node-ID", b.bus, b.node_id);
  v.value(Key{"bit", "", "of the node's first eight inputs, 6000h:01", {0, 7}}, b.bit);
  v.value(Key{"active_low", "", "the input is 0 while pressed"}, b.active_low);
}

/// A node whose bus or id could not be read blocks no other node.
template <class V>
bool understands_node(const V& v) {
  return v.understood("bus") && v.understood("node_id");
}

/// Visits the buttons, several of which may be bits of one node.
/// nodes: bus and id of other devices.
template <class V>
void visit_buttons(V& v, const RigNames& names, const std::set<std::pair<std::size_t, int>>& nodes,
                   RigParams& rig) {
  std::set<std::array<std::size_t, 3>> bits;
  v.tables(TableKey{"button", "A digital input of a CiA 401 node."}, rig.buttons,
           [&](auto& t, ButtonParams& b) {
             visit_button(t, names, b);
             if (!understands_node(t)) return;
             t.check(b.node_id != rig.host_node_id && !nodes.contains({b.bus, b.node_id}), "node_id",
                     "is taken by the host or by another device of this bus: choose another");
             t.check(bits.insert({b.bus, b.node_id, b.bit}).second, "bit",
                     "is the input of an earlier button: choose another");
           });
}

template <class V>
void visit_nodes(V& v, const RigNames& names, RigParams& rig) {
  std::set<std::pair<std::size_t, int>> nodes;
  const auto check_node = [&](auto& t, std::size_t bus, int node_id) {
    if (!understands_node(t)) return;
    t.check(node_id != rig.host_node_id, "node_id",
            "is the host's own node-ID: choose another, or change host_node_id in [device.supervision]");
    t.check(nodes.emplace(bus, node_id).second, "node_id",
            "is taken by another node of this bus: choose another");
  };
  v.tables(TableKey{"encoder", "A CiA 406 encoder."}, rig.encoders, [&](auto& t, EncoderParams& e) {
    visit_encoder(t, names, e);
    check_node(t, e.bus, e.node_id);
  });
  v.tables(TableKey{"drive", "A drive commanded in torque; CiA 402: mode CST."}, rig.drives,
           [&](auto& t, DriveParams& d) {
             visit_drive(t, names, d);
             check_node(t, d.bus, d.node_id);
           });
  visit_buttons(v, names, nodes, rig);
}

/// Checks that a bus has nodes of one protocol and the data rate that it requires.
template <class V>
void check_protocols(V& v, const RigParams& rig) {
  for (std::size_t bus = 0; bus < rig.buses.size(); ++bus) {
    const DriveProtocol protocol = protocol_of_bus(rig, bus);
    const std::string name = "'" + rig.buses[bus].name + "'";
    const auto on_bus = [bus](const auto& device) { return device.bus == bus; };
    const auto other = [&](const DriveParams& d) { return d.bus == bus && d.protocol != protocol; };
    const bool canopen_nodes =
        std::ranges::any_of(rig.encoders, on_bus) || std::ranges::any_of(rig.buttons, on_bus);
    v.check(std::ranges::none_of(rig.drives, other) && (bus_protocol(protocol).canopen || !canopen_nodes), "",
            "bus " + name + " has devices of more than one protocol: give each protocol a bus of its own");
    v.check(!bus_protocol(protocol).fd || rig.buses[bus].data_bit_rate > 0, "",
            "bus " + name + " carries CAN FD: give it a data_bit_rate, e.g. 5e6");
  }
}

/// True if a rig measures the joints, at least in part; without a rig only a motion moves them.
inline bool has_parts_on_buses(const RigParams& rig) {
  return !rig.encoders.empty() || !rig.drives.empty() || !rig.buttons.empty() || !rig.buses.empty() ||
         !rig.transmissions.empty();
}

}  // namespace godobject
