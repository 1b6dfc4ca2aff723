// All keys below [device] of a scene file. Visitors: platform/scene/text/key.h.
#pragma once

#include <numbers>
#include <set>

#include "hal/drive/link.h"
#include "hal/joint/kinematic_tree.h"
#include "platform/scene/joint/joints.h"
#include "platform/scene/keys/hand.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

inline constexpr double default_stale_steps = 3;

template <class V>
void visit_limits(V& v, LimitConfig& l) {
  v.value(Key{"force", "N", "largest displayed force", positive}, l.force);
  v.value(Key{"torque", "N m", "largest displayed torque", positive}, l.torque);
  v.value(Key{"force_rate", "N/s", "of the force", positive}, l.force_rate);
  v.value(Key{"torque_rate", "N m/s", "of the torque", positive}, l.torque_rate);
  v.value(Key{"ramp", "s", "from engaging to full coupling; 0: at once", {0, 60}}, l.ramp);
  v.value(Key{"grab_ramp", "s", "from gripping to full coupling", {0, 60}}, l.grab_ramp);
}

/// Names to which joints, handles, encoders and drives refer.
struct RigNames {
  std::vector<std::string> bodies;  // those that can have a handle
  std::vector<std::string> buses, joints;
  std::vector<DeviceJointKind> kinds;  // kinds of the joints
};

template <class V>
void visit_joint(V& v, const RigNames& names, DeviceJoint& j) {
  visit_name(v, "name, for other tables and columns of motions", j.name);
  v.check(j.name != base_name, "name", "is the name of the base: choose another name");
  std::vector<std::string> parents{base_name};
  parents.insert(parents.end(), names.joints.begin(), names.joints.end());
  if (j.parent.empty()) j.parent = parents.back();
  choose(v,
         Key{.name = "parent",
             .unit = "",
             .meaning = "earlier joint that carries it, or `\"base\"`",
             .otherwise = "the joint before it"},
         parents, j.parent);
  choose(v, Key{"kind", "", "turn (rad) about, or slide (m) along `axis`"}, std::array{"hinge", "slider"},
         j.kind);
  visit_pose(v, "position", "orientation_wxyz", "the joint's frame on the parent's link, at coordinate 0",
             j.X_PJ);
  v.unit_vector(Key{"axis", "", "unit vector in the joint's frame"}, j.axis_J);
  v.value(Key{"mass", "kg", "of its link, for the gravity of `[device.plant]`", not_negative}, j.mass);
  v.value(Key{"center_of_mass", "m", "of its link, from the joint's frame at coordinate 0"}, j.p_LM);
}

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
  v.value(Key{"home", "rad or m", "coordinate at `offset_counts`, e.g. in a jig"}, c.home);
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
  choose(v,
         Key{"use", "",
             "hold: presses grip the nearest body and release it in turn; clutch: closes a relative device's "
             "clutch while pressed; stop: emergency stop, best a contact that opens, active_low"},
         button_use_names, b.use);
  visit_node(v, names, "CANopen node-ID", b.bus, b.node_id);
  v.value(Key{"bit", "", "of the node's first eight inputs, 6000h:01", {0, 7}}, b.bit);
  v.value(Key{"active_low", "", "the input is 0 while pressed"}, b.active_low);
}

/// Default mechanics of a slider, equal to those of a hinge of 1e-3 kg m^2 and 1e-2 N m s/rad on a lever of
/// 0.1 m. The arm has about 500 N/m.
inline constexpr JointPlant plant_of_sliders{
    .inertia = 0.1, .damping = 1, .friction = 0.01, .hand_stiffness = 500, .hand_damping = 10};

inline bool is_slider(const DeviceJoint& joint) { return joint.kind == DeviceJointKind::slider; }

