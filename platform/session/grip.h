// Wrenches on the hand: of the body that a device holds, if it can hold one at a time, and a watch for their
// oscillation.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/device/held_feedback.h"
#include "hal/rig/swing_watch.h"
#include "platform/engine/engine.h"
#include "platform/motion/motion.h"
#include "platform/scene/scene.h"

namespace godobject {

/// Grip of a device that can hold one body at a time: selects the held body and computes the displayed
/// wrench.
class Grip {
 public:
  /// Allocates; the other functions do not. scene: must fulfil grips_bodies(scene).
  explicit Grip(const SceneConfig& scene);

  /// Selects the held body for the coming step. Only changes of the wish and of the button count.
  /// A press of the button grips the nearest body, its release releases it.
  /// The nearest body has its centre of mass nearest to the device after the last step, within grab_radius.
  /// Without one the device holds nothing until the next change.
  /// p_WD: position of the device, world, m.
  void update(const HoldWish& wish, bool button, const Vec3& p_WD, const Engine& engine) noexcept;

  /// Toggles the grip, for the device's own button: releases the held body, or grips the nearest if none is
  /// held.
  void press(const Vec3& p_WD, const Engine& engine) noexcept;

  /// Index of the held body in the scene; none if nothing is held.
  std::optional<std::size_t> body() const noexcept { return body_; }
  bool holds(std::size_t body) const noexcept { return body_ == body; }

  /// Computes the wrench of the held body's feedback on the hand, about the device's origin, in world axes.
  /// Zero while nothing is held. Call it once a step.
  /// Keeps the scene's limits of magnitude and rate also across gripping and releasing. During a gap in the
  /// samples the lever arm stays that of the last valid sample.
  Wrench feel(const BodySample& device, const Engine& engine, Limited& limited) noexcept;

 private:
  std::optional<std::size_t> nearest(const Vec3& p_WD, const Engine& engine) const noexcept;

  std::vector<std::size_t> coupled_;  // bodies that can be held
  double grab_radius_ = 0;
  double step_ = 0;
  FeedbackParams limits_;
  HeldFeedback::State felt_;
  HoldWish wish_;
  bool button_ = false;
  std::optional<std::size_t> body_;
};

/// Watches the displayed wrenches for oscillation between their bounds. DriveSwings (platform/device/rig.h)
/// watches the motors' commands.
class WrenchSwings {
 public:
  /// Allocates; the other functions do not. num_wrenches: number of displayed wrenches.
  WrenchSwings(const SceneConfig& scene, std::size_t num_wrenches);

  /// Updates with the wrench of this index in this step. Returns true if it oscillates.
  bool shows(std::size_t index, const Wrench& F) noexcept;
  void reset() noexcept;

 private:
  /// State of one force or torque.
  struct Shown {
    double bound, largest_change;  // bounds of the magnitude, and of its change in a step
    std::array<SwingWatch, 3> watches;
    Vec3 last = Vec3::Zero();

    bool shows(const Vec3& value) noexcept;
  };

  std::vector<Shown> shown_;  // force, torque of each wrench
};

}  // namespace godobject
