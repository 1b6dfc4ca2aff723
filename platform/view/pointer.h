// The hand in the page as the device: what its pointer says are samples of a device that takes hold of bodies, with
// limits, played back without stairs, and stale after three periods without one.
#pragma once

#include <optional>
#include <vector>

#include "platform/device/hand_device.h"
#include "platform/device/streamed_target.h"
#include "platform/view/frame.h"

namespace godobject {

/// A page sends a sample at least so often, and mostly 60 times a second: one that draws without a graphics card is slow.
inline constexpr Nanoseconds pointer_period_ns = 100'000'000, pointer_stale_ns = 3 * pointer_period_ns;
/// Faster a pointer does not move its target: what a message asks for beyond is left out, and the loop sees to it.
inline constexpr double max_pointer_speed = 1, max_pointer_turn_rate = 10;  // m/s, rad/s

class PointerDevice final : public HandDevice {
 public:
  /// Clock: of the loop, and of take().
  PointerDevice(const SceneConfig& scene, Nanoseconds (*clock)() noexcept);

  // The view's thread:

  /// A message of a client. p_WB: where the body is, for a message that takes hold of it. False: somebody else holds.
  bool take(std::uint64_t client, const PointerMessage& message, const Vec3& p_WB);
  /// The client is gone: what it holds is let go.
  void leave(std::uint64_t client);
  std::size_t num_bodies() const noexcept { return driven_.size(); }

  // The loop:

  void read(Period& period, std::span<BodySample> samples) noexcept override;
  std::optional<HoldWish> hold() const noexcept override { return stream_.heard().wish; }

 private:
  void say(std::optional<std::size_t> held, Nanoseconds now) noexcept;

  Nanoseconds (*clock_)() noexcept;
  std::vector<std::size_t> driven_;
  StreamedTarget stream_;

  // The view's thread's.
  StreamedSample said_;
  std::optional<std::uint64_t> client_;  // that holds
  std::uint32_t number_ = 0;             // of its last message
};

/// The scene with the pointer as its device: it takes hold of any coupled body, wherever it is, and nothing else moves.
/// An instrument that a motion moves by its joints is moved by them: see lead_joints_by_page().
void lead_by_pointer(SceneConfig& scene);

}  // namespace godobject
