// All keys below [device] of a scene file. Visitors: platform/scene/text/key.h.
#pragma once

#include "hal/rig/validate.h"
#include "platform/scene/keys/device_node.h"
#include "platform/scene/keys/device_plant.h"

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
  for (const std::string& error : homing_errors(rig)) v.check(false, "", error);
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
  plain_table(
      v,
      TableKey{"compensation", "The drives compensate the device's own weight, friction, inertia and delay."},
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
