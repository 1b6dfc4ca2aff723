#include "platform/scene/mesh/file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "platform/scene/mesh/builder.h"
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

}  // namespace

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

}  // namespace godobject
