// glTF 2.0: a node for each item of the picture, in the world; all numbers in one buffer within the file.
#include <algorithm>
#include <bit>

#include <nlohmann/json.hpp>

#include "platform/view/picture/picture.h"

namespace godobject {
namespace {

using Json = nlohmann::ordered_json;

constexpr int triangles_mode = 4, lines_mode = 1, float_type = 5126, u32_type = 5125, vertex_target = 34962,
              index_target = 34963;

std::string base64_of(const std::vector<std::uint8_t>& bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8u | (k < left ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= left ? digits[word >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

class GltfBuilder {
 public:
  GltfBuilder() {
    json_ = {{"asset", {{"version", "2.0"}, {"generator", "godobject"}}}, {"scene", 0}};
    // Rotates z up (here) to y up (glTF).
    json_["nodes"] = Json::array({{{"name", "world"},
                                   {"rotation", {-0.7071067811865476, 0.0, 0.0, 0.7071067811865476}},
                                   {"children", Json::array()}}});
    json_["scenes"] = Json::array({{{"nodes", {0}}}});
    for (const char* list : {"meshes", "materials", "accessors", "bufferViews"}) json_[list] = Json::array();
  }

  void add(const std::string& name, const std::vector<Vec3>& vertices,
           const std::vector<std::uint32_t>& indices, int mode, const Colour& colour) {
    if (vertices.empty() || indices.empty()) return;
    const std::size_t positions = add_positions(vertices), order = add_indices(indices);
    json_["materials"].push_back(
        {{"pbrMetallicRoughness",
          {{"baseColorFactor", linear(colour)}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.7}}},
         {"doubleSided", true}});
    json_["meshes"].push_back({{"name", name},
                               {"primitives", Json::array({{{"attributes", {{"POSITION", positions}}},
                                                            {"indices", order},
                                                            {"mode", mode},
                                                            {"material", json_["materials"].size() - 1}}})}});
    json_["nodes"].push_back({{"name", name}, {"mesh", json_["meshes"].size() - 1}});
    json_["nodes"][0]["children"].push_back(json_["nodes"].size() - 1);
  }

  std::string take() {
    json_["buffers"] = Json::array({{{"byteLength", bytes_.size()},
                                     {"uri", "data:application/octet-stream;base64," + base64_of(bytes_)}}});
    return json_.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  }

 private:
  static Json linear(const Colour& colour) {
    Json factors = Json::array();
    for (const std::uint8_t channel : colour) factors.push_back(std::pow(channel / 255.0, 2.2));
    factors.push_back(1.0);
    return factors;
  }
  void put(std::uint32_t word) {
    for (unsigned shift = 0; shift < 32; shift += 8)
      bytes_.push_back(static_cast<std::uint8_t>(word >> shift & 0xFFu));
  }
  std::size_t add_view(std::size_t first, int target) {
    json_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", first}, {"byteLength", bytes_.size() - first}, {"target", target}});
    return json_["bufferViews"].size() - 1;
  }
  std::size_t add_positions(const std::vector<Vec3>& vertices) {
    const std::size_t first = bytes_.size();
    std::array<float, 3> low{}, high{};
    for (std::size_t i = 0; i < vertices.size(); ++i)
      for (Eigen::Index k = 0; k < 3; ++k) {
        const auto x = static_cast<float>(vertices[i][k]);
        float &l = low[static_cast<std::size_t>(k)], &h = high[static_cast<std::size_t>(k)];
        l = i == 0 ? x : std::min(l, x);
        h = i == 0 ? x : std::max(h, x);
        put(std::bit_cast<std::uint32_t>(x));
      }
    json_["accessors"].push_back({{"bufferView", add_view(first, vertex_target)},
                                  {"componentType", float_type},
                                  {"count", vertices.size()},
                                  {"type", "VEC3"},
                                  {"min", low},
                                  {"max", high}});
    return json_["accessors"].size() - 1;
  }
  std::size_t add_indices(const std::vector<std::uint32_t>& indices) {
    const std::size_t first = bytes_.size();
    for (const std::uint32_t index : indices) put(index);
    json_["accessors"].push_back({{"bufferView", add_view(first, index_target)},
                                  {"componentType", u32_type},
                                  {"count", indices.size()},
                                  {"type", "SCALAR"}});
    return json_["accessors"].size() - 1;
  }

  Json json_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

std::string gltf_of(const Picture& picture) {
  GltfBuilder builder;
  for (const PictureMesh& item : picture.meshes) {
    std::vector<std::uint32_t> indices;
    for (const TriangleIndices& t : item.mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
    builder.add(item.name, item.mesh.vertices, indices, triangles_mode, item.colour);
  }
  for (const PictureWires& wires : picture.wires) {
    std::vector<Vec3> vertices;
    std::vector<std::uint32_t> indices;
    for (const auto& ends : wires.lines)
      for (const Vec3& p : ends) {
        indices.push_back(static_cast<std::uint32_t>(vertices.size()));
        vertices.push_back(p);
      }
    builder.add(wires.name, vertices, indices, lines_mode, wires.colour);
  }
  return builder.take();
}

}  // namespace godobject
