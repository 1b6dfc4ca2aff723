#include "platform/device/hand_device.h"

#include <algorithm>
#include <cmath>

namespace godobject {
namespace {

/// Periods for the last frames, which are those of a few cycles: a command to each drive, a message to each
/// node.
constexpr std::int64_t closing_periods = 10;

}  // namespace

// ---- prescribed joints -----------------------------------------------------------------------------

PrescribedSamples::PrescribedSamples(const SceneConfig& scene) {
  const std::vector<std::size_t> driven = driven_bodies(scene);
  if (!driven.empty()) first_driven_ = driven.front();
  for (const JointConfig& joint : scene.joints) {
    if (!joint.prescribed) continue;
    const std::vector<DeviceJoint>& device = device_tree(scene)->joints;
    Joint prescribed{.body = *body_named(scene, joint.child), .num_coordinates = joint.coordinates.size()};
    prescribed.driven = scene.bodies[prescribed.body].coupling.has_value();
    for (std::size_t i = 0; i < prescribed.num_coordinates; ++i)
      prescribed.device_joints[i] =
          std::ranges::find(device, joint.coordinates[i], &DeviceJoint::name) - device.begin();
    joints_.push_back(prescribed);
  }
}

void PrescribedSamples::write(const JointTarget& device, bool valid,
                              std::span<BodySample> samples) const noexcept {
  for (const Joint& joint : joints_) {
    BodySample& sample = samples[joint.body];
    sample.valid = valid;
    for (std::size_t i = 0; i < joint.num_coordinates; ++i) {
      sample.joint.q[static_cast<Eigen::Index>(i)] = device.q[joint.device_joints[i]];
      sample.joint.q_dot[static_cast<Eigen::Index>(i)] = device.q_dot[joint.device_joints[i]];
    }
    if (!joint.driven && first_driven_) sample.engaged = samples[*first_driven_].engaged;
  }
}

// ---- phases ---------------------------------------------------------------------------------------

std::int64_t DevicePhases::periods(double time_s) const noexcept {
  return std::llround(time_s / period_.step);
}

bool DevicePhases::makes_torque() const noexcept {
  return std::ranges::any_of(devices_, &HandDevice::makes_torque);
}

bool DevicePhases::boots() const noexcept {
  return std::ranges::any_of(devices_,
                             [](const HandDevice* device) { return device->boot_limit_s().has_value(); });
}

void DevicePhases::start(double limit_s) noexcept {
  if (phase_ != RunPhase::off) return;
  phase_ = boots() ? RunPhase::booting : RunPhase::running;
  for (const HandDevice* const device : devices_)
    limit_s = std::max(limit_s, device->boot_limit_s().value_or(0));
  periods_left_ = periods(limit_s);
}

void DevicePhases::advance(double t) noexcept {
  switch (phase_) {
    case RunPhase::booting: return boot(begin(t));
    case RunPhase::running_down: return run_down(begin(t));
    case RunPhase::closing: return close(begin(t));
    case RunPhase::off:
    case RunPhase::running:
    case RunPhase::ended: return;
  }
}

Period& DevicePhases::begin(double t) noexcept {
  period_.began_before = period_.began;
  period_.t = t;
  period_.has_begun = false;
  return period_;
}

void DevicePhases::boot(Period& period) noexcept {
  for (HandDevice* const device : devices_) device->boot(period);
  if (arm()) {
    phase_ = RunPhase::running;
  } else if (std::ranges::any_of(devices_, &HandDevice::failed) || --periods_left_ <= 0) {
    give_up_running();
  }
}

/// Arms the devices once all are ready.
bool DevicePhases::arm() noexcept {
  return std::ranges::all_of(devices_, &HandDevice::ready) && std::ranges::all_of(devices_, &HandDevice::arm);
}

void DevicePhases::stop() noexcept {
  if (phase_ == RunPhase::off) phase_ = RunPhase::ended;
  if (phase_ == RunPhase::booting || phase_ == RunPhase::running) give_up_running();
}

void DevicePhases::quick_stop() noexcept {
  stop();
  if (phase_ != RunPhase::running_down) return;
  for (HandDevice* const device : devices_) device->quick_stop();
}

void DevicePhases::give_up_running() noexcept {
  if (!makes_torque()) {
    phase_ = RunPhase::ended;
    return;
  }
  for (HandDevice* const device : devices_) device->disarm();
  phase_ = RunPhase::running_down;
  periods_left_ = periods(shut_down_limit_s);
}

void DevicePhases::run_down(Period& period) noexcept {
  if (periods_left_-- > 0) {
    bool goes_on = false;
    for (HandDevice* const device : devices_) goes_on = device->run_down(period) || goes_on;
    if (goes_on) return;
  }
  for (HandDevice* const device : devices_) device->stop(period);
  phase_ = RunPhase::closing;
  periods_left_ = closing_periods;
}

void DevicePhases::close(Period& period) noexcept {
  for (HandDevice* const device : devices_) device->close(period);
  if (--periods_left_ == 0) phase_ = RunPhase::ended;
}

void DevicePhases::restart() {
  if (phase_ != RunPhase::ended) return;
  phase_ = RunPhase::off;
  for (HandDevice* const device : devices_) device->restart();
}

}  // namespace godobject
