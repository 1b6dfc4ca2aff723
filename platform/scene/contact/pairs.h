// Pairs that can touch in a scene.
//
// Bodies of one tool, joined other than through the world, do not touch each other. A sphere touches
// obstacles and bodies of other tools: their shapes, or without shapes their spheres. Nodes of nets touch the
// same; the tool of a net is its carrier's. Nets do not touch each other.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// Returns for each body the first body of its tool.
std::vector<std::size_t> tools_of(const SceneConfig& scene);

/// Contacts that are possible in a scene.
enum class ContactScope : std::uint8_t {
  none,
  obstacles,  // bodies touch obstacles only
  bodies,     // bodies also touch each other
};

ContactScope contact_scope(const SceneConfig& scene);

/// A material and its first use, as "spheres of body 'tool'".
struct MaterialUse {
  std::string material;
  std::string where;
};

/// Returns each material once, in the order of bodies (spheres, then shapes), nets and obstacles.
std::vector<MaterialUse> materials_of(const SceneConfig& scene);

struct MaterialPair {
  MaterialUse a, b;
};

/// Returns each unordered pair of materials that can meet, once.
std::vector<MaterialPair> pairs_that_meet(const SceneConfig& scene);

/// Returns the scene's contact of these materials, in either order; null if there is none.
const ContactConfig* contact_of(const SceneConfig& scene, const std::string& a, const std::string& b);

/// Returns the smallest mass of a body with a sphere or shape of one of the materials, or of such a net's
/// mean node, kg. Returns 1 if there is none.
double lightest_of(const SceneConfig& scene, const std::vector<std::string>& materials);

}  // namespace godobject
