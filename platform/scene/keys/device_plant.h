// Keys of the mechanics of the device, and of its compensation by the drives.
#pragma once

#include "platform/scene/keys/hand.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

/// Default mechanics of a slider, equal to those of a hinge of 1e-3 kg m^2 and 1e-2 N m s/rad on a lever of
/// 0.1 m. The arm has about 500 N/m.
inline constexpr JointPlant plant_of_sliders{
    .inertia = 0.1, .damping = 1, .friction = 0.01, .hand_stiffness = 500, .hand_damping = 10};

inline bool is_slider(const DeviceJoint& joint) { return joint.kind == DeviceJointKind::slider; }

/// otherwise: text of the default of each of the five keys.
template <class V>
void visit_joint_plant(V& v, const std::array<std::string_view, 5>& otherwise, JointPlant& p) {
  std::size_t i = 0;
  const auto value = [&](std::string_view name, std::string_view unit, std::string_view meaning, Range range,
                         double& x) {
    v.value(Key{.name = name, .unit = unit, .meaning = meaning, .range = range, .otherwise = otherwise[i++]},
            x);
  };
  value("inertia", "kg m^2 or kg", "inertia or mass, seen at the joint", positive, p.inertia);
  value("damping", "N m s/rad or N s/m",
        "without the hand; state it for a real device too: the margins of `godobject check` depend on it",
        not_negative, p.damping);
  value("friction", "N m or N", "Coulomb friction", not_negative, p.friction);
  value("hand_stiffness", "N m/rad or N/m", "of the user's arm", not_negative, p.hand_stiffness);
  value("hand_damping", "N m s/rad or N s/m", "of the user's arm", not_negative, p.hand_damping);
}

/// Returns the mechanics of a device whose file has none; slides have defaults of their own.
inline PlantConfig default_plant(const std::vector<DeviceJoint>& joints) {
  PlantConfig plant;
  if (!joints.empty() && std::ranges::all_of(joints, is_slider)) {
    static_cast<JointPlant&>(plant) = plant_of_sliders;
    return plant;
  }
  for (const DeviceJoint& joint : joints)
    if (is_slider(joint)) plant.joints.push_back({.joint = joint.name, .plant = plant_of_sliders});
  return plant;
}

/// Copies values given for all joints to the joints with defaults of their kind.
template <class V>
void take_numbers_of_all(const V& v, PlantConfig& p) {
  const auto take = [&](std::string_view key, double JointPlant::*x) {
    if (!v.has(key)) return;
    for (PlantConfig::OfJoint& of_slide : p.joints) of_slide.plant.*x = p.*x;
  };
  take("inertia", &JointPlant::inertia);
  take("damping", &JointPlant::damping);
  take("friction", &JointPlant::friction);
  take("hand_stiffness", &JointPlant::hand_stiffness);
  take("hand_damping", &JointPlant::hand_damping);
}

/// Warns of one value for turns and slides, whose units differ.
/// own: joints with a table of their own.
template <class V>
void advise_on_units(V& v, const std::vector<DeviceJoint>& joints,
                     const std::vector<PlantConfig::OfJoint>& own) {
  if (std::ranges::all_of(joints, is_slider)) return;
  for (const DeviceJoint& joint : joints) {
    if (!is_slider(joint) || std::ranges::find(own, joint.name, &PlantConfig::OfJoint::joint) != own.end())
      continue;
    for (const char* const key : {"inertia", "damping", "friction"})
      v.advise(!v.has(key), key,
               "is one number for turns and for the slide '" + joint.name +
                   "', which have different units: give the slide a [[device.plant.joint]] table");
  }
}

