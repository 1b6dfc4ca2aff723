// Mesh files of every format: random bytes, or a cube with some bytes changed. A mesh that is read refers
// only to existing vertices, and is passed to the checks of solids.
#include <cstdlib>

#include "platform/scene/contact/params.h"
#include "platform/scene/mesh/file.h"
#include "tests/fuzz/decode.h"
#include "tests/support/mesh_files.h"

namespace {

using namespace godobject;

std::string any_bytes(fuzz::Input& in) {
  const auto bytes = in.bytes(4096);
  return {bytes.begin(), bytes.end()};
}

std::string edited(std::string file, fuzz::Input& in) {
  while (!in.empty()) {
    const std::size_t at = (std::size_t{in.byte()} << 8 | in.byte()) % file.size();
    const std::size_t cut = in.byte() % 8;
    const auto put = in.bytes(in.byte() % 16);
    file.replace(at, cut, std::string(put.begin(), put.end()));
    if (file.empty()) break;
  }
  return file;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<MeshFileText> cubes = cubes_in_every_format();
  fuzz::Input in(data, size);
  const std::uint8_t what = in.byte();
  const MeshFileText& cube = cubes[what % cubes.size()];
  const std::string file = what < 128 ? any_bytes(in) : edited(cube.bytes, in);
  MeshData mesh;
  if (!parse_mesh(file, std::string("fuzz") + cube.extension, 1, mesh).empty()) return 0;
  if (mesh.triangles.empty()) std::abort();
  for (const TriangleIndices& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle)
      if (vertex >= mesh.vertices.size()) std::abort();
  std::string why_not;
  static_cast<void>(MeshSolid::make(mesh, why_not));
  return 0;
}
