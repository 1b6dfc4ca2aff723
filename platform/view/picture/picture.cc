#include "platform/view/picture/picture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Geometry>

#include "core/math/pose.h"
#include "platform/view/drawing.h"

namespace godobject {
namespace {

// The page's colours.
constexpr Colour tool_colour{0xd5, 0x45, 0x2c}, body_colour{0x7e, 0x9f, 0xc7},
    obstacle_colour{0xa9, 0xa2, 0x94}, ghost_colour{0xe0, 0x8a, 0x1e}, unloaded_colour{0x2c, 0x9c, 0x5a},
    loaded_colour{0xd5, 0x26, 0x1c}, force_colour{0xb0, 0x1f, 0xb0}, contact_colour{0x1f, 0x7f, 0xd0};

Colour between(const Colour& a, const Colour& b, double s) {
  Colour c{};
  for (std::size_t i = 0; i < c.size(); ++i)
    c[i] = static_cast<std::uint8_t>(std::lround((1 - s) * a[i] + s * b[i]));
  return c;
}

/// Adds points around all finite solids. X_WB(body): pose of that body.
template <class Where>
void add_outline(const Drawing& drawing, const Where& X_WB, std::vector<Vec3>& points) {
  for (const Solid& solid : drawing.solids) {
    if (solid.kind == SolidKind::plane || solid.role == SolidRole::contact) continue;
    const Pose X = solid.body ? X_WB(*solid.body) * solid.X : solid.X;
    if (solid.kind == SolidKind::mesh) {
      for (const Vec3& p : drawing.meshes[solid.mesh].vertices) points.push_back(X.p + X.q * p);
      continue;
    }
    const double r = solid.size.x(), l = solid.size.y();
    Vec3 half(r, r, r);
    if (solid.kind == SolidKind::box) half = solid.size;
    if (solid.kind == SolidKind::capsule) half.z() += l;
    if (solid.kind == SolidKind::cylinder) half.z() = l;
    for (const double x : {-1.0, 1.0})
      for (const double y : {-1.0, 1.0})
        for (const double z : {-1.0, 1.0}) points.push_back(X.p + X.q * half.cwiseProduct(Vec3(x, y, z)));
  }
}

/// Sets centre and extent of the start of the scene, and the outline of instants of the whole recording. So
/// the camera of an animation stands still.
void set_bounds(const Recording& recording, const Drawing& drawing, Picture& picture) {
  constexpr std::size_t num_instants = 16;
  std::vector<Vec3>& points = picture.outline;
  add_outline(
      drawing, [&](std::size_t body) { return recording.scene.bodies[body].X_WB; }, points);
  for (const Vec3& p : nodes_at_start(recording.scene)) points.push_back(p);
  if (points.empty()) points.push_back(Vec3::Zero());
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  constexpr double least = 0.01;
  picture.centre = box.center();
  picture.extent = std::max(least, 0.5 * box.diagonal().norm());
  for (std::size_t i = 0; i < num_instants; ++i) {
    const CycleRecord& record =
        recording.samples[(recording.samples.size() - 1) * i / (num_instants - 1)].record;
    add_outline(
        drawing, [&](std::size_t body) { return record.bodies[body].X_WB; }, points);
  }
}

MeshData placed(MeshData mesh, const Pose& X) {
  for (Vec3& p : mesh.vertices) p = X.p + X.q * p;
  return mesh;
}

class PictureBuilder {
 public:
  PictureBuilder(const Recording& recording, const Drawing& drawing, const ViewSample& sample)
      : recording_(recording),
        scene_(recording.scene),
        drawing_(drawing),
        record_(sample.record),
        sample_(sample),
        driven_(driven_bodies(scene_)) {
    set_bounds(recording_, drawing_, picture_);
    max_force_ = scene_.device ? scene_.device->limits.force : LimitConfig{}.force;
  }

  Picture build() {
    for (const Solid& solid : drawing_.solids) add(solid);
    add_nets();
    for (const std::size_t body : driven_)
      if (is_shown(body)) add_device(body);
    for (std::size_t i = 0; i < sample_.num_touching; ++i)
      add_arrow("contact", sample_.touching[i].p_W, sample_.touching[i].F_W, contact_colour);
    return std::move(picture_);
  }

