// Joints as edges between bodies: what does not make a tree is refused by the names of the joints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// Joints taken one after the other, each checked against those before.
class JointTree {
 public:
  /// Adds a joint whose bodies exist. Empty, or why it cannot be in one tree with the earlier ones and what
  /// to do.
  std::string add(const JointConfig& joint);

 private:
  struct Edge {
    std::string name, parent, child;
  };

  /// Names of the joints on the way between two bodies, or between a body and the world; none: not joined.
  std::optional<std::vector<std::string>> way(const std::string& from, const std::string& to) const;
  bool extend_way(const std::string& from, const std::string& to, std::vector<std::string>& joints) const;

  std::vector<Edge> edges_;
};

/// The bodies with every parent before its children, otherwise in the order they are in. joints: a tree.
std::vector<BodyConfig> parents_first(const std::vector<BodyConfig>& bodies,
                                      const std::vector<JointConfig>& joints);

}  // namespace godobject
