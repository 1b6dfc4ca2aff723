#include "platform/simulated/session.h"

#include <cmath>

#include "sim/rig/link.h"
#include "sim/tracker/link.h"

namespace godobject {
namespace {

class MotionHand final : public Hand {
 public:
  explicit MotionHand(Motion motion) : motion_(std::move(motion)) {}
  bool moves_joints() const noexcept override { return motion_.has_joints(); }
  JointTarget joints(double t) const noexcept override { return motion_.joints(t); }
  Target target(std::size_t index, double t) const noexcept override { return motion_.target(index, t); }
  bool presses_clutch(std::size_t index, double t) const noexcept override {
    return motion_.switches(index, t).clutch;
  }
  bool presses_hold(double t) const noexcept override { return motion_.button(t); }

 private:
  Motion motion_;
};

/// Link of a simulated tracker with tools moved by the hand.
class MovedTrackerLink final : public TrackerLink {
 public:
  /// tools: tools of all trackers of the scene. moves_tools: true for the one link that moves them.
  MovedTrackerLink(std::unique_ptr<SimTrackerLink> link, std::shared_ptr<SimTrackers> tools, bool moves_tools)
      : link_(std::move(link)), tools_(std::move(tools)), moves_tools_(moves_tools) {}

  void begin_cycle(Nanoseconds now, double motion_time) noexcept override {
    if (moves_tools_) tools_->run(now, motion_time);
  }
  [[nodiscard]] bool try_read(TrackerReport& out, Nanoseconds now) noexcept override {
    return link_->try_read(out, now);
  }
  const TrackerParams& params() const noexcept override { return link_->params(); }

