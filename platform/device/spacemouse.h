// A SpaceMouse as the device, in rate control: the deflection of its cap sets the velocity of the target. The
// cap travels only a millimetre and springs back.
#pragma once

#include <algorithm>
#include <cmath>

#include "hal/tracker/spacenav.h"
#include "platform/device/hand_device.h"
#include "platform/device/streamed_target.h"
#include "platform/scene/scene.h"

namespace godobject {

/// Interval of the thread's samples, ns.
inline constexpr Nanoseconds spacemouse_tick_ns = 10'000'000;

class SpaceMouse final : public HandDevice {
 public:
  /// scene: must have a SpaceMouse. clock: clock of the loop, of take() and of tick().
  SpaceMouse(const SceneConfig& scene, LoopClock clock);

  // For the thread that reads the daemon:

  void take(const SpacenavEvent& event) noexcept;
  /// Emits a sample; to be called every spacemouse_tick_ns. connected: true while the daemon is connected.
  void tick(bool connected) noexcept;

  // For the loop:

  void read(Period& period, std::span<BodySample> samples) noexcept override;
  bool hold_pressed() const noexcept override { return hold_pressed_; }

 private:
  void go_on(Nanoseconds now) noexcept;

  SpaceMouseConfig config_;
  std::size_t body_;  // body of the target; for a device that grips bodies the first that can be held
  LoopClock clock_;
  Nanoseconds stale_after_;
  StreamedTarget stream_;

  // State of the thread:
  StreamedSample sent_;
  Vec3 v_W_ = Vec3::Zero(), w_W_ = Vec3::Zero();
  Nanoseconds t_event_ = 0;  // time of the last motion event

  // State of the loop:
  bool hold_pressed_ = false;
};

/// Removes the scene's motion, because the SpaceMouse replaces it.
inline void lead_by_spacemouse(SceneConfig& scene) { scene.motion.reset(); }

namespace spacemouse {

inline constexpr double stale_periods = 3;

inline std::size_t moved_body(const SceneConfig& scene) {
  const std::vector<std::size_t> driven = driven_bodies(scene);
  const std::optional<std::size_t> named = body_named(scene, scene.device->spacemouse->body);
  return grips_bodies(scene) || !named ? driven.front() : *named;
}

inline Pose start_of(const SceneConfig& scene) {
  const std::optional<std::size_t> named = body_named(scene, scene.device->spacemouse->body);
  return scene.bodies[named.value_or(moved_body(scene))].X_WB;
}

/// Returns 0 within the deadband, +-1 at full scale and beyond.
inline double deflection(double counts, const SpaceMouseConfig& config) noexcept {
  const double beyond = std::abs(counts) - config.deadband;
  return std::copysign(std::clamp(beyond / (config.full_scale - config.deadband), 0.0, 1.0), counts);
}

inline Vec3 deflection(const SpacenavEvent& event, std::size_t first,
                       const SpaceMouseConfig& config) noexcept {
  const Vec3 counts = spacenav_vector(event, first);
  const Vec3 u(deflection(counts.x(), config), deflection(counts.y(), config),
               deflection(counts.z(), config));
  return limited(u, 1);
}

}  // namespace spacemouse

inline SpaceMouse::SpaceMouse(const SceneConfig& scene, LoopClock clock)
    : config_(*scene.device->spacemouse),
      body_(spacemouse::moved_body(scene)),
      clock_(clock),
      stale_after_(to_ns(spacemouse::stale_periods / config_.rate_hz)),
      stream_({.X_WD = spacemouse::start_of(scene)},
              {.stale_after = stale_after_, .speed = config_.max_speed, .turn_rate = config_.max_turn_rate}) {
  sent_ = {.X_WD = spacemouse::start_of(scene), .t = clock_()};
}

/// Moves the target by v_W, w_W since the last sample or event, at most until the last deflection is stale.
inline void SpaceMouse::go_on(Nanoseconds now) noexcept {
  const Nanoseconds until = std::min(now, t_event_ + stale_after_);
  const double dt = 1e-9 * static_cast<double>(std::max(until - sent_.t, Nanoseconds{0}));
  sent_.X_WD = moved_by(sent_.X_WD, dt * v_W_, dt * w_W_);
  sent_.t = now;
}

inline void SpaceMouse::take(const SpacenavEvent& event) noexcept {
  const Nanoseconds now = clock_();
  using Kind = SpacenavEvent::Kind;
  if (event.kind == Kind::motion) {
    go_on(now);
    v_W_ = config_.max_speed * to_world(config_.q_WM, spacemouse::deflection(event, 0, config_));
    w_W_ = config_.max_turn_rate * to_world(config_.q_WM, spacemouse::deflection(event, 3, config_));
    t_event_ = now;
  } else {
    if (event.button == config_.clutch_button) sent_.clutch = event.kind == Kind::release;
    if (event.button == config_.hold_button && event.kind == Kind::press) ++sent_.presses;
  }
}

inline void SpaceMouse::tick(bool connected) noexcept {
  using State = StreamedSample::State;
  const Nanoseconds now = clock_();
  go_on(now);
  if (!connected) {  // the cap and the buttons are assumed released
    v_W_ = w_W_ = Vec3::Zero();
    sent_.clutch = true;
  }
  const bool rests = v_W_.isZero(0) && w_W_.isZero(0);
  const bool silent = !rests && now - t_event_ > stale_after_;
  sent_.state = !connected || silent ? State::lost : rests ? State::rests : State::leads;
  stream_.push(sent_);
}

inline void SpaceMouse::read(Period& period, std::span<BodySample> samples) noexcept {
  period.begin_by(clock_);
  stream_.play(period.now, period.step);
  BodySample& sample = samples[body_];
  sample.target = stream_.target();
  sample.valid = stream_.valid();
  sample.clutch = stream_.heard().clutch;
  hold_pressed_ = stream_.heard().presses != stream_.heard_before().presses;
}

}  // namespace godobject
