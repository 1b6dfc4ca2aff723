#include "platform/scene/mesh/file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

#include "platform/scene/contact/params.h"
#include "platform/scene/text/csv.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

struct Format {
  std::string_view extension;
  const char* faces;  // name of a face in messages
  std::string (*read)(std::string_view file, MeshBuilder& mesh);
};
constexpr std::array formats{Format{".stl", "face", read_stl}, Format{".obj", "line", read_obj},
                             Format{".ply", "face", read_ply}};

const Format* format_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  const auto* const found = std::ranges::find(formats, extension, &Format::extension);
  return found == formats.end() ? nullptr : found;
}

constexpr std::size_t max_table_bytes = std::size_t{64} << 20;  // for heights or centres

/// Appends a line of numbers. Returns their count; none if one is invalid.
std::optional<std::uint32_t> read_row(std::string_view line, std::vector<Real>& numbers) {
  std::uint32_t count = 0;
  while (true) {
    while (line.starts_with(' ')) line.remove_prefix(1);
    double x = 0;
    const auto [end, problem] = std::from_chars(line.data(), line.data() + line.size(), x);
    if (problem != std::errc{} || !std::isfinite(x)) return std::nullopt;
    numbers.push_back(x);
    ++count;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    while (line.starts_with(' ') || line.starts_with('\r')) line.remove_prefix(1);
    if (line.empty()) return count;
    if (!line.starts_with(',')) return std::nullopt;
    line.remove_prefix(1);
  }
}

std::string load_mesh(const std::string& path, ObstacleConfig& obstacle) {
  std::string why_not = read_mesh(path, obstacle.scale.value_or(1), obstacle.mesh);
  if (!why_not.empty()) return why_not;
  std::string complaint;
  if (MeshSolid::make(obstacle.mesh, complaint)) return "";
  return "holds no solid: " + complaint;
}

constexpr std::size_t max_corners = 3 * max_mesh_triangles;
constexpr int max_apexes = 16;       // corners of a face to try, so that time stays linear in the file
constexpr double least_area = 1e-9;  // relative to the longest edge squared, as in core/shape/mesh_setup.h

using Polygon = std::vector<std::uint32_t>;

/// Returns twice the area vector of a polygon (Newell).
Vec3 area_2(const std::vector<Vec3>& vertices, const Polygon& polygon) {
  Vec3 sum = Vec3::Zero();
  const Vec3& o = vertices[polygon[0]];
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    sum += (vertices[polygon[i]] - o).cross(vertices[polygon[i + 1]] - o);
  return sum;
}

/// True if the triangle has an area and its normal points along n.
bool faces(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& n) {
  const Vec3 u = b - a, v = c - a;
  const double longest_sq = std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
  return u.cross(v).dot(n) > least_area * longest_sq;
}

/// Finds the corner from which triangles fan out over the polygon without a folded or degenerate one.
class Fan {
 public:
  Fan(const std::vector<Vec3>& vertices, const Polygon& polygon)
      : vertices_(vertices), polygon_(polygon), n_(area_2(vertices, polygon).normalized()) {}

  /// A convex polygon has many such corners; a polygon with a single dent has one at the dent.
  std::optional<std::size_t> apex() const {
    if (is_apex(0)) return 0;
    int tries = max_apexes;
    for (const bool dents : {true, false}) {
      for (std::size_t i = 0; i < polygon_.size(); ++i) {
        if (dents && faces(at(i + polygon_.size() - 1), at(i), at(i + 1), n_)) continue;
        if (tries-- == 0) return std::nullopt;
        if (is_apex(i)) return i;
      }
    }
    return std::nullopt;
  }

 private:
  const Vec3& at(std::size_t i) const { return vertices_[polygon_[i % polygon_.size()]]; }
  bool is_apex(std::size_t i) const {
    for (std::size_t k = 1; k + 1 < polygon_.size(); ++k)
      if (!faces(at(i), at(i + k), at(i + k + 1), n_)) return false;
    return true;
  }

  const std::vector<Vec3>& vertices_;
  const Polygon& polygon_;
  Vec3 n_;
};

/// Removes repeated corners: a quadrilateral with two equal corners is a triangle.
void remove_repeated(Polygon& polygon) {
  polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
  while (polygon.size() > 1 && polygon.front() == polygon.back()) polygon.pop_back();
}

/// Numbers positions in the order of their first use.
class Welder {
 public:
  Welder(double scale, MeshData& to) : scale_(scale), to_(to) {}

  std::uint32_t operator()(const std::array<float, 3>& p) {
    const auto next = static_cast<std::uint32_t>(to_.vertices.size());
    const auto [entry, is_new] = numbers_.try_emplace(p, next);
    if (is_new) {
      const auto in_m = [&](float x) { return scale_ * static_cast<double>(x); };
      to_.vertices.emplace_back(in_m(p[0]), in_m(p[1]), in_m(p[2]));
    }
    return entry->second;
  }

 private:
  double scale_;
  MeshData& to_;
  std::map<std::array<float, 3>, std::uint32_t> numbers_;
};

}  // namespace

// ---- meshes ---------------------------------------------------------------------------------------

std::string parse_mesh(std::string_view file, const std::string& path, double scale, MeshData& mesh) {
  mesh = {};
  const Format* const format = format_of(path);
  if (!format) return path + ": the name of a mesh file must end in .stl, .obj or .ply";
  MeshBuilder builder(format->faces);
  std::string wrong = format->read(file, builder);
  if (wrong.empty()) wrong = builder.build(scale, mesh);
  if (wrong.empty()) return "";
  mesh = {};
  return path + ": " + wrong;
}

