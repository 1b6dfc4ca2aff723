// Drawable scene: the solids of bodies and obstacles, the nets, and the scene as JSON for the page.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "platform/scene/net/params.h"
#include "platform/scene/scene.h"
#include "platform/view/frame.h"

namespace godobject {

enum class SolidKind : std::uint8_t { box, sphere, capsule, cylinder, plane, mesh };
inline constexpr std::array solid_kind_names{"box", "sphere", "capsule", "cylinder", "plane", "mesh"};

/// Meaning of a solid.
enum class SolidRole : std::uint8_t {
  shape,     // a shape of a body
  inertia,   // the solid of equal mass and inertia, for a body without shapes
  contact,   // a contact sphere of a body
  obstacle,  // fixed in the world
};
inline constexpr std::array solid_role_names{"shape", "inertia", "contact", "obstacle"};

struct Solid {
  SolidKind kind = SolidKind::box;
  SolidRole role = SolidRole::shape;
  std::optional<std::size_t> body{};  // absent: fixed in the world
  std::string name{};                 // name of the body or the obstacle
  Pose X{};                           // pose of the solid on its body, or in the world
  // box: half extents; sphere: radius, -, -; capsule, cylinder about z: radius, half length, -
  Vec3 size = Vec3::Zero();
  std::size_t mesh = 0;  // index in Drawing::meshes
};

struct Drawing {
  std::vector<Solid> solids;
  std::vector<MeshData> meshes;  // also of height fields
};

/// Returns the solids of the obstacles, then of the bodies.
Drawing drawing_of(const SceneConfig& scene);

/// Returns the simplest solid of uniform density with this mass and inertia: a sphere, a cylinder or a box.
Solid solid_of_inertia(double mass, const Mat3& inertia);

// Nets.

/// Returns the positions of the nodes, world, m: those of the sample, or the nodes' anchors if the sample has
/// none, as with traces.
std::vector<Vec3> nodes_of(const SceneNets& nets, const ViewSample& sample);

/// Returns the positions of the nodes at the start, world, m.
std::vector<Vec3> nodes_at_start(const SceneConfig& scene);

/// Returns the triangles of a net, with the net's own node indices.
std::vector<TriangleIndices> triangles_of(const NetRange& net);

// The scene as JSON: names, shapes, and texts for the bits of faults and limits.

/// Text for a bit of a frame's fault and limit words.
struct BitText {
  std::string name, text;  // text: meaning and remedy
};

struct BusLoadText {
  std::string name;
  double percent = 0;  // worst case
};

/// Data of a view besides its scene.
struct ViewAbout {
  std::string title;  // "run sim/scenes/lego.toml", or the file of a recording
  bool live = true;
  bool takes_pointer = false;
  bool takes_pace = false;                                             // true if pages may pause the run
  bool fast = false;                                                   // true if the run is not in wall time
  std::string no_reset = "this program does not start its run again";  // empty: pages may reset the run
  std::string warning{};                                               // displayed on the page; empty: none
  std::vector<BitText> faults{}, rig_faults{}, limits{};
  std::vector<BusLoadText> buses{};
};

/// Returns the JSON text, with the keys of docs/view.md.
std::string scene_json(const SceneConfig& scene, const ViewAbout& about);

}  // namespace godobject
