// All keys of a [[joint]]. Visitors: platform/scene/text/key.h.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <set>

#include "core/math/rotation_error.h"
#include "core/math/so3.h"
#include "platform/scene/joint/joints.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

inline std::string quoted(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
  return text;
}

inline double angle_between(const Quat& a, const Quat& b) {
  return rotation_error(a, b, Vec3::Zero()).phi_B.norm();
}

/// Formats three digits for messages.
inline std::string rounded(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", x);
  return text.data();
}

/// Visits an end of a stop. end: infinite without a stop at this end.
template <class V>
void visit_stop_end(V& v, const Key& key, double& end) {
  std::optional<double> given;
  if (std::isfinite(end)) given = end;
  v.value(key, given);
  if (given) end = *given;
}

/// Visits the coordinate of a table of a joint. table: "stop" or "spring".
template <class V>
void visit_coordinate_of(V& v, const JointConfig& j, const std::string& table, std::string& name) {
  const bool only_one = j.coordinates.size() == 1, none = num_coordinates(j.kind) == 0;
  if (name.empty() && only_one) name = j.coordinates.front();
  const Key coordinate{.name = "coordinate",
                       .unit = "",
                       .meaning = "one of the joint's coordinates",
                       .required = !only_one && !none,
                       .otherwise = "the only one"};
  if (none) v.value(coordinate, name);
  else choose(v, coordinate, j.coordinates, name);
  v.check(!none, "",
          "joint '" + j.name + "' has no coordinate for a " + table + ": remove the [[joint." + table +
              "]] table, or use another kind of joint");
}

template <class V>
void visit_stop(V& v, const JointConfig& j, StopConfig& s) {
  visit_coordinate_of(v, j, "stop", s.coordinate);
  visit_stop_end(v, Key{"lower", "rad or m", "lower end; turns are counted, beyond +-pi too"},
                 s.params.lower);
  visit_stop_end(v, Key{"upper", "rad or m", "upper end"}, s.params.upper);
  v.check(std::isfinite(s.params.lower) || std::isfinite(s.params.upper), "",
          "the stop has no end: give lower, upper or both");
  v.check(s.params.lower < s.params.upper, "upper", "must be above lower");
  v.value(Key{"stiffness", "N m/rad or N/m", "beyond `width`", positive, true}, s.params.k);
  v.value(Key{"damping", "N m s/rad or N s/m", "beyond `width`, inwards only", not_negative}, s.params.g);
  v.value(Key{"width", "rad or m", "travel over which both rise from zero", positive, true}, s.params.width);
}

/// Checks that the value of a key names a body, or the world where that is admissible. No second error is
/// reported for a key that is missing or has one.
template <class V>
void check_body_name(V& v, std::string_view key, const std::vector<std::string>& bodies, bool or_world,
                     const std::string& name) {
  const bool known = (or_world && name == world_name) || std::ranges::find(bodies, name) != bodies.end();
  v.check(known || !v.understood(key), key,
          "is \"" + name + "\", which is not a body: admissible is " + (or_world ? "\"world\", " : "") +
              quoted(bodies));
}

template <class V>
void visit_joint_ends(V& v, const std::vector<std::string>& bodies, JointConfig& j) {
  v.value(Key{"parent", "", "parent body, or \"world\""}, j.parent);
  check_body_name(v, "parent", bodies, true, j.parent);
  v.value(Key{.name = "child", .unit = "", .meaning = "child body", .required = true}, j.child);
  v.check(j.child != world_name, "child", "is the world, which cannot be a child: swap parent and child");
  check_body_name(v, "child", bodies, false, j.child);
}

