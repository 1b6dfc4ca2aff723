// Displayed wrench of a gripped body.
#pragma once

#include "core/device/feedback.h"

namespace godobject {

/// Moves the feedback from the gripped body's target to the device's origin (9), where the hand is. Changes
/// by gripping and releasing stay within the limits of size and rate.
struct HeldFeedback {
  using Params = FeedbackParams;  // limits; the gains are those of the body
  struct State {
    LimitedFeedback::State shown;
    Vec3 lever_W = Vec3::Zero();  // vector from the device's origin to the target
  };

  /// Returns the wrench on the hand about the device's origin, world axes; call once per step.
  /// F_W: wrench of the gripped body at its target's origin p_WT; null without one.
  /// valid: p_WD is a valid sample; otherwise the last lever is used.
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
