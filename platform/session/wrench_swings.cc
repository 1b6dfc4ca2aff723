#include "platform/session/wrench_swings.h"

namespace godobject {
namespace {

constexpr double nearly = 1 - 1e-6;  // fraction of a bound that counts as reached, because of rounding

}  // namespace

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
