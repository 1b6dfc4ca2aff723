// Files of obstacles and nets: triangle meshes from STL, OBJ and PLY, heights, and centres of spheres.
// Their readers share a scanner of words and a builder of triangles.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/geometry.h"

namespace godobject {

/// Reads all triangles of the file, polygons cut into triangles and equal corners merged. Returns why it
/// cannot be read, with the remedy; empty on success. Memory is bounded and time linear in the size of any
/// file.
/// scale: m per unit of the file.
std::string read_mesh(const std::string& path, double scale, MeshData& mesh);
/// Parses the bytes of a file as read_mesh() does.
/// path: selects the format, and is the name in messages.
std::string parse_mesh(std::string_view file, const std::string& path, double scale, MeshData& mesh);

/// Reads the file of an obstacle by obstacle.shape.kind. Returns why this failed, with the remedy; empty on
/// success.
std::string load_file(const std::string& path, ObstacleConfig& obstacle);

/// Reads rows of comma-separated heights, m, without a header; the first row is at y = 0.
std::string read_heights(const std::string& path, HeightGrid& grid);

/// Reads a CSV with columns x, y, z, m.
std::string read_centres(const std::string& path, std::vector<Vec3>& centres);

// Common part of the readers of mesh formats. Errors name their place.

/// Reads the words of a text one by one, with their lines. Safe for untrusted files.
class TextScanner {
 public:
  explicit TextScanner(std::string_view text) : rest_(text) {}

  /// Returns the next word, on this line or a later one; empty at the end of the text.
  std::string_view word() {
    while (!rest_.empty() && is_space(rest_.front())) {
      line_ += rest_.front() == '\n';
      rest_.remove_prefix(1);
    }
    return take(rest_, word_length(rest_));
  }
  /// Returns the rest of this line without its end.
  std::string_view rest_of_line() {
    const std::string_view line = take(rest_, std::min(rest_.find('\n'), rest_.size()));
    if (rest_.empty()) return line;
    rest_.remove_prefix(1);
    ++line_;
    return line;
  }
  /// As rest_of_line(), joined with the next line after a backslash at its end.
  std::string_view rest_of_joined_line() {
    std::string_view line = rest_of_line();
    while (!rest_.empty() && (line.ends_with('\\') || line.ends_with("\\\r"))) {
      const char* const begin = line.data();
      const std::string_view next = rest_of_line();
      line = {begin, static_cast<std::size_t>(next.data() + next.size() - begin)};
    }
    return line;
  }
  std::string_view rest() const { return rest_; }
  /// Returns the line of the latest word, counted from 1.
  std::size_t line() const { return line_; }

  /// Returns the first word of a line, and removes it from the line.
  static std::string_view first_word(std::string_view& line) {
    line.remove_prefix(static_cast<std::size_t>(std::ranges::find_if_not(line, is_space) - line.begin()));
    return take(line, word_length(line));
  }

 private:
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  static std::size_t word_length(std::string_view text) {
    return static_cast<std::size_t>(std::ranges::find_if(text, is_space) - text.begin());
  }
  static std::string_view take(std::string_view& text, std::size_t length) {
    const std::string_view taken = text.substr(0, length);
    text.remove_prefix(length);
    return taken;
  }

  std::string_view rest_;
  std::size_t line_ = 1;
};

/// Parses the whole word as a number.
template <class T>
std::optional<T> number_of(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  T value{};
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (problem != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// Limits of a mesh. Each triangle takes some 250 bytes in the core, and contacts need far fewer.
inline constexpr std::size_t max_mesh_bytes = std::size_t{256} << 20;
inline constexpr std::size_t max_mesh_triangles = 2'000'000;

/// Builds a mesh. Every member function that returns a string returns an empty one, or an error with its
/// remedy.
class MeshBuilder {
 public:
  /// places: name of the numbers of faces in messages: "line" or "face".
  explicit MeshBuilder(const char* places) : places_(places) {}

  std::string add_vertex(const std::array<double, 3>& p);
  /// Adds a face by the numbers of its vertices, from 0 in the order of add_vertex(); later vertices are
  /// allowed.
  std::string add_face(std::span<const std::int64_t> corners, std::size_t place);
  std::int64_t num_vertices() const { return static_cast<std::int64_t>(points_.size()); }

  /// Cuts faces into triangles and merges corners at one place.
  /// scale: m per unit of the file.
  std::string build(double scale, MeshData& to) const;

 private:
  /// Single precision, as in STL and most PLY files, so that equal corners meet.
  using Point = std::array<float, 3>;
  struct Face {
    std::uint32_t end;    // in corners_; the face starts at the end of the previous one
    std::uint32_t place;  // number in messages
  };

  std::string in_face(const Face& face, const std::string& what) const;

  const char* places_;
  std::vector<Point> points_;
  std::vector<std::int64_t> corners_;  // corners of all faces
  std::vector<Face> faces_;
};

/// Readers of the text of a file. Errors name lines or elements, without the file's name.
std::string read_stl(std::string_view file, MeshBuilder& mesh);
std::string read_obj(std::string_view file, MeshBuilder& mesh);
std::string read_ply(std::string_view file, MeshBuilder& mesh);

}  // namespace godobject
