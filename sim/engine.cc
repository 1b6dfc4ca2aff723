#include "sim/engine.h"

#include <algorithm>

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
  std::stable_sort(rows.begin(), rows.end(), [](const CompositionRow& a, const CompositionRow& b) {
    return a.composition.bytes() < b.composition.bytes();
  });
  return rows;
}

bool is_haptic(const FeedbackConfig& f) {
  return f.stiffness > 0 || f.damping > 0 || f.rotational_stiffness > 0 || f.rotational_damping > 0;
}

bool covers(const Composition& c, const SceneConfig& scene) {
  const auto any_body = [&](auto has) { return std::any_of(scene.bodies.begin(), scene.bodies.end(), has); };
  const bool coupled = any_body([](const BodyConfig& b) { return b.coupling.has_value(); });
  const bool haptic = any_body([](const BodyConfig& b) { return b.feedback && is_haptic(*b.feedback); });
  const DeviceKind kind = scene.device ? scene.device->kind : DeviceKind::non_haptic;
  const bool pose_kind = kind == DeviceKind::impedance || kind == DeviceKind::non_haptic;
  const bool same_kind =
      pose_kind ? c.kind == DeviceKind::impedance || c.kind == DeviceKind::non_haptic : c.kind == kind;
  const bool needs_device = coupled || kind == DeviceKind::admittance;
  if (c.integrator != scene.integrator || scene.bodies.size() > c.max_bodies) return false;
  if (needs_device && !(c.device && same_kind)) return false;
  if (coupled && !c.coupling) return false;
  return !(haptic && kind != DeviceKind::non_haptic) || c.feedback;
}

}  // namespace

std::vector<Composition> compositions() {
  std::vector<Composition> all;
  for (const CompositionRow& r : table()) all.push_back(r.composition);
  return all;
}

std::unique_ptr<Engine> make_engine(const SceneConfig& scene, std::span<const BodySample> at_start,
                                    std::string& why_not) {
  for (const CompositionRow& r : table())
    if (covers(r.composition, scene)) return r.make(scene, at_start, r.composition);
  why_not = "no compiled composition has integrator '" + scene.integrator + "', " +
            std::to_string(scene.bodies.size()) + " bodies and the parts of scene '" + scene.name + "'";
  return nullptr;
}

}  // namespace godobject