std::string read_mesh(const std::string& path, double scale, MeshData& mesh) {
  if (!format_of(path)) return parse_mesh("", path, scale, mesh);
  const FileText file = read_file(path, max_mesh_bytes);
  return file.text ? parse_mesh(*file.text, path, scale, mesh) : path + ": " + file.why_not;
}

// ---- obstacles ------------------------------------------------------------------------------------

std::string read_heights(const std::string& path, HeightGrid& grid) {
  const FileText file = read_file(path, max_table_bytes);
  if (!file.text) return path + ": " + file.why_not;
  grid = {};
  std::string_view rest = *file.text;
  for (std::uint32_t line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view row = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (row.find_first_not_of(" \r") == std::string_view::npos) continue;
    const std::optional<std::uint32_t> columns = read_row(row, grid.height);
    const std::string where = path + ", line " + std::to_string(line) + ": ";
    if (!columns) return where + "must be numbers (m) between commas";
    if (grid.columns == 0) grid.columns = *columns;
    if (*columns != grid.columns)
      return where + "has " + std::to_string(*columns) + " numbers, the lines before " +
             std::to_string(grid.columns);
    ++grid.rows;
  }
  if (grid.rows < 2 || grid.columns < 2) return path + ": a height field has at least 2 rows of 2 numbers";
  return "";
}

std::string read_centres(const std::string& path, std::vector<Vec3>& centres) {
  const CsvResult read = read_csv(path, {}, max_table_bytes);
  if (!read.table) return read.errors.front();
  std::array<std::size_t, 3> columns{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name(1, static_cast<char>('x' + i));
    const std::optional<std::size_t> found = read.table->find(name);
    if (!found) return path + ": has no column '" + name + "': the centres of spheres are x, y, z (m)";
    columns[i] = *found;
  }
  centres.clear();
  for (std::size_t row = 0; row < read.table->num_rows(); ++row)
    centres.emplace_back(read.table->at(row, columns[0]), read.table->at(row, columns[1]),
                         read.table->at(row, columns[2]));
  return centres.empty() ? path + ": has no rows: add a row for each sphere" : "";
}

std::string load_file(const std::string& path, ObstacleConfig& obstacle) {
  switch (obstacle.shape.kind) {
    case ShapeKind::mesh: return load_mesh(path, obstacle);
    case ShapeKind::height_field: return read_heights(path, obstacle.heights);
    case ShapeKind::sphere: return read_centres(path, obstacle.centres);
    default: return "has no meaning for an obstacle of this kind";
  }
}

// ---- triangles from vertices and faces ------------------------------------------------------------

std::string MeshBuilder::add_vertex(const std::array<double, 3>& p) {
  if (points_.size() == max_corners) return "more than " + std::to_string(max_corners) + " vertices";
  Point point;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(std::abs(p[i]) <= static_cast<double>(std::numeric_limits<float>::max())))
      return "a coordinate is not a finite number in single precision";
    point[i] = static_cast<float>(p[i]);
  }
  points_.push_back(point);
  return "";
}

std::string MeshBuilder::add_face(std::span<const std::int64_t> corners, std::size_t place) {
  if (corners_.size() + corners.size() > max_corners)
    return "the faces have more than " + std::to_string(max_corners) +
           " corners in all: simplify the mesh with a mesh editor";
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  faces_.push_back({static_cast<std::uint32_t>(corners_.size()), static_cast<std::uint32_t>(place)});
  return "";
}

std::string MeshBuilder::in_face(const Face& face, const std::string& what) const {
  return std::string(places_) + " " + std::to_string(face.place) + ": " + what;
}

std::string MeshBuilder::build(double scale, MeshData& to) const {
  to = {};
  Welder weld(scale, to);
  constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> welded(points_.size(), unused);
  Polygon polygon;
  std::size_t begin = 0;
  for (const Face& face : faces_) {
    polygon.clear();
    for (; begin < face.end; ++begin) {
      const std::int64_t v = corners_[begin];
      if (v < 0 || v >= num_vertices())
        return in_face(face, "there is no vertex " + std::to_string(v) + " (counted from 0): the file has " +
                                 std::to_string(points_.size()));
      std::uint32_t& number = welded[static_cast<std::size_t>(v)];
      if (number == unused) number = weld(points_[static_cast<std::size_t>(v)]);
      polygon.push_back(number);
    }
    remove_repeated(polygon);
    if (polygon.size() < 3) continue;  // a point or a line; its neighbours meet there
    std::size_t apex = 0;
    if (polygon.size() > 3) {
      const std::optional<std::size_t> found = Fan(to.vertices, polygon).apex();
      if (!found)
        return in_face(face, "a face of " + std::to_string(polygon.size()) +
                                 " corners is not flat, or not star-shaped from any corner: cut it into "
                                 "triangles with a mesh editor");
      apex = *found;
    }
    if (to.triangles.size() + polygon.size() - 2 > max_mesh_triangles)
      return "more than " + std::to_string(max_mesh_triangles) +
             " triangles: simplify the mesh with a mesh editor";
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
      const auto at = [&](std::size_t i) { return polygon[(apex + i) % polygon.size()]; };
      to.triangles.push_back({at(0), at(k), at(k + 1)});
    }
  }
  return to.triangles.empty() ? "has no triangles: export the mesh as triangles" : "";
}

}  // namespace godobject