/// otherwise: text of the default of each of the five keys.
template <class V>
void visit_joint_plant(V& v, const std::array<std::string_view, 5>& otherwise, JointPlant& p) {
  std::size_t i = 0;
  const auto value = [&](std::string_view name, std::string_view unit, std::string_view meaning, Range range,
                         double& x) {
    v.value(Key{.name = name, .unit = unit, .meaning = meaning, .range = range, .otherwise = otherwise[i++]},
            x);
  };
  value("inertia", "kg m^2 or kg", "inertia or mass, seen at the joint", positive, p.inertia);
  value("damping", "N m s/rad or N s/m",
        "without the hand; state it for a real device too: the margins of `godobject check` depend on it",
        not_negative, p.damping);
  value("friction", "N m or N", "Coulomb friction", not_negative, p.friction);
  value("hand_stiffness", "N m/rad or N/m", "of the user's arm", not_negative, p.hand_stiffness);
  value("hand_damping", "N m s/rad or N s/m", "of the user's arm", not_negative, p.hand_damping);
}

/// Returns the mechanics of a device whose file has none; slides have defaults of their own.
inline PlantConfig default_plant(const std::vector<DeviceJoint>& joints) {
  PlantConfig plant;
  if (!joints.empty() && std::ranges::all_of(joints, is_slider)) {
    static_cast<JointPlant&>(plant) = plant_of_sliders;
    return plant;
  }
  for (const DeviceJoint& joint : joints)
    if (is_slider(joint)) plant.joints.push_back({.joint = joint.name, .plant = plant_of_sliders});
  return plant;
}

/// Copies values given for all joints to the joints with defaults of their kind.
template <class V>
void take_numbers_of_all(const V& v, PlantConfig& p) {
  const auto take = [&](std::string_view key, double JointPlant::*x) {
    if (!v.has(key)) return;
    for (PlantConfig::OfJoint& of_slide : p.joints) of_slide.plant.*x = p.*x;
  };
  take("inertia", &JointPlant::inertia);
  take("damping", &JointPlant::damping);
  take("friction", &JointPlant::friction);
  take("hand_stiffness", &JointPlant::hand_stiffness);
  take("hand_damping", &JointPlant::hand_damping);
}

/// Warns of one value for turns and slides, whose units differ.
/// own: joints with a table of their own.
template <class V>
void advise_on_units(V& v, const std::vector<DeviceJoint>& joints,
                     const std::vector<PlantConfig::OfJoint>& own) {
  if (std::ranges::all_of(joints, is_slider)) return;
  for (const DeviceJoint& joint : joints) {
    if (!is_slider(joint) || std::ranges::find(own, joint.name, &PlantConfig::OfJoint::joint) != own.end())
      continue;
    for (const char* const key : {"inertia", "damping", "friction"})
      v.advise(!v.has(key), key,
               "is one number for turns and for the slide '" + joint.name +
                   "', which have different units: give the slide a [[device.plant.joint]] table");
  }
}

/// p: default_plant(), or the result of an earlier visit.
template <class V>
void visit_plant(V& v, const std::vector<DeviceJoint>& joints, PlantConfig& p) {
  visit_joint_plant(v,
                    {"0.001, of a slide 0.1", "0.01, of a slide 1.0", "0.001, of a slide 0.01",
                     "20.0, of a slide 500.0", "0.5, of a slide 10.0"},
                    p);
  take_numbers_of_all(v, p);
  v.value(Key{"gravity", "m/s^2", "on the links that have a mass, world axes"}, p.gravity_W);
  std::vector<std::string> names;
  for (const DeviceJoint& joint : joints) names.push_back(joint.name);
  std::vector<PlantConfig::OfJoint> own = p.joints;
  v.tables(TableKey{"joint", "The same of one joint."}, own, [&](auto& t, PlantConfig::OfJoint& j) {
    choose(t, Key{.name = "joint", .unit = "", .meaning = "", .required = true}, names, j.joint);
    if constexpr (requires { t.keys_of("", "", ""); })
      return t.keys_of("[device.plant]", "inertia", "hand_damping");
    j.plant = p.of(j.joint);
    constexpr std::string_view as_all = "as `[device.plant]`";
    visit_joint_plant(t, {as_all, as_all, as_all, as_all, as_all}, j.plant);
    t.check(j.joint.empty() || std::ranges::count(own, j.joint, &PlantConfig::OfJoint::joint) == 1, "joint",
            "has an earlier table");
  });
  advise_on_units(v, joints, own);
  for (const PlantConfig::OfJoint& j : p.joints)
    if (std::ranges::find(own, j.joint, &PlantConfig::OfJoint::joint) == own.end()) own.push_back(j);
  p.joints = own;
}

