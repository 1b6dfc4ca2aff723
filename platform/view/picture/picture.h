// A still of an instant, without a browser: what the page draws, as triangles, lines and a camera.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "platform/view/picture/png.h"
#include "platform/view/picture/triangles.h"
#include "platform/view/recorded/recording.h"

namespace godobject {

/// In the world.
struct PictureMesh {
  std::string name;
  MeshData mesh;
  Colour colour{};
  bool in_front = false;  // of everything that is not
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
  double extent = 1;  // half the diagonal of what there is to look at, m
};

/// Bodies are solid where the simulation has them; in wireframe, with the coupling and the force to the hand, where the
/// device has them. centre and extent are those of the scene at its start.
Picture picture_of(const Recording& recording, const Drawing& drawing, const ViewSample& sample);

/// As the page shows it at first.
Image drawn(const Picture& picture, std::uint32_t width, std::uint32_t height);
/// glTF 2.0 with all its data in it.
std::string gltf_of(const Picture& picture);

}  // namespace godobject