template <class V>
void visit_joint_frames(V& v, JointConfig& j) {
  Vec3 axis = Vec3::UnitZ();
  v.shorthand(Key{.name = "axis",
                  .unit = "",
                  .meaning = "of a hinge, slider or cylindrical joint: unit vector, equal in both bodies at "
                             "coordinate zero, instead of orientations",
                  .otherwise = "none"},
              axis);
  if (v.has("axis")) {
    v.check(is_along_z(j.kind), "axis",
            "has no meaning for this kind of joint: give parent_orientation_wxyz and child_orientation_wxyz");
    v.check(std::abs(axis.norm() - 1) <= 1e-6, "axis", "must have length 1");
    v.check(!v.has("parent_orientation_wxyz") && !v.has("child_orientation_wxyz"), "axis",
            "and the orientations of the frames both give the axis: remove one of them");
    j.X_BP.q = j.X_BC.q = turn_from_z(axis);
  }
  visit_pose(v, "parent_position", "parent_orientation_wxyz", "the joint's frame on the parent", j.X_BP);
  visit_pose(v, "child_position", "child_orientation_wxyz", "the joint's frame on the child", j.X_BC);
}

template <class V>
void visit_coordinates(V& v, JointConfig& j) {
  if (j.coordinates.empty()) j.coordinates = default_coordinates(j.name, j.kind);
  v.value(Key{.name = "coordinates",
              .unit = "",
              .meaning = "names of its turns (rad), then slides (m)",
              .otherwise = "the joint's name; of two with `_turn`, `_slide` or `_x`, `_y`"},
          j.coordinates);
  const std::size_t n = num_coordinates(j.kind);
  v.check(j.coordinates.size() == n, "coordinates",
          "are " + std::to_string(j.coordinates.size()) + ": a joint of this kind has " + std::to_string(n));
  v.check(std::ranges::all_of(j.coordinates, is_plain_name), "coordinates",
          "must each be one or more letters, digits, '_' or '-'");
  v.value(Key{"imposed", "", "prescribed by the device's joints of the same names"}, j.prescribed);
  v.check(!j.prescribed || n > 0, "imposed", "has no meaning for a joint without named coordinates");
  v.value(Key{.name = "start",
              .unit = "rad or m",
              .meaning = "first coordinate at t = 0, which places the child",
              .otherwise = "that of the bodies' poses"},
          j.start[0]);
  v.value(Key{.name = "start_second",
              .unit = "rad or m",
              .meaning = "second coordinate",
              .otherwise = "that of the bodies' poses"},
          j.start[1]);
  v.check(!j.start[0] || n > 0, "start", "has no meaning for a joint without named coordinates");
  v.check(!j.start[1] || n > 1, "start_second", "has no meaning for a joint of one coordinate");
}

template <class V>
void visit_joint_springs(V& v, JointConfig& j);

template <class V>
void visit_tool_joint(V& v, const std::vector<std::string>& bodies, JointConfig& j) {
  visit_name(v, "name, in columns of traces", j.name);
  std::size_t kind = static_cast<std::size_t>(j.kind) - 1;
  static const std::string meaning = "motion of the child: " + joint_kind_meanings();
  v.one_of(Key{"kind", "", meaning}, joint_kind_names(), kind);
  j.kind = static_cast<JointKind>(kind + 1);
  visit_joint_ends(v, bodies, j);
  visit_joint_frames(v, j);
  visit_coordinates(v, j);
  std::set<std::string> stopped;
  v.tables(TableKey{"stop", "Springs at the ends of one coordinate."}, j.stops, [&](auto& t, StopConfig& s) {
    visit_stop(t, j, s);
    t.check(stopped.insert(s.coordinate).second, "coordinate", "has an earlier stop");
    t.check(!j.prescribed, "", "the joint is imposed, and a stop has no effect on it: remove one of them");
  });
  visit_joint_springs(v, j);
}

/// Checks a joint that closes a loop with earlier ones.
template <class V>
void check_loop(V& v, const JointConfig& j, const std::vector<std::string>& loop) {
  const bool has_coordinates =
      j.prescribed || !j.stops.empty() || !j.springs.empty() || j.start[0] || j.start[1];
  v.check(!has_coordinates, "",
          "joint '" + j.name + "' closes a loop with joints " + quoted(loop) +
              ", and as the last of them it has no coordinate for stops, springs, imposed or start: list it "
              "before one of the others");
}

