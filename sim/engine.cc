#include "sim/engine.h"

#include <algorithm>
#include <optional>

#include "sim/engine_of.h"

namespace godobject {
namespace {

/// Adding a composition: one file engine_<what>.cc and one line here.
std::vector<CompositionRow> table() {
  std::vector<CompositionRow> rows;
  add_free(rows);
  add_pose(rows);
  add_haptic(rows);
  add_relative(rows);
  add_admittance(rows);
  add_free_joints(rows);
  add_pose_joints(rows);
  add_haptic_joints(rows);
  add_haptic_stops(rows);
  std::stable_sort(rows.begin(), rows.end(), [](const CompositionRow& a, const CompositionRow& b) {
    return a.composition.bytes() < b.composition.bytes();
  });
  return rows;
}

bool is_haptic(const FeedbackConfig& f) {
  return f.stiffness > 0 || f.damping > 0 || f.rotational_stiffness > 0 || f.rotational_damping > 0;
}

/// What a scene asks of a composition.
struct Needs {
  bool coupling = false, feedback = false, joints = false, stops = false, imposed = false;
  std::optional<DeviceKind> kind;  // absent: no device
};

Needs needs_of(const SceneConfig& scene) {
  const auto any_body = [&](auto has) { return std::ranges::any_of(scene.bodies, has); };
  const auto any_joint = [&](auto has) { return std::ranges::any_of(scene.joints, has); };
  const DeviceKind kind = scene.device ? scene.device->kind : DeviceKind::non_haptic;
  Needs needs;
  needs.coupling = any_body([](const BodyConfig& b) { return b.coupling.has_value(); });
  needs.feedback = kind != DeviceKind::non_haptic &&
                   any_body([](const BodyConfig& b) { return b.feedback && is_haptic(*b.feedback); });
  needs.joints = !scene.joints.empty();
  needs.stops = any_joint([](const JointConfig& j) { return !j.stops.empty(); });
  needs.imposed = any_joint([](const JointConfig& j) { return j.imposed; });
  if (needs.coupling || needs.imposed || kind == DeviceKind::admittance) needs.kind = kind;
  return needs;
}

bool gives_a_pose(DeviceKind kind) { return kind == DeviceKind::impedance || kind == DeviceKind::non_haptic; }

/// All but the number of bodies.
bool has_parts_for(const Composition& c, const Needs& needs, const SceneConfig& scene) {
  if (c.integrator != scene.integrator) return false;
  if (needs.kind) {
    const bool same_kind = gives_a_pose(*needs.kind) ? gives_a_pose(c.kind) : c.kind == *needs.kind;
    if (!c.device || !same_kind) return false;
  }
  return (c.coupling || !needs.coupling) && (c.feedback || !needs.feedback) && (c.joints || !needs.joints) &&
         (c.stops || !needs.stops) && (c.imposed || !needs.imposed);
}

std::string why_none(const Needs& needs, const SceneConfig& scene) {
  std::size_t most = 0;
  for (const Composition& c : compositions())
    if (has_parts_for(c, needs, scene)) most = std::max(most, c.max_bodies);
  std::string parts;
  const auto add = [&](bool needed, const std::string& what) {
    if (needed) parts += (parts.empty() ? "" : ", ") + what;
  };
  add(needs.kind.has_value(),
      std::string("a device of kind '") +
          device_kind_names[static_cast<std::size_t>(needs.kind.value_or(DeviceKind::non_haptic))] + "'");
  add(needs.coupling, "couplings");
  add(needs.feedback, "feedback");
  add(needs.joints, "joints");
  add(needs.stops, "stops");
  add(needs.imposed, "imposed joints");
  const std::string what = "integrator '" + scene.integrator + "' and the parts of scene '" + scene.name +
                           "' (" + (parts.empty() ? "free bodies" : parts) + ")";
  if (most == 0) return "no compiled composition has " + what;
  return "no compiled composition with " + what + " has room for " + std::to_string(scene.bodies.size()) +
         " bodies; the largest holds " + std::to_string(most);
}

/// For rules that a scene file cannot break this is a bug of the reader.
std::string complaint(Invalid rule) {
  switch (rule) {
    case Invalid::step_not_positive: return "the step must be above zero";
    case Invalid::too_many_bodies: return "the number of bodies is not within the composition's capacity";
    case Invalid::mass_not_positive: return "a mass is not above zero";
    case Invalid::inertia_not_positive: return "an inertia is not symmetric and positive definite";
    case Invalid::anisotropy_too_small: return "an anisotropy is below that of its inertia";
    case Invalid::gain_negative: return "a stiffness, damping, limit or ramp is negative or not finite";
    case Invalid::parent_not_before: return "a joint's parent does not stand before its child";
    case Invalid::joint_frame: return "the frame of a joint is not finite or not a rotation";
    case Invalid::stop: return "a stop has crossed ends, ends beyond half a turn, negative gains or no width";
    case Invalid::not_imposable: return "an imposed joint has no coordinates of its own";
    default: return "rule " + std::to_string(static_cast<int>(rule)) + " of core/setup.h is broken";
  }
}

}  // namespace

std::vector<Composition> compositions() {
  std::vector<Composition> all;
  for (const CompositionRow& r : table()) all.push_back(r.composition);
  return all;
}

std::unique_ptr<Engine> make_engine(const SceneConfig& scene, std::span<const BodySample> at_start,
                                    std::string& why_not) {
  const Needs needs = needs_of(scene);
  for (const CompositionRow& r : table()) {
    if (scene.bodies.size() > r.composition.max_bodies || !has_parts_for(r.composition, needs, scene))
      continue;
    const Invalid broken = r.check(scene);
    if (broken == Invalid::nothing) return r.make(scene, at_start, r.composition);
    why_not = "the core does not take scene '" + scene.name + "': " + complaint(broken);
    return nullptr;
  }
  why_not = why_none(needs, scene);
  return nullptr;
}

}  // namespace godobject
