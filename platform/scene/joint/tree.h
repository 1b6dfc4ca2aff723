// Joints as edges between bodies; joints that do not form a tree are rejected by name.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// Adds joints one by one, each checked against the earlier ones.
class JointTree {
 public:
  /// Adds a joint whose bodies exist. Returns why it cannot form a tree with the earlier ones, with the
  /// remedy; empty on success.
  std::string add(const JointConfig& joint);

 private:
  struct Edge {
    std::string name, parent, child;
  };

  /// Returns the names of the joints on the path between two bodies, or a body and the world; none if they
  /// are not connected.
  std::optional<std::vector<std::string>> way(const std::string& from, const std::string& to) const;
  bool extend_way(const std::string& from, const std::string& to, std::vector<std::string>& joints) const;

  std::vector<Edge> edges_;
};

/// Returns the bodies with every parent before its children, otherwise in their order. joints: a tree.
std::vector<BodyConfig> parents_first(const std::vector<BodyConfig>& bodies,
                                      const std::vector<JointConfig>& joints);

}  // namespace godobject
