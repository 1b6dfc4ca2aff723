// MuJoCo's model of a case without contacts. A free body has three slides and a ball whose springs are the
// coupling; articulated bodies are a tree. Its files nest bodies: a hundred links are too deep.
#pragma once

#include "tests/bench/peer/mujoco_model.h"

namespace godobject::bench {

inline std::string numbers(const oracle::Quaterniond& q) {
  std::ostringstream text;
  text.precision(17);
  text << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z();
  return text.str();
}

/// Writes the joints of a child, in its axes at the start, where their coordinates are zero.
/// q: attitude of the child in its parent.
inline void write_joints(std::ostream& xml, const oracle::Joint& joint, const oracle::Quaterniond& q) {
  const auto one = [&](const char* type, const oracle::Vector3d& axis) {
    xml << "<joint type='" << type << "' pos='" << numbers(joint.anchor_C) << "' axis='" << numbers(axis)
        << "'/>";
  };
  const oracle::Vector3d own = q.conjugate() * joint.axis_P;
  switch (joint.type) {
    case oracle::JointType::ball: return one("ball", own);
    case oracle::JointType::hinge: return one("hinge", own);
    case oracle::JointType::cylindrical: return one("slide", own), one("hinge", own);
    case oracle::JointType::universal: return one("hinge", own), one("hinge", joint.axis_C);
    default: throw std::invalid_argument("a case has a joint that mujoco_tree.h does not write");
  }
}

/// Writes the joints of a coupled body without a joint. Slides measure from the origin, so that their springs
/// have the target as their reference.
inline void write_springs(std::ostream& xml, const oracle::Coupling& c) {
  for (const char* const axis : {"1 0 0", "0 1 0", "0 0 1"})
    xml << "<joint type='slide' axis='" << axis << "' stiffness='" << c.k_t << "' damping='" << c.g_t
        << "'/>";
  xml << "<joint type='ball' stiffness='" << c.k_r << "' damping='" << c.g_r << "'/>";
}

class MujocoTree {
 public:
  MujocoTree(const oracle::Case& problem, double h, const std::string& integrator) : problem_(problem) {
    xml_.precision(17);
    xml_ << "<mujoco><compiler inertiafromgeom='false' boundmass='0' boundinertia='0'/><option timestep='"
         << h << "' gravity='" << numbers(problem.gravity) << "' integrator='" << integrator
         << "'><flag constraint='disable'/></option><worldbody>";
    for (std::size_t i = 0; i < problem.bodies.size(); ++i)
      if (!parent(i)) write_body(i);
    if (has_actuators()) write_targets();
    xml_ << "</worldbody>";
    if (has_actuators()) write_actuators();
    xml_ << "</mujoco>";
  }

  std::string text() const { return xml_.str(); }

 private:
  bool has_actuators() const { return !problem_.joints.empty() && problem_.bodies.front().coupling; }
  const oracle::Joint* joint(std::size_t child) const {
    for (const oracle::Joint& j : problem_.joints)
      if (j.child == child) return &j;
    return nullptr;
  }
  std::optional<std::size_t> parent(std::size_t child) const {
    const oracle::Joint* const j = joint(child);
    return j == nullptr ? std::nullopt : j->parent;
  }

  void write_body(std::size_t i) {
    const oracle::Body& body = problem_.bodies[i];
    const oracle::RigidState P = parent(i) ? problem_.bodies[*parent(i)].start : oracle::RigidState{};
    const oracle::Quaterniond q = P.q.conjugate() * body.start.q;
    const oracle::Joint* const own = joint(i);
    xml_ << "<body";
    if (own != nullptr)
      xml_ << " pos='" << numbers(P.q.conjugate() * (body.start.p - P.p)) << "' quat='" << numbers(q) << "'";
    xml_ << '>';
    own != nullptr ? write_joints(xml_, *own, q) : write_springs(xml_, *body.coupling);
    xml_ << "<inertial pos='0 0 0' mass='" << body.m << "' diaginertia='" << numbers(body.I_B.diagonal())
         << "'/><site name='s" << i << "'/>";
    for (const oracle::Joint& j : problem_.joints)
      if (j.parent == i) write_body(j.child);
    xml_ << "</body>";
  }

  void write_targets() {
    for (std::size_t i = 0; i < problem_.bodies.size(); ++i)
      xml_ << "<body mocap='true'><site name='t" << i << "'/></body>";
  }

  /// Writes the actuators between a body's site and that of its target: k (control - length) - g rate.
  void write_actuators() {
    xml_ << "<actuator>";
    const auto one = [&](std::size_t i, const std::string& gear, double k, double g) {
      xml_ << "<general site='s" << i << "' refsite='t" << i << "' gear='" << gear << "' gainprm='" << k
           << "' biastype='affine' biasprm='0 " << -k << ' ' << -g << "'/>";
    };
    for (std::size_t i = 0; i < problem_.bodies.size(); ++i) {
      const oracle::Coupling& c = *problem_.bodies[i].coupling;
      for (const std::string axis : {"1 0 0", "0 1 0", "0 0 1"}) one(i, axis + " 0 0 0", c.k_t, c.g_t);
      for (const std::string axis : {"1 0 0", "0 1 0", "0 0 1"}) one(i, "0 0 0 " + axis, c.k_r, c.g_r);
    }
    xml_ << "</actuator>";
  }

  const oracle::Case& problem_;
  std::ostringstream xml_;
};

}  // namespace godobject::bench
