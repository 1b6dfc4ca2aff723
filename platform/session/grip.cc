#include "platform/session/grip.h"

namespace godobject {

Grip::Grip(const SceneConfig& scene)
    : coupled_(driven_bodies(scene)), grab_radius_(scene.device->grab_radius.value_or(0)), step_(scene.step) {
  const LimitConfig& limits = scene.device->limits;
  limits_ = {.gains = {},
             .max_force = limits.force,
             .max_torque = limits.torque,
             .max_force_rate = limits.force_rate,
             .max_torque_rate = limits.torque_rate};
}

void Grip::update(const HoldWish& wish, bool button, const Vec3& p_WD, const Engine& engine) noexcept {
  if (wish != wish_) {
    body_.reset();
    if (wish.kind == HoldWish::Kind::body) body_ = wish.body;
    if (wish.kind == HoldWish::Kind::nearest) body_ = nearest(p_WD, engine);
  }
  if (button != button_) body_ = button ? nearest(p_WD, engine) : std::nullopt;
  wish_ = wish;
  button_ = button;
}

void Grip::press(const Vec3& p_WD, const Engine& engine) noexcept {
  body_ = body_ ? std::nullopt : nearest(p_WD, engine);
}

std::optional<std::size_t> Grip::nearest(const Vec3& p_WD, const Engine& engine) const noexcept {
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

Wrench Grip::feel(const BodySample& device, const Engine& engine, Limited& limited) noexcept {
  const Wrench F_W = body_ ? engine.feedback(*body_) : Wrench{};
  const Vec3 p_WT = body_ ? engine.view(*body_).target.X_WD.p : Vec3::Zero();
  return HeldFeedback::show(limits_, body_ ? &F_W : nullptr, p_WT, device.target.X_WD.p, device.valid, step_,
                            felt_, limited);
}

}  // namespace godobject
