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
  /// Fraction of a bound that counts as reached, because of rounding.
  static constexpr double nearly = 1 - 1e-6;

  /// State of one force or torque.
  struct Shown {
    double bound, largest_change;  // bounds of the magnitude, and of its change in a step
    std::array<SwingWatch, 3> watches;
    Vec3 last = Vec3::Zero();

    bool shows(const Vec3& value) noexcept;
  };

  std::vector<Shown> shown_;  // force, torque of each wrench
};

// ---- grip -----------------------------------------------------------------------------------------

inline Grip::Grip(const SceneConfig& scene)
    : coupled_(driven_bodies(scene)), grab_radius_(scene.device->grab_radius.value_or(0)), step_(scene.step) {
  const LimitConfig& limits = scene.device->limits;
  limits_ = {.gains = {},
             .max_force = limits.force,
             .max_torque = limits.torque,
             .max_force_rate = limits.force_rate,
             .max_torque_rate = limits.torque_rate};
}

inline void Grip::update(const HoldWish& wish, bool button, const Vec3& p_WD, const Engine& engine) noexcept {
  if (wish != wish_) {
    body_.reset();
    if (wish.kind == HoldWish::Kind::body) body_ = wish.body;
    if (wish.kind == HoldWish::Kind::nearest) body_ = nearest(p_WD, engine);
  }
  if (button != button_) body_ = button ? nearest(p_WD, engine) : std::nullopt;
  wish_ = wish;
  button_ = button;
}

inline void Grip::press(const Vec3& p_WD, const Engine& engine) noexcept {
  body_ = body_ ? std::nullopt : nearest(p_WD, engine);
}

inline std::optional<std::size_t> Grip::nearest(const Vec3& p_WD, const Engine& engine) const noexcept {
  std::optional<std::size_t> found;
  double least = grab_radius_;
  for (const std::size_t body : coupled_) {
    const double distance = (engine.view(body).X_WB.p - p_WD).norm();
    if (!(distance <= least) || (found && distance == least)) continue;
    least = distance;
    found = body;
  }
  return found;
}

inline Wrench Grip::feel(const BodySample& device, const Engine& engine, Limited& limited) noexcept {
  const Wrench F_W = body_ ? engine.feedback(*body_) : Wrench{};
  const Vec3 p_WT = body_ ? engine.view(*body_).target.X_WD.p : Vec3::Zero();
  return HeldFeedback::show(limits_, body_ ? &F_W : nullptr, p_WT, device.target.X_WD.p, device.valid, step_,
                            felt_, limited);
}

// ---- oscillation ----------------------------------------------------------------------------------

inline WrenchSwings::WrenchSwings(const SceneConfig& scene, std::size_t num_wrenches) {
  const LimitConfig limits = scene.device ? scene.device->limits : LimitConfig{};
  const auto add = [&](double bound, double rate) {
    const SwingWatch watch(bound, rate, scene.step);
    shown_.push_back({.bound = bound, .largest_change = rate * scene.step, .watches = {watch, watch, watch}});
  };
  for (std::size_t i = 0; i < num_wrenches; ++i) {
    add(limits.force, limits.force_rate);
    add(limits.torque, limits.torque_rate);
  }
}

inline bool WrenchSwings::Shown::shows(const Vec3& value) noexcept {
  const bool bounded = value.norm() >= nearly * bound || (value - last).norm() >= nearly * largest_change;
  last = value;
  bool swings = false;
  for (std::size_t i = 0; i < watches.size(); ++i)
    swings = watches[i].update(value[static_cast<Eigen::Index>(i)], bounded) || swings;
  return swings;
}

inline bool WrenchSwings::shows(std::size_t index, const Wrench& F) noexcept {
  const bool force = shown_[2 * index].shows(F.f), torque = shown_[2 * index + 1].shows(F.tau);
  return force || torque;
}

inline void WrenchSwings::reset() noexcept {
  for (Shown& shown : shown_) {
    for (SwingWatch& watch : shown.watches) watch.reset();
    shown.last.setZero();
  }
}

}  // namespace godobject
