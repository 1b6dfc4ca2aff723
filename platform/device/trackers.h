// Trackers as the device: each tool's tracked pose is a target.
#pragma once

#include <memory>
#include <vector>

#include "platform/device/hand_device.h"
#include "platform/device/tracked_poses.h"

namespace godobject {

class TrackerDevice final : public HandDevice {
 public:
  /// Allocates; the other functions do not. links: one for each tracker of the scene's device, in their
  /// order.
  /// clock: clock of the links, used if no rig sets the time; null: one step per period.
  TrackerDevice(const SceneConfig& scene, std::vector<std::unique_ptr<TrackerLink>> links,
                Nanoseconds (*clock)() noexcept);

  std::optional<double> boot_limit_s() const noexcept override;
  void boot(Period& period) noexcept override { update(period); }
  bool ready() const noexcept override { return poses_.ready(); }
  bool failed() const noexcept override;
  void read(Period& period, std::span<BodySample> samples) noexcept override;

  const TrackedPoses& poses() const noexcept { return poses_; }

 private:
  void update(Period& period) noexcept;

  std::vector<std::size_t> bodies_;  // one per pose
  Nanoseconds (*clock_)() noexcept;
  TrackedPoses poses_;
};

}  // namespace godobject
