// A device that takes hold of bodies: which one it holds, and what the hand feels of it.
#pragma once

#include <optional>
#include <vector>

#include "core/device/held_feedback.h"
#include "platform/engine/engine.h"
#include "platform/motion/motion.h"

namespace godobject {

class Grip {
 public:
  /// takes_hold(scene) must be true. Allocates; nothing later does.
  explicit Grip(const SceneConfig& scene);

  /// Decides what is held from now on. A wish counts when it changes, and so does the button: pressed it
  /// takes hold of the nearest body, let go it lets go. The nearest body is that at the end of the last step
  /// whose centre of mass is nearest to the device, within grab_radius; where there is none the device holds
  /// nothing until asked again.
  void update(const HoldWish& wish, bool button, const Vec3& p_WD, const Engine& engine) noexcept;

  /// The device's own button goes down: what is held is let go; where nothing is, the nearest body is taken.
  void press(const Vec3& p_WD, const Engine& engine) noexcept;

  /// Index of the held body in the scene.
  std::optional<std::size_t> body() const noexcept { return body_; }
  bool holds(std::size_t body) const noexcept { return body_ == body; }

  /// To be called once a step: the held body's feedback as a wrench on the hand, about the device's origin,
  /// world axes; zero while nothing is held. Within the scene's limits of size and rate, whatever is taken or
  /// let go.
  /// During a gap in the samples the lever is that of the last one.
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

}  // namespace godobject
