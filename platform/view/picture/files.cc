// Files of a picture: PNG of 8-bit RGB, still or animated (APNG), and glTF 2.0. A glTF file has a node for
// each item of the picture, in the world; all numbers are in one buffer within the file.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string_view>

#include <nlohmann/json.hpp>

#include "hal/base/crc32.h"
#include "platform/view/picture/picture.h"

namespace godobject {
namespace {

void put_u32(std::string& to, std::uint32_t value) {
  for (unsigned shift = 32; shift > 0; shift -= 8) to += static_cast<char>(value >> (shift - 8) & 0xFFu);
}

void put_chunk(std::string& to, std::string_view type, std::string_view data) {
  put_u32(to, static_cast<std::uint32_t>(data.size()));
  std::string body(type);
  body += data;
  to += body;
  put_u32(to, crc32(body));
}

/// Deflate with the fixed codes. Its only matches are runs of one byte, which occur in flat areas.
class Deflate {
 public:
  explicit Deflate(std::string& to) : to_(to) {
    put(1, 1);  // the last block
    put(1, 2);  // with fixed codes
  }
  void run(std::uint8_t byte, std::size_t length) {
    constexpr std::size_t longest = 258, shortest = 3;
    literal(byte);
    for (--length; length >= shortest;) {
      const std::size_t now = std::min(length, longest);
      match(static_cast<unsigned>(now));
      length -= now;
    }
    for (; length > 0; --length) literal(byte);
  }
  void end() {
    symbol(256);
    if (num_bits_ > 0) to_ += static_cast<char>(bits_);
  }

 private:
  /// Writes bits, least significant bit first.
  void put(std::uint32_t value, unsigned bits) {
    bits_ |= value << num_bits_;
    for (num_bits_ += bits; num_bits_ >= 8; num_bits_ -= 8, bits_ >>= 8u)
      to_ += static_cast<char>(bits_ & 0xFFu);
  }
  /// Writes a Huffman code, most significant bit first.
  void code(std::uint32_t value, unsigned bits) {
    std::uint32_t reversed = 0;
    for (unsigned i = 0; i < bits; ++i) reversed |= (value >> i & 1u) << (bits - 1 - i);
    put(reversed, bits);
  }
  void symbol(unsigned s) {
    if (s < 144) code(0x30 + s, 8);
    else if (s < 256) code(0x190 + s - 144, 9);
    else if (s < 280) code(s - 256, 7);
    else code(0xC0 + s - 280, 8);
  }
  void literal(std::uint8_t byte) { symbol(byte); }
  /// Writes `length` bytes, 3 to 258, equal to the previous byte.
  void match(unsigned length) {
    static constexpr std::array<unsigned, 29> base{3,  4,  5,  6,   7,   8,   9,   10,  11, 13,
                                                   15, 17, 19, 23,  27,  31,  35,  43,  51, 59,
                                                   67, 83, 99, 115, 131, 163, 195, 227, 258};
    static constexpr std::array<unsigned, 29> extra{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                                    2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
    std::size_t i = base.size() - 1;
    while (base[i] > length) --i;
    symbol(static_cast<unsigned>(257 + i));
    put(length - base[i], extra[i]);
    code(0, 5);  // a distance of 1
  }

  std::string& to_;
  std::uint32_t bits_ = 0;
  unsigned num_bits_ = 0;
};

std::string zlib_of(const std::vector<std::uint8_t>& bytes) {
  std::string to("\x78\x01", 2);
  Deflate deflate(to);
  std::uint32_t a = 1, b = 0;  // Adler-32
  for (std::size_t i = 0; i < bytes.size();) {
    std::size_t end = i + 1;
    while (end < bytes.size() && bytes[end] == bytes[i]) ++end;
    deflate.run(bytes[i], end - i);
    for (; i < end; ++i) {
      a = (a + bytes[i]) % 65521;
      b = (b + a) % 65521;
    }
  }
  deflate.end();
  put_u32(to, b << 16u | a);
  return to;
}

/// Encodes each row as its difference to the row above, which is zero in flat areas.
std::string rows_of(const Image& image) {
  constexpr std::uint8_t filter_up = 2;
  const std::size_t stride = std::size_t{3} * image.width;
  std::vector<std::uint8_t> rows;
  rows.reserve((stride + 1) * image.height);
  for (std::size_t y = 0; y < image.height; ++y) {
    rows.push_back(filter_up);
    for (std::size_t x = 0; x < stride; ++x) {
      const std::uint8_t above = y > 0 ? image.rgb[(y - 1) * stride + x] : std::uint8_t{0};
      rows.push_back(static_cast<std::uint8_t>(image.rgb[y * stride + x] - above));
    }
  }
  return zlib_of(rows);
}

std::string header_of(const Image& image) {
  std::string data;
  put_u32(data, image.width);
  put_u32(data, image.height);
  return data.append("\x08\x02\x00\x00\x00", 5);  // 8 bits, RGB
}

std::string frame_control(const Image& image, std::uint32_t number, double seconds) {
  std::string data;
  for (const std::uint32_t value : {number, image.width, image.height, 0u, 0u}) put_u32(data, value);
  const auto ms = static_cast<std::uint32_t>(std::lround(1000 * seconds));
  put_u32(data, (ms & 0xFFFFu) << 16u | 1000u);
  return data.append(2, '\0');  // stays, replaces
}

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

// ---- PNG ------------------------------------------------------------------------------------------

std::string png_of(const std::vector<Image>& images, double seconds) {
  std::string to("\x89PNG\r\n\x1a\n", 8);
  put_chunk(to, "IHDR", header_of(images.front()));
  const bool moves = images.size() > 1;
  if (moves) {
    std::string control;
    put_u32(control, static_cast<std::uint32_t>(images.size()));
    put_u32(control, 0);  // repeats endlessly
    put_chunk(to, "acTL", control);
  }
  std::uint32_t number = 0;
  for (const Image& image : images) {
    if (moves) put_chunk(to, "fcTL", frame_control(image, number++, seconds));
    if (number <= 1) {
      put_chunk(to, "IDAT", rows_of(image));
      continue;
    }
    std::string data;
    put_u32(data, number++);
    put_chunk(to, "fdAT", data + rows_of(image));
  }
  put_chunk(to, "IEND", "");
  return to;
}

// ---- glTF -----------------------------------------------------------------------------------------

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
