// Exact state of a simulated device: the true handle pose, and a reference engine that receives it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "platform/device/prescribed_samples.h"
#include "platform/session/truth.h"
#include "sim/hand.h"
#include "sim/rig/link.h"

namespace godobject {

class SimulatedTruth final : public Truth {
 public:
  /// Allocates. link: link of the scene's rig, which must outlive this object; null for a device of trackers
  /// alone.
  SimulatedTruth(const SceneConfig& scene, std::shared_ptr<const Hand> hand, const SimLink* link);

  void start(const SceneConfig& scene, std::span<const BodySample> samples) override;
  void step(double t, std::span<const BodySample> samples) noexcept override;
  void measure(const Followed& followed, CycleRecord& record) const noexcept override;
  bool reachable() const noexcept override { return link_ == nullptr || link_->rig().reachable(); }
  std::vector<double> bus_load_percent() const override;

 private:
  Target target(std::size_t driven, double t) const noexcept;

  std::shared_ptr<const Hand> hand_;
  const SimLink* link_;
  std::vector<std::size_t> driven_;                 // bodies
  std::vector<std::optional<std::size_t>> handle_;  // handle of each driven body, if the rig has one
  bool grips_bodies_ = false;                       // true if one handle moves any held body
  PrescribedSamples joints_;
  std::vector<BodySample> samples_;  // samples of an ideal device
  std::unique_ptr<Engine> engine_;
};

}  // namespace godobject
