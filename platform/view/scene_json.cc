#include "platform/view/scene_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "platform/scene/joint/joints.h"
#include "platform/view/frame.h"
#include "platform/view/joint_pointer.h"
#include "platform/view/nets.h"
#include "platform/view/solids.h"

namespace godobject {
namespace {

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

Json to_json(const std::vector<BitText>& bits) {
  Json list = Json::array();
  for (const BitText& bit : bits) list.push_back({{"name", bit.name}, {"text", bit.text}});
  return list;
}

}  // namespace

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
            {"coordinates", Json::array()},
            {"carriers", Json::array()},
            {"buses", Json::array()}};
  if (about.takes_pointer && scene.device && scene.device->unmeasured_tree) {
    json["coordinates"] = coordinates_of(scene);
    json["carriers"] = carriers_of(scene);
  }
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
