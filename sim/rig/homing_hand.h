// The simulated user of a device with incremental sensors. While the motion stands still, as in a boot, the
// hand brings the device to its home pose. There it presses the home button once a second. It returns to the
// motion when this runs.
#pragma once

#include <algorithm>
#include <cmath>

#include "hal/base/nanoseconds.h"
#include "hal/rig/params.h"

namespace godobject {

class HomingHand {
 public:
  // s
  static constexpr double way_s = 0.5;                    // from the motion to the home pose, or back
  static constexpr double period_s = 1, pressed_s = 0.2;  // of the presses
  static constexpr double usual_time_s = 3;               // until a host is armed, with a margin

  /// wanted: false for a hand that does nothing here.
  HomingHand(const RigParams& rig, bool wanted) {
    for (std::size_t i = 0; i < rig.tree.joints.size(); ++i) {
      const std::string& joint = rig.tree.joints[i].name;
      homes_[i] = is_incremental(rig, joint) ? std::optional(sensor_of(rig, joint)->home) : std::nullopt;
      is_used_ = is_used_ || (wanted && homes_[i].has_value());
    }
  }

  bool is_used() const noexcept { return is_used_; }
  /// Advances to t. motion_time: time of the motion then, s.
  void advance(Nanoseconds t, double motion_time) noexcept {
    const double dt = 1e-9 * static_cast<double>(t - t_ns_);
    const bool stands_still = motion_time == motion_time_;
    still_s_ = stands_still ? still_s_ + dt : 0;
    const double before = way_;
    way_ = std::clamp(way_ + (stands_still ? dt : -dt) / way_s, 0.0, 1.0);
    way_per_s_ = dt > 0 ? (way_ - before) / dt : 0;
    t_ns_ = t;
    motion_time_ = motion_time;
  }
  /// Moves the coordinates of the actuators from the motion towards the home pose.
  JointTarget moved(JointTarget actuators) const noexcept {
    const double share = way_ * way_ * (3 - 2 * way_), share_per_s = 6 * way_ * (1 - way_) * way_per_s_;
    for (Eigen::Index i = 0; i < actuators.q.size(); ++i) {
      const std::optional<double>& home = homes_[static_cast<std::size_t>(i)];
      if (!home) continue;
      const double left = *home - actuators.q[i];
      actuators.q_dot[i] += share_per_s * left - share * actuators.q_dot[i];
      actuators.q[i] += share * left;
    }
    return actuators;
  }
  bool presses() const noexcept {
    return is_used_ && still_s_ >= period_s && std::fmod(still_s_, period_s) < pressed_s;
  }

 private:
  std::array<std::optional<double>, max_joints> homes_{};  // coordinate of each joint's actuator, rad or m
  bool is_used_ = false;
  double way_ = 1;  // 1: in the home pose, where the device begins
  double way_per_s_ = 0, still_s_ = 0, motion_time_ = 0;
  Nanoseconds t_ns_ = 0;
};

}  // namespace godobject