 private:
  std::unique_ptr<SimTrackerLink> link_;
  std::shared_ptr<SimTrackers> tools_;
  bool moves_tools_;
};

/// Makes the rig's link; null with errors.
std::unique_ptr<SimLink> make_rig(const SceneConfig& scene, const std::shared_ptr<const Hand>& hand,
                                  const RigProfiles& profiles, std::vector<std::string>& errors) {
  errors = RigDevice::complaints(scene);
  if (!errors.empty()) return nullptr;
  const std::string why_not = SimRig::why_not(scene.device->rig->tree, *hand);
  if (!why_not.empty()) {
    errors.push_back(why_not);
    return nullptr;
  }
  return std::make_unique<SimLink>(sim_rig_config(scene), scene.step, hand,
                                   gather_time(scene.step) / gather_polls, profiles);
}

std::vector<std::unique_ptr<TrackerLink>> make_trackers(const SceneConfig& scene,
                                                        const std::shared_ptr<const Hand>& hand,
                                                        std::vector<std::string>& errors) {
  const std::vector<TrackerParams>& trackers = scene.device->trackers;
  std::vector<std::unique_ptr<SimTrackerLink>> made;
  std::vector<SimTracker*> far;
  for (std::size_t i = 0; i < trackers.size(); ++i) {
    auto link = make_sim_tracker_link(trackers[i], simulated_rate_hz(trackers[i].protocol),
                                      scene.wire.seed + i, errors);
    if (link) far.push_back(&link->far());
    made.push_back(std::move(link));
  }
  std::vector<std::unique_ptr<TrackerLink>> links;
  if (!errors.empty()) return links;
  const auto tools = std::make_shared<SimTrackers>(sim_trackers_config(scene), hand, std::move(far));
  for (std::size_t i = 0; i < made.size(); ++i)
    links.push_back(std::make_unique<MovedTrackerLink>(std::move(made[i]), tools, i == 0));
  return links;
}

/// Returns one error for each fault that cannot be played; none for scenes that load_scene() checked.
std::vector<std::string> unplayable_faults(const SceneConfig& scene) {
  std::vector<std::string> errors;
  for (const FaultConfig& fault : scene.faults) {
    if (!scene.device || (fault.tracker.empty() && !scene.device->rig)) continue;
    const std::string why_not = why_not_playable(fault, *scene.device);
    if (!why_not.empty()) errors.push_back("fault '" + fault.verb + "' cannot be played: " + why_not);
  }
  return errors;
}

std::unique_ptr<TrackerLink> make_resting_tracker(const TrackerParams& params,
                                                  std::vector<std::string>& errors) {
  return make_sim_tracker_link(params, simulated_rate_hz(params.protocol), 1, errors);
}

Session::Made make_simulated_session(SceneConfig scene, Motion motion, const RigProfiles& profiles) {
  DeviceParts device;
  std::vector<std::string> errors = unplayable_faults(scene);
  const std::shared_ptr<const Hand> hand = hand_of(motion);
  std::unique_ptr<SimLink> rig;
  if (errors.empty() && scene.device && scene.device->rig) rig = make_rig(scene, hand, profiles, errors);
  if (errors.empty() && scene.device) device.trackers = make_trackers(scene, hand, errors);
  if (!errors.empty()) return {.session = nullptr, .errors = errors};
  device.truth = std::make_unique<SimulatedTruth>(scene, hand, rig.get());
  device.buses = std::move(rig);
  return Session::make(std::move(scene), std::move(motion), std::move(device));
}

}  // namespace

// ---- session --------------------------------------------------------------------------------------

SimulatedDevices simulated_devices() {
  return {.faults = simulated_faults(),
          .make_session = make_simulated_session,
          .make_resting_tracker = make_resting_tracker};
}

std::shared_ptr<const Hand> hand_of(Motion motion) { return std::make_shared<MotionHand>(std::move(motion)); }

SimRigConfig sim_rig_config(const SceneConfig& scene) {
  const std::vector<std::optional<std::size_t>> by_handle = driven_by_handles(scene);
  return {.rig = *scene.device->rig,
          .plant = scene.device->plant,
          .wire = scene.wire,
          .faults = scene.faults,
          .shows_force = shows_force(scene.device->kind),
          .target = by_handle.empty() ? 0 : by_handle.front().value_or(0)};
}

SimTrackersConfig sim_trackers_config(const SceneConfig& scene) {
  SimTrackersConfig config{.trackers = scene.device->trackers, .faults = scene.faults, .targets = {}};
  for (const TrackerParams& tracker : config.trackers) {
    config.targets.emplace_back();
    for (const TrackedToolParams& tool : tracker.tools)
      config.targets.back().push_back(driven_by_tool(scene, tool));
  }
  return config;
}

Session::Made make_session(SceneConfig scene, Motion motion, BusChoice bus, const RigProfiles& profiles) {
  if (bus == BusChoice::direct || driven_bodies(scene).empty())
    return Session::make(std::move(scene), std::move(motion));
  return make_simulated_session(std::move(scene), std::move(motion), profiles);
}

// ---- exact state ----------------------------------------------------------------------------------

SimulatedTruth::SimulatedTruth(const SceneConfig& scene, std::shared_ptr<const Hand> hand,
                               const SimLink* link)
    : hand_(std::move(hand)),
      link_(link),
      driven_(driven_bodies(scene)),
      handle_(driven_.size()),
      grips_bodies_(grips_bodies(scene)) {
  if (link_ == nullptr) return;
  const std::vector<std::optional<std::size_t>> by_handle = driven_by_handles(scene);
  for (std::size_t k = 0; k < by_handle.size(); ++k)
    if (by_handle[k]) handle_[*by_handle[k]] = k;
  joints_ = PrescribedSamples(scene);
}

void SimulatedTruth::start(const SceneConfig& scene, std::span<const BodySample> samples) {
  samples_.assign(samples.begin(), samples.end());
  std::string why_not;
  engine_ = make_engine(scene, samples_, why_not);
}

/// Returns the exact pose of the handle of this driven body; without a handle, the hand's target.
Target SimulatedTruth::target(std::size_t driven, double t) const noexcept {
  const std::size_t index = grips_bodies_ ? 0 : driven;
  if (handle_[index]) return link_->rig().handle(*handle_[index]);
  return hand_->target(index, t);
}

void SimulatedTruth::step(double t, std::span<const BodySample> samples) noexcept {
  std::ranges::copy(samples, samples_.begin());
  for (BodySample& sample : samples_) sample.valid = true;
  for (std::size_t i = 0; i < driven_.size(); ++i) samples_[driven_[i]].target = target(i, t);

  if (link_ != nullptr) joints_.write(link_->rig().joints(), true, samples_);
  for (std::size_t i = 0; i < samples_.size(); ++i) samples_[i].engaged = samples[i].engaged;
  static_cast<void>(engine_->step(samples_));
}

void SimulatedTruth::measure(const Followed& followed, CycleRecord& record) const noexcept {
  record.following = {};
  for (const std::size_t body : followed.bodies) {
    const Pose &X_WH = samples_[body].target.X_WD, &X_WD = followed.samples[body].target.X_WD;
    const BodyView &view = record.bodies[body], exact = engine_->view(body);
    const auto following = [&](const BodyView& of) {
      return between(of.X_WB, followed.by_an_offset ? of.target.X_WD : X_WH);
    };
    record.following = worst(record.following, following(view));
    record.exact_following = worst(record.exact_following, following(exact));
    record.sensing = worst(record.sensing, between(X_WD, X_WH));
    record.encoders = worst(record.encoders, between(view.X_WB, exact.X_WB));
  }
}

std::vector<double> SimulatedTruth::bus_load_percent() const {
  std::vector<double> loads;
  if (link_ != nullptr)
    for (std::size_t i = 0; i < link_->rig().host_buses().size(); ++i)
      loads.push_back(link_->load_percent(i));
  return loads;
}

}  // namespace godobject