/// Returns the speed of a joint from which the direction of its motion is certain: two counts a step.
inline double certain_speed(const RigParams& rig, const std::string& joint, double step_s) {
  const Calibration* const sensor = sensor_of(rig, joint);
  return 2 / ((sensor == nullptr ? 1 : sensor->counts_per_unit) * step_s);
}

/// plant: mechanics of the device, which the drives compensate.
template <class V>
void visit_compensation(V& v, const PlantConfig& plant, double step_s, RigParams* rig,
                        CompensationConfig& c) {
  v.value(Key{"gravity", "", "drives carry the links: masses of joints, gravity of `[device.plant]`"},
          c.gravity);
  v.value(Key{"friction", "", "share of the friction of `[device.plant]` that they overcome", {0, 1}},
          c.friction);
  v.value(Key{"ahead", "s", "handles are predicted over this time, the delay of bus and drives", {0, 0.1}},
          c.ahead_s);
  const bool has_drives = rig != nullptr && !rig->drives.empty();
  v.check(has_drives || (!c.gravity && c.friction == 0), "", "needs drives: add [[device.drive]]");
  v.check(rig != nullptr || c.ahead_s == 0, "ahead", "needs joints with encoders: add [[device.encoder]]");
  if (rig == nullptr) return;
  const bool has_weight =
      !plant.gravity_W.isZero() &&
      std::ranges::any_of(rig->tree.joints, [](const DeviceJoint& j) { return j.mass > 0; });
  v.check(!c.gravity || has_weight, "gravity",
          "has nothing to carry: give `mass` in [[device.joint]] and `gravity` in [device.plant]");
  CompensationParams& params = rig->compensation;
  params = {.gravity_W = c.gravity ? plant.gravity_W : Vec3::Zero(), .ahead_s = c.ahead_s};
  if (c.friction == 0) return;
  for (const DeviceJoint& joint : rig->tree.joints) {
    params.friction.push_back(c.friction * plant.of(joint.name).friction);
    params.certain_speed.push_back(certain_speed(*rig, joint.name, step_s));
  }
}

template <class V>
void visit_supervision(V& v, RigParams& rig) {
  v.value(Key{"stale_after", "s", "age beyond which the pose is held and the force fades", positive, false,
              "3 steps"},
          rig.stale_after_s);
  rig.lost_after_s = std::max(rig.lost_after_s, rig.stale_after_s);
  v.value(
      Key{"lost_after", "s", "time without a valid sample until a fault; at least `stale_after`", positive},
      rig.lost_after_s);
  v.check(rig.lost_after_s >= rig.stale_after_s, "lost_after", "must be at least stale_after");
  v.value(Key{"boot_timeout", "s", "until every drive is enabled", positive}, rig.boot_timeout_s);
  v.value(Key{"heartbeat_timeout", "s", "time without a node's heartbeat, once one arrived, until a fault",
              positive},
          rig.heartbeat_timeout_s);
  v.value(Key{"heartbeat_period", "s", "of the host", positive}, rig.heartbeat_period_s);
  v.value(Key{"host_node_id", "", "of the host on every bus", {1, 127}}, rig.host_node_id);
}

template <class V>
void visit_joints(V& v, std::vector<DeviceJoint>& joints, RigNames& names) {
  v.tables(
      TableKey{"joint",
               "A joint of the device and its link, parents first. Without any: the tool's coordinates."},
      joints, [&](auto& t, DeviceJoint& j) {
        visit_joint(t, names, j);
        t.check(std::ranges::find(names.joints, j.name) == names.joints.end(), "name",
                "is the name of an earlier joint");
        names.joints.push_back(j.name);
        names.kinds.push_back(j.kind);
      });
}

