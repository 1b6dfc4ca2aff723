// URDF as XML: elements and attributes, each checked by itself.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include <tinyxml2.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "platform/scene/mesh/file.h"
#include "platform/scene/text/key.h"
#include "platform/scene/urdf/urdf.h"

namespace godobject {
namespace {

using tinyxml2::XMLElement;

constexpr double moment_rounding = 1e-14;    // relative, of computed principal moments
constexpr double triangle_tolerance = 1e-6;  // relative; descriptions print six digits or more

TextPosition place_of(const XMLElement& e) {
  return {.line = static_cast<std::uint32_t>(e.GetLineNum()), .column = 1};
}

bool is_one_of(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::ranges::find(names, name) != names.end();
}

/// Returns the command that expands the xacro file of which `file` is, or should become, the description.
std::string xacro_command(const std::string& file) {
  const std::filesystem::path path(printable(file));
  if (path.extension() != ".xacro") return "xacro " + path.string() + ".xacro > " + path.string();
  std::filesystem::path to = path.parent_path() / path.stem();
  if (to.extension() != ".urdf") to += ".urdf";
  return "xacro " + path.string() + " > " + to.string();
}

class UrdfReader {
 public:
  explicit UrdfReader(Diagnostics& log) : log_(log) {}

  std::optional<UrdfRobot> read(std::string_view xml) {
    tinyxml2::XMLDocument document;
    if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS) {
      const auto line = static_cast<std::uint32_t>(std::max(document.ErrorLineNum(), 1));
      log_.error({.line = line, .column = 1}, "is not well-formed XML (" + std::string(document.ErrorName()) +
                                                  "): correct the element that begins on this line");
      return std::nullopt;
    }
    const XMLElement* const root = document.RootElement();
    if (root == nullptr || std::string_view(root->Name()) != "robot") {
      log_.error(root ? place_of(*root) : TextPosition{},
                 "begins with " + (root ? excerpt(root->Name()) : std::string("nothing")) +
                     ": a URDF has one root element <robot>");
      return std::nullopt;
    }
    if (refuse_xacro(*root)) return std::nullopt;
    robot_.name = attribute(*root, "name", "robot");
    for (const XMLElement* e = root->FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const std::string_view name = e->Name();
      if (name == "link") read_link(*e);
      else if (name == "joint") read_joint(*e);
      else leave_out(*e, is_one_of(name, {"material", "transmission", "gazebo", "ros2_control", "sensor"}));
    }
    return std::move(robot_);
  }

 private:
  void error(const XMLElement& e, const std::string& text) { log_.error(place_of(e), text); }

  /// True after an error if the element, or one below it, is of the macro language.
  bool refuse_xacro(const XMLElement& e) {
    bool is_macro = std::string_view(e.Name()).starts_with("xacro:");
    for (const tinyxml2::XMLAttribute* a = e.FirstAttribute(); a != nullptr; a = a->Next()) {
      const std::string_view value = a->Value();
      is_macro = is_macro || value.find("${") != value.npos || value.find("$(") != value.npos;
    }
    if (is_macro)
      error(e, "element <" + shortened(e.Name()) + "> is xacro, from which a URDF is made: run  " +
                   xacro_command(log_.file()) + "  and import the URDF");
    for (const XMLElement* c = e.FirstChildElement(); c != nullptr && !is_macro; c = c->NextSiblingElement())
      is_macro = refuse_xacro(*c);
    return is_macro;
  }

  /// Counts an element that scenes cannot express. known: URDF has such elements, so there is no warning.
  void leave_out(const XMLElement& e, bool known) {
    const std::string name = "<" + shortened(e.Name()) + ">";
    ++robot_.left_out[name];
    if (!known) log_.warning(place_of(e), "element " + name + " is left out: this program does not read it");
  }
  /// Ignores children with other names than these.
  void leave_out_others(const XMLElement& e, std::initializer_list<std::string_view> read,
                        std::initializer_list<std::string_view> known) {
    for (const XMLElement* c = e.FirstChildElement(); c != nullptr; c = c->NextSiblingElement())
      if (!is_one_of(c->Name(), read)) leave_out(*c, is_one_of(c->Name(), known));
  }

