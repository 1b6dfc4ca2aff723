#include "tests/oracle/case/reference_case.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "tests/oracle/case/csv_table.h"

namespace godobject::oracle {

namespace {

using nlohmann::json;

Vector3d vector3(const json& numbers) {
  const auto values = numbers.get<std::array<double, 3>>();
  return {values[0], values[1], values[2]};
}

Quaterniond quaternion_wxyz(const json& numbers) {
  const auto values = numbers.get<std::array<double, 4>>();
  return Quaterniond(values[0], values[1], values[2], values[3])
      .normalized();  // the files round to 12 digits
}

Body body_from(const json& description) {
  Body body;
  body.name = description.at("name").get<std::string>();
  body.m = description.at("mass").get<double>();
  body.I_B = vector3(description.at("inertia")).asDiagonal();
  body.start.p = vector3(description.at("position"));
  body.start.q = quaternion_wxyz(description.at("orientation_wxyz"));
  body.start.v = vector3(description.at("velocity"));
  body.start.w = vector3(description.at("angular_velocity"));
  return body;
}

Coupling coupling_from(const json& description) {
  Coupling coupling;
  coupling.k_t = description.at("stiffness").get<double>();
  coupling.g_t = description.at("damping").get<double>();
  coupling.k_r = description.at("rotational_stiffness").get<double>();
  coupling.g_r = description.at("rotational_damping").get<double>();
  return coupling;
}

JointType joint_type(const std::string& name) {
  static const std::map<std::string, JointType> types = {
      {"fixed", JointType::fixed},         {"ball", JointType::ball},
      {"hinge", JointType::hinge},         {"slider", JointType::slider},
      {"universal", JointType::universal}, {"cylindrical", JointType::cylindrical}};
  const auto found = types.find(name);
  if (found == types.end())
    throw std::runtime_error("the oracle does not know joints of type '" + name + "'");
  return found->second;
}

std::size_t index_of(const std::string& name, const std::vector<Body>& bodies) {
  const auto found =
      std::find_if(bodies.begin(), bodies.end(), [&](const Body& b) { return b.name == name; });
  if (found == bodies.end())
    throw std::runtime_error("a joint names the body '" + name + "', which is not there");
  return static_cast<std::size_t>(found - bodies.begin());
}

/// Anchors that are not given are at the origin. "axis" is one vector for both bodies: their axes are
/// parallel if the joint's coordinate is zero.
Joint joint_from(const json& description, const std::vector<Body>& bodies) {
  const auto type = description.at("type").get<std::string>();
  const auto child = description.at("child").get<std::string>();
  const auto parent = description.at("parent").get<std::string>();
  const auto read = [&](const char* key, Vector3d& value) {
    if (description.contains(key)) value = vector3(description.at(key));
  };
  Joint joint;
  joint.name = type + " of " + child;
  joint.type = joint_type(type);
  joint.child = index_of(child, bodies);
  if (parent != "world") joint.parent = index_of(parent, bodies);
  read(joint.parent ? "anchor_in_parent" : "anchor_in_world", joint.anchor_P);
  if (!joint.parent) read("anchor_in_parent", joint.anchor_P);
  read("anchor_in_child", joint.anchor_C);
  read("axis", joint.axis_P);
  read("axis_in_parent", joint.axis_P);
  read("axis_in_child", joint.axis_C);
  return joint;
}

std::vector<Vector3d> vectors(const CsvTable& table, const std::string& x, const std::string& y,
                              const std::string& z) {
  const std::vector<double> xs = table.column(x), ys = table.column(y), zs = table.column(z);
  std::vector<Vector3d> result;
  for (std::size_t i = 0; i < table.num_rows(); ++i) result.emplace_back(xs[i], ys[i], zs[i]);
  return result;
}

std::vector<Vector3d> positions(const CsvTable& table, const std::string& body) {
  return vectors(table, body + ".x", body + ".y", body + ".z");
}

std::vector<Quaterniond> attitudes(const CsvTable& table, const std::string& body) {
  const std::vector<double> ws = table.column(body + ".qw");
  const std::vector<Vector3d> n = vectors(table, body + ".qx", body + ".qy", body + ".qz");
  std::vector<Quaterniond> result;
  for (std::size_t i = 0; i < table.num_rows(); ++i) result.emplace_back(ws[i], n[i].x(), n[i].y(), n[i].z());
  return result;
}

ReferenceCase read_case(const std::filesystem::path& folder) {
  std::ifstream stream(folder / "case.json");
  if (!stream) throw std::runtime_error((folder / "case.json").string() + ": cannot be read");
  const json description = json::parse(stream);
  if (description.contains("contact")) {
    throw std::runtime_error(folder.string() + ": the oracle does not solve cases with contact");
  }
  ReferenceCase loaded;
  loaded.about = description.at("about").get<std::string>();
  loaded.duration = description.at("duration").get<double>();
  loaded.problem.gravity = vector3(description.at("gravity"));
  for (const json& body_description : description.at("bodies")) {
    Body body = body_from(body_description);
    const json& couplings = description.at("coupling");
    if (couplings.contains(body.name)) {
      body.coupling = coupling_from(couplings.at(body.name));
      body.coupling->target = load_motion(folder / "motion.csv", body.name);
    }
    loaded.problem.bodies.push_back(body);
  }
  for (const json& joint : description.value("joints", json::array())) {
    loaded.problem.joints.push_back(joint_from(joint, loaded.problem.bodies));
  }
  loaded.expected = load_solution(folder / "reference.csv", loaded.problem.bodies);
  return loaded;
}

}  // namespace

std::shared_ptr<const Target> load_motion(const std::filesystem::path& file, const std::string& body) {
  const CsvTable table(file);
  return std::make_shared<TabulatedTarget>(table.column("t"), positions(table, body), attitudes(table, body));
}

Solution load_solution(const std::filesystem::path& file, const std::vector<Body>& bodies) {
  const CsvTable table(file);
  Solution solution;
  solution.times = table.column("t");
  solution.states.resize(table.num_rows());
  for (const Body& body : bodies) {
    const std::vector<Vector3d> p = positions(table, body.name);
    const std::vector<Quaterniond> q = attitudes(table, body.name);
    const std::vector<Vector3d> v = vectors(table, body.name + ".vx", body.name + ".vy", body.name + ".vz");
    const std::vector<Vector3d> w = vectors(table, body.name + ".wx", body.name + ".wy", body.name + ".wz");
    for (std::size_t i = 0; i < table.num_rows(); ++i) solution.states[i].push_back({p[i], q[i], v[i], w[i]});
  }
  return solution;
}

ReferenceCase load_reference_case(const std::filesystem::path& folder) {
  try {
    return read_case(folder);
  } catch (const json::exception& error) {
    throw std::runtime_error((folder / "case.json").string() + ": " + error.what());
  }
}

}  // namespace godobject::oracle
