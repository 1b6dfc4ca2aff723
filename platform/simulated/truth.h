// The truth of a simulated device: the handle as it is, and an engine beside the session's that is told it exactly.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "platform/device/led_joints.h"
#include "platform/session/truth.h"
#include "sim/hand.h"
#include "sim/rig/link.h"

namespace godobject {

class SimulatedTruth final : public Truth {
 public:
  /// link: of the scene's rig, which outlives this; null for a device of trackers alone. Allocates.
  SimulatedTruth(const SceneConfig& scene, std::shared_ptr<const Hand> hand, const SimLink* link);

  void start(std::span<const BodySample> samples) override;
  void step(double t, std::span<const BodySample> samples) noexcept override;
  void measure(const Followed& followed, CycleRecord& record) const noexcept override;
  bool reachable() const noexcept override { return link_ == nullptr || link_->rig().reachable(); }
  std::vector<double> bus_load_percent() const override;

 private:
  Target target(std::size_t driven, double t) const noexcept;

  SceneConfig scene_;
  std::shared_ptr<const Hand> hand_;
  const SimLink* link_;
  std::vector<std::size_t> driven_;                 // bodies
  std::vector<std::optional<std::size_t>> handle_;  // of each of them, where the rig has one for it
  bool takes_hold_ = false;                         // one handle leads whatever is held
  LedJoints joints_;
  std::vector<BodySample> samples_;  // what a perfect device would tell
  std::unique_ptr<Engine> engine_;
};

}  // namespace godobject
