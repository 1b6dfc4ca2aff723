#include "platform/view/drawing.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/shape/height_field.h"
#include "platform/scene/joint/joints.h"
#include "platform/view/frame.h"
#include "platform/view/pointer.h"

namespace godobject {
namespace {

/// Returns the height field as triangles, with sides and without a bottom, as in the contact search.
MeshData mesh_of(const HeightGrid& grid, double spacing) {
  MeshData mesh;
  const std::uint32_t n = grid.columns, m = grid.rows;
  for (std::uint32_t j = 0; j < m; ++j)
    for (std::uint32_t i = 0; i < n; ++i)
      mesh.vertices.emplace_back(i * spacing, j * spacing, grid.height[std::size_t{j} * n + i]);
  for (std::uint32_t j = 0; j + 1 < m; ++j)
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

SolidKind kind_of(ShapeKind kind) noexcept {
  switch (kind) {
    case ShapeKind::plane: return SolidKind::plane;
    case ShapeKind::box: return SolidKind::box;
    case ShapeKind::sphere: return SolidKind::sphere;
    case ShapeKind::capsule: return SolidKind::capsule;
    case ShapeKind::height_field:
    case ShapeKind::mesh: break;
  }
  return SolidKind::mesh;
}

Solid solid_of(const ShapeConfig& shape, SolidRole role, const std::string& name) {
  Solid solid{.kind = kind_of(shape.kind), .role = role, .name = name, .X = shape.X};
  const double radius = shape.radius.value_or(0);
  solid.size = shape.half_extents.value_or(Vec3(radius, shape.half_length.value_or(0), 0));
  return solid;
}

void add(const ObstacleConfig& obstacle, Drawing& to) {
  Solid solid = solid_of(obstacle.shape, SolidRole::obstacle, obstacle.name);
  if (solid.kind == SolidKind::mesh) {
    solid.mesh = to.meshes.size();
    const bool is_field = obstacle.shape.kind == ShapeKind::height_field;
    to.meshes.push_back(is_field ? mesh_of(obstacle.heights, obstacle.spacing.value_or(1)) : obstacle.mesh);
  }
  if (obstacle.centres.empty()) to.solids.push_back(solid);
  for (const Vec3& centre : obstacle.centres) {
    solid.X.p = obstacle.shape.X.p + obstacle.shape.X.q * centre;
    to.solids.push_back(solid);
  }
}

void add(const BodyConfig& body, std::size_t index, Drawing& to) {
  const auto put = [&](Solid solid) {
    solid.body = index;
    solid.name = body.name;
    to.solids.push_back(std::move(solid));
  };
  for (const ShapeConfig& shape : body.shapes) put(solid_of(shape, SolidRole::shape, body.name));
  if (body.shapes.empty()) put(solid_of_inertia(body.mass, body.inertia));
  for (const SphereConfig& row : body.spheres)
    for (int i = 0; i < row.count; ++i)
      put({.kind = SolidKind::sphere,
           .role = SolidRole::contact,
           .X = {.p = row.p_B + i * row.spacing, .q = Quat::Identity()},
           .size = Vec3(row.radius, 0, 0)});
}

/// Returns the radius of a ball about the solid's origin that contains it, m.
double reach_of(const Solid& solid, const Drawing& drawing) {
  double reach = solid.kind == SolidKind::box ? solid.size.norm() : solid.size.sum();
  if (solid.kind == SolidKind::mesh)
    for (const Vec3& p : drawing.meshes[solid.mesh].vertices) reach = std::max(reach, p.norm());
  return reach;
}

/// Shrinks balls of equal inertia to markers, because they show no shape and would hide those that have one.
void bound_markers(const SceneConfig& scene, Drawing& drawing) {
  constexpr double max_share = 0.04;  // radius of a marker, of half the scene's diagonal
  const auto is_marker = [](const Solid& solid) {
    return solid.role == SolidRole::inertia && solid.kind == SolidKind::sphere;
  };
  Eigen::AlignedBox3d box;
  for (const Solid& solid : drawing.solids) {
    if (solid.kind == SolidKind::plane || is_marker(solid)) continue;
    const Pose X = solid.body ? scene.bodies[*solid.body].X_WB : Pose{};
    const Vec3 at = X.p + X.q * solid.X.p, reach = Vec3::Constant(reach_of(solid, drawing));
    box.extend(Eigen::AlignedBox3d(at - reach, at + reach));
  }
  if (box.isEmpty()) return;
  const double max_radius = max_share * 0.5 * box.diagonal().norm();
  for (Solid& solid : drawing.solids)
    if (is_marker(solid)) solid.size.x() = std::min(solid.size.x(), max_radius);
}

bool about_equal(double a, double b) noexcept {
  constexpr double tolerance = 0.01;
  return std::abs(a - b) <= tolerance * std::max(a, b);
}

/// Returns the anchors of the nodes. X_WB(body): pose of that body.
template <class Where>
std::vector<Vec3> on_anchors(const SceneNets& nets, const Where& X_WB) {
  std::vector<Vec3> nodes;
  for (const NetNode& node : nets.nodes) {
    const Pose X = node.body == world ? Pose{} : X_WB(node.body);
    nodes.push_back(X.p + X.q * node.p_B);
  }
  return nodes;
}

using Json = nlohmann::ordered_json;

Json to_json(const Vec3& a) { return {a.x(), a.y(), a.z()}; }

/// Position, then x, y, z, w of the quaternion.
Json to_json(const Pose& X) { return {X.p.x(), X.p.y(), X.p.z(), X.q.x(), X.q.y(), X.q.z(), X.q.w()}; }

Json to_json(const Solid& solid) {
  return {{"kind", solid_kind_names.at(static_cast<std::size_t>(solid.kind))},
          {"role", solid_role_names.at(static_cast<std::size_t>(solid.role))},
          {"body", solid.body ? Json(*solid.body) : Json(nullptr)},
          {"name", solid.name},
          {"pose", to_json(solid.X)},
          {"size", to_json(solid.size)},
          {"mesh", solid.mesh}};
}

Json to_json(const MeshData& mesh) {
  Json vertices = Json::array(), triangles = Json::array();
  for (const Vec3& p : mesh.vertices)
    for (const double x : p) vertices.push_back(static_cast<float>(x));
  for (const TriangleIndices& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) triangles.push_back(corner);
  return {{"vertices", std::move(vertices)}, {"triangles", std::move(triangles)}};
}

/// nodes: positions of all nets' nodes at the start.
Json to_json(const NetRange& net, const std::vector<Vec3>& nodes) {
  Vec3 low = nodes[net.first_node], high = low;
  for (std::size_t i = net.first_node; i < net.first_node + net.num_nodes; ++i) {
    low = low.cwiseMin(nodes[i]);
    high = high.cwiseMax(nodes[i]);
  }
  Json triangles = Json::array();
  for (const TriangleIndices& triangle : triangles_of(net))
    for (const std::uint32_t corner : triangle) triangles.push_back(corner);
  return {{"name", net.name},
          {"num_vertices", net.num_nodes},
          {"bounds", {to_json(low), to_json(high)}},
          {"triangles", std::move(triangles)}};
}

Json to_json(const JointConfig& joint, const SceneConfig& scene) {
  const std::optional<std::size_t> parent = body_named(scene, joint.parent);
  return {{"name", joint.name},
          {"kind", joint_kind_names().at(static_cast<std::size_t>(joint.kind) - 1)},
          {"parent", parent ? Json(*parent) : Json(nullptr)},
          {"child", *body_named(scene, joint.child)},
          {"pose", to_json(joint.X_BP)}};
}

/// Lists the coordinates that a page moves, with the coordinates of their parent links, and their ranges.
Json coordinates_of(const SceneConfig& scene) {
  Json list = Json::array();
  const KinematicTreeParams& tree = *device_tree(scene);
  const std::vector<CoordinateRange> ranges = page_ranges(scene);
  for (std::size_t i = 0; i < tree.joints.size(); ++i) {
    const std::size_t parent = parent_link(tree.joints, i).value_or(0);
    list.push_back({{"name", tree.joints[i].name},
                    {"turns", tree.joints[i].kind == DeviceJointKind::hinge},
                    {"parent", parent > 0 ? Json(parent - 1) : Json(nullptr)},
                    {"lower", ranges[i].lower},
                    {"upper", ranges[i].upper}});
  }
  return list;
}

/// Lists, for each driven body, the index of the coordinate that carries its handle, or null.
Json carriers_of(const SceneConfig& scene) {
  const KinematicTreeParams& tree = *device_tree(scene);
  Json list = Json::array();
  for (const std::size_t body : driven_bodies(scene)) {
    const auto handle = std::ranges::find(tree.handles, scene.bodies[body].name, &HandleParams::body);
    const auto joint = handle == tree.handles.end()
                           ? tree.joints.end()
                           : std::ranges::find(tree.joints, handle->joint, &DeviceJoint::name);
    list.push_back(joint == tree.joints.end() ? Json(nullptr) : Json(joint - tree.joints.begin()));
  }
  return list;
}

Json values_of(const SceneConfig& scene) {
  Json list = Json::array();
  for (const ViewValue& value : view_values(scene))
    list.push_back({{"of", value.of}, {"index", value.index}, {"name", value.name}, {"unit", value.unit}});
  return list;
}

Json to_json(const std::vector<BitText>& bits) {
  Json list = Json::array();
  for (const BitText& bit : bits) list.push_back({{"name", bit.name}, {"text", bit.text}});
  return list;
}

}  // namespace

// ---- solids ---------------------------------------------------------------------------------------

Solid solid_of_inertia(double mass, const Mat3& inertia) {
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(inertia);
  const Vec3& I = axes.eigenvalues();  // in ascending order
  Mat3 R = axes.eigenvectors();
  const auto root = [](double a) { return std::sqrt(std::max(a, 0.0)); };
  Solid solid{.role = SolidRole::inertia};
  if (about_equal(I.x(), I.z())) {  // I = 2/5 m r^2
    solid.kind = SolidKind::sphere;
    solid.size = Vec3(root(2.5 * I.mean() / mass), 0, 0);
    return solid;
  }
  const bool rod = about_equal(I.y(), I.z()), disc = about_equal(I.x(), I.y());
  if (rod || disc) {  // about z: I_z = m r^2 / 2, I_x = m (3 r^2 + l^2) / 12
    const double I_z = rod ? I.x() : I.z(), I_x = rod ? I.z() : I.x();
    const double r_sq = 2 * I_z / mass, l_sq = 12 * I_x / mass - 3 * r_sq;
    solid.kind = SolidKind::cylinder;
    solid.size = Vec3(root(r_sq), 0.5 * root(l_sq), 0);
    const Vec3 z = R.col(rod ? 0 : 2);
    solid.X.q = turn_from_z(z.z() < 0 ? Vec3(-z) : z);
    return solid;
  }
  // I_x = m (b^2 + c^2) / 3 of half extents a, b, c: a^2 = 3 (I_y + I_z - I_x) / 2 m
  for (int i = 0; i < 3; ++i) solid.size[i] = root(1.5 * (I.sum() - 2 * I[i]) / mass);
  if (R.determinant() < 0) R.col(0) = -R.col(0);
  solid.X.q = Quat(R);
  return solid;
}

Drawing drawing_of(const SceneConfig& scene) {
  Drawing drawing;
  for (const ObstacleConfig& obstacle : scene.obstacles) add(obstacle, drawing);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) add(scene.bodies[i], i, drawing);
  bound_markers(scene, drawing);
  return drawing;
}

// ---- nets -----------------------------------------------------------------------------------------

std::vector<Vec3> nodes_of(const SceneNets& nets, const ViewSample& sample) {
  if (sample.net_nodes.size() == nets.nodes.size()) return sample.net_nodes;
  return on_anchors(nets, [&](std::size_t body) { return sample.record.bodies[body].X_WB; });
}

std::vector<Vec3> nodes_at_start(const SceneConfig& scene) {
  return on_anchors(scene_nets(scene), [&](std::size_t body) { return scene.bodies[body].X_WB; });
}

std::vector<TriangleIndices> triangles_of(const NetRange& net) {
  std::vector<TriangleIndices> triangles = net.triangles;
  const auto first = static_cast<std::uint32_t>(net.first_node);
  for (TriangleIndices& t : triangles)
    for (std::uint32_t& corner : t) corner -= first;
  return triangles;
}

// ---- JSON -----------------------------------------------------------------------------------------

std::string scene_json(const SceneConfig& scene, const ViewAbout& about) {
  const Drawing drawing = drawing_of(scene);
  const LimitConfig limits = scene.device ? scene.device->limits : LimitConfig{};
  Json json{{"type", "scene"},
            {"version", view_version},
            {"title", about.title},
            {"name", scene.name},
            {"about", scene.about},
            {"live", about.live},
            {"takes_pointer", about.takes_pointer},
            {"takes_pace", about.takes_pace},
            {"no_reset", about.no_reset},
            {"fast", about.fast},
            {"warning", about.warning},
            {"step", scene.step},
            {"gravity", to_json(scene.gravity)},
            {"max_force", limits.force},
            {"max_torque", limits.torque},
            {"takes_hold", grips_bodies(scene)},
            {"device", scene.device ? Json(scene.device->name) : Json(nullptr)},
            {"driven", driven_bodies(scene)},
            {"bodies", Json::array()},
            {"joints", Json::array()},
            {"solids", Json::array()},
            {"meshes", Json::array()},
            {"surfaces", Json::array()},
            {"faults", to_json(about.faults)},
            {"rig_faults", to_json(about.rig_faults)},
            {"limits", to_json(about.limits)},
            {"values", values_of(scene)},
            {"terms", term_names(scene)},
            {"device_joints", Json::array()},
            {"coordinates", Json::array()},
            {"carriers", Json::array()},
            {"buses", Json::array()}};
  if (about.takes_pointer && scene.device && scene.device->unmeasured_tree) {
    json["coordinates"] = coordinates_of(scene);
    json["carriers"] = carriers_of(scene);
  }
  if (scene.device && scene.device->rig)
    for (const DeviceJoint& joint : scene.device->rig->tree.joints)
      json["device_joints"].push_back(joint.name);
  for (const BodyConfig& body : scene.bodies)
    json["bodies"].push_back({{"name", body.name}, {"mass", body.mass}, {"pose", to_json(body.X_WB)}});
  for (const JointConfig& joint : scene.joints) json["joints"].push_back(to_json(joint, scene));
  for (const Solid& solid : drawing.solids) json["solids"].push_back(to_json(solid));
  for (const MeshData& mesh : drawing.meshes) json["meshes"].push_back(to_json(mesh));
  const std::vector<Vec3> nodes = nodes_at_start(scene);
  for (const NetRange& net : scene_nets(scene).nets) json["surfaces"].push_back(to_json(net, nodes));
  for (const BusLoadText& bus : about.buses)
    json["buses"].push_back({{"name", bus.name}, {"percent", bus.percent}});
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace godobject
