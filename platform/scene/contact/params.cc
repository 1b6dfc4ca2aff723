#include "platform/scene/contact/params.h"

#include <algorithm>

#include "platform/scene/contact/pairs.h"

namespace godobject {
namespace {

ShapeParams shape_params(const ShapeConfig& shape) {
  return {.kind = shape.kind,
          .X_WS = shape.X,
          .half_extents = shape.half_extents.value_or(Vec3::Zero()),
          .radius = shape.radius.value_or(0),
          .half_length = shape.half_length.value_or(0)};
}

ContactLaw law_of(const ContactConfig& c) {
  return {.k = c.stiffness,
          .c = c.damping,
          .mu = c.friction,
          .k_t = c.tangential_stiffness.value_or(c.stiffness),
          .c_t = c.tangential_damping.value_or(c.damping),
          .push_out = c.push_out_speed};
}

/// Builds the contacts part by part.
class ContactBuilder {
 public:
  explicit ContactBuilder(const SceneConfig& scene) {
    for (const MaterialUse& use : materials_of(scene)) to_.materials.push_back(use.material);
    for (const ContactConfig& contact : scene.contacts) add(contact);
    for (const ObstacleConfig& obstacle : scene.obstacles) add(obstacle);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) add(scene.bodies[i], i);
  }
  SceneContacts take() { return std::move(to_); }

 private:
  MaterialId id_of(const std::string& material) const {
    return static_cast<MaterialId>(std::ranges::find(to_.materials, material) - to_.materials.begin());
  }

  void add(const ContactConfig& contact) {
    const MaterialId a = id_of(contact.materials[0]), b = id_of(contact.materials[1]);
    if (std::max(a, b) >= to_.materials.size()) return;  // unused material
    to_.laws[a][b] = to_.laws[b][a] = law_of(contact);
  }

  void add(const ObstacleConfig& obstacle) {
    ShapeParams shape = shape_params(obstacle.shape);
    if (shape.kind == ShapeKind::mesh) shape.mesh = mesh_of(obstacle);
    if (shape.kind == ShapeKind::height_field) shape.height_field = height_field_of(obstacle);
    for (std::size_t i = 0; i < num_solids(obstacle); ++i) {
      if (!obstacle.centres.empty())
        shape.X_WS.p = obstacle.shape.X.p + obstacle.shape.X.q * obstacle.centres[i];
      to_.surfaces.push_back({.body = world, .shape = shape, .material = id_of(obstacle.shape.material)});
      to_.surface_names.push_back("obstacle '" + obstacle.name + "'");
    }
  }

  void add(const BodyConfig& body, std::size_t index) {
    for (const SphereConfig& row : body.spheres)
      for (int i = 0; i < row.count; ++i)
        to_.spheres.push_back({.body = index,
                               .p_B = row.p_B + i * row.spacing,
                               .radius = row.radius,
                               .material = id_of(row.material)});
    for (const ShapeConfig& shape : body.shapes) {
      to_.surfaces.push_back(
          {.body = index, .shape = shape_params(shape), .material = id_of(shape.material)});
      to_.surface_names.push_back("shape of body '" + body.name + "'");
    }
  }

  const TriangleMesh* mesh_of(const ObstacleConfig& obstacle) {
    std::string why_not;
    to_.meshes.push_back(MeshSolid::make(obstacle.mesh, why_not));
    return to_.meshes.back() ? &to_.meshes.back()->mesh() : nullptr;  // null is rejected by the core
  }

  const HeightField* height_field_of(const ObstacleConfig& obstacle) {
    to_.heights.push_back(obstacle.heights.height);
    to_.height_fields.push_back({.height = to_.heights.back(),
                                 .columns = obstacle.heights.columns,
                                 .rows = obstacle.heights.rows,
                                 .spacing = obstacle.spacing.value_or(0)});
    return &to_.height_fields.back();
  }

  SceneContacts to_;
};

}  // namespace

std::size_t num_solids(const ObstacleConfig& obstacle) {
  return obstacle.centres.empty() ? 1 : obstacle.centres.size();
}

SceneContacts scene_contacts(const SceneConfig& scene) { return ContactBuilder(scene).take(); }

ContactCounts contact_counts(const SceneConfig& scene) {
  ContactCounts counts;
  for (const ObstacleConfig& obstacle : scene.obstacles) counts.surfaces += num_solids(obstacle);
  for (const BodyConfig& body : scene.bodies) {
    counts.surfaces += body.shapes.size();
    for (const SphereConfig& row : body.spheres) counts.spheres += static_cast<std::size_t>(row.count);
  }
  return counts;
}

}  // namespace godobject
