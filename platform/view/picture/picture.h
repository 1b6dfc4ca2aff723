// A picture of an instant, drawn without a browser: the page's view as triangles, lines and a camera, and its
// files.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "platform/view/drawing.h"
#include "platform/view/recorded/recording.h"

namespace godobject {

using Colour = std::array<std::uint8_t, 3>;

/// Returns triangles in the axes of the solid. plane_half_size: half size of the square that represents a
/// plane, m.
MeshData triangles_of(const Solid& solid, const Drawing& drawing, double plane_half_size);
/// Returns the wireframe of a solid: pairs of points, in the axes of the solid.
std::vector<std::array<Vec3, 2>> wires_of(const Solid& solid, const Drawing& drawing);

/// Returns a cylinder from a to b.
MeshData rod(const Vec3& a, const Vec3& b, double radius);
/// Returns an arrow from a to b. shaft_radius: radius of its shaft, m.
MeshData arrow(const Vec3& a, const Vec3& b, double shaft_radius);

/// An image of 8-bit RGB.
struct Image {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // row by row, 3 bytes a pixel
};

/// Triangles in the world.
struct PictureMesh {
  std::string name;
  MeshData mesh;
  Colour colour{};
  bool in_front = false;  // drawn over all other meshes
  bool has_edges = false;
};
struct PictureWires {
  std::string name;
  std::vector<std::array<Vec3, 2>> lines;
  Colour colour{};
  double opacity = 1;
};
struct Picture {
  std::vector<PictureMesh> meshes;
  std::vector<PictureWires> wires;
  std::vector<Vec3> outline{};  // points that the camera shows, m
  Vec3 centre = Vec3::Zero();
  double extent = 1;  // half the diagonal of the scene's bounds, m
};

/// Makes the picture of a sample. Bodies are solid at their simulated pose. At the pose of the device they
/// are wireframes, with the coupling and the force to the hand. The outline is that of the whole recording;
/// centre and extent are those of the start.
Picture picture_of(const Recording& recording, const Drawing& drawing, const ViewSample& sample);

/// Draws the picture with the page's initial camera. width, height: pixels.
Image drawn(const Picture& picture, std::uint32_t width, std::uint32_t height);
/// Returns the picture as glTF 2.0 with all data embedded.
std::string gltf_of(const Picture& picture);

/// Returns the bytes of a PNG file. Several images, all of one size, make an animation that repeats. seconds:
/// duration of each image, s.
std::string png_of(const std::vector<Image>& images, double seconds = 0.1);

}  // namespace godobject
