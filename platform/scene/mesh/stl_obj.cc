// STL, text and binary: triangles with three corners each.
// OBJ: vertices and faces. Other statements do not affect the solid and are skipped; referenced files, such
// as materials, are not opened.
#include <bit>
#include <cstring>

#include "platform/scene/mesh/file.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

constexpr std::size_t header_bytes = 84, triangle_bytes = 50, normal_bytes = 12;

/// Reads a little-endian value, as on the supported processors.
template <class T>
T value_at(std::string_view file, std::size_t at) {
  static_assert(std::endian::native == std::endian::little);
  T value;
  std::memcpy(&value, file.data() + at, sizeof value);
  return value;
}

std::string add_triangle(MeshBuilder& mesh, std::size_t place) {
  const std::int64_t end = mesh.num_vertices();
  return mesh.add_face(std::array{end - 3, end - 2, end - 1}, place);
}

std::size_t bytes_of_triangles(std::string_view file) {
  return header_bytes + triangle_bytes * value_at<std::uint32_t>(file, header_bytes - 4);
}

std::array<double, 3> point_at(std::string_view file, std::size_t at) {
  std::array<double, 3> p{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    p[axis] = static_cast<double>(value_at<float>(file, at + axis * sizeof(float)));
  return p;
}

std::string read_binary(std::string_view file, MeshBuilder& mesh) {
  std::size_t number = 0;
  for (std::size_t at = header_bytes; at < file.size(); at += triangle_bytes, ++number) {
    std::string wrong;
    for (std::size_t corner = 1; corner <= 3 && wrong.empty(); ++corner)
      wrong = mesh.add_vertex(point_at(file, at + normal_bytes * corner));
    if (wrong.empty()) wrong = add_triangle(mesh, number);
    if (!wrong.empty()) return "face " + std::to_string(number) + ": " + wrong;
  }
  return "";
}

bool is(std::string_view word, std::string_view lower_case) {
  return std::ranges::equal(word, lower_case, {}, [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
}

class TextReader {
 public:
  TextReader(std::string_view file, MeshBuilder& mesh) : text_(file), mesh_(mesh) {}

  std::string read() {
    std::string wrong;
    for (std::string_view word = text_.word(); !word.empty() && wrong.empty(); word = text_.word()) {
      wrong = item(word);
      if (!wrong.empty()) return "line " + std::to_string(text_.line()) + ": " + wrong;
    }
    return corners_ == 0 ? "" : "ends within a facet: export it again";
  }

 private:
  std::string item(std::string_view word) {
    if (is(word, "solid") || is(word, "endsolid")) {
      name_ = text_.rest_of_line();
    } else if (is(word, "normal")) {
      for (int i = 0; i < 3; ++i) text_.word();  // skip the normal, which follows from the corners
    } else if (is(word, "vertex")) {
      return vertex();
    } else if (is(word, "endfacet")) {
      if (corners_ != 3) return "a facet has " + std::to_string(corners_) + " vertices, not 3";
      corners_ = 0;
      return add_triangle(mesh_, text_.line());
    } else if (!is(word, "facet") && !is(word, "outer") && !is(word, "loop") && !is(word, "endloop")) {
      return excerpt(word) + " is not a word of an STL file";
    }
    return "";
  }

  std::string vertex() {
    std::array<double, 3> p{};
    for (double& x : p) {
      const std::string_view word = text_.word();
      if (word.empty()) return "ends within a facet: export it again";
      const std::optional<double> read = number_of<double>(word);
      if (!read) return excerpt(word) + " is not a number";
      x = *read;
    }
    ++corners_;
    return mesh_.add_vertex(p);
  }

  TextScanner text_;
  MeshBuilder& mesh_;
  std::string_view name_;
  int corners_ = 0;
};

std::string read_vertex(std::string_view line, MeshBuilder& mesh) {
  std::array<double, 3> p{};
  for (double& x : p) {
    const std::string_view word = TextScanner::first_word(line);
    const std::optional<double> read = number_of<double>(word);
    if (!read) return excerpt(word) + " is not a number";
    x = *read;
  }
  return mesh.add_vertex(p);
}

/// Parses "7", "7/1", "7//2" or "7/1/2": the first number counts vertices from 1, or backwards from the last
/// with -1.
std::optional<std::int64_t> corner_of(std::string_view word, std::int64_t num_vertices) {
  const auto number = number_of<std::int64_t>(word.substr(0, word.find('/')));
  if (!number || *number == 0 || *number < -num_vertices) return std::nullopt;
  return *number > 0 ? *number - 1 : num_vertices + *number;
}

std::string read_face(std::string_view line, std::size_t number, MeshBuilder& mesh) {
  std::vector<std::int64_t> corners;
  for (std::string_view word = TextScanner::first_word(line); !word.empty();
       word = TextScanner::first_word(line)) {
    if (word.ends_with('\\')) word.remove_suffix(1);  // the line continues
    if (word.empty()) continue;
    const std::optional<std::int64_t> corner = corner_of(word, mesh.num_vertices());
    if (!corner) return excerpt(word) + " is not a vertex number: count from 1, or from -1 backwards";
    corners.push_back(*corner);
  }
  return mesh.add_face(corners, number);
}

}  // namespace

// ---- STL ------------------------------------------------------------------------------------------

std::string read_stl(std::string_view file, MeshBuilder& mesh) {
  const bool has_header = file.size() >= header_bytes;
  if (has_header && file.size() == bytes_of_triangles(file)) return read_binary(file, mesh);
  if (is(file.substr(0, 5), "solid")) return TextReader(file, mesh).read();
  return "neither begins with \"solid\" nor has the size of a binary STL file: export it again";
}

// ---- OBJ ------------------------------------------------------------------------------------------

std::string read_obj(std::string_view file, MeshBuilder& mesh) {
  TextScanner text(file);
  while (!text.rest().empty()) {
    const std::size_t number = text.line();
    std::string_view line = text.rest_of_joined_line();
    const std::string_view kind = TextScanner::first_word(line);
    std::string wrong;
    if (kind == "v") wrong = read_vertex(line, mesh);
    if (kind == "f") wrong = read_face(line, number, mesh);
    if (!wrong.empty()) return "line " + std::to_string(number) + ": " + wrong;
  }
  return "";
}

}  // namespace godobject
