// All keys of [[spring]], [[force]], [[gear]] and [[joint.spring]]. Visitors: platform/scene/text/key.h.
#pragma once

#include <cmath>
#include <set>

#include "platform/scene/keys/joint.h"

namespace godobject {

/// Largest deviation of a rigid gear at the start that rounding explains, rad or m.
inline constexpr double rounded_deviation = 1e-6;

template <class V>
void visit_joint_spring(V& v, const JointConfig& j, JointSpringConfig& s) {
  visit_coordinate_of(v, j, "spring", s.coordinate);
  v.value(Key{"stiffness", "N m/rad or N/m", "", not_negative, true}, s.k);
  v.value(Key{"damping", "N m s/rad or N s/m", "", not_negative}, s.g);
  v.value(Key{"rest", "rad or m", "coordinate without force; turns are counted"}, s.rest);
}

/// Visits the name of a body that must exist.
template <class V>
void visit_body_name(V& v, const Key& key, const SceneConfig& scene, bool or_world, std::string& name) {
  v.value(key, name);
  std::vector<std::string> bodies;
  for (const BodyConfig& body : scene.bodies) bodies.push_back(body.name);
  check_body_name(v, key.name, bodies, or_world, name);
}

/// Returns the position of a point of a body, or of the world, at the start.
inline Vec3 point_at_start(const SceneConfig& scene, const std::string& name, const Vec3& p) {
  const std::optional<std::size_t> body = body_named(scene, name);
  if (!body) return p;
  const Pose& X_WB = scene.bodies[*body].X_WB;
  return X_WB.p + X_WB.q * p;
}

template <class V>
void visit_spring(V& v, const SceneConfig& scene, SpringConfig& s) {
  visit_name(v, "name, in columns of traces", s.name);
  visit_body_name(v, Key{"a", "", "first body, or \"world\""}, scene, true, s.a);
  visit_body_name(v, Key{.name = "b", .unit = "", .meaning = "second body", .required = true}, scene, false,
                  s.b);
  v.check(s.a != s.b, "b", "is the body of the other end: a spring joins two bodies, or one and the world");
  v.value(Key{"position_a", "m", "end on a: body axes about its centre of mass; on the world in the world"},
          s.p_A);
  v.value(Key{"position_b", "m", "end on b"}, s.p_B);
  v.value(Key{"stiffness", "N/m", "", {0, 1e13}, true}, s.k);
  v.value(Key{"damping", "N s/m", "along the spring; without rest length in all directions", not_negative},
          s.g);
  v.value(Key{.name = "rest_length",
              .unit = "m",
              .meaning = "0: pulls the ends together",
              .range = not_negative,
              .otherwise = "the distance at t = 0"},
          s.rest_length);
  const double distance = (point_at_start(scene, s.b, s.p_B) - point_at_start(scene, s.a, s.p_A)).norm();
  if (!s.rest_length && !v.has("rest_length")) s.rest_length = distance;
}

template <class V>
void visit_force(V& v, const SceneConfig& scene, ForceConfig& f) {
  visit_name(v, "", f.name);
  visit_body_name(v, Key{.name = "body", .unit = "", .meaning = "", .required = true}, scene, false, f.body);
  v.value(Key{"position", "m", "point of the body, body axes about the centre of mass"}, f.p_B);
  v.value(Key{.name = "force", .unit = "N", .meaning = "world axes", .required = true}, f.F_W);
}

template <class V>
void visit_gear(V& v, const SceneConfig& scene, GearConfig& g) {
  std::vector<std::string> coordinates;
  for (const JointConfig& joint : scene.joints)
    coordinates.insert(coordinates.end(), joint.coordinates.begin(), joint.coordinates.end());
  visit_name(v, "name, in columns of traces", g.name);
  choose(v, Key{.name = "a", .unit = "", .meaning = "coordinate of a joint", .required = true}, coordinates,
         g.a);
  choose(v, Key{.name = "b", .unit = "", .meaning = "coordinate of a joint", .required = true}, coordinates,
         g.b);
  v.value(Key{"ratio", "1, m/rad or rad/m", "of q_b = ratio q_a + offset", any_number, true}, g.ratio);
  v.value(Key{.name = "offset",
              .unit = "rad or m",
              .meaning = "",
              .otherwise = "that of the coordinates at t = 0"},
          g.offset);
  v.value(Key{.name = "stiffness",
              .unit = "N m/rad or N/m",
              .meaning = "force on b by its deviation",
              .range = positive,
              .otherwise = "rigid"},
          g.stiffness);
  v.value(Key{"damping", "N m s/rad or N s/m", "with a stiffness", not_negative}, g.damping);
  v.check(g.damping == 0 || g.stiffness, "damping",
          "has no effect on a rigid gear: give a stiffness, or remove it");
  v.check(g.ratio != 0, "ratio", "is 0, which ties b to no other coordinate: use [[joint.spring]]");
  const CoordinateOfJoint a = coordinate_named(scene, g.a), b = coordinate_named(scene, g.b);
  if (a.joint == nullptr || b.joint == nullptr) return;
  v.check(g.a != g.b, "b", "is the same coordinate as a: a gear joins two");
  v.check(
      !a.joint->prescribed || !b.joint->prescribed, "",
      "both coordinates are imposed by the device, so that the gear has no effect: remove it, or impose one");
  if (!has_bodies(scene, *a.joint) || !has_bodies(scene, *b.joint)) return;  // reported at the joint
  const auto at_start = [&](const CoordinateOfJoint& q) {
    return coordinates_at_start(scene.bodies, *q.joint)[static_cast<Eigen::Index>(q.number)];
  };
  const double offset = at_start(b) - g.ratio * at_start(a);
  if (!g.offset && !v.has("offset")) g.offset = offset;
  if (!g.offset) return;
  v.check(g.stiffness || std::abs(*g.offset - offset) <= rounded_deviation, "offset",
          "is " + rounded(*g.offset) + ", but the bodies are placed with " + rounded(offset) +
              ": place them by `start` of their joints, remove the offset, or give the gear a stiffness");
}

/// Visits the springs of a joint.
template <class V>
void visit_joint_springs(V& v, JointConfig& j) {
  std::set<std::string> sprung;
  v.tables(TableKey{"spring", "Spring on one coordinate."}, j.springs, [&](auto& t, JointSpringConfig& s) {
    visit_joint_spring(t, j, s);
    t.check(sprung.insert(s.coordinate).second, "coordinate", "has an earlier spring");
    t.check(!j.prescribed, "", "the joint is imposed, and a spring has no effect on it: remove one of them");
  });
}

/// Visits springs, forces and gears.
template <class V>
void visit_terms(V& v, SceneConfig& s) {
  std::set<std::string> names;
  for (const JointConfig& joint : s.joints) names.insert(joint.name);
  for (const JointConfig& joint : s.loops) names.insert(joint.name);
  const auto check_name = [&](auto& t, const std::string& name) {
    t.check(names.insert(name).second, "name", "is the name of an earlier joint, spring, force or gear");
  };
  v.tables(TableKey{"spring", "A spring between points of two bodies, or of the world and a body."},
           s.springs, [&](auto& t, SpringConfig& one) {
             visit_spring(t, s, one);
             check_name(t, one.name);
           });
  v.tables(TableKey{"force", "A constant force."}, s.forces, [&](auto& t, ForceConfig& one) {
    visit_force(t, s, one);
    check_name(t, one.name);
  });
  v.tables(TableKey{"gear", "A gear between two coordinates of joints; its force acts on both."}, s.gears,
           [&](auto& t, GearConfig& one) {
             visit_gear(t, s, one);
             check_name(t, one.name);
           });
}

}  // namespace godobject
