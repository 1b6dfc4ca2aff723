// A motion as the device: targets, wrenches of the hand and switches are passed to the core unchanged.
#pragma once

#include <vector>

#include "platform/device/hand_device.h"
#include "platform/device/prescribed_samples.h"
#include "platform/motion/motion.h"

namespace godobject {

class HandedMotion final : public HandDevice {
 public:
  /// Allocates; the other functions do not. motion: a motion of this scene, which must outlive this object.
  HandedMotion(const SceneConfig& scene, const Motion& motion)
      : motion_(motion),
        driven_(driven_bodies(scene)),
        joints_(motion.has_joints() ? PrescribedSamples(scene) : PrescribedSamples()) {}

  void read(Period& period, std::span<BodySample> samples) noexcept override {
    for (std::size_t i = 0; i < motion_.num_bodies(); ++i) samples[driven_[i]] = sample(i, period.t);
    write_joints(period.t, samples);
  }

  /// Writes the prescribed joints' coordinates, if the motion is one of the device's joints.
  void write_joints(double t, std::span<BodySample> samples) const noexcept {
    if (motion_.has_joints()) joints_.write(motion_.joints(t), true, samples);
  }

  /// Returns the sample of the target of this index: see Motion.
  BodySample sample(std::size_t index, double t) const noexcept {
    const MotionSwitches switches = motion_.switches(index, t);
    return {.target = motion_.target(index, t),
            .F_WB = motion_.wrench(index, t),
            .engaged = switches.engaged,
            .clutch = switches.clutch,
            .joint = {}};
  }

 private:
  const Motion& motion_;
  std::vector<std::size_t> driven_;
  PrescribedSamples joints_;
};

}  // namespace godobject
