// Contacts of a scene: the pairs that can touch, and the parameters of the core with the storage of prepared
// meshes and height fields.
//
// Bodies of one tool, joined other than through the world, do not touch each other. A sphere touches
// obstacles and bodies of other tools: their shapes, or without shapes their spheres. Shapes touch shapes of
// other tools and obstacles. Nodes of nets touch as spheres do, and the surfaces of other nets; the tool of a
// net is its carrier's.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "core/contact/rounded.h"
#include "core/shape/mesh_setup.h"
#include "platform/scene/geometry.h"
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

/// A mesh with the data required by queries, in storage of its own.
class MeshSolid {
 public:
  /// Returns null, and sets `why_not`, if the triangles are not a solid or too many.
  static std::unique_ptr<MeshSolid> make(const MeshData& data, std::string& why_not);

  const MeshData& data() const { return data_; }
  /// Valid during the life of this object.
  const TriangleMesh& mesh() const { return mesh_; }

 private:
  explicit MeshSolid(const MeshData& data);
  MeshReport set_up(double grid_spacing);
  MeshStorage storage();

  MeshData data_;
  std::vector<Vec3> face_normals_, vertex_normals_;
  std::vector<EdgeNormals> edge_normals_;
  std::vector<std::uint32_t> half_edges_, cell_start_, cell_triangles_;
  TriangleMesh mesh_;
};

/// Laws of pairs of materials, symmetric; zero for pairs that do not meet.
using LawTable = std::array<std::array<ContactLaw, max_materials>, max_materials>;

/// Spheres in the order of their bodies. Surfaces of the world in the order of obstacles, then those of
/// bodies.
struct SceneContacts {
  std::vector<BodySphere> spheres;
  std::vector<Surface> surfaces;
  std::vector<std::string> surface_names;  // name of each surface in messages: "obstacle 'board'"
  std::vector<std::string> materials;      // by MaterialId
  LawTable laws;
  // Targets of pointers in surfaces, at stable addresses when this is moved.
  std::vector<std::unique_ptr<MeshSolid>> meshes;
  std::deque<std::vector<Real>> heights;
  std::deque<HeightField> height_fields;
};

/// Point of a plane that no body reaches, m.
inline const Vec3 parked_plane(0, 0, -1e4);

/// Converts the contacts of a scene that was read without errors: it has at most max_materials, and its
/// meshes are solids.
SceneContacts scene_contacts(const SceneConfig& scene);

/// Returns the dimensions and the pose of a shape; those of a file are none.
ShapeParams shape_params(const ShapeConfig& shape);

/// Returns the number of surfaces of an obstacle: one, or the number of its centres.
std::size_t num_solids(const ObstacleConfig& obstacle);

/// Capacities that a scene requires, counted without making geometry.
struct ContactCounts {
  std::size_t spheres = 0, surfaces = 0;
};
ContactCounts contact_counts(const SceneConfig& scene);

/// Sets the parameters of a composition that has room for the contacts; `contacts` outlives them.
template <class Params>
void set_contact_params(const SceneContacts& contacts, Params& par) noexcept {
  par.num_spheres = contacts.spheres.size();
  std::ranges::copy(contacts.spheres, par.spheres.begin());
  par.num_surfaces = contacts.surfaces.size();
  std::ranges::copy(contacts.surfaces, par.surfaces.begin());
  par.laws = contacts.laws;
  mark_rounded_points(par);
}

}  // namespace godobject
