#include "platform/scene/mesh/obstacle_file.h"

#include <array>
#include <charconv>
#include <cmath>

#include "platform/scene/mesh/file.h"
#include "platform/scene/mesh/solid.h"
#include "platform/scene/text/csv.h"

namespace godobject {
namespace {

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

}  // namespace

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

}  // namespace godobject
