#include "sim/mesh_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string_view>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

namespace godobject {
namespace {

constexpr std::array<std::string_view, 3> extensions{".stl", ".obj", ".ply"};

/// Gives corners at one place one number. An STL file repeats every corner for each of its triangles.
class Welder {
 public:
  explicit Welder(double scale) : scale_(scale) {}

  void add(const aiMesh& mesh, MeshData& to) {
    for (const aiFace& face : std::span(mesh.mFaces, mesh.mNumFaces)) {
      if (face.mNumIndices != 3) continue;  // a point or a line
      TriangleIndices t;
      for (std::size_t k = 0; k < 3; ++k) t[k] = vertex(mesh.mVertices[face.mIndices[k]], to);
      const bool has_area = t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
      if (has_area) to.triangles.push_back(t);  // without one, its neighbours meet where it was
    }
  }

 private:
  std::uint32_t vertex(const aiVector3D& p, MeshData& to) {
    const auto next = static_cast<std::uint32_t>(to.vertices.size());
    const auto [entry, is_new] = numbers_.try_emplace({p.x, p.y, p.z}, next);
    if (is_new)
      to.vertices.emplace_back(scale_ * static_cast<double>(p.x), scale_ * static_cast<double>(p.y),
                               scale_ * static_cast<double>(p.z));
    return entry->second;
  }

  double scale_;
  std::map<std::array<ai_real, 3>, std::uint32_t> numbers_;
};

bool is_known(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::find(extensions, extension) != extensions.end();
}

}  // namespace

std::string read_mesh(const std::string& path, double scale, MeshData& mesh) {
  mesh = {};
  if (!is_known(path)) return path + ": a mesh is read from a file that ends in .stl, .obj or .ply";
  if (!std::filesystem::is_regular_file(path))
    return "cannot be read: is " + path + " the right path? Paths are relative to the scene file";
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate | aiProcess_PreTransformVertices);
  if (!scene) return path + ": " + importer.GetErrorString();
  Welder welder(scale);
  for (const aiMesh* part : std::span(scene->mMeshes, scene->mNumMeshes)) welder.add(*part, mesh);
  return mesh.triangles.empty() ? path + ": has no triangles" : "";
}

}  // namespace godobject
