// Device of scenes that are loaded at run time: any of the core's device kinds, selected by a parameter. A
// product with one device names that in its scene type and has no code for the others.
#pragma once

#include "core/godobject.h"

namespace godobject {

struct AnyDevice {
  enum class Kind : std::uint8_t { pose, holding, relative, admittance };
  struct Params : RampParams {
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

}  // namespace godobject
