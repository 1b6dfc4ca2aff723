// A picture of an instant, drawn without a browser: the page's view as triangles, lines and a camera.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "platform/view/picture/png.h"
#include "platform/view/picture/triangles.h"
#include "platform/view/recorded/recording.h"

namespace godobject {

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
  Vec3 centre = Vec3::Zero();
  double extent = 1;  // half the diagonal of the scene's bounds, m
};

/// Makes the picture of a sample. Bodies are solid at their simulated pose. At the pose of the device they
/// are wireframes, with the coupling and the force to the hand. centre and extent are those of the scene at
/// its start.
Picture picture_of(const Recording& recording, const Drawing& drawing, const ViewSample& sample);

/// Draws the picture with the page's initial camera. width, height: pixels.
Image drawn(const Picture& picture, std::uint32_t width, std::uint32_t height);
/// Returns the picture as glTF 2.0 with all data embedded.
std::string gltf_of(const Picture& picture);

}  // namespace godobject
