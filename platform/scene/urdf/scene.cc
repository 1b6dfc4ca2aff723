// A robot description as a scene file.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>

#include "core/math/pose.h"
#include "core/math/so3.h"
#include "platform/scene/mesh/file.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"
#include "platform/scene/urdf/urdf.h"

namespace godobject {
namespace {

constexpr double rounding = 1e-14;         // below it numbers are rounding errors of turned frames
constexpr double depth_of_weight = 1e-4;   // m, by which the weight of all bodies presses in a chosen contact
constexpr double standard_gravity = 9.81;  // m/s^2

std::string text_of(double x, double unit = 1) { return shortest(std::abs(x) <= rounding * unit ? 0 : x); }
std::string text_of(const Vec3& x, double unit = 1) {
  return "[" + text_of(x.x(), unit) + ", " + text_of(x.y(), unit) + ", " + text_of(x.z(), unit) + "]";
}
std::string text_of(const Quat& q) {
  return "[" + text_of(q.w()) + ", " + text_of(q.x()) + ", " + text_of(q.y()) + ", " + text_of(q.z()) + "]";
}
bool is_identity(const Quat& q) { return q.vec().cwiseAbs().maxCoeff() <= rounding; }

std::string mesh_of(const UrdfShape& shape) {
  return "mesh " + excerpt(std::filesystem::path(shape.file).filename().string());
}

class UrdfScene {
 public:
  UrdfScene(const UrdfRobot& robot, const std::vector<UrdfGroup>& groups, std::string scene_folder,
            Diagnostics& log)
      : robot_(robot), groups_(groups), scene_folder_(std::move(scene_folder)), log_(log) {}

  std::string write() {
    write_head();
    for (std::size_t i = urdf_ground + 1; i < groups_.size(); ++i) write_body(groups_[i]);
    for (std::size_t i = urdf_ground + 1; i < groups_.size(); ++i) write_joint(groups_[i]);
    for (const UrdfGroup& group : groups_)
      if (group.joint && group.joint->mimic) write_gear(*group.joint);
    write_obstacles();
    write_contact();
    return std::move(out_);
  }

 private:
  void comment(const std::string& text) { out_ += "# " + text + "\n"; }
  void table(const std::string& name) { out_ += "\n" + name + "\n"; }
  void key(const std::string& name, const std::string& value) { out_ += name + " = " + value + "\n"; }
  void name(const std::string& key_name, const std::string& value) { key(key_name, "\"" + value + "\""); }
  void pose(const std::string& prefix, const Pose& X) {
    if (X.p.cwiseAbs().maxCoeff() > rounding) key(prefix + "position", text_of(X.p));
    if (!is_identity(X.q)) key(prefix + "orientation_wxyz", text_of(X.q));
  }

  void write_head() {
    const std::string file = printable(std::filesystem::path(log_.file()).filename().string());
    comment("Imported from " + file +
            ". Bodies are its links, with their names and axes, about the centre of mass.");
    comment("Links fixed to each other are one body. Bodies that are joined do not touch each other.");
    std::string list;
    for (const auto& [element, count] : robot_.left_out)
      list += (list.empty() ? "" : ", ") + element + " (" + std::to_string(count) + ")";
    if (!list.empty()) comment("Left out, because scenes have no key for them: " + list + ".");
    std::string scene_name = robot_.name;
    for (char& c : scene_name)
      if (!is_plain_name(std::string(1, c))) c = '_';
    out_ += "[scene]\n";
    name("name", scene_name);
    out_ += "gravity = " + text_of(Vec3(0, 0, -standard_gravity)) + "  # a description has none; z is up\n";
  }

