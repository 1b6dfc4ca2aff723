#include "platform/view/pointer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace godobject {
namespace {

/// Returns a sample at the first driven body that holds no body.
StreamedSample start_of(const SceneConfig& scene, const std::vector<std::size_t>& driven) {
  StreamedSample start;
  if (!driven.empty()) start.X_WD.p = scene.bodies[driven.front()].X_WB.p;
  return start;
}

HoldWish wish_for(std::optional<std::size_t> body) noexcept {
  return body ? HoldWish{.kind = HoldWish::Kind::body, .body = *body} : HoldWish{};
}

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

// ---- bodies ---------------------------------------------------------------------------------------

PointerDevice::PointerDevice(const SceneConfig& scene, LoopClock clock)
    : clock_(clock),
      driven_(driven_bodies(scene)),
      stream_(
          start_of(scene, driven_),
          {.stale_after = pointer_stale_ns, .speed = max_pointer_speed, .turn_rate = max_pointer_turn_rate}),
      sent_(start_of(scene, driven_)) {}

bool PointerDevice::take(std::uint64_t client, const PointerMessage& message, const Vec3& p_WB) {
  const bool is_holder = client_ == client;
  if (client_ && !is_holder) return false;
  if (message.target >= driven_.size() || (is_holder && message.number <= number_)) return false;
  const Nanoseconds now = clock_();
  const std::size_t body = driven_[message.target];
  if (message.holds && sent_.wish != wish_for(body)) {  // gripped at its present position
    sent_.X_WD = {.p = p_WB, .q = Quat::Identity()};
    ++sent_.path;
  } else if (message.holds && message.moves) {
    const double dt = 1e-9 * static_cast<double>(std::min(now - sent_.t, pointer_stale_ns));
    sent_.X_WD = moved_by(sent_.X_WD, limited(message.dp_W, dt * max_pointer_speed),
                          limited(message.dphi_W, dt * max_pointer_turn_rate));
  }
  client_ = message.holds ? std::optional(client) : std::nullopt;
  number_ = message.number;
  say(message.holds ? std::optional(body) : std::nullopt, now);
  return true;
}

void PointerDevice::leave(std::uint64_t client) {
  if (client_ != client) return;
  client_.reset();
  say(std::nullopt, clock_());
}

void PointerDevice::say(std::optional<std::size_t> held, Nanoseconds now) noexcept {
  sent_.wish = wish_for(held);
  sent_.state = held ? StreamedSample::State::leads : StreamedSample::State::rests;
  sent_.t = now;
  stream_.push(sent_);
}

void PointerDevice::read(Period& period, std::span<BodySample> samples) noexcept {
  period.begin_by(clock_);
  stream_.play(period.now, period.step);
  for (const std::size_t body : driven_) {
    samples[body].target = stream_.target();
    samples[body].valid = stream_.valid();
  }
}

void lead_by_pointer(SceneConfig& scene) {
  if (page_moves_joints(scene)) return lead_joints_by_page(scene);
  const bool shows = scene.device && shows_force(scene.device->kind);
  const LimitConfig limits = scene.device ? scene.device->limits : LimitConfig{};
  DeviceConfig pointer;
  pointer.name = "pointer";
  pointer.kind = shows ? DeviceKind::impedance : DeviceKind::non_haptic;
  pointer.limits = limits;
  pointer.grab_radius = 1;  // makes it a device that grips bodies
  scene.device = pointer;
  scene.motion.reset();
  scene.faults.clear();
}

// ---- joints ---------------------------------------------------------------------------------------

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

JointPointer::JointPointer(const SceneConfig& scene, LoopClock clock)
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
