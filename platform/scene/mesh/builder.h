// What the readers of mesh formats have in common: vertices and faces as they stand in a file become triangles, or an
// error that says where.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/contact/config.h"

namespace godobject {

/// What a mesh may have. Each triangle takes some 250 bytes in the core, and contacts are felt on far fewer.
inline constexpr std::size_t max_mesh_bytes = std::size_t{256} << 20;
inline constexpr std::size_t max_mesh_triangles = 2'000'000;

/// Every member function that returns a string returns an empty one, or what is wrong and what to do.
class MeshBuilder {
 public:
  /// places: what numbers of faces count in messages: "line" or "face".
  explicit MeshBuilder(const char* places) : places_(places) {}

  std::string add_vertex(const std::array<double, 3>& p);
  /// Vertices by their numbers in the order of add_vertex(), from 0; those that come later are allowed.
  std::string add_face(std::span<const std::int64_t> corners, std::size_t place);
  std::int64_t num_vertices() const { return static_cast<std::int64_t>(points_.size()); }

  /// Cuts faces into triangles and gives corners at one place one number. scale: m per unit of the file.
  std::string build(double scale, MeshData& to) const;

 private:
  /// STL and most PLY files hold single precision, and so do the corners that must meet.
  using Point = std::array<float, 3>;
  struct Face {
    std::uint32_t end;    // in corners_; it begins where the face before it ends
    std::uint32_t place;  // for messages
  };

  std::string in_face(const Face& face, const std::string& what) const;

  const char* places_;
  std::vector<Point> points_;
  std::vector<std::int64_t> corners_;  // of all faces
  std::vector<Face> faces_;
};

/// Readers of the text of a file; errors are lines or elements of it, without its name.
std::string read_stl(std::string_view file, MeshBuilder& mesh);
std::string read_obj(std::string_view file, MeshBuilder& mesh);
std::string read_ply(std::string_view file, MeshBuilder& mesh);

}  // namespace godobject