  /// Returns the child of this name; null without one. A second one is an error.
  const XMLElement* child(const XMLElement& e, const char* name, const std::string& owner) {
    const XMLElement* const found = e.FirstChildElement(name);
    if (const XMLElement* const second = found ? found->NextSiblingElement(name) : nullptr)
      error(*second, owner + " has a second <" + name + ">: remove one of them");
    return found;
  }
  std::string attribute(const XMLElement& e, const char* name, const std::string& owner) {
    if (const char* const text = e.Attribute(name); text != nullptr && *text != '\0') return text;
    error(e, owner + ": <" + std::string(e.Name()) + "> has no attribute '" + name + "': add it");
    return "";
  }
  /// Reads N numbers. fallback: without the attribute; none: the attribute is required.
  template <int N>
  Eigen::Matrix<double, N, 1> numbers(const XMLElement& e, const char* name, const std::string& owner,
                                      std::optional<Eigen::Matrix<double, N, 1>> fallback = {}) {
    Eigen::Matrix<double, N, 1> x = fallback.value_or(Eigen::Matrix<double, N, 1>::Ones());
    if (fallback && e.Attribute(name) == nullptr) return x;
    const std::string text = attribute(e, name, owner);
    if (text.empty()) return x;
    TextScanner words(text);
    bool good = true;
    for (int i = 0; i < N; ++i) {
      const std::optional<double> value = number_of<double>(words.word());
      good = good && value && std::isfinite(*value);
      if (good) x[i] = *value;
    }
    if (good && words.word().empty()) return x;
    error(e, owner + ": '" + name + "' of <" + e.Name() + "> is " + excerpt(text) + ": give " +
                 (N == 1 ? "one finite number" : "three finite numbers, separated by spaces"));
    return Eigen::Matrix<double, N, 1>::Ones();
  }
  double number(const XMLElement& e, const char* name, const std::string& owner,
                std::optional<double> fallback = {}) {
    using One = Eigen::Matrix<double, 1, 1>;
    return numbers<1>(e, name, owner, fallback ? std::optional<One>(One(*fallback)) : std::nullopt)[0];
  }
  double length(const XMLElement& e, const char* name, const std::string& owner) {
    const double x = number(e, name, owner);
    if (!(x > 0))
      error(e, owner + ": '" + name + "' of <" + e.Name() + "> is " + shortest_plain(x) + ": must be > 0");
    return x;
  }
  std::string plain_name(const XMLElement& e, const std::string& owner) {
    const std::string name = attribute(e, "name", owner);
    if (!name.empty() && !is_plain_name(name))
      error(e, owner + " has the name " + excerpt(name) +
                   ": rename it to one or more letters, digits, '_' or '-', which scenes require");
    return name;
  }

  /// Reads <origin>: the frame of an element in that of its parent.
  Pose origin(const XMLElement& e, const std::string& owner) {
    const XMLElement* const found = child(e, "origin", owner);
    if (found == nullptr) return {};
    const Vec3 rpy = numbers<3>(*found, "rpy", owner, Vec3(Vec3::Zero()));
    // R = R_z(yaw) R_y(pitch) R_x(roll)
    const Quat q = Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) *
                   Eigen::AngleAxisd(rpy.x(), Vec3::UnitX());
    return {.p = numbers<3>(*found, "xyz", owner, Vec3(Vec3::Zero())), .q = q.normalized()};
  }

