// Keys and wheel in the page as the device of an articulated instrument: they move the coordinates of its joints.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "platform/device/hand_device.h"
#include "platform/device/led_joints.h"
#include "platform/rt/ring.h"
#include "platform/view/frame.h"

namespace godobject {

/// Largest rates at which a page moves a turn, rad/s, and a slide, m/s. The loop enforces them.
inline constexpr double max_page_turn_rate = 3, max_page_slide_rate = 0.3;

/// Interval in which a page moves a coordinate, rad or m.
struct CoordinateRange {
  double lower = 0, upper = 0;
};

/// True if pages move the joints of this scene's device instead of its bodies: its motion is one of joints.
bool page_moves_joints(const SceneConfig& scene);

/// Replaces the device by its joints alone, at rest where the motion begins. page_moves_joints() is true.
void lead_joints_by_page(SceneConfig& scene);

/// For each joint of the device: its stops and half their distance beyond, so that jaws can press; without stops half
/// a turn, or half a metre, about the start.
std::vector<CoordinateRange> page_ranges(const SceneConfig& scene);

class JointPointer final : public HandDevice {
 public:
  /// scene: of lead_joints_by_page(). clock: of the loop and of take(). Allocates; nothing later does.
  JointPointer(const SceneConfig& scene, Nanoseconds (*clock)() noexcept);

  // The view's thread:

  /// Applies a message of a client. False if another client moves the joints, or the message is not for this device.
  bool take(std::uint64_t client, const JointsMessage& message);
  /// The client is gone: its coordinates stay.
  void leave(std::uint64_t client);

  // The loop:

  void read(Period& period, std::span<BodySample> samples) noexcept override;

 private:
  using Coordinates = std::array<double, max_joints>;
  struct Sample {
    Coordinates q{};
    bool leads = false;  // stale if the next sample does not come
    Nanoseconds t = 0;
  };

  void push(bool leads, Nanoseconds now) noexcept;
  double max_rate(std::size_t joint) const noexcept;

  Nanoseconds (*clock_)() noexcept;
  std::vector<DeviceJoint> joints_;
  std::vector<CoordinateRange> ranges_;
  KinematicTree tree_;
  std::vector<std::size_t> bodies_;  // of each handle
  LedJoints led_;
  Ring<Sample> samples_{64};

  // The view's thread's.
  Sample said_;
  std::optional<std::uint64_t> client_;  // that moves the joints
  std::uint32_t number_ = 0;             // of its last message
  Coordinates room_{};                   // by which it may still move each joint at once, rad or m

  // The loop's.
  Sample heard_;
  JointTarget shown_;
};

}  // namespace godobject
