// Small solids as mesh files in each supported format, and mutations of such files.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "core/math/types.h"

namespace godobject {

/// Returns corner i of the unit cube; its faces have four corners, counter-clockwise from outside.
inline Vec3 cube_corner(int i) { return {Real(i & 1), Real(i >> 1 & 1), Real(i >> 2 & 1)}; }
inline constexpr int cube_faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

inline std::string text_of(const Vec3& p) {
  return std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
}

/// Returns the bytes of a number in the byte order of a binary file.
template <class T>
std::string bytes_of(T value, std::endian order = std::endian::little) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (order != std::endian::native) std::ranges::reverse(bytes);
  return bytes;
}

inline std::string bytes_of(const Vec3& p, std::endian order = std::endian::little) {
  std::string bytes;
  for (const Real x : p) bytes += bytes_of(static_cast<float>(x), order);
  return bytes;
}

/// Calls f with the three corners of each of the cube's triangles.
template <class F>
void for_each_cube_triangle(F f) {
  for (const auto& face : cube_faces) {
    f(std::array{face[0], face[1], face[2]});
    f(std::array{face[0], face[2], face[3]});
  }
}

inline std::string cube_stl() {
  std::string text = "solid cube\n";
  for_each_cube_triangle([&](const auto& triangle) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int i : triangle) text += "vertex " + text_of(cube_corner(i));
    text += "endloop\nendfacet\n";
  });
  return text + "endsolid cube\n";
}

inline std::string cube_binary_stl() {
  std::string bytes(80, 's');
  bytes += bytes_of(std::uint32_t{12});
  for_each_cube_triangle([&](const auto& triangle) {
    bytes += bytes_of(Vec3(0, 0, 0));
    for (const int i : triangle) bytes += bytes_of(cube_corner(i));
    bytes += bytes_of(std::uint16_t{0});
  });
  return bytes;
}

inline std::string cube_obj(int num_faces = 6) {
  std::string text;
  for (int i = 0; i < 8; ++i) text += "v " + text_of(cube_corner(i));
  for (int f = 0; f < num_faces; ++f) {
    text += "f";
    for (const int i : cube_faces[f]) text += " " + std::to_string(i + 1);
    text += "\n";
  }
  return text;
}

inline std::string cube_ply_header(const std::string& format) {
  return "ply\nformat " + format +
         " 1.0\ncomment a cube\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
}

inline std::string cube_ply() {
  std::string text = cube_ply_header("ascii");
  for (int i = 0; i < 8; ++i) text += text_of(cube_corner(i));
  for (const auto& face : cube_faces) {
    text += "4";
    for (const int i : face) text += " " + std::to_string(i);
    text += "\n";
  }
  return text;
}

inline std::string cube_binary_ply(std::endian order) {
  std::string bytes =
      cube_ply_header(order == std::endian::little ? "binary_little_endian" : "binary_big_endian");
  for (int i = 0; i < 8; ++i) bytes += bytes_of(cube_corner(i), order);
  for (const auto& face : cube_faces) {
    bytes += bytes_of(std::uint8_t{4});
    for (const int i : face) bytes += bytes_of(std::int32_t{i}, order);
  }
  return bytes;
}

/// A cube in a format: file extension and bytes.
struct MeshFileText {
  const char* extension;
  std::string bytes;
};

inline std::vector<MeshFileText> cubes_in_every_format() {
  return {{".ply", cube_ply()},
          {".ply", cube_binary_ply(std::endian::little)},
          {".ply", cube_binary_ply(std::endian::big)},
          {".obj", cube_obj()},
          {".stl", cube_stl()},
          {".stl", cube_binary_stl()}};
}

/// Returns the file with one to eight mutations by damage, careless writers or attackers. A mutation changes
/// a byte or bit, removes, duplicates or moves a range, cuts the end, or replaces a number by an invalid one.
inline std::string mutated(std::string file, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto below = [&](std::size_t n) { return n == 0 ? std::size_t{0} : random() % n; };
  static constexpr std::array words{"-1",
                                    "4294967295",
                                    "2147483648",
                                    "1e39",
                                    "nan",
                                    "inf",
                                    "99",
                                    "18446744073709551616",
                                    "",
                                    "0",
                                    "-0.0",
                                    "list",
                                    "f 1//2 3/4/5 -1",
                                    "element",
                                    "\n",
                                    "property int q\n"};
  for (std::size_t changes = 1 + below(8); changes > 0; --changes) {
    const std::size_t at = below(file.size()), length = below(std::min<std::size_t>(file.size() - at, 64));
    switch (below(7)) {
      case 0:
        if (!file.empty()) file[at] = static_cast<char>(below(256));
        break;
      case 1:
        if (!file.empty()) file[at] = static_cast<char>(file[at] ^ (1 << below(8)));
        break;
      case 2: file.erase(at, length); break;
      case 3: file.insert(at, file.substr(at, length)); break;
      case 4: file.insert(below(file.size() + 1), file.substr(at, length)); break;
      case 5: file.resize(at); break;
      default: {
        const std::size_t begin = std::min(file.find_first_of("0123456789", at), file.size());
        const std::size_t end = std::min(file.find_first_not_of("0123456789.", begin), file.size());
        file.replace(begin, end - begin, words[below(words.size())]);
      }
    }
  }
  return file;
}

}  // namespace godobject
