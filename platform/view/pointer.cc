#include "platform/view/pointer.h"

#include <algorithm>

#include "core/math/rotation_error.h"
#include "core/math/so3.h"

namespace godobject {
namespace {

/// Of at most this length.
Vec3 limited(const Vec3& a, double most) noexcept {
  const double length = a.norm();
  return length > most ? Vec3(a * (most / length)) : a;
}

}  // namespace

PointerDevice::PointerDevice(const SceneConfig& scene, Nanoseconds (*clock)() noexcept)
    : clock_(clock), driven_(driven_bodies(scene)) {
  if (!driven_.empty()) said_.X.p = scene.bodies[driven_.front()].X_WB.p;
  heard_ = said_;
  shown_.X_WD = said_.X;
}

bool PointerDevice::take(std::uint64_t client, const PointerMessage& message, const Vec3& p_WB) {
  const bool is_holder = client_ == client;
  if (client_ && !is_holder) return false;
  if (message.target >= driven_.size() || (is_holder && message.number <= number_)) return false;
  const Nanoseconds now = clock_();
  const std::size_t body = driven_[message.target];
  if (message.holds && said_.body != body) {  // taken where it is
    said_.X = {.p = p_WB, .q = Quat::Identity()};
    ++said_.grip;
  } else if (message.holds && message.moves) {
    const double dt = 1e-9 * static_cast<double>(std::min(now - said_.t, pointer_stale_ns));
    said_.X.p += limited(message.dp_W, dt * max_pointer_speed);
    said_.X.q = renormalized(exp_so3(limited(message.dphi_W, dt * max_pointer_turn_rate)) * said_.X.q);
  }
  said_.body = message.holds ? std::optional(body) : std::nullopt;
  said_.t = now;
  client_ = message.holds ? std::optional(client) : std::nullopt;
  number_ = message.number;
  static_cast<void>(samples_.try_push(said_));  // full: the loop stands still
  return true;
}

void PointerDevice::leave(std::uint64_t client) {
  if (client_ != client) return;
  client_.reset();
  said_.body.reset();
  said_.t = clock_();
  static_cast<void>(samples_.try_push(said_));
}

void PointerDevice::read(Period& period, std::span<BodySample> samples) noexcept {
  period.begin_by(clock_);
  const Nanoseconds now = period.now;
  for (Sample sample; samples_.try_pop(sample); heard_ = sample) {
    if (sample.grip != heard_.grip) {  // taken hold of anew, elsewhere
      track_ = PoseTrack(pointer_stale_ns);
      shown_ = {.X_WD = sample.X, .V_WD = {}};
    }
    track_.push(sample.X, sample.t, now);
  }
  const PoseTrack::Played played = track_.at(now);
  follow(played, period.step);
  for (const std::size_t body : driven_) {
    samples[body].X_WD = shown_.X_WD;
    samples[body].V_WD = shown_.V_WD;
    samples[body].valid = played.valid || !heard_.body;  // a device that holds nothing is at rest
  }
  wish_ = heard_.body ? HoldWish{.kind = HoldWish::Kind::body, .body = *heard_.body} : HoldWish{};
}

/// No faster than allowed; at rest where nothing is played.
void PointerDevice::follow(const PoseTrack::Played& played, double step) noexcept {
  shown_.V_WD = {};
  if (!played.valid) return;
  Pose& X = shown_.X_WD;
  const RotationError turn = rotation_error(X.q, played.target.X_WD.q, Vec3::Zero());
  const Vec3 dp_W = limited(played.target.X_WD.p - X.p, step * max_pointer_speed);
  const Vec3 dphi_W = limited(to_world(X.q, turn.phi_B), step * max_pointer_turn_rate);
  X = {.p = X.p + dp_W, .q = renormalized(exp_so3(dphi_W) * X.q)};
  shown_.V_WD = {.w = dphi_W / step, .v = dp_W / step};
}

void lead_by_pointer(SceneConfig& scene) {
  const bool shows = scene.device && shows_force(scene.device->kind);
  const LimitConfig limits = scene.device ? scene.device->limits : LimitConfig{};
  DeviceConfig pointer;
  pointer.name = "pointer";
  pointer.kind = shows ? DeviceKind::impedance : DeviceKind::non_haptic;
  pointer.limits = limits;
  pointer.grab_radius = 1;  // it takes hold
  scene.device = pointer;
  scene.motion.reset();
  scene.faults.clear();
}

}  // namespace godobject