/// Visits the transmissions. Sensors and drives of their joints turn, also those of sliders.
template <class V>
void visit_transmissions(V& v, RigNames& names, RigParams& rig) {
  v.tables(
      TableKey{"transmission",
               "Cables and discs that couple joints, q = M a. The drive and the encoder that name the i-th "
               "joint are on the i-th actuator: their counts, limits and slip are those of a_i."},
      rig.transmissions, [&](auto& t, TransmissionParams& m) {
        t.value(Key{.name = "joints", .unit = "", .meaning = "its joints, in order", .required = true},
                m.joints);
        t.value(Key{.name = "joint_per_actuator",
                    .unit = "rad/rad or m/rad",
                    .meaning = "matrix M, a row for each of its joints; torques of actuators are M^T tau",
                    .required = true},
                m.joint_per_actuator);
        if (m.joints.empty() || m.joint_per_actuator.empty()) return;  // reported by their keys
        for (const std::string& error : validate(std::span(&m, 1), rig.tree.joints))
          t.check(false, "", error);
      });
  for (const TransmissionParams& m : rig.transmissions) {
    for (const std::string& joint : m.joints) {
      const auto index =
          static_cast<std::size_t>(std::ranges::find(names.joints, joint) - names.joints.begin());
      if (index < names.kinds.size()) names.kinds[index] = DeviceJointKind::hinge;
    }
  }
}

template <class V>
void visit_handle(V& v, const RigNames& names, HandleParams& h) {
  choose(v, Key{.name = "body", .unit = "", .meaning = "coupled body whose target it is", .required = true},
         names.bodies, h.body);
  choose(v, Key{.name = "joint", .unit = "", .meaning = "joint on whose link it sits", .required = true},
         names.joints, h.joint);
  visit_pose(v, "position", "orientation_wxyz", "the handle on that link", h.X_LH);
}

/// The single handle defined by [device.chain] without a table of its own.
struct ShortHandle {
  Pose X_LH;
  bool given = false;
};

template <class V>
void visit_chain(V& v, Pose& X_WB, ShortHandle& handle) {
  visit_pose(v, "base_position", "base_orientation_wxyz", "the base in the world", X_WB);
  v.shorthand(Key{"handle_position", "m", "the only handle on the last link"}, handle.X_LH.p);
  v.shorthand(Key{"handle_orientation_wxyz", "", "its attitude"}, handle.X_LH.q);
  handle.given = v.has("handle_position") || v.has("handle_orientation_wxyz");
}

