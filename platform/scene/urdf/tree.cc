// The tree of a robot description, and its links merged into bodies.
#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>

#include <Eigen/Geometry>

#include "core/math/pose.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"
#include "platform/scene/urdf/urdf.h"

namespace godobject {
namespace {

/// Sets mass, centre and inertia of rigidly joined links:
/// c = sum m_i c_i / m,  I = sum (R_i I_i R_i^T + m_i (|d_i|^2 1 - d_i d_i^T)),  d_i = c_i - c
void weigh(UrdfGroup& group) {
  const auto centre = [](const UrdfInertial& part, const Pose& X) { return X * part.p_L; };
  for (const auto& [link, joint, X] : group.links) {
    if (!link->inertial) continue;
    group.mass += link->inertial->mass;
    group.c += link->inertial->mass * centre(*link->inertial, X);
  }
  if (group.mass > 0) group.c /= group.mass;
  for (const auto& [link, joint, X] : group.links) {
    if (!link->inertial) continue;
    const Mat3 R = X.q.toRotationMatrix();
    const Vec3 d = centre(*link->inertial, X) - group.c;
    group.I += R * link->inertial->I_L * R.transpose() +
               link->inertial->mass * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
  }
  group.I = (0.5 * (group.I + group.I.transpose())).eval();
}

class UrdfTree {
 public:
  UrdfTree(const UrdfRobot& robot, Diagnostics& log) : robot_(robot), log_(log) {
    for (const UrdfLink& link : robot.links) links_.emplace(link.name, &link);
    for (const UrdfJoint& joint : robot.joints) {
      joints_.emplace(joint.child, &joint);
      children_[joint.parent].push_back(&joint);
    }
  }

  std::vector<UrdfGroup> grouped() {
    for (const UrdfJoint& joint : robot_.joints) check_ends(joint);
    const bool ends_are_there = log_.ok();
    for (const UrdfJoint& joint : robot_.joints)
      if (joint.mimic && ends_are_there) check_mimic(joint);
    if (const UrdfLink* const root = checked_root()) add_tree(*root);
    if (log_.ok()) check_masses();
    return std::move(groups_);
  }

 private:
  /// Link on a joint, before it is in a group.
  struct Next {
    const UrdfLink* link;
    const UrdfJoint* joint;  // null: of the root
    std::size_t on;          // group of the parent link
    Pose X;                  // link's frame on that group, at coordinate zero
  };

  const UrdfJoint* joint_of(const UrdfLink& child) const {
    const auto found = joints_.find(child.name);
    return found == joints_.end() ? nullptr : found->second;
  }

  const UrdfJoint* joint_named(const std::string& name) const {
    const auto found = std::ranges::find(robot_.joints, name, &UrdfJoint::name);
    return found == robot_.joints.end() ? nullptr : &*found;
  }

  /// Checks that a joint follows one that moves, and in the end one that follows none.
  void check_mimic(const UrdfJoint& joint) {
    const std::string owner = "joint " + excerpt(joint.name);
    const auto refuse = [&](const std::string& why) { log_.error(joint.mimic->at, owner + why); };
    const UrdfJoint* const leader = joint_named(joint.mimic->joint);
    if (leader == nullptr)
      return refuse(" follows joint " + excerpt(joint.mimic->joint) +
                    " by <mimic>, which does not exist: name a joint of this robot");
    if (!joint.moves() || !leader->moves())
      return refuse(" and joint " + excerpt(leader->name) +
                    " are joined by <mimic>, and one of them has no coordinate: remove <mimic>");
    if (joint.mimic->multiplier == 0)
      return refuse(" follows joint " + excerpt(leader->name) +
                    " with multiplier 0: remove <mimic>, and make the joint a fixed one");
    std::set<const UrdfJoint*> leaders{&joint};
    for (const UrdfJoint* next = leader; next != nullptr && next->mimic;
         next = joint_named(next->mimic->joint))
      if (!leaders.insert(next).second || leaders.contains(joint_named(next->mimic->joint)))
        return refuse(" follows itself by <mimic>, over joint " + excerpt(next->name) +
                      ": remove one <mimic> of the ring");
    check_limits(joint, *leader);
  }

  /// Warns if a joint follows another beyond its own limits: its stops would hold both.
  void check_limits(const UrdfJoint& joint, const UrdfJoint& leader) {
    if (!joint.limit || !leader.limit) return;
    const auto follows = [&](double q) { return joint.mimic->multiplier * q + joint.mimic->offset; };
    const auto [first, last] = std::minmax({follows(leader.limit->lower), follows(leader.limit->upper)});
    const double slack = stop_width * (joint.limit->upper - joint.limit->lower);
    if (first >= joint.limit->lower - slack && last <= joint.limit->upper + slack) return;
    const auto range = [](double from, double to) {
      return shortest_plain(from) + " to " + shortest_plain(to);
    };
    log_.warning(joint.mimic->at,
                 "joint " + excerpt(joint.name) + " follows joint " + excerpt(leader.name) + " from " +
                     range(first, last) + ", beyond its own limits of " +
                     range(joint.limit->lower, joint.limit->upper) +
                     ", whose stops then hold both: correct <limit>, or the multiplier of <mimic>");
  }

  /// Returns the coordinate at the start. Only of joints that check_mimic() accepts.
  double start_of(const UrdfJoint& joint) const {
    if (joint.mimic && log_.ok())
      return joint.mimic->multiplier * start_of(*joint_named(joint.mimic->joint)) + joint.mimic->offset;
    // limits in the wrong order have an error of their own
    return joint.limit ? std::max(joint.limit->lower, std::min(0.0, joint.limit->upper)) : 0;
  }

