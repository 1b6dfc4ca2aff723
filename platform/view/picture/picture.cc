#include "platform/view/picture/picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/device/holding.h"
#include "platform/view/nets.h"

namespace godobject {
namespace {

// The page's colours.
constexpr Colour tool_colour{0xd5, 0x45, 0x2c}, body_colour{0x7e, 0x9f, 0xc7},
    obstacle_colour{0xa9, 0xa2, 0x94}, ghost_colour{0xe0, 0x8a, 0x1e}, unloaded_colour{0x2c, 0x9c, 0x5a},
    loaded_colour{0xd5, 0x26, 0x1c}, force_colour{0xb0, 0x1f, 0xb0}, contact_colour{0x1f, 0x7f, 0xd0};

Colour between(const Colour& a, const Colour& b, double s) {
  Colour c{};
  for (std::size_t i = 0; i < c.size(); ++i)
    c[i] = static_cast<std::uint8_t>(std::lround((1 - s) * a[i] + s * b[i]));
  return c;
}

/// Sets centre and extent as in the page: the bounds of all finite solids at the start of the scene.
void set_bounds(const SceneConfig& scene, const Drawing& drawing, Picture& picture) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max()), high = -low;
  const auto add = [&](const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  for (const Solid& solid : drawing.solids) {
    if (solid.kind == SolidKind::plane || solid.role == SolidRole::contact) continue;
    const Pose X = solid.body ? composed(scene.bodies[*solid.body].X_WB, solid.X) : solid.X;
    const bool is_long = solid.kind == SolidKind::capsule || solid.kind == SolidKind::cylinder;
    const double reach = solid.kind == SolidKind::box ? solid.size.norm() : solid.size.x();
    const Vec3 axis = X.q * Vec3(0, 0, is_long ? solid.size.y() : 0);
    for (const double side : {-1.0, 1.0}) add(X.p + side * (axis + Vec3::Constant(reach / std::sqrt(3.0))));
    for (const double side : {-1.0, 1.0}) add(X.p + side * (axis - Vec3::Constant(reach / std::sqrt(3.0))));
    if (solid.kind == SolidKind::mesh)
      for (const Vec3& p : drawing.meshes[solid.mesh].vertices) add(X.p + X.q * p);
  }
  for (const Vec3& p : nodes_at_start(scene)) add(p);
  if (low.x() > high.x()) low = high = Vec3::Zero();
  constexpr double least = 0.01;
  picture.centre = 0.5 * (low + high);
  picture.extent = std::max(least, 0.5 * (high - low).norm());
}

MeshData placed(MeshData mesh, const Pose& X) {
  for (Vec3& p : mesh.vertices) p = X.p + X.q * p;
  return mesh;
}

class PictureBuilder {
 public:
  PictureBuilder(const Recording& recording, const Drawing& drawing, const ViewSample& sample)
      : recording_(recording),
        scene_(recording.scene),
        drawing_(drawing),
        record_(sample.record),
        sample_(sample),
        driven_(driven_bodies(scene_)) {
    set_bounds(scene_, drawing_, picture_);
    max_force_ = scene_.device ? scene_.device->limits.force : LimitConfig{}.force;
  }

  Picture build() {
    for (const Solid& solid : drawing_.solids) add(solid);
    add_nets();
    for (const std::size_t body : driven_)
      if (is_shown(body)) add_device(body);
    for (std::size_t i = 0; i < sample_.num_touching; ++i)
      add_arrow("contact", sample_.touching[i].p_W, sample_.touching[i].F_W, contact_colour);
    return std::move(picture_);
  }

 private:
  /// True if the device is drawn at this body: at each driven body, or at the held one if the device grips
  /// bodies.
  bool is_shown(std::size_t body) const {
    return grips_bodies(scene_) ? record_.held == body : std::ranges::find(driven_, body) != driven_.end();
  }

  void add(const Solid& solid) {
    if (solid.role == SolidRole::contact) return;
    const Pose X = solid.body ? composed(record_.bodies[*solid.body].X_WB, solid.X) : solid.X;
    const Colour& colour = !solid.body ? obstacle_colour : is_shown(*solid.body) ? tool_colour : body_colour;
    picture_.meshes.push_back({.name = solid.name,
                               .mesh = placed(triangles_of(solid, drawing_, 2 * picture_.extent), X),
                               .colour = colour,
                               .has_edges = solid.kind == SolidKind::box});
  }

  void add_nets() {
    const SceneNets nets = scene_nets(scene_);
    const std::vector<Vec3> nodes = nodes_of(recording_, nets, sample_);
    for (const NetRange& net : nets.nets) {
      const auto first = nodes.begin() + static_cast<std::ptrdiff_t>(net.first_node);
      MeshData mesh{.vertices = {first, first + static_cast<std::ptrdiff_t>(net.num_nodes)},
                    .triangles = triangles_of(net)};
      const Colour& colour = net.carrier == world ? body_colour : tool_colour;
      picture_.meshes.push_back(
          {.name = net.name, .mesh = std::move(mesh), .colour = colour, .has_edges = false});
    }
  }

  void add_device(std::size_t body) {
    const BodyView& view = record_.bodies[body];
    const double apart = (view.target.X_WD.p - view.X_WB.p).norm() / (0.02 * picture_.extent);
    PictureWires wires{.name = scene_.bodies[body].name + ", device",
                       .lines = {},
                       .colour = ghost_colour,
                       .opacity = std::min(1.0, 0.35 + 0.65 * apart)};
    for (const Solid& solid : drawing_.solids) {
      if (solid.body != body || solid.role == SolidRole::contact) continue;
      const Pose X = composed(view.target.X_WD, solid.X);
      for (const auto& [a, b] : wires_of(solid, drawing_))
        wires.lines.push_back({X.p + X.q * a, X.p + X.q * b});
    }
    picture_.wires.push_back(std::move(wires));
    constexpr double shortest = 1e-9;
    const double load = std::min(1.0, view.coupling_B.f.norm() / max_force_);
    if ((view.target.X_WD.p - view.X_WB.p).norm() > shortest)
      picture_.meshes.push_back(
          {.name = "coupling",
           .mesh = rod(view.X_WB.p, view.target.X_WD.p, 0.006 * picture_.extent * (1 + load)),
           .colour = between(unloaded_colour, loaded_colour, load),
           .in_front = true});
    add_arrow("force to the hand", view.target.X_WD.p,
              grips_bodies(scene_) ? record_.hand_W.f : view.feedback_D.f, force_colour);
  }

  void add_arrow(const char* name, const Vec3& from, const Vec3& F, const Colour& colour) {
    const double length = std::min(0.4 * F.norm() / max_force_, 0.5) * picture_.extent;
    if (length < 0.004 * picture_.extent) return;
    picture_.meshes.push_back({.name = name,
                               .mesh = arrow(from, from + length * F.normalized(), 0.006 * picture_.extent),
                               .colour = colour,
                               .in_front = true});
  }

  const Recording& recording_;
  const SceneConfig& scene_;
  const Drawing& drawing_;
  const CycleRecord& record_;
  const ViewSample& sample_;
  std::vector<std::size_t> driven_;
  double max_force_ = 1;
  Picture picture_;
};

}  // namespace

Picture picture_of(const Recording& recording, const Drawing& drawing, const ViewSample& sample) {
  return PictureBuilder(recording, drawing, sample).build();
}

}  // namespace godobject
