// What can touch what in a scene. Bodies of one tool, joined other than through the world, do not touch each
// other. A sphere touches obstacles, and bodies of other tools: their shapes, or their spheres where they
// have no shapes. So do nodes of nets, and the tool of a net is its carrier's; nets do not touch each other.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// For each body the first body of its tool.
std::vector<std::size_t> tools_of(const SceneConfig& scene);

/// What of a scene can touch.
enum class ContactScope : std::uint8_t {
  none,
  obstacles,  // bodies touch obstacles only
  bodies,     // and each other
};

ContactScope contact_scope(const SceneConfig& scene);

/// A material, and what is made of it first: "spheres of body 'tool'".
struct MaterialUse {
  std::string material;
  std::string where;
};

/// Each material once, in the order of bodies (spheres, then shapes), then nets, then obstacles.
std::vector<MaterialUse> materials_of(const SceneConfig& scene);

struct MaterialPair {
  MaterialUse a, b;
};

/// Each unordered pair of materials that can meet, once.
std::vector<MaterialPair> pairs_that_meet(const SceneConfig& scene);

/// The scene's contact of these materials, in either order; null without.
const ContactConfig* contact_of(const SceneConfig& scene, const std::string& a, const std::string& b);

/// Mass of the lightest body with a sphere or shape of one of the materials, or of such a net's mean node, kg; 1 where
/// there is none.
double lightest_of(const SceneConfig& scene, const std::vector<std::string>& materials);

}  // namespace godobject
