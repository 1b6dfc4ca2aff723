// Parameters of the core from a scene that was loaded at run time.
#pragma once

#include "core/setup.h"
#include "platform/engine/any_device.h"
#include "platform/scene/joint/joints.h"

namespace godobject {

template <class Joints>
typename Joints::Params joint_params_of(const SceneConfig& scene, const JointConfig& joint) {
  typename Joints::Params par;
  static_cast<JointParams&>(par) = joint_params(scene.bodies, joint);
  if constexpr (uses<typename Joints::Stops>) {
    for (const StopConfig& stop : joint.stops)
      for (std::size_t i = 0; i < joint.coordinates.size(); ++i)
        if (joint.coordinates[i] == stop.coordinate) par.stop.stops[i] = stop.params;
  }
  if constexpr (uses<typename Joints::Prescribed>) par.motion.prescribed = joint.prescribed;
  return par;
}

/// Returns a coupling so stiff that an implicit step ends within 1e-9 of the body's distance from its
/// target.
inline SpringParams rigid_spring(const RigidBodyParams& body, Real h) noexcept {
  constexpr Real stiff = 1e9;
  return {.k = stiff * body.m / (h * h),
          .g = 0,
          .k_r = stiff * principal_moments(body.I_B).z() / (h * h),
          .g_r = 0};
}

inline Real ramp_of(const SceneConfig& scene, const LimitConfig& limits) {
  if (!scene.device || scene.coupling == CouplingMode::imposed) return 0;
  return grips_bodies(scene) ? limits.grab_ramp : limits.ramp;
}

template <Scene S>
Params<S> params_of(const SceneConfig& scene) {
  Params<S> par;
  par.h = scene.step;
  par.num_bodies = scene.bodies.size();
  par.gravity_W = scene.gravity;
  const LimitConfig limits = scene.device ? scene.device->limits : LimitConfig{};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyConfig& body = scene.bodies[i];
    par.bodies[i].body = rigid_body(body.mass, body.inertia);
    const bool imposed = scene.coupling == CouplingMode::imposed && body.coupling;
    par.bodies[i].coupling =
        imposed ? rigid_spring(par.bodies[i].body, par.h) : body.coupling.value_or(SpringParams{});
    par.bodies[i].feedback = {.gains = displayed_gains(scene, body),
                              .max_force = limits.force,
                              .max_torque = limits.torque,
                              .max_force_rate = limits.force_rate,
                              .max_torque_rate = limits.torque_rate};
    par.bodies[i].device.kind = kind_of(scene);
    par.bodies[i].device.rise = ramp_of(scene, limits);
    par.bodies[i].device.display_ratio = scene.device ? scene.device->display_ratio : 1;
    if (scene.device && scene.device->rig) par.bodies[i].device.stale = scene.device->rig->stale_after_s;
  }
  if constexpr (uses<typename S::Joints>) {
    for (const JointConfig& joint : scene.joints)
      par.bodies[*body_named(scene, joint.child)].joint = joint_params_of<typename S::Joints>(scene, joint);
  }
  return par;
}

/// Returns the share of a named coordinate.
inline CoordinateShare share_of(const SceneConfig& scene, const std::string& name, Real ratio) {
  const CoordinateOfJoint q = coordinate_named(scene, name);
  return {.body = static_cast<std::uint32_t>(*body_named(scene, q.joint->child)),
          .c = static_cast<int>(q.number),
          .ratio = ratio};
}
inline std::uint32_t end_of(const SceneConfig& scene, const std::string& body) {
  const std::optional<std::size_t> i = body_named(scene, body);
  return i ? static_cast<std::uint32_t>(*i) : TermEnds::on_world;
}

/// Sets springs, gears and springs of joints, closing joints, and forces, which are the kinds of ToolTerms.
template <class Terms>
void set_terms(const SceneConfig& scene, Terms& terms) {
  const auto add = [](auto& of, const auto& one) { of.list.at(of.size++) = one; };
  for (const SpringConfig& s : scene.springs)
    add(terms.template of<0>(), DampedSpringParams{.a = {.on = end_of(scene, s.a), .p = s.p_A},
                                                   .b = {.on = end_of(scene, s.b), .p = s.p_B},
                                                   .k = s.k,
                                                   .g = s.g,
                                                   .l_0 = s.rest_length.value_or(0)});
  for (const GearConfig& g : scene.gears)
    add(terms.template of<1>(),
        CoordinateSpringParams{.of = {{share_of(scene, g.a, -g.ratio), share_of(scene, g.b, 1)}},
                               .size = 2,
                               .y_0 = g.offset.value_or(0),
                               .k = g.stiffness.value_or(0),
                               .g = g.damping,
                               .is_rigid = !g.stiffness});
  for (const JointConfig& joint : scene.joints)
    for (const JointSpringConfig& s : joint.springs)
      add(terms.template of<1>(),
          CoordinateSpringParams{
              .of = {{share_of(scene, s.coordinate, 1), {}}}, .size = 1, .y_0 = s.rest, .k = s.k, .g = s.g});
  for (const JointConfig& joint : scene.loops)
    add(terms.template of<2>(), LoopJointParams{.kind = joint.kind,
                                                .a = end_of(scene, joint.parent),
                                                .b = end_of(scene, joint.child),
                                                .P = joint_frame(joint.X_BP),
                                                .C = joint_frame(joint.X_BC)});
  for (const ForceConfig& f : scene.forces)
    add(terms.template of<3>(),
        ConstantForceParams{.at = {.on = end_of(scene, f.body), .p = f.p_B}, .F_W = f.F_W});
}

}  // namespace godobject
