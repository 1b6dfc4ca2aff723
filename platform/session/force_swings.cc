#include "platform/session/force_swings.h"

namespace godobject {
namespace {

constexpr double nearly = 1 - 1e-6;  // of a bound: what is bounded is there to rounding

}  // namespace

ForceSwings::ForceSwings(const SceneConfig& scene, std::size_t num_wrenches) {
  const LimitConfig limits = scene.device ? scene.device->limits : LimitConfig{};
  const auto add = [&](double bound, double rate) {
    const SwingWatch watch(bound, rate, scene.step);
    shown_.push_back({.bound = bound, .largest_change = rate * scene.step, .watches = {watch, watch, watch}});
  };
  for (std::size_t i = 0; i < num_wrenches; ++i) {
    add(limits.force, limits.force_rate);
    add(limits.torque, limits.torque_rate);
  }
  if (!scene.device || !scene.device->rig) return;
  for (const DriveParams& drive : scene.device->rig->drives)
    drives_.emplace_back(drive.torque_max_Nm, drive.torque_rate_Nm_per_s, scene.step);
}

bool ForceSwings::Shown::shows(const Vec3& value) noexcept {
  const bool bounded = value.norm() >= nearly * bound || (value - last).norm() >= nearly * largest_change;
  last = value;
  bool swings = false;
  for (std::size_t i = 0; i < watches.size(); ++i)
    swings = watches[i].update(value[static_cast<Eigen::Index>(i)], bounded) || swings;
  return swings;
}

bool ForceSwings::shows(std::size_t index, const Wrench& F) noexcept {
  const bool force = shown_[2 * index].shows(F.f), torque = shown_[2 * index + 1].shows(F.tau);
  return force || torque;
}

std::optional<std::size_t> ForceSwings::commands(const Rig& rig, const CommandReport& report) noexcept {
  std::optional<std::size_t> swings;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const bool bounded = ((report.torque_limited | report.rate_limited) >> i & 1u) != 0;
    if (drives_[i].update(rig.commanded_torque_Nm(i), bounded)) swings = i;
  }
  return swings;
}

void ForceSwings::reset() noexcept {
  for (Shown& shown : shown_) {
    for (SwingWatch& watch : shown.watches) watch.reset();
    shown.last.setZero();
  }
  for (SwingWatch& watch : drives_) watch.reset();
}

}  // namespace godobject
