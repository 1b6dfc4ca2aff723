// What a scene file says of nets: deformable surfaces of masses and springs, on a body or in the world.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "platform/scene/contact/config.h"

namespace godobject {

/// Room of the compiled compositions, for all nets of a scene together.
inline constexpr std::size_t max_net_nodes = 1536, max_net_springs = 9216, max_net_contacts = 768,
                             max_net_attachments = 256;

/// Names of NetKind in scene files, in its order.
inline constexpr std::array net_kind_names{"tube", "capsule", "sphere", "sheet", "mesh"};

enum class NetKind : std::uint8_t {
  tube,     // about z, open at both ends
  capsule,  // about z, closed
  sphere,
  sheet,  // in the plane z = 0, its middle at the origin
  mesh,   // of a file
};

/// Vertices of the net within it hang on stiff anchors.
struct HeldConfig {
  Vec3 p_F = Vec3::Zero();  // its centre in the net's frame F, m
  double radius = 0;        // m, > 0
};

/// Vertices of the net within it are attached, where they are at the start, to a body that does not carry it.
struct AttachedConfig {
  std::string body;                 // its name, or world_name
  Vec3 p_F = Vec3::Zero();          // its centre in the net's frame F, m
  double radius = 0;                // m, > 0
  std::optional<double> stiffness;  // N/m of each vertex, > 0
  double relaxation_time = 0;       // tau: g = tau k, s
};

struct NetConfig {
  std::string name;
  std::string body = "world";  // its carrier: name of a body, or world_name
  Pose X_BF;  // of the net's frame F: in the carrier's axes about its centre of mass, or in the world

  // Its surface, on which its vertices are. Each kind has the dimensions it needs and no others.
  NetKind kind = NetKind::sheet;
  std::optional<double> spacing;        // of vertices, m, > 0; a mesh has its own
  std::optional<double> radius;         // tube, capsule, sphere: m, > 0
  std::optional<double> half_length;    // tube, capsule: m along z
  std::optional<double> length, width;  // sheet: m along x and y, > 0
  std::string file;                     // mesh
  std::optional<double> scale;          // mesh: m per unit of its file
  MeshData surface;                     // made of these, in F; vertices in the order of nodes

  // What it is made of.
  std::optional<double> thickness;         // m, >= 0: twice the radius with which nodes touch
  double surface_density = 0;              // sigma, kg/m^2, > 0
  double membrane_stiffness = 0;           // E t, N/m, > 0
  double bending = 0;                      // stiffness of bending springs against structural ones
  double relaxation_time = 0;              // tau of springs: g = tau k, s
  double settling_time = 0;                // s, > 0
  std::optional<double> anchor_stiffness;  // kappa, N/m^3, >= 0; absent: as settling_time wants it
  std::string material = default_material;

  // What is held, beyond the anchors of all vertices.
  bool rim = false;                      // vertices on the edge of an open surface
  std::vector<HeldConfig> held;          // and those in these
  std::optional<double> held_stiffness;  // N/m of each
  std::vector<AttachedConfig> attached;  // to others
};

}  // namespace godobject
