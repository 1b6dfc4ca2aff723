// Keys and wheel in the page as the device of an articulated instrument: they move the coordinates of its
// joints.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "platform/device/hand_device.h"
#include "platform/device/prescribed_samples.h"
#include "platform/rt/ring.h"
#include "platform/view/frame.h"

namespace godobject {

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

class JointPointer final : public HandDevice {
 public:
  /// Allocates; the other functions do not. scene: after lead_joints_by_page(). clock: clock of the loop and
  /// of take().
  JointPointer(const SceneConfig& scene, Nanoseconds (*clock)() noexcept);

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

  Nanoseconds (*clock_)() noexcept;
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