/// p: default_plant(), or the result of an earlier visit.
template <class V>
void visit_plant(V& v, const std::vector<DeviceJoint>& joints, PlantConfig& p) {
  visit_joint_plant(v,
                    {"0.001, of a slide 0.1", "0.01, of a slide 1.0", "0.001, of a slide 0.01",
                     "20.0, of a slide 500.0", "0.5, of a slide 10.0"},
                    p);
  take_numbers_of_all(v, p);
  v.value(Key{"gravity", "m/s^2", "on the links that have a mass, world axes"}, p.gravity_W);
  v.value(Key{"hand_homes", "",
              "before the motion the hand brings incremental sensors to their `home` and presses the button"},
          p.hand_homes);
  std::vector<std::string> names;
  for (const DeviceJoint& joint : joints) names.push_back(joint.name);
  std::vector<PlantConfig::OfJoint> own = p.joints;
  v.tables(TableKey{"joint", "The same of one joint."}, own, [&](auto& t, PlantConfig::OfJoint& j) {
    choose(t, Key{.name = "joint", .unit = "", .meaning = "", .required = true}, names, j.joint);
    if constexpr (requires { t.keys_of("", "", ""); })
      return t.keys_of("[device.plant]", "inertia", "hand_damping");
    j.plant = p.of(j.joint);
    constexpr std::string_view as_all = "as `[device.plant]`";
    visit_joint_plant(t, {as_all, as_all, as_all, as_all, as_all}, j.plant);
    t.check(j.joint.empty() || std::ranges::count(own, j.joint, &PlantConfig::OfJoint::joint) == 1, "joint",
            "has an earlier table");
  });
  advise_on_units(v, joints, own);
  for (const PlantConfig::OfJoint& j : p.joints)
    if (std::ranges::find(own, j.joint, &PlantConfig::OfJoint::joint) == own.end()) own.push_back(j);
  p.joints = own;
}

/// Returns the speed of a joint from which the direction of its motion is certain: two counts a step.
inline double certain_speed(const RigParams& rig, const std::string& joint, double step_s) {
  const Calibration* const sensor = sensor_of(rig, joint);
  return 2 / ((sensor == nullptr ? 1 : sensor->counts_per_unit) * step_s);
}

/// plant: mechanics of the device, which the drives compensate.
template <class V>
void visit_compensation(V& v, const PlantConfig& plant, double step_s, RigParams* rig,
                        CompensationConfig& c) {
  v.value(Key{"gravity", "", "drives carry the links: masses of joints, gravity of `[device.plant]`"},
          c.gravity);
  v.value(Key{"friction", "", "share of the friction of `[device.plant]` that they overcome", {0, 1}},
          c.friction);
  v.value(Key{"inertia",
              "",
              "share of the inertia of `[device.plant]` that they move, counted by `check`",
              {0, CompensationConfig::max_inertia_share}},
          c.inertia);
  v.value(Key{"inertia_cutoff", "Hz", "of the acceleration that they follow", positive}, c.inertia_cutoff_Hz);
  v.value(Key{"ahead", "s", "handles are predicted over this time, the delay of bus and drives", {0, 0.1}},
          c.ahead_s);
  const bool has_drives = rig != nullptr && !rig->drives.empty();
  v.check(has_drives || (!c.gravity && c.friction == 0 && c.inertia == 0), "",
          "needs drives: add [[device.drive]]");
  v.check(rig != nullptr || c.ahead_s == 0, "ahead", "needs joints with encoders: add [[device.encoder]]");
  if (rig == nullptr) return;
  const bool has_weight =
      !plant.gravity_W.isZero() &&
      std::ranges::any_of(rig->tree.joints, [](const DeviceJoint& j) { return j.mass > 0; });
  v.check(!c.gravity || has_weight, "gravity",
          "has nothing to carry: give `mass` in [[device.joint]] and `gravity` in [device.plant]");
  v.check(c.inertia == 0 || rig->transmissions.empty(), "inertia",
          "moves joints with a drive of their own: remove it, or the [[device.transmission]]");
  CompensationParams& params = rig->compensation;
  params = {.gravity_W = c.gravity ? plant.gravity_W : Vec3::Zero(),
            .inertia_cutoff = 2 * pi * c.inertia_cutoff_Hz,
            .ahead_s = c.ahead_s};
  for (const DeviceJoint& joint : rig->tree.joints) {
    if (c.inertia > 0) params.inertia.push_back(c.inertia * plant.of(joint.name).inertia);
    if (c.friction == 0) continue;
    params.friction.push_back(c.friction * plant.of(joint.name).friction);
    params.certain_speed.push_back(certain_speed(*rig, joint.name, step_s));
  }
}

}  // namespace godobject
