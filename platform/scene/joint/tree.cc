#include "platform/scene/joint/tree.h"

#include <algorithm>

namespace godobject {

std::string JointTree::add(const JointConfig& joint) {
  if (joint.parent == joint.child)
    return "joint '" + joint.name + "' joins body '" + joint.child +
           "' to itself: give it another parent or child";
  if (const auto joints = way(joint.parent, joint.child)) {
    if (joints->size() == 1)
      return "joints '" + joints->front() + "' and '" + joint.name + "' both join '" + joint.parent +
             "' and '" + joint.child +
             "', which constrains some motion twice: remove one of them, or make them one joint of another "
             "kind";
    std::string names;
    for (const std::string& name : *joints) names += "'" + name + "', ";
    return "joints " + names + "'" + joint.name +
           "' close a loop, but a tool must be a tree: remove one of them, or close the loop by couplings to "
           "the device";
  }
  const auto earlier = std::ranges::find(edges_, joint.child, &Edge::child);
  if (earlier != edges_.end())
    return "body '" + joint.child + "' is the child of joints '" + earlier->name + "' and '" + joint.name +
           "': swap parent and child of one of them";
  edges_.push_back({.name = joint.name, .parent = joint.parent, .child = joint.child});
  return "";
}

std::optional<std::vector<std::string>> JointTree::way(const std::string& from, const std::string& to) const {
  std::vector<std::string> joints;
  if (!extend_way(from, to, joints)) return std::nullopt;
  return joints;
}

/// Searches the earlier joints, which are a forest: a path that does not turn back meets no body twice.
bool JointTree::extend_way(const std::string& from, const std::string& to,
                           std::vector<std::string>& joints) const {
  if (from == to) return true;
  for (const Edge& edge : edges_) {
    const bool turns_back = !joints.empty() && joints.back() == edge.name;
    if (turns_back || (edge.parent != from && edge.child != from)) continue;
    joints.push_back(edge.name);
    if (extend_way(edge.parent == from ? edge.child : edge.parent, to, joints)) return true;
    joints.pop_back();
  }
  return false;
}

std::vector<BodyConfig> parents_first(const std::vector<BodyConfig>& bodies,
                                      const std::vector<JointConfig>& joints) {
  std::vector<BodyConfig> ordered;
  std::vector<bool> taken(bodies.size(), false);
  const auto is_there = [&](const std::string& name) {
    return name == world_name || std::ranges::find(ordered, name, &BodyConfig::name) != ordered.end();
  };
  const auto can_be_next = [&](std::size_t i) {
    if (taken[i]) return false;
    const auto joint = std::ranges::find(joints, bodies[i].name, &JointConfig::child);
    return joint == joints.end() || is_there(joint->parent);
  };
  while (ordered.size() < bodies.size()) {
    std::size_t next = 0;
    while (next < bodies.size() && !can_be_next(next)) ++next;
    if (next == bodies.size()) return bodies;  // not a tree
    taken[next] = true;
    ordered.push_back(bodies[next]);
  }
  return ordered;
}

}  // namespace godobject
