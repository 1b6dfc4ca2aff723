// A mesh with all the arrays that the caller of set_up_mesh() owns, for tests.
#pragma once

#include <vector>

#include "core/shape/mesh_setup.h"

namespace godobject {

/// Vertices and triangles of a mesh, and the arrays of its set-up, which refers to them.
struct MeshArrays {
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;
  std::vector<Vec3> face_normals{}, vertex_normals{};
  std::vector<EdgeNormals> edge_normals{};
  std::vector<std::uint32_t> half_edges{}, cell_start{}, cell_triangles{};
  TriangleMesh mesh{};

  MeshStorage storage() {
    return {face_normals, edge_normals, vertex_normals, half_edges, cell_start, cell_triangles};
  }
  MeshReport set_up(Real spacing, std::size_t cells = 20000, std::size_t entries = 200000) {
    face_normals.resize(triangles.size());
    edge_normals.resize(triangles.size());
    vertex_normals.resize(vertices.size());
    half_edges.resize(3 * triangles.size());
    cell_start.resize(cells + 1);
    cell_triangles.resize(entries);
    return set_up_mesh(vertices, triangles, spacing, storage(), mesh);
  }
};

}  // namespace godobject