  void write_body(const UrdfGroup& group) {
    table("[[body]]");
    name("name", group.first->name);
    for (const UrdfPart& part : group.links)
      if (part.link != group.first)
        comment("with link " + part.link->name + ", by joint " + part.joint->name);
    key("mass", shortest(group.mass));
    const double largest = group.I.cwiseAbs().maxCoeff();
    const Mat3 I = (group.I.array().abs() <= rounding * largest).select(0, group.I);
    key("inertia", I.isDiagonal(0)
                       ? text_of(Vec3(I.diagonal()), largest)
                       : "[" + text_of(Vec3(I.row(0)), largest) + ", " + text_of(Vec3(I.row(1)), largest) +
                             ", " + text_of(Vec3(I.row(2)), largest) + "]");
    if (group.start != 0)
      comment("starts with joint " + group.joint->name +
              (group.joint->mimic ? " where its <mimic> puts it" : " at its limit nearest to zero"));
    pose("", group.X_W * Pose{group.c, Quat::Identity()});
    for (const auto& [link, joint, X_L] : group.links)
      for (const UrdfShape& shape : link->shapes) {
        const Pose X = X_L * shape.X_L;
        if (!is_solid(shape, *link)) continue;
        write_solid("[[body.shape]]", "", shape, {X.p - group.c, X.q});
        shaped_tools_.insert(group.tool);
      }
  }

  /// True if bodies can carry the shape; otherwise adds a warning and a comment.
  bool is_solid(const UrdfShape& shape, const UrdfLink& link) {
    if (shape.kind == UrdfShapeKind::mesh)
      return leave_out(shape, link, mesh_of(shape),
                       "bodies carry boxes, spheres and capsules: add [[body.shape]] tables");
    if (shape.kind == UrdfShapeKind::cylinder && shape.length < 2 * shape.radius)
      return leave_out(shape, link, "cylinder shorter than wide",
                       "a capsule does not fit into it: add a box to the scene");
    return true;
  }
  bool leave_out(const UrdfShape& shape, const UrdfLink& link, const std::string& which,
                 const std::string& why) {
    log_.warning(shape.at, "link '" + link.name + "': " + which + " is left out; " + why);
    comment("left out: " + which + " of link " + link.name + "; " + why);
    return false;
  }

  void write_solid(const std::string& head, const std::string& title, const UrdfShape& shape, const Pose& X) {
    table(head);
    if (!title.empty()) name("name", title);
    if (shape.kind == UrdfShapeKind::cylinder)
      comment("inside a cylinder of length " + shortest(shape.length) + " m: its ends are round");
    constexpr std::array kinds{"box", "sphere", "capsule", "mesh"};
    name("kind", kinds.at(static_cast<std::size_t>(shape.kind)));
    pose("", X);
    if (shape.kind == UrdfShapeKind::box) key("half_extents", text_of(Vec3(shape.size / 2), 0));
    if (shape.radius > 0) key("radius", shortest(shape.radius));
    if (shape.kind == UrdfShapeKind::cylinder) key("half_length", shortest(shape.length / 2 - shape.radius));
  }

  void write_joint(const UrdfGroup& group) {
    const UrdfJoint* const joint = group.joint;
    if (joint && joint->kind == UrdfJointKind::floating) return;
    const bool is_fixed = !joint || joint->kind == UrdfJointKind::fixed;
    out_ += joint ? "" : "\n# Holds the root in the world; without this joint the robot is free.";
    table("[[joint]]");
    std::string title = joint ? joint->name : group.first->name + "_to_world";
    while (!joint && std::ranges::find(robot_.joints, title, &UrdfJoint::name) != robot_.joints.end())
      title += "_";
    name("name", title);
    name("kind", is_fixed ? "fixed" : joint->kind == UrdfJointKind::prismatic ? "slider" : "hinge");
    name("parent", group.parent == urdf_ground ? world_name : groups_[group.parent].first->name);
    name("child", group.first->name);
    const Vec3 c_P = group.parent == urdf_ground ? Vec3(Vec3::Zero()) : groups_[group.parent].c;
    Pose X_P{group.X_P.p - c_P, group.X_P.q}, X_C{-group.c, Quat::Identity()};
    if (!is_fixed && is_identity(X_P.q)) {
      key("axis", text_of(joint->axis_C));
    } else if (!is_fixed) {
      X_C.q = turn_from_z(joint->axis_C);
      X_P.q = X_P.q * X_C.q;
    }
    pose("parent_", X_P);
    pose("child_", X_C);
    if (!joint || !joint->limit) return;
    const double range = joint->limit->upper - joint->limit->lower;
    table("[[joint.stop]]");
    key("lower", shortest(joint->limit->lower));
    key("upper", shortest(joint->limit->upper));
    comment("chosen: the width is 1 % of the range; over it the stiffness bears the effort limit");
    key("stiffness", shortest(joint->limit->effort / (stop_width * range)));
    key("width", shortest(stop_width * range));
  }

