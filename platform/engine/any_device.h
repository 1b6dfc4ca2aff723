// The device of scenes that are chosen at run time: each of the core's kinds of devices, which one a parameter says. A
// product with one device names that in its scene type, and carries nothing of the others.
#pragma once

#include "core/godobject.h"

namespace godobject {

struct AnyDevice {
  enum class Kind : std::uint8_t { pose, holding, relative, admittance };
  struct Params : RampParams {
    Kind kind = Kind::pose;
  };
  using State = HoldingState;
  using Pull = HoldingPull;
  /// The input of every kind; those that `kind` does not read do not matter.
  struct Input {
    PoseDevice::Input pose;  // of a device that takes hold, too
    RelativeDevice::Input relative;
    AdmittanceDevice::Input admittance;
  };

  static Pull pull(const Params& par, const Input& in, const RigidBodyState& body, Real h, const State& x,
                   Limited& limited) noexcept {
    switch (par.kind) {
      case Kind::pose: break;
      case Kind::holding: return HoldingDevice::pull(par, in.pose, body, h, x, limited);
      case Kind::relative: return {RelativeDevice::pull(par, in.relative, body, h, x, limited), {}};
      case Kind::admittance: return {AdmittanceDevice::pull(par, in.admittance, body, h, x, limited), {}};
    }
    return {PoseDevice::pull(par, in.pose, body, h, x, limited), {}};
  }
};

/// All of them are checked: what a kind does not read stays at its defaults, which are good.
inline Fault check(const AnyDevice::Input& in) noexcept {
  return check(in.pose) | check(in.relative) | check(in.admittance);
}

}  // namespace godobject
