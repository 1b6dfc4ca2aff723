// What the hand feels of a body that the device has taken hold of.
#pragma once

#include "core/device/feedback.h"

namespace godobject {

/// (9)  The held body's feedback acts at its target, the hand at the device's origin. What changes when a body is taken or
/// let go stays within the limits of size and rate.
struct HeldFeedback {
  using Params = FeedbackParams;  // limits; the gains are the body's own
  struct State {
    LimitedFeedback::State shown;
    Vec3 lever_W = Vec3::Zero();  // from the device's origin to the target
  };

  /// To be called once a step. Wrench on the hand about the device's origin, world axes. F_W: of the held body at the
  /// target's origin p_WT; null while nothing is held. valid: p_WD is a good sample; otherwise the last lever holds.
  static Wrench show(const Params& par, const Wrench* F_W, const Vec3& p_WT, const Vec3& p_WD, bool valid,
                     Real h, State& x, Limited& limited) noexcept {
    Wrench wanted;
    if (F_W != nullptr) {
      if (valid) x.lever_W = p_WT - p_WD;
      wanted = moved_to_parent(*F_W, x.lever_W, Vec3::Zero());
    }
    LimitedFeedback::Output out;
    LimitedFeedback::show(par, wanted, h, x.shown, out, limited);
    return out.F_D;
  }
};

}  // namespace godobject
