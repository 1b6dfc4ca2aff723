#include "tests/oracle/validate.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>

#include "tests/oracle/joint/rows.h"

namespace godobject::oracle {

namespace {

void require(bool holds, const std::string& rule) {
  if (!holds) throw std::invalid_argument(rule);
}

bool is_unit(const Vector3d& axis) { return std::abs(axis.norm() - 1) < 1e-9; }

void validate(const Body& body) {
  const std::string name = "body '" + body.name + "': ";
  require(body.m > 0 && std::isfinite(body.m), name + "the mass must be positive");
  require(body.I_B.isApprox(body.I_B.transpose(), 1e-14), name + "the inertia must be symmetric");
  require(body.I_B.llt().info() == Eigen::Success, name + "the inertia must be positive definite");
  require(std::abs(body.start.q.norm() - 1) < 1e-9, name + "the orientation must be a unit quaternion");
  require(!body.coupling || body.coupling->target, name + "the coupling needs a target");
}

void validate(const Joint& joint, std::size_t num_bodies) {
  const std::string name = "joint '" + joint.name + "': ";
  require(joint.child < num_bodies, name + "there is no such child");
  require(!joint.parent || *joint.parent < num_bodies, name + "there is no such parent");
  require(is_unit(joint.axis_P) && is_unit(joint.axis_C), name + "an axis must be a unit vector");
  require(std::abs(joint.q_PC.norm() - 1) < 1e-9, name + "q_PC must be a unit quaternion");
  if (joint.imposed) {
    require(joint.type == JointType::hinge || joint.type == JointType::slider,
            name + "only a hinge or a slider can be imposed");
    require(static_cast<bool>(joint.imposed->at), name + "the imposed motion is missing");
  }
}

void validate(const Spring& spring, std::size_t num_bodies) {
  require(spring.b < num_bodies && (!spring.a || *spring.a < num_bodies), "a spring is on no body");
  require(spring.k >= 0 && spring.g >= 0 && spring.l_0 >= 0, "a spring has a negative number");
}

/// The joint whose child each body is; from any body the walk to the parents must end.
void require_a_tree(const Case& problem) {
  std::vector<const Joint*> joint_above(problem.bodies.size(), nullptr);
  for (const Joint& joint : problem.joints) {
    const Joint*& above = joint_above[joint.child];
    require(!above, "joint '" + joint.name + "': its child already has the joint '" +
                        (above ? above->name : "") + "' to a parent");
    above = &joint;
  }
  for (const Joint& start : problem.joints) {
    const Joint* joint = &start;
    for (std::size_t steps = 0; joint && joint->parent; joint = joint_above[*joint->parent]) {
      require(++steps <= problem.joints.size(),
              "joint '" + start.name + "': it is part of a loop or ends in one");
    }
  }
}

BodyState start_of(const Body& body) {
  const RigidState& x = body.start;
  return {x.p.cast<Scalar>(), x.q.cast<Scalar>().normalized(), x.v.cast<Scalar>(), x.w.cast<Scalar>()};
}

void require_shut(const Case& problem, const Joint& joint) {
  const BodyState parent = joint.parent ? start_of(problem.bodies[*joint.parent]) : BodyState{};
  const JointRows rows = joint_rows(joint, 0, parent, start_of(problem.bodies[joint.child]));
  const std::string name = "joint '" + joint.name + "': ";
  require(!rows.reversed, name + "its axes point against each other at the start");
  require((rows.g.array().abs() <= start_tolerance).all(), name + "it is open at the start");
  require((rows.rate.array().abs() <= start_tolerance).all(),
          name + "it is torn by the velocities at the start");
}

}  // namespace

void validate(const Case& problem) {
  for (const Body& body : problem.bodies) validate(body);
  for (const Joint& joint : problem.joints) validate(joint, problem.bodies.size());
  for (const Spring& spring : problem.springs) validate(spring, problem.bodies.size());
  for (const FloorSphere& sphere : problem.on_floor)
    require(sphere.body < problem.bodies.size(), "a sphere is on no body");
  require_a_tree(problem);
  for (const Joint& joint : problem.joints) require_shut(problem, joint);
}

}  // namespace godobject::oracle