template <class V>
void visit_handles(V& v, const RigNames& names, const ShortHandle& handle,
                   const std::vector<HandleParams>& of_scene, std::vector<HandleParams>& handles) {
  std::set<std::string> held;
  v.tables(
      TableKey{"handle",
               "Where the user holds a body. Without any: one for the first coupled body on the last link, "
               "at `handle_position` of `[device.chain]`; with the tool's joints one at each coupled body."},
      handles, [&](auto& t, HandleParams& h) {
        visit_handle(t, names, h);
        t.check(held.insert(h.body).second, "body", "has an earlier handle");
      });
  v.check(handles.empty() || !handle.given, "handle",
          "and handle_position in [device.chain] both place handles: remove one of them");
  v.check(of_scene.empty() || !handle.given, "",
          "handle_position in [device.chain] has no meaning for a device with the joints of the tool: remove "
          "it, or add [[device.handle]] tables");
  if (handles.empty()) handles = of_scene;
  v.check(handles.size() <= max_handles, "handle",
          "must be at most " + std::to_string(max_handles) + " tables [[device.handle]], not " +
              std::to_string(handles.size()));
  if (handles.empty() && !names.joints.empty() && !names.bodies.empty())
    handles.push_back({.body = names.bodies.front(), .joint = names.joints.back(), .X_LH = handle.X_LH});
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
  v.tables(TableKey{"encoder", "A CiA 406 absolute encoder."}, rig.encoders, [&](auto& t, EncoderParams& e) {
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

template <class V>
void check_number_of_joints(V& v, std::size_t num_joints) {
  v.check(num_joints >= 1 && num_joints <= max_joints, "joint",
          "must be 1 to " + std::to_string(max_joints) + " tables [[device.joint]], not " +
              std::to_string(num_joints));
}

/// Checks rules between the parts of a rig.
template <class V>
void check_rig(V& v, const RigParams& rig) {
  v.check(!rig.buses.empty(), "", "encoders, drives, buttons and their supervision need a [[bus]]");
  check_protocols(v, rig);
  check_number_of_joints(v, rig.tree.joints.size());
  for (const DeviceJoint& joint : rig.tree.joints) {
    const auto on_joint = [&](const auto& node) { return node.joint == joint.name; };
    v.check(std::ranges::any_of(rig.encoders, on_joint) || std::ranges::any_of(rig.drives, on_joint), "",
            "joint '" + joint.name + "' is not measured: add a [[device.encoder]] for it");
  }
}

/// Gives a device without joints of its own those of the tool. Returns the handles.
template <class V>
std::vector<HandleParams> take_joints_of_tool(V& v, const SceneConfig& scene, RigNames& names,
                                              std::vector<DeviceJoint>& joints) {
  DeviceTree device = device_from_joints(scene);
  for (const std::string& error : device.errors) v.check(false, "", error);
  joints = std::move(device.tree.joints);
  for (const DeviceJoint& joint : joints) {
    names.joints.push_back(joint.name);
    names.kinds.push_back(joint.kind);
  }
  return std::move(device.tree.handles);
}

/// Parts between hand and core that a file describes.
enum class PartsOfDevice : std::uint8_t { none, joints, rig };

/// Visits the tree, its encoders and its drives.
/// given: parts that `rig` has from an earlier visit.
template <class V>
PartsOfDevice visit_rig(V& v, PartsOfDevice given, const SceneConfig& scene, std::vector<std::string> bodies,
                        RigParams& rig) {
  bool has_supervision = given == PartsOfDevice::rig, has_chain = given != PartsOfDevice::none;
  v.table(TableKey{"supervision", "Time limits."}, has_supervision,
          [&](auto& t) { visit_supervision(t, rig); });
  ShortHandle handle;
  v.table(TableKey{"chain", "Base, and only handle."}, has_chain,
          [&](auto& t) { visit_chain(t, rig.tree.X_WB, handle); });
  RigNames names{.bodies = std::move(bodies), .buses = {}, .joints = {}, .kinds = {}};
  for (const BusParams& bus : rig.buses) names.buses.push_back(bus.name);
  visit_joints(v, rig.tree.joints, names);
  const bool has_more =
      v.has("handle") || v.has("encoder") || v.has("drive") || v.has("button") || v.has("transmission");
  std::vector<HandleParams> of_scene;
  if (has_more && rig.tree.joints.empty() && !scene.joints.empty())
    of_scene = take_joints_of_tool(v, scene, names, rig.tree.joints);
  visit_handles(v, names, handle, of_scene, rig.tree.handles);
  visit_transmissions(v, names, rig);
  visit_nodes(v, names, rig);
  if (has_supervision || has_parts_on_buses(rig)) {
    check_rig(v, rig);
    return PartsOfDevice::rig;
  }
  if (!has_chain && rig.tree.joints.empty() && rig.tree.handles.empty()) return PartsOfDevice::none;
  check_number_of_joints(v, rig.tree.joints.size());
  return PartsOfDevice::joints;
}

/// Returns the joints of the tool for a device without joints. Returns none if they do not move every handle,
/// or if the device grips bodies or is pushed.
inline std::optional<KinematicTreeParams> implied_tree(SceneConfig scene, const DeviceConfig& device) {
  const bool holds = !device.holds.empty() || device.grab_radius;
  if (holds || device.kind == DeviceKind::admittance || scene.joints.empty()) return std::nullopt;
  scene.device = device;
  DeviceTree of_tool = device_from_joints(scene);
  const std::size_t num_joints = of_tool.tree.joints.size(), num_handles = of_tool.tree.handles.size();
  const bool fits =
      num_joints >= 1 && num_joints <= max_joints && num_handles >= 1 && num_handles <= max_handles;
  return of_tool.errors.empty() && fits ? std::optional(std::move(of_tool.tree)) : std::nullopt;
}

/// Returns the bodies that can have a handle: the coupled ones; without any, the first if an admittance
/// device pushes it.
inline std::vector<std::string> holdable_bodies(SceneConfig scene, const DeviceConfig& device) {
  scene.device = device;
  std::vector<std::string> names;
  for (const std::size_t body : driven_bodies(scene)) names.push_back(scene.bodies[body].name);
  return names;
}

template <class V>
void visit_device(V& v, const SceneConfig& scene, const std::vector<BusParams>& buses, DeviceConfig& d) {
  visit_name(v, "", d.name);
  choose(v, Key{"kind", "", "see Devices above"}, device_kind_names, d.kind);
  v.value(
      Key{"display_ratio",
          "",
          "relative device: shift of the target for a shift of the device. Below 1 the tool seems heavier "
          "to the eye; the displayed force is multiplied by it, so that the hand's work is the tool's",
          {0, 10}},
      d.display_ratio);
  v.check(d.display_ratio == 1 || d.kind == DeviceKind::relative, "display_ratio",
          "has a meaning for a relative device alone: remove it, or set kind to relative");
  visit_grabbing(v, scene, d);
  plain_table(v, TableKey{"limits", "Bounds of the displayed wrench, and ramps."}, [&](auto& t) {
    visit_limits(t, d.limits);
    t.value(Key{"passivity_control", "",
                "bounds the energy that sampling and delay add on driven axes without margin "
                "(docs/theory/passivity.md)"},
            d.controls_passivity);
  });
  RigParams rig = d.rig.value_or(RigParams{.buses = buses,
                                           .tree = d.unmeasured_tree.value_or(KinematicTreeParams{}),
                                           .encoders = {},
                                           .drives = {}});
  rig.buses = buses;
  const bool is_new = !d.rig;
  if (is_new) rig.stale_after_s = default_stale_steps * scene.step;
  const PartsOfDevice given = d.rig               ? PartsOfDevice::rig
                              : d.unmeasured_tree ? PartsOfDevice::joints
                                                  : PartsOfDevice::none;
  const PartsOfDevice parts = visit_rig(v, given, scene, holdable_bodies(scene, d), rig);
  const bool has_other_hand = v.has("tracker") || v.has("spacemouse");
  if (parts == PartsOfDevice::rig) d.rig = rig;
  if (parts == PartsOfDevice::joints) d.unmeasured_tree = rig.tree;
  if (parts == PartsOfDevice::none && !has_other_hand) d.unmeasured_tree = implied_tree(scene, d);
  v.check(parts != PartsOfDevice::joints || !has_other_hand, "joint",
          "are not measured, and trackers or a SpaceMouse move the tool: add a [[device.encoder]] for each "
          "and a [[bus]], or remove the joints");
  const std::vector<DeviceJoint> joints = d.rig               ? d.rig->tree.joints
                                          : d.unmeasured_tree ? d.unmeasured_tree->joints
                                                              : std::vector<DeviceJoint>{};
  if (given == PartsOfDevice::none) d.plant = default_plant(joints);
  plain_table(v, TableKey{"plant", "Simulated mechanics of device and hand."},
              [&](auto& t) { visit_plant(t, joints, d.plant); });
  plain_table(v,
              TableKey{"compensation", "The drives compensate the device's own weight, friction and delay."},
              [&](auto& t) {
                visit_compensation(t, d.plant, scene.step, d.rig ? &*d.rig : nullptr, d.compensation);
              });
  visit_trackers(v, holdable_bodies(scene, d), handled_bodies(d), d.trackers);
  optional_table(v, TableKey{"spacemouse", "A SpaceMouse ([trackers](trackers.md#spacemouse))."},
                 d.spacemouse,
                 [&](auto& t, SpaceMouseConfig& s) { visit_spacemouse(t, holdable_bodies(scene, d), s); });
  if (d.spacemouse) check_spacemouse(v, d);
}

}  // namespace godobject
