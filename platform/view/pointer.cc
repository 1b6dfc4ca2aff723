#include "platform/view/pointer.h"

#include <algorithm>

#include "platform/view/joint_pointer.h"

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

}  // namespace

PointerDevice::PointerDevice(const SceneConfig& scene, Nanoseconds (*clock)() noexcept)
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

}  // namespace godobject