  void check_ends(const UrdfJoint& joint) {
    for (const std::string* end : {&joint.parent, &joint.child}) {
      if (end->empty() || links_.contains(*end) || log_.full()) continue;
      std::vector<std::string_view> names;
      for (const UrdfLink& link : robot_.links) names.push_back(link.name);
      const auto nearest = nearest_name(*end, names);
      log_.error(joint.at, "joint " + excerpt(joint.name) + " names link " + excerpt(*end) +
                               ", which does not exist: " +
                               (nearest ? "did you mean '" + std::string(*nearest) + "'?" : "add the link"));
    }
    if (const UrdfJoint* const earlier = joints_.at(joint.child); earlier != &joint && !joint.child.empty())
      log_.error(joint.at, "link " + excerpt(joint.child) + " is the child of joints " +
                               excerpt(earlier->name) + " and " + excerpt(joint.name) +
                               ", but a robot must be a tree: remove one of them");
  }

  /// Returns the root; null without any. More than one is an error.
  const UrdfLink* checked_root() {
    const UrdfLink* root = nullptr;
    for (const UrdfLink& link : robot_.links) {
      const bool is_root = joint_of(link) == nullptr;
      if (is_root && root != nullptr)
        log_.error(link.at, "link " + excerpt(link.name) + " is a second root beside " + excerpt(root->name) +
                                ": add a joint whose child it is, of type fixed or floating");
      if (link.name == world_name && !(is_root && !link.inertial))
        log_.error(link.at, "link 'world' is the ground in scenes, and here it has " +
                                std::string(is_root ? "mass" : "a parent") + ": rename it");
      if (is_root && root == nullptr) root = &link;
    }
    if (robot_.links.empty()) log_.error({}, "has no links: add <link> elements");
    else if (root == nullptr)
      log_.error(robot_.joints.front().at, "joint " + excerpt(robot_.joints.front().name) +
                                               " is in a loop, and no link is a root: remove a joint");
    return root;
  }

  /// Adds all links behind the root, each joint with its whole branch before the next one.
  void add_tree(const UrdfLink& root) {
    groups_.emplace_back();
    std::vector<Next> next{{&root, nullptr, urdf_ground, {}}};
    std::unordered_map<const UrdfLink*, bool> reached;
    while (!next.empty()) {
      const Next now = next.back();
      next.pop_back();
      if (!std::exchange(reached[now.link], true)) add(now, next);
    }
    if (!log_.ok()) return;  // branches of second roots are no loops
    for (const UrdfLink& link : robot_.links)
      if (!reached.contains(&link))
        log_.error(link.at, "link " + excerpt(link.name) +
                                " is in a loop of joints, or behind one: remove joint " +
                                excerpt(joint_of(link)->name) + " or another of the loop");
  }

  void add(const Next& now, std::vector<Next>& next) {
    const UrdfJoint* const joint = now.joint;
    const bool is_fixed = !joint || joint->kind == UrdfJointKind::fixed;
    const bool is_merged = is_fixed && !(now.on == urdf_ground && now.link->inertial);
    if (!is_merged) {
      UrdfGroup group;
      group.first = now.link;
      group.joint = joint;
      group.parent = now.on;
      group.X_P = now.X;
      if (joint) group.start = start_of(*joint);
      Pose motion;
      if (joint && joint->kind == UrdfJointKind::prismatic) motion.p = group.start * joint->axis_C;
      else if (joint) motion.q = Quat(Eigen::AngleAxisd(group.start, joint->axis_C));
      group.X_W = groups_[now.on].X_W * now.X * motion;
      const bool is_free = now.on == urdf_ground || (joint && joint->kind == UrdfJointKind::floating);
      group.tool = is_free ? groups_.size() : groups_[now.on].tool;
      groups_.push_back(group);
    }
    const std::size_t on = is_merged ? now.on : groups_.size() - 1;
    const Pose X = is_merged ? now.X : Pose{};
    groups_[on].links.push_back({now.link, joint, X});
    const auto children = children_.find(now.link->name);
    if (children == children_.end()) return;
    for (auto child = children->second.rbegin(); child != children->second.rend(); ++child)
      if (const auto link = links_.find((*child)->child); link != links_.end())
        next.push_back({link->second, *child, on, X * (*child)->X_PC});
  }

  void check_masses() {
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      UrdfGroup& group = groups_[i];
      weigh(group);
      if (i != urdf_ground && !(group.mass > 0))
        log_.error(group.first->at, "link '" + group.first->name + "' moves by joint '" + group.joint->name +
                                        "' and has no mass: add <inertial>, or make the joint fixed");
    }
    if (groups_.size() == urdf_ground + 1)
      log_.error(robot_.links.front().at, "no link has mass, so nothing can move: add <inertial>");
    if (groups_.size() > max_tables_of_bodies + 1)
      log_.error({}, "has " + std::to_string(groups_.size() - 1) + " bodies; a scene has at most " +
                         std::to_string(max_tables_of_bodies) + ": join some by fixed joints");
  }

  const UrdfRobot& robot_;
  Diagnostics& log_;
  std::unordered_map<std::string, const UrdfLink*> links_;                   // by name
  std::unordered_map<std::string, const UrdfJoint*> joints_;                 // by child, the first of each
  std::unordered_map<std::string, std::vector<const UrdfJoint*>> children_;  // by parent
  std::vector<UrdfGroup> groups_;
};

}  // namespace

std::vector<UrdfGroup> groups_of(const UrdfRobot& robot, Diagnostics& log) {
  return UrdfTree(robot, log).grouped();
}

}  // namespace godobject
