#include "platform/view/joint_pointer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "platform/view/pointer.h"

namespace godobject {
namespace {

constexpr double half_turn = std::numbers::pi, half_metre = 0.5;
/// Lag of the joints behind the messages, s. It spans some messages, because their steps would be felt.
constexpr double lag_s = 0.05;

/// Returns the stop of the scene's coordinate of this name, if it has both ends; else null.
const StopParams* stop_of(const SceneConfig& scene, const std::string& coordinate) {
  for (const JointConfig& joint : scene.joints)
    for (const StopConfig& stop : joint.stops)
      if (stop.coordinate == coordinate && std::isfinite(stop.params.upper - stop.params.lower))
        return &stop.params;
  return nullptr;
}

}  // namespace

bool page_moves_joints(const SceneConfig& scene) {
  const KinematicTreeParams* const tree = device_tree(scene);
  if (tree == nullptr || tree->handles.empty() || grips_bodies(scene)) return false;
  if (scene.device->kind == DeviceKind::admittance) return false;
  return scene.motion && !scene.motion->joints.empty();
}

void lead_joints_by_page(SceneConfig& scene) {
  const JointVector start = Motion(scene).joints(0).q;
  DeviceConfig page;
  page.name = "pointer";
  page.kind = shows_force(scene.device->kind) ? DeviceKind::impedance : DeviceKind::non_haptic;
  page.limits = scene.device->limits;
  page.unmeasured_tree = *device_tree(scene);
  MotionConfig rest;
  for (std::size_t i = 0; i < page.unmeasured_tree->joints.size(); ++i)
    rest.joints.push_back(
        {.coordinate = page.unmeasured_tree->joints[i].name, .offset = start[static_cast<Eigen::Index>(i)]});
  scene.device = page;
  scene.motion = rest;
  scene.faults.clear();
}

std::vector<CoordinateRange> page_ranges(const SceneConfig& scene) {
  std::vector<CoordinateRange> ranges;
  const JointVector start = Motion(scene).joints(0).q;
  for (const DeviceJoint& joint : device_tree(scene)->joints) {
    const double q = start[static_cast<Eigen::Index>(ranges.size())];
    const double reach = joint.kind == DeviceJointKind::hinge ? half_turn : half_metre;
    CoordinateRange range{q - reach, q + reach};
    if (const StopParams* const stop = stop_of(scene, joint.name)) {
      const double beyond = 0.5 * (stop->upper - stop->lower);
      range = {std::min(q, stop->lower - beyond), std::max(q, stop->upper + beyond)};
    }
    ranges.push_back(range);
  }
  return ranges;
}

JointPointer::JointPointer(const SceneConfig& scene, Nanoseconds (*clock)() noexcept)
    : clock_(clock),
      joints_(device_tree(scene)->joints),
      ranges_(page_ranges(scene)),
      tree_(*device_tree(scene)),
      prescribed_(scene),
      shown_(Motion(scene).joints(0)) {
  const std::vector<std::size_t> driven = driven_bodies(scene);
  for (const std::optional<std::size_t>& target : driven_by_handles(scene))
    bodies_.push_back(driven[target.value_or(0)]);
  for (std::size_t i = 0; i < joints_.size(); ++i) sent_.q[i] = shown_.q[static_cast<Eigen::Index>(i)];
  heard_ = sent_;
}

double JointPointer::max_rate(std::size_t joint) const noexcept {
  return joints_[joint].kind == DeviceJointKind::hinge ? max_page_turn_rate : max_page_slide_rate;
}

bool JointPointer::take(std::uint64_t client, const JointsMessage& message) {
  const bool is_holder = client_ == client;
  if (client_ && !is_holder) return false;
  if (message.num_joints != joints_.size() || (is_holder && message.number <= number_)) return false;
  const Nanoseconds now = clock_();
  // Messages may come late and several at once. Each refills the allowance by the time since the previous
  // one, at most pointer_stale_ns.
  const Nanoseconds since = is_holder ? std::min(now - sent_.t, pointer_stale_ns) : pointer_stale_ns;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double full = 1e-9 * static_cast<double>(pointer_stale_ns) * max_rate(i);
    room_[i] = std::min(room_[i] + 1e-9 * static_cast<double>(since) * max_rate(i), full);
    if (!is_holder || !message.holds) continue;
    const double dq = std::clamp(message.dq[i], -room_[i], room_[i]);
    room_[i] -= std::abs(dq);
    sent_.q[i] = std::clamp(sent_.q[i] + dq, ranges_[i].lower, ranges_[i].upper);
  }
  client_ = message.holds ? std::optional(client) : std::nullopt;
  number_ = message.number;
  push(message.holds, now);
  return true;
}

void JointPointer::leave(std::uint64_t client) {
  if (client_ != client) return;
  client_.reset();
  push(false, clock_());
}

/// Sends a sample to the loop. It is dropped if the ring is full, which occurs only if the loop stands still;
/// the next one contains its displacements.
void JointPointer::push(bool leads, Nanoseconds now) noexcept {
  sent_.leads = leads;
  sent_.t = now;
  static_cast<void>(samples_.try_push(sent_));
}

/// Follows the newest sample with a lag, within the rate limits. A stale sample stops the coordinates.
void JointPointer::read(Period& period, std::span<BodySample> samples) noexcept {
  period.begin_by(clock_);
  for (Sample sample; samples_.try_pop(sample);) heard_ = sample;
  const bool valid = !heard_.leads || period.now - heard_.t <= pointer_stale_ns;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    double& q = shown_.q[static_cast<Eigen::Index>(i)];
    const double rate = (heard_.q[i] - q) / std::max(lag_s, period.step);
    double& q_dot = shown_.q_dot[static_cast<Eigen::Index>(i)];
    q_dot = valid ? std::clamp(rate, -max_rate(i), max_rate(i)) : 0;
    q += q_dot * period.step;
  }
  const TreeConfiguration at = tree_.at(shown_.q);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    samples[bodies_[k]].target = {at.X_WH(k), at.twist(k, shown_.q_dot)};
    samples[bodies_[k]].valid = valid;
  }
  prescribed_.write(shown_, valid, samples);
}

}  // namespace godobject
