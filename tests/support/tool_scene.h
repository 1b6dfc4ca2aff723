// Scenes with joints for tests: as text, as shipped, and at the state of a run.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/toml.h"
#include "platform/session/session.h"

namespace godobject::test {

inline std::string body(const std::string& name, const std::string& more = "") {
  return "[[body]]\nname = \"" + name + "\"\nmass = 0.1\ninertia = [1e-4, 1e-4, 1e-4]\n" + more;
}

inline std::string joint(const std::string& name, const std::string& kind, const std::string& parent,
                         const std::string& child, const std::string& more = "") {
  return "[[joint]]\nname = \"" + name + "\"\nkind = \"" + kind + "\"\nparent = \"" + parent +
         "\"\nchild = \"" + child + "\"\n" + more;
}

inline LoadResult parse_tool(const std::string& text) {
  return parse_scene("[scene]\nname = \"test\"\n" + text, "a.toml");
}

inline SceneConfig load_shipped(const std::string& name) {
  return load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/" + name).scene.value();
}

/// Returns the bodies of the scene at the poses of a record.
inline std::vector<BodyConfig> placed(const SceneConfig& scene, const CycleRecord& record) {
  std::vector<BodyConfig> bodies = scene.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i].X_WB = record.bodies[i].X_WB;
  return bodies;
}

}  // namespace godobject::test
