// A SpaceMouse as the device: rate control. How far its cap is pushed and turned is how fast the target moves, because the cap
// travels a millimetre and springs back (docs/decisions/051-spacemouse.md).
#pragma once

#include "hal/tracker/spacenav.h"
#include "platform/device/hand_device.h"
#include "platform/device/streamed_target.h"
#include "platform/scene/scene.h"

namespace godobject {

/// Samples leave the thread so often.
inline constexpr Nanoseconds spacemouse_tick_ns = 10'000'000;

class SpaceMouse final : public HandDevice {
 public:
  /// The scene has one. clock: of the loop, and of take() and tick().
  SpaceMouse(const SceneConfig& scene, Nanoseconds (*clock)() noexcept);

  // The thread that reads the daemon:

  void take(const SpacenavEvent& event) noexcept;
  /// Every spacemouse_tick_ns. connected: the daemon is there.
  void tick(bool connected) noexcept;

  // The loop:

  void read(Period& period, std::span<BodySample> samples) noexcept override;
  bool hold_pressed() const noexcept override { return hold_pressed_; }

 private:
  void go_on(Nanoseconds now) noexcept;

  SpaceMouseConfig config_;
  std::size_t body_;  // its target's; the first that can be held, where it takes hold of bodies
  Nanoseconds (*clock_)() noexcept;
  Nanoseconds stale_after_;
  StreamedTarget stream_;

  // The thread's.
  StreamedSample said_;
  Vec3 v_W_ = Vec3::Zero(), w_W_ = Vec3::Zero();
  Nanoseconds t_event_ = 0;  // of the last motion

  // The loop's.
  bool hold_pressed_ = false;
};

/// The scene led by its SpaceMouse: its motion is out of play.
void lead_by_spacemouse(SceneConfig& scene);

}  // namespace godobject
