// A SpaceMouse as the device, in rate control: the deflection of its cap sets the velocity of the target. The
// cap travels only a millimetre and springs back (docs/decisions/051-spacemouse.md).
#pragma once

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
  SpaceMouse(const SceneConfig& scene, Nanoseconds (*clock)() noexcept);

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
  Nanoseconds (*clock_)() noexcept;
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
void lead_by_spacemouse(SceneConfig& scene);

}  // namespace godobject
