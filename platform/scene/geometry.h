// Geometry of a scene file: spheres and shapes of bodies, obstacles, contacts of their materials, and nets.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/contact.h"
#include "core/shape/list.h"

namespace godobject {

inline constexpr const char* default_material = "default";

/// A row of equal spheres on a body; one sphere if count is 1.
struct SphereConfig {
  Vec3 p_B = Vec3::Zero();  // centre of the first, m, body axes about the centre of mass
  double radius = 0;        // m, > 0
  std::string material = default_material;
  int count = 1;                // >= 1
  Vec3 spacing = Vec3::Zero();  // vector from one centre to the next, m, body axes
};

/// A solid. Each kind has only the dimensions that it requires.
struct ShapeConfig {
  ShapeKind kind = ShapeKind::box;
  Pose X;  // body shape: in body axes about the centre of mass; obstacle: in the world
  std::optional<Vec3> half_extents;   // box: m, > 0
  std::optional<double> radius;       // sphere, capsule: m, > 0
  std::optional<double> half_length;  // capsule: m, >= 0
  std::string material = default_material;
};

/// Triangles, counter-clockwise seen from outside.
struct MeshData {
  std::vector<Vec3> vertices;  // m
  std::vector<TriangleIndices> triangles;
};

/// Heights over a grid: column i, row j stands at x = i spacing, y = j spacing.
struct HeightGrid {
  std::vector<Real> height;  // row by row, m
  std::uint32_t columns = 0, rows = 0;
};

/// An obstacle, fixed in the world.
struct ObstacleConfig {
  std::string name;
  ShapeConfig shape;
  std::string file;             // name of the file of a mesh, height field or many spheres; empty without one
  std::optional<double> scale;  // m per unit of a mesh file
  std::optional<double> spacing;  // m, distance of neighbours in a height field's grid
  // Contents of the file.
  MeshData mesh;
  HeightGrid heights;
  std::vector<Vec3> centres;  // m, centres of the spheres in the axes of shape.X
};

/// Law of a contact between two materials (22), (23).
struct ContactConfig {
  std::vector<std::string> materials;  // two, in any order; may be equal
  ContactLaw law{};                    // of each sphere
};

// Nets: deformable surfaces of masses and springs, on a body or in the world.

/// Capacities of the compiled compositions, for all nets of a scene together.
inline constexpr std::size_t max_net_nodes = 1536, max_net_springs = 9216, max_net_contacts = 768,
                             max_net_attachments = 256;
/// Triangles of all nets: of three edges each, which they share in twos, so springs are at least 3/2 of them.
inline constexpr std::size_t max_net_faces = max_net_springs * 2 / 3;

/// Names of NetKind in scene files, in its order.
inline constexpr std::array net_kind_names{"tube", "capsule", "sphere", "sheet", "mesh"};

enum class NetKind : std::uint8_t {
  tube,     // about z, open at both ends
  capsule,  // about z, closed
  sphere,
  sheet,  // in the plane z = 0, centred at the origin
  mesh,   // from a file
};

/// A ball whose nodes are held by stiff anchors.
struct HeldConfig {
  Vec3 p_F = Vec3::Zero();  // m, centre in the net's frame F
  double radius = 0;        // m, > 0
};

/// A ball whose nodes are attached, at their places at the start, to a body other than the carrier.
struct AttachedConfig {
  std::string body;                 // name of the body, or world_name
  Vec3 p_F = Vec3::Zero();          // m, centre in the net's frame F
  double radius = 0;                // m, > 0
  std::optional<double> stiffness;  // N/m of each node, > 0
  double relaxation_time = 0;       // tau: g = tau k, s
};

struct NetConfig {
  std::string name;
  std::string body = "world";  // name of the carrier, or world_name
  Pose X_BF;  // net's frame F in the carrier's axes about its centre of mass, or in the world

  // Surface with the nodes. Each kind has only the dimensions that it requires.
  NetKind kind = NetKind::sheet;
  std::optional<double> spacing;        // m, distance of nodes, > 0; a mesh has its own
  std::optional<double> radius;         // tube, capsule, sphere: m, > 0
  std::optional<double> half_length;    // tube, capsule: m along z
  std::optional<double> length, width;  // sheet: m along x and y, > 0
  std::string file;                     // mesh
  std::optional<double> scale;          // mesh: m per unit of its file
  MeshData surface;                     // generated, in F; vertices in the order of nodes

  // Material of the surface.
  std::optional<double> thickness;         // m, twice the radius of the nodes' contact spheres, >= 0
  double surface_density = 0;              // sigma, kg/m^2, > 0
  double membrane_stiffness = 0;           // E t, N/m, > 0
  double bending = 0;                      // stiffness of bending springs relative to structural ones
  double relaxation_time = 0;              // tau of springs: g = tau k, s
  double settling_time = 0;                // s, > 0
  std::optional<double> anchor_stiffness;  // kappa, N/m^3, >= 0; absent: derived from settling_time
  std::string material = default_material;
  bool touches_itself = false;  // true: its nodes touch its own surface, too

  // Nodes that are held in addition to their anchors.
  bool rim = false;                      // true: nodes on the edge of an open surface
  std::vector<HeldConfig> held;          // nodes in these balls
  std::optional<double> held_stiffness;  // N/m of each node
  std::vector<AttachedConfig> attached;  // balls of nodes attached to other bodies
};

}  // namespace godobject
