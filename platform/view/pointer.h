// The page's pointer as a device that grips bodies: its messages are limited and interpolated. They are stale
// after three periods without a message.
#pragma once

#include <optional>
#include <vector>

#include "platform/device/hand_device.h"
#include "platform/device/streamed_target.h"
#include "platform/view/frame.h"

namespace godobject {

/// Longest interval of a page's samples. Usually there are 60 per second; pages without a graphics card are
/// slower.
inline constexpr Nanoseconds pointer_period_ns = 100'000'000, pointer_stale_ns = 3 * pointer_period_ns;
/// Limits of the target's speed, enforced by the loop; motion beyond them is left out.
inline constexpr double max_pointer_speed = 1, max_pointer_turn_rate = 10;  // m/s, rad/s

class PointerDevice final : public HandDevice {
 public:
  /// clock: clock of the loop and of take().
  PointerDevice(const SceneConfig& scene, Nanoseconds (*clock)() noexcept);

  // For the view's thread:

  /// Applies a message of a client. Returns false if another client holds a body. p_WB: position of the body,
  /// for a message that grips it, world, m.
  bool take(std::uint64_t client, const PointerMessage& message, const Vec3& p_WB);
  /// Releases the body of a client that is gone.
  void leave(std::uint64_t client);
  std::size_t num_bodies() const noexcept { return driven_.size(); }

  // For the loop:

  void read(Period& period, std::span<BodySample> samples) noexcept override;
  std::optional<HoldWish> hold() const noexcept override { return stream_.heard().wish; }

 private:
  void say(std::optional<std::size_t> held, Nanoseconds now) noexcept;

  Nanoseconds (*clock_)() noexcept;
  std::vector<std::size_t> driven_;
  StreamedTarget stream_;

  // State of the view's thread:
  StreamedSample sent_;
  std::optional<std::uint64_t> client_;  // client that holds a body
  std::uint32_t number_ = 0;             // number of its last message
};

/// Replaces the scene's device by the pointer, which can grip any coupled body at any place; no other motion
/// remains. An instrument moved by its joints is moved by joints here too: see lead_joints_by_page().
void lead_by_pointer(SceneConfig& scene);

}  // namespace godobject
