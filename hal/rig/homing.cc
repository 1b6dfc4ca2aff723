// Rig: homing of joints with incremental sensors. A press of the home button sets their zeros while all of
// them rest. Each boot drops the zeros, as does each fault of their nodes or buses, which may have lost
// power.
#include <algorithm>

#include "hal/rig/rig.h"

namespace godobject {

void Rig::add_homed_joints() {
  for (std::size_t joint = 0; joint < num_joints(); ++joint) {
    const std::string& name = params_.tree.joints[joint].name;
    if (!is_incremental(params_, name)) continue;
    const double counts = rest_travel_counts / sensor_of(params_, name)->counts_per_unit;
    const double travel = is_rotary(params_, name) ? rest_travel_rad : rest_travel_m;
    homed_joints_.push_back(
        {.joint = joint, .node = measured_[joint].node, .rest = RestWatch(travel + counts)});
  }
}

void Rig::begin_boot(Nanoseconds now) noexcept {
  boot_started_ns_ = now;
  for (const HomedJoint& homed : homed_joints_) sensors_[homed.joint]->drop_zero();
}

void Rig::drop_zeros(const RigFaultPlace& place) noexcept {
  for (const HomedJoint& homed : homed_joints_) {
    const RigNode& node = nodes_[homed.node];
    if (place.bus == node.bus && (place.node_id == 0 || place.node_id == node.id))
      sensors_[homed.joint]->drop_zero();
  }
}

void Rig::begin_homing(Nanoseconds now) noexcept {
  for (HomedJoint& homed : homed_joints_) homed.rest.restart(sensors_[homed.joint]->sample(now).q, now);
  home_was_pressed_ = true;  // a button that is pressed already confirms nothing
}

// Sets the zeros at a press. A press while a joint moves or lacks a sample is refused.
void Rig::home(Nanoseconds now) noexcept {
  const bool was_pressed = home_was_pressed_;
  home_was_pressed_ = is_pressed(ButtonUse::home);
  for (HomedJoint& homed : homed_joints_) {
    const Encoder& sensor = *sensors_[homed.joint];
    homed.rest.update(sensor.sample(now).q, sensor.good(now), now);
  }
  if (!homed_joints_.empty()) {
    if (!home_was_pressed_ || was_pressed) return;
    const auto moving = std::ranges::find_if(
        homed_joints_, [now](const HomedJoint& homed) { return !homed.rest.at_rest(now); });
    if (moving != homed_joints_.end()) {
      ++refused_presses_.count;
      refused_presses_.joint = moving->joint;
      return;
    }
    for (const HomedJoint& homed : homed_joints_) sensors_[homed.joint]->set_zero();
    boot_started_ns_ = now;
  }
  static_cast<void>(supervisor_.on(RigEvent::homed));
}

bool Rig::is_pressed(ButtonUse use) const noexcept {
  return std::ranges::any_of(
      buttons_, [use](const ButtonOnBus& button) { return button.params.use == use && button.pressed; });
}

}  // namespace godobject