  void read_inertial(const XMLElement& e, const std::string& owner, UrdfLink& link) {
    const XMLElement* const mass = child(e, "mass", owner);
    const XMLElement* const inertia = child(e, "inertia", owner);
    if (mass == nullptr) error(e, owner + ": <inertial> has no <mass value=\"...\"/>: add it, kg");
    if (inertia == nullptr)
      error(e, owner + ": <inertial> has no <inertia ixx=... izz=.../>: add it, kg m^2");
    if (mass == nullptr || inertia == nullptr) return;
    const Pose X = origin(e, owner);
    UrdfInertial read{.mass = number(*mass, "value", owner), .p_L = X.p, .I_L = {}};
    if (read.mass == 0) return;  // because frames and bases of arms are described so
    if (!mass_of_body.contains(read.mass))
      error(*mass, owner + " has a mass of " + shortest_plain(read.mass) + " kg: give " +
                       shortest_plain(mass_of_body.min) + " to " + shortest_plain(mass_of_body.max) +
                       " kg, or remove <inertial> if the link is fixed to another");
    Mat3 I;
    I(0, 0) = number(*inertia, "ixx", owner);
    I(1, 1) = number(*inertia, "iyy", owner);
    I(2, 2) = number(*inertia, "izz", owner);
    I(0, 1) = I(1, 0) = number(*inertia, "ixy", owner, 0);
    I(0, 2) = I(2, 0) = number(*inertia, "ixz", owner, 0);
    I(1, 2) = I(2, 1) = number(*inertia, "iyz", owner, 0);
    const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(I, Eigen::EigenvaluesOnly).eigenvalues();
    const std::string written = owner + " has principal moments of inertia " + shortest_plain(moments.x()) +
                                ", " + shortest_plain(moments.y()) + ", " + shortest_plain(moments.z()) +
                                " kg m^2, as no solid has: each must be above 0 and at most the sum of the "
                                "other two; correct ixx to izz, about the centre of mass";
    if (!(moments.x() > moment_rounding * moments.z())) error(*inertia, written);
    else if (moments.z() > (moments.x() + moments.y()) * (1 + triangle_tolerance))
      log_.warning(place_of(*inertia), written);  // as in scenes, because the equations hold
    const Mat3 R = X.q.toRotationMatrix();
    read.I_L = X.q.vec().isZero(0) ? I : Mat3(R * I * R.transpose());
    link.inertial = read;
  }

  /// Leaves out a sphere of radius 0, by which some descriptions mark a point of contact.
  void leave_out_point(const XMLElement& sphere, const std::string& owner) {
    ++robot_.left_out["<sphere> of radius 0"];
    log_.warning(
        place_of(sphere),
        owner + ": a sphere of radius 0 is left out; give it one, or add a [[body.sphere]] to the scene");
  }

  void read_shape(const XMLElement& e, const std::string& owner, UrdfLink& link) {
    leave_out_others(e, {"origin", "geometry"}, {"contact_coefficients", "verbose"});
    const XMLElement* const geometry = child(e, "geometry", owner);
    const XMLElement* const solid = geometry ? geometry->FirstChildElement() : nullptr;
    if (solid == nullptr) return error(e, owner + ": <collision> has no shape in <geometry>: add one");
    if (const XMLElement* const second = solid->NextSiblingElement())
      error(*second, owner + ": <geometry> has a second shape: give each a <collision> of its own");
    UrdfShape shape{.at = place_of(*solid), .X_L = origin(e, owner), .file = {}};
    const std::string_view kind = solid->Name();
    if (kind == "box") {
      shape.size = numbers<3>(*solid, "size", owner);
    } else if (kind == "sphere") {
      shape.kind = UrdfShapeKind::sphere;
      if (number(*solid, "radius", owner) == 0) return leave_out_point(*solid, owner);
      shape.radius = length(*solid, "radius", owner);
    } else if (kind == "cylinder") {
      shape.kind = UrdfShapeKind::cylinder;
      shape.radius = length(*solid, "radius", owner);
      shape.length = length(*solid, "length", owner);
    } else if (kind == "mesh") {
      shape.kind = UrdfShapeKind::mesh;
      shape.file = attribute(*solid, "filename", owner);
      shape.size = numbers<3>(*solid, "scale", owner, Vec3(Vec3::Ones()));
    } else {
      return error(*solid, owner + " has a shape <" + shortened(kind) +
                               ">: use <box>, <sphere>, <cylinder> or <mesh>");
    }
    if (!(shape.size.minCoeff() > 0))
      error(*solid, owner + ": each number of a <" + std::string(kind) + "> must be > 0");
    link.shapes.push_back(shape);
  }

