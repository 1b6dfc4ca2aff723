// Common part of the readers of mesh formats: converts vertices and faces of a file into triangles, or
// returns an error with its place.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/contact/config.h"

namespace godobject {

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
