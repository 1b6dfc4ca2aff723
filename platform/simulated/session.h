// Simulated devices of scenes. This folder, the command line's `simulate` and the Python module are the only
// users of sim in platform. It is a library of its own (godobject::simulated).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "platform/device/hand_device.h"
#include "platform/scene/toml.h"
#include "platform/session/record.h"
#include "platform/session/session.h"
#include "sim/fault/target.h"
#include "sim/hand.h"
#include "sim/rig/link.h"
#include "sim/rig/rig.h"
#include "sim/tracker/trackers.h"

namespace godobject {

/// Returns the interface to this simulation for code that does not link it: see
/// platform/session/session.h.
SimulatedDevices simulated_devices();

/// Makes a session. bus: sim: the scene's device, simulated; direct: no device, the motion drives the core.
/// profiles: profiles of the simulated nodes.
Session::Made make_session(SceneConfig scene, Motion motion, BusChoice bus, const RigProfiles& profiles = {});

/// Returns the motion as the hand that moves a simulated device.
std::shared_ptr<const Hand> hand_of(Motion motion);
/// Returns the simulator configuration for the scene's device (which must exist). Handles of unknown bodies
/// stay fixed.
SimRigConfig sim_rig_config(const SceneConfig& scene);
/// Returns the configuration of simulated trackers for the scene's device (which must have trackers).
SimTrackersConfig sim_trackers_config(const SceneConfig& scene);

/// Returns the reason why the simulated device cannot play this fault; empty if it can.
inline std::string why_not_playable(const FaultConfig& fault, const DeviceConfig& device) {
  if (!fault.tracker.empty()) return resolve(fault, device.trackers).error;
  return resolve(fault, *device.rig).error;
}

inline std::vector<std::string> fault_verb_names() {
  std::vector<std::string> names;
  for (const FaultVerbText& text : fault_verb_texts()) names.emplace_back(text.name);
  return names;
}

/// Returns the checks for load_scene() and load_faults(), which add the place in the file to errors.
inline FaultChecks simulated_faults() {
  return {.verbs = fault_verb_names, .why_not_playable = why_not_playable};
}

/// Exact state of a simulated device: the true handle pose, and a reference engine that receives it.
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