  void read_link(const XMLElement& e) {
    UrdfLink link{.at = place_of(e), .name = plain_name(e, "a link"), .inertial = {}, .shapes = {}};
    const std::string owner = "link " + excerpt(link.name);
    if (!link_names_.insert(link.name).second)
      error(e, owner + " has the name of an earlier link: rename one of them");
    if (const XMLElement* const inertial = child(e, "inertial", owner)) read_inertial(*inertial, owner, link);
    for (const XMLElement* c = e.FirstChildElement("collision"); c; c = c->NextSiblingElement("collision"))
      read_shape(*c, owner, link);
    leave_out_others(e, {"inertial", "collision"}, {"visual"});
    robot_.links.push_back(link);
  }

  void read_limit(const XMLElement& e, const std::string& owner, UrdfJoint& joint) {
    const XMLElement* const limit = child(e, "limit", owner);
    const bool turns = joint.kind == UrdfJointKind::revolute;
    if (limit == nullptr)
      return error(e, owner + " has no <limit>: add lower, upper and effort" +
                          (turns ? ", or use type=\"continuous\"" : ""));
    UrdfLimit read{.lower = number(*limit, "lower", owner, 0),
                   .upper = number(*limit, "upper", owner, 0),
                   .effort = number(*limit, "effort", owner)};
    const std::string unit = turns ? " rad" : " m";
    if (!(read.lower < read.upper))
      error(*limit, owner + " has limits from " + shortest_plain(read.lower) + " to " +
                        shortest_plain(read.upper) + unit +
                        ": lower must be below upper; a joint that does not move has type=\"fixed\"");
    if (!(read.effort > 0))
      error(*limit, owner + " has an effort limit of " + shortest_plain(read.effort) +
                        (turns ? " N m" : " N") +
                        ": must be > 0, because the joint's stops get their stiffness from it");
    if (limit->Attribute("velocity") != nullptr) ++robot_.left_out["velocity of <limit>"];
    joint.limit = read;
  }

  void read_joint(const XMLElement& e) {
    UrdfJoint joint;
    joint.at = place_of(e);
    joint.name = plain_name(e, "a joint");
    const std::string owner = "joint " + excerpt(joint.name);
    if (!joint_names_.insert(joint.name).second)
      error(e, owner + " has the name of an earlier joint: rename one of them");
    const std::string type = attribute(e, "type", owner);
    const auto kind = std::ranges::find(urdf_joint_kinds, type);
    if (kind != urdf_joint_kinds.end())
      joint.kind = static_cast<UrdfJointKind>(kind - urdf_joint_kinds.begin());
    else if (!type.empty())
      error(e, owner + " has the type " + excerpt(type) +
                   ", which scenes do not have: use revolute, continuous, prismatic, fixed or floating");
    for (const auto& [name, link] : {std::pair("parent", &joint.parent), std::pair("child", &joint.child)}) {
      if (const XMLElement* const end = child(e, name, owner)) *link = attribute(*end, "link", owner);
      else error(e, owner + " has no <" + name + " link=\"...\"/>: add it");
    }
    joint.X_PC = origin(e, owner);
    if (const XMLElement* const axis = child(e, "axis", owner)) {
      const Vec3 read = numbers<3>(*axis, "xyz", owner);
      if (read.norm() > 0) joint.axis_C = read.normalized();
      else error(*axis, owner + " has an axis of length zero: give a unit vector");
    }
    if (kind != urdf_joint_kinds.end() && is_one_of(type, {"revolute", "prismatic"}))
      read_limit(e, owner, joint);
    else if (e.FirstChildElement("limit") != nullptr) ++robot_.left_out["<limit> of other joints"];
    if (const XMLElement* const mimic = child(e, "mimic", owner))
      joint.mimic = UrdfMimic{.at = place_of(*mimic),
                              .joint = attribute(*mimic, "joint", owner),
                              .multiplier = number(*mimic, "multiplier", owner, 1),
                              .offset = number(*mimic, "offset", owner, 0)};
    leave_out_others(e, {"origin", "parent", "child", "axis", "limit", "mimic"},
                     {"dynamics", "calibration", "safety_controller"});
    robot_.joints.push_back(joint);
  }

  Diagnostics& log_;
  UrdfRobot robot_;
  std::set<std::string> link_names_, joint_names_;
};

}  // namespace

std::optional<UrdfRobot> read_urdf(std::string_view xml, Diagnostics& log) {
  return UrdfReader(log).read(xml);
}

}  // namespace godobject
