#include "tests/study/peer/scene_file.h"

#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/oracle/target.h"

namespace godobject::study {
namespace {

using nlohmann::json;

json wxyz_of(const oracle::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }
json pose_json(const oracle::RigidState& x) { return {{"p", list_of(x.p)}, {"q", wxyz_of(x.q)}}; }
json state_json(const oracle::RigidState& x) {
  json state = pose_json(x);
  state["v"] = list_of(x.v);
  state["w"] = list_of(x.w);
  return state;
}

json body_json(const oracle::Body& body) {
  json result{{"m", body.m}, {"I", list_of(body.I_B.diagonal())}, {"start", state_json(body.start)}};
  if (const auto& c = body.coupling)
    result["coupling"] = {{"k", c->k_t}, {"g", c->g_t}, {"k_r", c->k_r}, {"g_r", c->g_r}};
  return result;
}

const char* type_name(oracle::JointType type) {
  switch (type) {
    case oracle::JointType::ball: return "ball";
    case oracle::JointType::hinge: return "hinge";
    case oracle::JointType::cylindrical: return "cylindrical";
    case oracle::JointType::universal: return "universal";
    default:
      throw std::invalid_argument("a scene for the peers has a joint that scene_file.cc does not write");
  }
}

json joint_json(const oracle::Joint& joint) {
  return {{"type", type_name(joint.type)},
          {"parent", joint.parent ? json(*joint.parent) : json()},
          {"child", joint.child},
          {"anchor_P", list_of(joint.anchor_P)},
          {"anchor_C", list_of(joint.anchor_C)},
          {"axis_P", list_of(joint.axis_P)},
          {"axis_C", list_of(joint.axis_C)}};
}

json case_json(const std::string& name, const oracle::Case& problem, double duration) {
  json result{{"name", name}, {"duration", duration}, {"from", 0.0}, {"gravity", list_of(problem.gravity)}};
  result["bodies"] = result["joints"] = result["instants"] = json::array();
  for (const oracle::Body& body : problem.bodies) result["bodies"].push_back(body_json(body));
  for (const oracle::Joint& joint : problem.joints) result["joints"].push_back(joint_json(joint));
  return result;
}

/// Returns poses of the reference, if any, and targets of the coupled bodies.
json instant_json(const oracle::Case& problem, double t, const std::vector<oracle::RigidState>& reference) {
  json instant{{"t", t}, {"poses", json::array()}, {"targets", json::array()}};
  for (const oracle::RigidState& x : reference) instant["poses"].push_back(pose_json(x));
  for (const oracle::Body& body : problem.bodies)
    if (body.coupling) instant["targets"].push_back(state_json(body.coupling->target->at(t)));
  return instant;
}

void write_json(const std::filesystem::path& file, const json& content) {
  std::ofstream out(file);
  out << content << '\n';
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace

json list_of(const oracle::Vector3d& a) { return {a.x(), a.y(), a.z()}; }

void write_scene(const std::filesystem::path& file, const ReferenceScene& scene,
                 const oracle::Solution& reference) {
  json content = case_json(scene.name, scene.problem, scene.duration);
  content["from"] = scene.from;
  for (std::size_t n = 0; n < reference.times.size(); ++n)
    content["instants"].push_back(instant_json(scene.problem, reference.times[n], reference.states[n]));
  write_json(file, content);
}

void write_scene(const std::filesystem::path& file, const bench::ContactScene& scene) {
  constexpr double between_targets = 0.1;  // s
  json content = case_json(scene.name, scene.problem, scene.duration);
  json contact{{"radius", scene.radius}, {"mu", scene.law.mu}, {"k", scene.law.k}, {"c", scene.law.c}};
  contact["centres"] = json::array();
  for (const Vec3& centre : scene.centres) contact["centres"].push_back(list_of(centre));
  if (scene.half_extents) contact["half_extents"] = list_of(*scene.half_extents);
  content["contact"] = contact;
  for (double t = 0; t <= scene.duration; t += between_targets)
    content["instants"].push_back(instant_json(scene.problem, t, {}));
  write_json(file, content);
}

}  // namespace godobject::study
