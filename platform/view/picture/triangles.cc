#include "platform/view/picture/triangles.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace godobject {
namespace {

constexpr std::uint32_t num_sides = 32, num_rings = 8;  // sides of round solids; rings of a half sphere

/// Returns a surface of revolution about z through points (radius, height) from bottom to top; both ends are
/// closed.
MeshData turned(const std::vector<std::array<double, 2>>& profile) {
  MeshData mesh;
  for (const auto& [radius, height] : profile)
    for (std::uint32_t i = 0; i < num_sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / num_sides;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
    }
  const auto n = static_cast<std::uint32_t>(profile.size());
  for (std::uint32_t ring = 0; ring + 1 < n; ++ring)
    for (std::uint32_t i = 0; i < num_sides; ++i) {
      const std::uint32_t a = ring * num_sides + i, b = ring * num_sides + (i + 1) % num_sides;
      mesh.triangles.push_back({a, b, b + num_sides});
      mesh.triangles.push_back({a, b + num_sides, a + num_sides});
    }
  const auto cap = [&](std::uint32_t first, double height, bool top) {
    const auto centre = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(0, 0, height);
    for (std::uint32_t i = 0; i < num_sides; ++i) {
      const std::uint32_t a = first + i, b = first + (i + 1) % num_sides;
      mesh.triangles.push_back(top ? TriangleIndices{centre, a, b} : TriangleIndices{centre, b, a});
    }
  };
  cap(0, profile.front()[1], false);
  cap((n - 1) * num_sides, profile.back()[1], true);
  return mesh;
}

/// Returns the profile of two half spheres, half_length above and below the middle.
std::vector<std::array<double, 2>> rounded(double radius, double half_length) {
  std::vector<std::array<double, 2>> profile;
  for (int side : {-1, 1})
    for (std::uint32_t ring = 0; ring <= num_rings; ++ring) {
      const double part = static_cast<double>(ring) / num_rings;
      const double angle = 0.5 * std::numbers::pi * (side < 0 ? part - 1 : part);
      profile.push_back({radius * std::cos(angle), radius * std::sin(angle) + side * half_length});
    }
  return profile;
}

MeshData box(const Vec3& half) {
  MeshData mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (const auto& [a, b] : {std::array{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        Vec3 corner;
        corner[axis] = side * half[axis];
        corner[u] = a * half[u];
        corner[v] = b * half[v];
        mesh.vertices.push_back(corner);
      }
      const std::uint32_t second = side > 0 ? 1 : 3, fourth = side > 0 ? 3 : 1;
      mesh.triangles.push_back({first, first + second, first + 2});
      mesh.triangles.push_back({first, first + 2, first + fourth});
    }
  return mesh;
}

void place(MeshData& mesh, const Vec3& a, const Vec3& b) {
  const Quat q = turn_from_z(b - a);
  for (Vec3& p : mesh.vertices) p = a + q * p;
}

/// Returns edges of one triangle only, and edges between triangles with normals that differ by more than 14
/// degrees.
std::vector<std::array<Vec3, 2>> sharp_edges(const MeshData& mesh) {
  constexpr double same_face = 0.97;  // cosine
  const auto key = [&](std::uint32_t i) {
    const Vec3& p = mesh.vertices[i];
    return std::array{p.x(), p.y(), p.z()};
  };
  struct Edge {
    Vec3 normal;
    bool sharp = true;
  };
  std::map<std::array<std::array<double, 3>, 2>, Edge> edges;
  for (const TriangleIndices& t : mesh.triangles) {
    const Vec3 n = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                       .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                       .normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      std::array ends{key(t[k]), key(t[(k + 1) % 3])};
      std::ranges::sort(ends);
      const auto [found, is_new] = edges.try_emplace(ends, Edge{.normal = n});
      if (!is_new) found->second.sharp = found->second.normal.dot(n) < same_face;
    }
  }
  std::vector<std::array<Vec3, 2>> wires;
  for (const auto& [ends, edge] : edges)
    if (edge.sharp) wires.push_back({Vec3(ends[0].data()), Vec3(ends[1].data())});
  return wires;
}

/// Returns every fourth ring and every eighth meridian of a round solid.
std::vector<std::array<Vec3, 2>> round_wires(const MeshData& mesh) {
  constexpr std::uint32_t every = 4;
  std::vector<std::array<Vec3, 2>> wires;
  const auto num_profile = static_cast<std::uint32_t>(mesh.vertices.size() - 2) / num_sides;
  for (std::uint32_t ring = 0; ring < num_profile; ++ring)
    for (std::uint32_t i = 0; i < num_sides; ++i) {
      const std::uint32_t a = ring * num_sides + i, b = ring * num_sides + (i + 1) % num_sides;
      if (ring % every == 0 || ring + 1 == num_profile) wires.push_back({mesh.vertices[a], mesh.vertices[b]});
      if (i % (2 * every) == 0 && ring + 1 < num_profile)
        wires.push_back({mesh.vertices[a], mesh.vertices[a + num_sides]});
    }
  return wires;
}

}  // namespace

MeshData triangles_of(const Solid& solid, const Drawing& drawing, double plane_half_size) {
  const double r = solid.size.x(), l = solid.size.y(), s = plane_half_size;
  switch (solid.kind) {
    case SolidKind::box: return box(solid.size);
    case SolidKind::sphere: return turned(rounded(r, 0));
    case SolidKind::capsule: return turned(rounded(r, l));
    case SolidKind::cylinder: return turned({{r, -l}, {r, l}});
    case SolidKind::plane:
      return {.vertices = {{-s, -s, 0}, {s, -s, 0}, {s, s, 0}, {-s, s, 0}},
              .triangles = {{0, 1, 2}, {0, 2, 3}}};
    case SolidKind::mesh: break;
  }
  return drawing.meshes[solid.mesh];
}

std::vector<std::array<Vec3, 2>> wires_of(const Solid& solid, const Drawing& drawing) {
  const MeshData mesh = triangles_of(solid, drawing, 1);
  const bool is_round = solid.kind == SolidKind::sphere || solid.kind == SolidKind::capsule ||
                        solid.kind == SolidKind::cylinder;
  return is_round ? round_wires(mesh) : sharp_edges(mesh);
}

MeshData rod(const Vec3& a, const Vec3& b, double radius) {
  MeshData mesh = turned({{radius, 0}, {radius, (b - a).norm()}});
  place(mesh, a, b);
  return mesh;
}

MeshData arrow(const Vec3& a, const Vec3& b, double shaft_radius) {
  const double length = (b - a).norm(), head = std::min(0.4 * length, 8 * shaft_radius);
  MeshData mesh = turned(
      {{shaft_radius, 0}, {shaft_radius, length - head}, {3 * shaft_radius, length - head}, {0, length}});
  place(mesh, a, b);
  return mesh;
}

}  // namespace godobject
