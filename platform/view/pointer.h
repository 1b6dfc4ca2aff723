// Input of a page as the device of a run: its pointer grips bodies; its keys and wheel move the joints of an
// articulated instrument.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "platform/device/hand_device.h"
#include "platform/device/streamed_target.h"
#include "platform/rt/ring.h"
#include "platform/view/frame.h"

namespace godobject {

/// Longest interval of a page's samples. Usually there are 60 per second; pages without a graphics card are
/// slower.
inline constexpr Nanoseconds pointer_period_ns = 100'000'000, pointer_stale_ns = 3 * pointer_period_ns;
/// Limits of the target's speed, enforced by the loop; motion beyond them is left out.
inline constexpr double max_pointer_speed = 1, max_pointer_turn_rate = 10;  // m/s, rad/s

/// The page's pointer as a device that grips bodies: its messages are limited and interpolated. They are
/// stale after three periods without a message.
class PointerDevice final : public HandDevice {
 public:
  /// clock: clock of the loop and of take().
  PointerDevice(const SceneConfig& scene, LoopClock clock);

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

  LoopClock clock_;
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

/// Largest rates at which a page moves an angle, rad/s, and a length, m/s. The loop enforces them.
inline constexpr double max_page_turn_rate = 3, max_page_slide_rate = 0.3;

/// Interval in which a page moves a coordinate, rad or m.
struct CoordinateRange {
  double lower = 0, upper = 0;
};

/// True if pages move the joints of this scene's device instead of its bodies, because its motion is one of
/// joints.
bool page_moves_joints(const SceneConfig& scene);

/// Replaces the device by its joints alone, at rest at the start of the motion. page_moves_joints() must be
/// true.
void lead_joints_by_page(SceneConfig& scene);

/// Returns the range of each joint of the device: its stops, extended by half their distance so that jaws can
/// press. Without stops half a turn, or half a metre, about the start.
std::vector<CoordinateRange> page_ranges(const SceneConfig& scene);

/// Keys and wheel in the page as the device of an articulated instrument.
class JointPointer final : public HandDevice {
 public:
  /// Allocates; the other functions do not. scene: after lead_joints_by_page(). clock: clock of the loop and
  /// of take().
  JointPointer(const SceneConfig& scene, LoopClock clock);

  // For the view's thread:

  /// Applies a message of a client. Returns false if another client moves the joints, or the message does not
  /// fit this device.
  bool take(std::uint64_t client, const JointsMessage& message);
  /// Releases the joints of a client that is gone; the coordinates stay.
  void leave(std::uint64_t client);

  // For the loop:

  void read(Period& period, std::span<BodySample> samples) noexcept override;

 private:
  using Coordinates = std::array<double, max_joints>;
  struct Sample {
    Coordinates q{};
    bool leads = false;  // true: stale if the next sample is late
    Nanoseconds t = 0;
  };

  void push(bool leads, Nanoseconds now) noexcept;
  double max_rate(std::size_t joint) const noexcept;

  LoopClock clock_;
  std::vector<DeviceJoint> joints_;
  std::vector<CoordinateRange> ranges_;
  KinematicTree tree_;
  std::vector<std::size_t> bodies_;  // one per handle
  PrescribedSamples prescribed_;
  Ring<Sample> samples_{64};

  // State of the view's thread:
  Sample sent_;
  std::optional<std::uint64_t> client_;  // client that moves the joints
  std::uint32_t number_ = 0;             // number of its last message
  Coordinates room_{};  // remaining displacement of each joint that is allowed at once, rad or m

  // State of the loop:
  Sample heard_;
  JointTarget shown_;
};

}  // namespace godobject
