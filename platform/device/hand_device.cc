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

RunPhase phase_of(RigState state) noexcept {
  switch (state) {
    case RigState::off: return RunPhase::off;
    case RigState::booting:
    case RigState::homing:
    case RigState::enabling:
    case RigState::ready: return RunPhase::booting;
    case RigState::armed:
    case RigState::hold:
    case RigState::fault: return RunPhase::running;
    case RigState::stopping: return RunPhase::running_down;
    case RigState::closing: return RunPhase::closing;
    case RigState::ended: break;
  }
  return RunPhase::ended;
}

void DevicePhases::start(double limit_s) noexcept {
  if (!supervisor_.on(RigEvent::start)) return;
  if (!boots()) arm();
  for (const HandDevice* const device : devices_)
    limit_s = std::max(limit_s, device->boot_limit_s().value_or(0));
  periods_left_ = periods(limit_s);
}

void DevicePhases::advance(double t) noexcept {
  switch (phase()) {
    case RunPhase::booting: return boot(begin(t));
    case RunPhase::running_down: return run_down(begin(t));
    case RunPhase::closing:
    case RunPhase::ended: return close(begin(t));  // after the end, only time passes
    case RunPhase::off:
    case RunPhase::running: return;
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
  arm();
  if (phase() == RunPhase::running) return;
  if (!std::ranges::any_of(devices_, &HandDevice::waits_for_user)) --periods_left_;
  if (std::ranges::any_of(devices_, &HandDevice::failed) || periods_left_ <= 0) give_up_running();
}

/// Arms the devices once all are ready. start() is the request to do so.
void DevicePhases::arm() noexcept {
  if (!std::ranges::all_of(devices_, &HandDevice::ready)) return;
  for (const RigEvent event : {RigEvent::nodes_up, RigEvent::homed, RigEvent::drives_up})
    static_cast<void>(supervisor_.on(event));
  if (std::ranges::all_of(devices_, &HandDevice::arm)) static_cast<void>(supervisor_.on(RigEvent::arm));
}

void DevicePhases::stop() noexcept {
  if (phase() == RunPhase::off) static_cast<void>(supervisor_.on(RigEvent::stop));
  if (phase() == RunPhase::booting || phase() == RunPhase::running) give_up_running();
}

void DevicePhases::quick_stop() noexcept {
  stop();
  if (phase() != RunPhase::running_down) return;
  static_cast<void>(supervisor_.on(RigEvent::quick_stop));
  for (HandDevice* const device : devices_) device->quick_stop();
}

void DevicePhases::give_up_running() noexcept {
  static_cast<void>(supervisor_.on(RigEvent::stop));
  if (!makes_torque()) {
    for (const RigEvent event : {RigEvent::zero_reached, RigEvent::frames_sent})
      static_cast<void>(supervisor_.on(event));
    return;
  }
  for (HandDevice* const device : devices_) device->disarm();
  periods_left_ = periods(shut_down_limit_s);
}

void DevicePhases::run_down(Period& period) noexcept {
  if (periods_left_-- > 0) {
    bool goes_on = false;
    for (HandDevice* const device : devices_) goes_on = device->run_down(period) || goes_on;
    if (goes_on) return;
  }
  for (HandDevice* const device : devices_) device->stop(period);
  static_cast<void>(supervisor_.on(RigEvent::zero_reached));
  periods_left_ = closing_periods;
}

void DevicePhases::close(Period& period) noexcept {
  for (HandDevice* const device : devices_) device->close(period);
  if (--periods_left_ == 0) static_cast<void>(supervisor_.on(RigEvent::frames_sent));
}

void DevicePhases::restart() {
  if (!supervisor_.on(RigEvent::restart)) return;
  for (HandDevice* const device : devices_) device->restart();
}

}  // namespace godobject
