#include "platform/scene/contact/params.h"

#include <algorithm>
#include <cmath>

namespace godobject {
namespace {

constexpr std::size_t max_cells = std::size_t{1} << 22;  // 16 MB
// Limits of the cells in the boxes of all triangles, for some tenths of a second and the memory of the grid's
// cells.
constexpr double max_entries = 1 << 24, max_entries_per_triangle = 64;

/// Returns the mean edge, which makes the grid's cells about as large as the triangles: few triangles per
/// cell, few cells per query.
double mean_edge(const MeshData& data) {
  double sum = 0;
  for (const TriangleIndices& t : data.triangles)
    for (std::size_t k = 0; k < 3; ++k) sum += (data.vertices[t[(k + 1) % 3]] - data.vertices[t[k]]).norm();
  return sum / (3 * static_cast<double>(data.triangles.size()));
}

/// Returns the number of grid cells of this spacing in a box with these edges, including cut ones.
double cells_in(const Vec3& edges, double spacing) { return (edges.array() / spacing + 1).prod(); }

/// Returns the smallest spacing, doubled from `spacing`, that bounds the size of the grid and the time to
/// fill it. Without the bound, a few large triangles among many small ones would lie in millions of cells
/// each.
double bounded_spacing(const MeshData& data, double spacing) {
  Vec3 low = data.vertices.front(), high = low;
  for (const Vec3& p : data.vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  while (cells_in(high - low, spacing) > 2.0 * max_cells) spacing *= 2;
  const auto entries = [&] {
    double sum = 0;
    for (const TriangleIndices& t : data.triangles) {
      const Vec3 &a = data.vertices[t[0]], &b = data.vertices[t[1]], &c = data.vertices[t[2]];
      sum += cells_in(a.cwiseMax(b).cwiseMax(c) - a.cwiseMin(b).cwiseMin(c), spacing);
    }
    return sum;
  };
  const double most = max_entries + max_entries_per_triangle * static_cast<double>(data.triangles.size());
  while (entries() > most) spacing *= 2;
  return spacing;
}

std::string place(const MeshData& data, std::size_t triangle) {
  const Vec3 p = data.vertices[data.triangles[triangle][0]];
  return " (triangle " + std::to_string(triangle) + " at " + std::to_string(p.x()) + ", " +
         std::to_string(p.y()) + ", " + std::to_string(p.z()) + " m)";
}

std::string complaint(const MeshReport& report, const MeshData& data) {
  switch (report.invalid) {
    case MeshInvalid::no_triangle: return "there is no triangle";
    case MeshInvalid::vertex_not_finite: return "a vertex is not finite";
    case MeshInvalid::degenerate_triangle:
      return "a triangle has no area" + place(data, report.number) + ": remove it with a mesh editor";
    case MeshInvalid::not_closed:
      return "the surface is not closed, or triangles at an edge run in different directions" +
             place(data, report.number) + ": close its holes with a mesh editor";
    case MeshInvalid::folded:
      return "two triangles coincide" + place(data, report.number) +
             ": remove one of them with a mesh editor";
    case MeshInvalid::inside_out:
      return "its triangles face inwards: reverse their corners with a mesh editor";
    default: return "its grid does not fit (rule " + std::to_string(static_cast<int>(report.invalid)) + ")";
  }
}

/// Builds the contacts part by part.
class ContactBuilder {
 public:
  explicit ContactBuilder(const SceneConfig& scene) {
    for (const MaterialUse& use : materials_of(scene)) to_.materials.push_back(use.material);
    for (const ContactConfig& contact : scene.contacts) add(contact);
    for (const ObstacleConfig& obstacle : scene.obstacles) add(obstacle);
    for (std::size_t i = 0; i < scene.world_planes; ++i) add_world_plane(i);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) add(scene.bodies[i], i);
  }
  SceneContacts take() { return std::move(to_); }

 private:
  MaterialId id_of(const std::string& material) const {
    return static_cast<MaterialId>(std::ranges::find(to_.materials, material) - to_.materials.begin());
  }

  void add(const ContactConfig& contact) {
    const MaterialId a = id_of(contact.materials[0]), b = id_of(contact.materials[1]);
    if (std::max(a, b) >= to_.materials.size()) return;  // unused material
    to_.laws[a][b] = to_.laws[b][a] = contact.law;
  }

  void add(const ObstacleConfig& obstacle) {
    ShapeParams shape = shape_params(obstacle.shape);
    if (shape.kind == ShapeKind::mesh) shape.mesh = mesh_of(obstacle);
    if (shape.kind == ShapeKind::height_field) shape.height_field = height_field_of(obstacle);
    for (std::size_t i = 0; i < num_solids(obstacle); ++i) {
      if (!obstacle.centres.empty())
        shape.X_WS.p = obstacle.shape.X.p + obstacle.shape.X.q * obstacle.centres[i];
      to_.surfaces.push_back({.body = world, .shape = shape, .material = id_of(obstacle.shape.material)});
      to_.surface_names.push_back("obstacle '" + obstacle.name + "'");
    }
  }

  /// Adds a plane of another simulation, out of reach and with a material of its own.
  void add_world_plane(std::size_t i) {
    to_.surfaces.push_back({.body = world,
                            .shape = {.kind = ShapeKind::plane, .X_WS = {.p = parked_plane}},
                            .material = static_cast<MaterialId>(to_.materials.size())});
    to_.surface_names.push_back("plane " + std::to_string(i) + " of the world");
    to_.materials.push_back(to_.surface_names.back());
  }

  void add(const BodyConfig& body, std::size_t index) {
    for (const SphereConfig& row : body.spheres)
      for (int i = 0; i < row.count; ++i)
        to_.spheres.push_back({.body = index,
                               .p_B = row.p_B + i * row.spacing,
                               .radius = row.radius,
                               .material = id_of(row.material)});
    for (const ShapeConfig& shape : body.shapes) {
      to_.surfaces.push_back(
          {.body = index, .shape = shape_params(shape), .material = id_of(shape.material)});
      to_.surface_names.push_back("shape of body '" + body.name + "'");
    }
  }

  const TriangleMesh* mesh_of(const ObstacleConfig& obstacle) {
    std::string why_not;
    to_.meshes.push_back(MeshSolid::make(obstacle.mesh, why_not));
    return to_.meshes.back() ? &to_.meshes.back()->mesh() : nullptr;  // null is rejected by the core
  }

  const HeightField* height_field_of(const ObstacleConfig& obstacle) {
    to_.heights.push_back(obstacle.heights.height);
    to_.height_fields.push_back({.height = to_.heights.back(),
                                 .columns = obstacle.heights.columns,
                                 .rows = obstacle.heights.rows,
                                 .spacing = obstacle.spacing.value_or(0)});
    return &to_.height_fields.back();
  }

  SceneContacts to_;
};

}  // namespace

// ---- meshes ---------------------------------------------------------------------------------------

MeshSolid::MeshSolid(const MeshData& data) : data_(data) {
  face_normals_.resize(data.triangles.size());
  vertex_normals_.resize(data.vertices.size());
  edge_normals_.resize(data.triangles.size());
  half_edges_.resize(3 * data.triangles.size());
  cell_start_.resize(2);
}

MeshStorage MeshSolid::storage() {
  return {.face_normals = face_normals_,
          .edge_normals = edge_normals_,
          .vertex_normals = vertex_normals_,
          .half_edges = half_edges_,
          .cell_start = cell_start_,
          .cell_triangles = cell_triangles_};
}

/// Grows the storage by the amounts that the core reports as missing.
MeshReport MeshSolid::set_up(double grid_spacing) {
  while (true) {
    const MeshReport report = set_up_mesh(data_.vertices, data_.triangles, grid_spacing, storage(), mesh_);
    if (report.invalid == MeshInvalid::cells_full && report.number > max_cells) {
      grid_spacing *= 2;
    } else if (report.invalid == MeshInvalid::cells_full) {
      cell_start_.resize(report.number + 1);
    } else if (report.invalid == MeshInvalid::cell_triangles_full) {
      cell_triangles_.resize(report.number);
    } else {
      return report;
    }
  }
}

std::unique_ptr<MeshSolid> MeshSolid::make(const MeshData& data, std::string& why_not) {
  std::unique_ptr<MeshSolid> solid(new MeshSolid(data));
  const double spacing = mean_edge(data);
  const bool is_usable = std::isfinite(spacing) && spacing > 0;  // otherwise the core reports the error
  const MeshReport report = solid->set_up(is_usable ? bounded_spacing(data, spacing) : spacing);
  if (report.invalid == MeshInvalid::nothing) return solid;
  why_not = complaint(report, data);
  return nullptr;
}

// ---- contacts -------------------------------------------------------------------------------------

ShapeParams shape_params(const ShapeConfig& shape) {
  return {.kind = shape.kind,
          .X_WS = shape.X,
          .half_extents = shape.half_extents.value_or(Vec3::Zero()),
          .radius = shape.radius.value_or(0),
          .half_length = shape.half_length.value_or(0)};
}

std::size_t num_solids(const ObstacleConfig& obstacle) {
  return obstacle.centres.empty() ? 1 : obstacle.centres.size();
}

SceneContacts scene_contacts(const SceneConfig& scene) { return ContactBuilder(scene).take(); }

ContactCounts contact_counts(const SceneConfig& scene) {
  ContactCounts counts{.surfaces = scene.world_planes};
  for (const ObstacleConfig& obstacle : scene.obstacles) counts.surfaces += num_solids(obstacle);
  for (const BodyConfig& body : scene.bodies) {
    counts.surfaces += body.shapes.size();
    for (const SphereConfig& row : body.spheres) counts.spheres += static_cast<std::size_t>(row.count);
  }
  return counts;
}

}  // namespace godobject