/// Checks that a child placed by `start` has no other place.
template <class V>
void check_start(V& v, const std::vector<BodyConfig>& bodies, const JointConfig& j) {
  const auto child = std::ranges::find(bodies, j.child, &BodyConfig::name);
  const Pose& X = child->X_WB;
  if (!child->is_placed || !(j.start[0] || j.start[1])) return;
  std::vector<BodyConfig> moved = bodies;
  BodyConfig& again = moved[static_cast<std::size_t>(child - bodies.begin())];
  again.is_placed = false;
  place_children(moved, std::span(&j, 1));
  const Pose& by_start = again.X_WB;
  const bool agrees =
      (by_start.p - X.p).norm() <= rounded_gap.m && angle_between(by_start.q, X.q) <= rounded_gap.rad;
  v.check(
      agrees, "start",
      "places body '" + j.child + "' elsewhere than its own position and orientation: remove one of both");
}

/// Checks rules between joints, and between a joint and the poses of its bodies.
template <class V>
void visit_tool_joints(V& v, SceneConfig& s) {
  std::vector<std::string> bodies;
  for (const BodyConfig& body : s.bodies) bodies.push_back(body.name);
  std::set<std::string> names, coordinates;
  JointTree tree;
  std::vector<JointConfig> all = s.joints, without_bodies;
  all.insert(all.end(), s.loops.begin(), s.loops.end());
  s.joints.clear();
  s.loops.clear();
  v.tables(TableKey{"joint",
                    "A joint of two bodies, or of a body and the world. Its frames on both coincide at "
                    "coordinate zero.",
                    false, max_tables_of_bodies},
           all, [&](auto& t, JointConfig& j) {
             visit_tool_joint(t, bodies, j);
             t.check(names.insert(j.name).second, "name", "is the name of an earlier joint");
             for (const std::string& q : j.coordinates)
               t.check(coordinates.insert(q).second, "coordinates",
                       "has '" + q + "', which is the name of another coordinate: choose another");
             if (!has_bodies(s, j)) return without_bodies.push_back(j);
             const JointTree::Added added = tree.add(j);
             // a joint without its bodies may be that which makes this one the last of a loop
             t.check(added.why_not.empty() || !without_bodies.empty(), "", added.why_not);
             if (!added.loop.empty()) {
               check_loop(t, j, added.loop);
               return s.loops.push_back(j);
             }
             s.joints.push_back(j);
             check_start(t, s.bodies, j);
             const auto child = std::ranges::find(s.bodies, j.child, &BodyConfig::name);
             if (!child->is_placed || j.start[0] || j.start[1]) return;
             const JointGap gap = gap_at_start(s.bodies, j);
             t.advise(!is_apart(gap), "",
                      "joint '" + j.name + "' is apart by " + rounded(gap.m) + " m and " + rounded(gap.rad) +
                          " rad with the bodies at their places: the run starts with body '" + j.child +
                          "' and the bodies joined to it moved to close the joint; place '" + j.child +
                          "' there, or correct the frames of the joint");
           });
  s.bodies = parents_first(s.bodies, s.joints);
  place_children(s.bodies, s.joints);
  close_gaps(s.bodies, s.joints);
  s.joints.insert(s.joints.end(), without_bodies.begin(), without_bodies.end());
  for (const JointConfig& j : s.loops) {
    const JointGap gap = gap_at_start(s.bodies, j);
    v.check(
        !is_apart(gap), "joint",
        "'" + j.name + "' closes a loop, and its ends are " + rounded(gap.m) + " m and " + rounded(gap.rad) +
            " rad apart with the bodies at their places: correct its frames, or the places of the bodies");
  }
}

}  // namespace godobject
