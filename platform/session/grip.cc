#include "platform/session/grip.h"

namespace godobject {
namespace {

constexpr double nearly = 1 - 1e-6;  // fraction of a bound that counts as reached, because of rounding

}  // namespace

// ---- grip -----------------------------------------------------------------------------------------

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

// ---- oscillation ----------------------------------------------------------------------------------

WrenchSwings::WrenchSwings(const SceneConfig& scene, std::size_t num_wrenches) {
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

bool WrenchSwings::Shown::shows(const Vec3& value) noexcept {
  const bool bounded = value.norm() >= nearly * bound || (value - last).norm() >= nearly * largest_change;
  last = value;
  bool swings = false;
  for (std::size_t i = 0; i < watches.size(); ++i)
    swings = watches[i].update(value[static_cast<Eigen::Index>(i)], bounded) || swings;
  return swings;
}

bool WrenchSwings::shows(std::size_t index, const Wrench& F) noexcept {
  const bool force = shown_[2 * index].shows(F.f), torque = shown_[2 * index + 1].shows(F.tau);
  return force || torque;
}

void WrenchSwings::reset() noexcept {
  for (Shown& shown : shown_) {
    for (SwingWatch& watch : shown.watches) watch.reset();
    shown.last.setZero();
  }
}

}  // namespace godobject
