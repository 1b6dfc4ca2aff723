// The device of scenes that are loaded at run time.
#pragma once

#include "core/godobject.h"
#include "platform/engine/engine.h"

namespace godobject {

/// Device of scenes that are loaded at run time: any of the core's device kinds, selected by a parameter. A
/// product with one device names that in its scene type and has no code for the others.
struct AnyDevice {
  enum class Kind : std::uint8_t { pose, holding, relative, admittance };
  struct Params : RelativeDevice::Params {
    Kind kind = Kind::pose;
  };
  using State = HoldingState;
  using CouplingInput = GripInput;
  /// Inputs of all kinds; `kind` selects the one that is read.
  struct Input {
    PoseDevice::Input pose;  // also of a device that grips bodies
    RelativeDevice::Input relative;
    AdmittanceDevice::Input admittance;
  };

  static CouplingInput coupling_input(const Params& par, const Input& in, const RigidBodyState& body, Real h,
                                      const State& x, Limited& limited) noexcept {
    switch (par.kind) {
      case Kind::pose: break;
      case Kind::holding: return HoldingDevice::coupling_input(par, in.pose, body, h, x, limited);
      case Kind::relative: return {RelativeDevice::coupling_input(par, in.relative, body, h, x, limited), {}};
      case Kind::admittance:
        return {AdmittanceDevice::coupling_input(par, in.admittance, body, h, x, limited), {}};
    }
    return {PoseDevice::coupling_input(par, in.pose, body, h, x, limited), {}};
  }
};

/// Checks the inputs of all kinds; unused ones keep their valid defaults.
inline Fault check(const AnyDevice::Input& in) noexcept {
  return check(in.pose) | check(in.relative) | check(in.admittance);
}

/// Returns the change of pose of a relative device since `before`.
inline RelativeDevice::Input increment(const BodySample& sample, const Target& before) noexcept {
  const RotationError turn = rotation_error(before.X_WD.q, sample.target.X_WD.q, Vec3::Zero());
  return {.dp_W = sample.target.X_WD.p - before.X_WD.p,
          .dphi_W = to_world(before.X_WD.q, turn.phi_B),
          .clutch = sample.clutch,
          .valid = sample.valid,
          .engaged = sample.engaged};
}

/// Sets the input of the device kind from the general sample.
inline void set_input(AnyDevice::Kind kind, const BodySample& sample, const Target& before,
                      AnyDevice::Input& in) noexcept {
  switch (kind) {
    case AnyDevice::Kind::pose:
    case AnyDevice::Kind::holding:
      in.pose = {.target = sample.target, .valid = sample.valid, .engaged = sample.engaged};
      return;
    case AnyDevice::Kind::relative: in.relative = increment(sample, before); return;
    case AnyDevice::Kind::admittance:
      in.admittance = {.F_WB = sample.F_WB, .valid = sample.valid, .engaged = sample.engaged};
      return;
  }
}

inline AnyDevice::Kind kind_of(const SceneConfig& scene) noexcept {
  switch (scene.device ? scene.device->kind : DeviceKind::non_haptic) {
    case DeviceKind::impedance:
    case DeviceKind::non_haptic: break;
    case DeviceKind::relative: return AnyDevice::Kind::relative;
    case DeviceKind::admittance: return AnyDevice::Kind::admittance;
  }
  return grips_bodies(scene) ? AnyDevice::Kind::holding : AnyDevice::Kind::pose;
}

}  // namespace godobject
