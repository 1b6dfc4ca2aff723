// Keys of joints of the device, of transmissions and handles on them.
#pragma once

#include <set>

#include "hal/joint/kinematic_tree.h"
#include "platform/scene/joint/joints.h"
#include "platform/scene/keys/hand.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

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
  v.value(
      Key{.name = "lower",
          .unit = "rad or m",
          .meaning = "lower end of its range, for the margins of `check` and the fault `joint_beyond_range`",
          .otherwise = "the start, of a hinge half a turn less"},
      j.lower);
  v.value(Key{.name = "upper",
              .unit = "rad or m",
              .meaning = "upper end",
              .otherwise = "the start, of a hinge half a turn more"},
          j.upper);
  v.check(j.lower.has_value() == j.upper.has_value(), "", "give both ends, lower and upper, or none");
  v.check(!j.lower || !j.upper || *j.lower < *j.upper, "upper", "must be above lower");
  v.value(Key{"mass", "kg", "of its link, for the gravity of `[device.plant]`", not_negative}, j.mass);
  v.value(Key{"center_of_mass", "m", "of its link, from the joint's frame at coordinate 0"}, j.p_LM);
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

template <class V>
void check_number_of_joints(V& v, std::size_t num_joints) {
  v.check(num_joints >= 1 && num_joints <= max_joints, "joint",
          "must be 1 to " + std::to_string(max_joints) + " tables [[device.joint]], not " +
              std::to_string(num_joints));
}

}  // namespace godobject
