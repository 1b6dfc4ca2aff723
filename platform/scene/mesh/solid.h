// A mesh with the data required by queries, in storage of its own.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/shape/mesh_setup.h"
#include "platform/scene/contact/config.h"

namespace godobject {

class MeshSolid {
 public:
  /// Returns null, and sets `why_not`, if the triangles are not a solid or too many.
  static std::unique_ptr<MeshSolid> make(const MeshData& data, std::string& why_not);

  const MeshData& data() const { return data_; }
  /// Valid during the life of this object.
  const TriangleMesh& mesh() const { return mesh_; }

 private:
  explicit MeshSolid(const MeshData& data);
  MeshReport set_up(double grid_spacing);
  MeshStorage storage();

  MeshData data_;
  std::vector<Vec3> face_normals_, vertex_normals_;
  std::vector<EdgeNormals> edge_normals_;
  std::vector<std::uint32_t> half_edges_, cell_start_, cell_triangles_;
  TriangleMesh mesh_;
};

}  // namespace godobject