 private:
  /// True if the device is drawn at this body: at each driven body, or at the held one if the device grips
  /// bodies.
  bool is_shown(std::size_t body) const {
    return grips_bodies(scene_) ? record_.held == body : std::ranges::find(driven_, body) != driven_.end();
  }

  void add(const Solid& solid) {
    if (solid.role == SolidRole::contact) return;
    const Pose X = solid.body ? record_.bodies[*solid.body].X_WB * solid.X : solid.X;
    const Colour& colour = !solid.body ? obstacle_colour : is_shown(*solid.body) ? tool_colour : body_colour;
    picture_.meshes.push_back({.name = solid.name,
                               .mesh = placed(triangles_of(solid, drawing_, 2 * picture_.extent), X),
                               .colour = colour,
                               .has_edges = solid.kind == SolidKind::box});
  }

  void add_nets() {
    const SceneNets nets = scene_nets(scene_);
    const std::vector<Vec3> nodes = nodes_of(recording_, nets, sample_);
    for (const NetRange& net : nets.nets) {
      const auto first = nodes.begin() + static_cast<std::ptrdiff_t>(net.first_node);
      MeshData mesh{.vertices = {first, first + static_cast<std::ptrdiff_t>(net.num_nodes)},
                    .triangles = triangles_of(net)};
      const Colour& colour = net.carrier == world ? body_colour : tool_colour;
      picture_.meshes.push_back(
          {.name = net.name, .mesh = std::move(mesh), .colour = colour, .has_edges = false});
    }
  }

  void add_device(std::size_t body) {
    const BodyView& view = record_.bodies[body];
    // as in the page, nothing is drawn over a tool in the same place
    const double apart = (view.target.X_WD.p - view.X_WB.p).norm() / (0.02 * picture_.extent) +
                         between(view.target.X_WD, view.X_WB).rad / 0.1;
    PictureWires wires{.name = scene_.bodies[body].name + ", device",
                       .lines = {},
                       .colour = ghost_colour,
                       .opacity = std::min(1.0, apart)};
    for (const Solid& solid : drawing_.solids) {
      if (solid.body != body || solid.role == SolidRole::contact) continue;
      const Pose X = view.target.X_WD * solid.X;
      for (const auto& [a, b] : wires_of(solid, drawing_))
        wires.lines.push_back({X.p + X.q * a, X.p + X.q * b});
    }
    picture_.wires.push_back(std::move(wires));
    constexpr double shortest = 1e-9;
    const double load = std::min(1.0, view.coupling_B.f.norm() / max_force_);
    if ((view.target.X_WD.p - view.X_WB.p).norm() > shortest)
      picture_.meshes.push_back(
          {.name = "coupling",
           .mesh = rod(view.X_WB.p, view.target.X_WD.p, 0.006 * picture_.extent * (1 + load)),
           .colour = between(unloaded_colour, loaded_colour, load),
           .in_front = true});
    add_arrow("force to the hand", view.target.X_WD.p,
              grips_bodies(scene_) ? record_.hand_W.f : view.feedback_D.f, force_colour);
  }

  void add_arrow(const char* name, const Vec3& from, const Vec3& F, const Colour& colour) {
    const double length = std::min(0.4 * F.norm() / max_force_, 0.5) * picture_.extent;
    if (length < 0.004 * picture_.extent) return;
    picture_.meshes.push_back({.name = name,
                               .mesh = arrow(from, from + length * F.normalized(), 0.006 * picture_.extent),
                               .colour = colour,
                               .in_front = true});
  }

  const Recording& recording_;
  const SceneConfig& scene_;
  const Drawing& drawing_;
  const CycleRecord& record_;
  const ViewSample& sample_;
  std::vector<std::size_t> driven_;
  double max_force_ = 1;
  Picture picture_;
};

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

// ---- pictures -------------------------------------------------------------------------------------

Picture picture_of(const Recording& recording, const Drawing& drawing, const ViewSample& sample) {
  return PictureBuilder(recording, drawing, sample).build();
}

// ---- solids as triangles --------------------------------------------------------------------------

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