  /// Writes the gear of a joint that follows another. Its offset is that of the coordinates at the start.
  void write_gear(const UrdfJoint& joint) {
    table("[[gear]]");
    std::string title = joint.name + "_gear";
    while (std::ranges::find(robot_.joints, title, &UrdfJoint::name) != robot_.joints.end()) title += "_";
    name("name", title);
    name("a", joint.mimic->joint);
    name("b", joint.name);
    key("ratio", shortest(joint.mimic->multiplier));
  }

  /// True if a body is joined to the link; an obstacle there would touch the body at its joint.
  bool carries_body(const UrdfLink& link) const {
    return std::ranges::any_of(groups_, [&](const UrdfGroup& group) {
      return group.joint && group.joint->kind != UrdfJointKind::floating && group.joint->parent == link.name;
    });
  }

  void write_obstacles() {
    std::set<std::string> names;
    for (const auto& [link, joint, X_L] : groups_[urdf_ground].links)
      for (const UrdfShape& shape : link->shapes) {
        if (carries_body(*link)) {
          leave_out(shape, *link, "shape",
                    "as an obstacle it would touch the bodies joined to this link: move it to a link with "
                    "<inertial>");
          continue;
        }
        std::string title = link->name;
        for (int i = 2; names.contains(title); ++i) title = link->name + "_" + std::to_string(i);
        const Pose X = X_L * shape.X_L;
        if (shape.kind == UrdfShapeKind::mesh) {
          if (!write_mesh(shape, *link, title, X)) continue;
        } else {
          if (!is_solid(shape, *link)) continue;
          write_solid("[[obstacle]]", title, shape, X);
        }
        names.insert(title);
      }
    num_obstacles_ = names.size();
  }

  /// Writes a mesh obstacle if the scene can read its file; otherwise leaves it out.
  bool write_mesh(const UrdfShape& shape, const UrdfLink& link, const std::string& title, const Pose& X) {
    namespace fs = std::filesystem;
    const std::string which = mesh_of(shape);
    const fs::path scene = fs::absolute(scene_folder_).lexically_normal();
    const fs::path file = fs::absolute(fs::path(log_.file())).parent_path() / shape.file;
    const std::string from_scene = file.lexically_normal().lexically_relative(scene).string();
    const FilePath found = path_below(scene_folder_, from_scene);
    const bool is_plain = shape.file.find("://") == std::string::npos &&
                          printable(from_scene) == from_scene && from_scene.find('\'') == std::string::npos;
    if (!is_plain || found.path.empty())
      return leave_out(shape, link, which,
                       "put it into the folder of the scene, and name it by its path from there");
    if (shape.size.maxCoeff() != shape.size.minCoeff())
      return leave_out(shape, link, which, "its scales differ: scale the file itself");
    ObstacleConfig obstacle;
    obstacle.shape.kind = ShapeKind::mesh;
    obstacle.scale = shape.size.x();
    if (const std::string why_not = load_file(found.path, obstacle); !why_not.empty())
      return leave_out(shape, link, which, printable(why_not));
    write_solid("[[obstacle]]", title, shape, X);
    key("file", "'" + from_scene + "'");
    if (shape.size.x() != 1) key("scale", shortest(shape.size.x()));
    return true;
  }

  void write_contact() {
    if (num_obstacles_ == 0 && shaped_tools_.size() < 2) return;  // nothing can meet
    double mass = 0;
    for (std::size_t i = urdf_ground + 1; i < groups_.size(); ++i) mass += groups_[i].mass;
    table("[[contact]]");
    comment("chosen: the weight of all bodies presses one sphere in by 0.1 mm");
    key("materials", "[\"default\", \"default\"]");
    key("stiffness", shortest(mass * standard_gravity / depth_of_weight));
  }

  const UrdfRobot& robot_;
  const std::vector<UrdfGroup>& groups_;
  std::string scene_folder_;
  Diagnostics& log_;
  std::set<std::size_t> shaped_tools_;
  std::size_t num_obstacles_ = 0;
  std::string out_;
};

}  // namespace

std::string scene_of_urdf(const UrdfRobot& robot, const std::vector<UrdfGroup>& groups,
                          const std::string& scene_folder, Diagnostics& log) {
  return UrdfScene(robot, groups, scene_folder, log).write();
}

}  // namespace godobject
