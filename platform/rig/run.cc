#include "platform/rig/run.h"

#include <algorithm>
#include <cstdio>

#include "platform/device/hand_device.h"
#include "platform/rig/buses.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/setup.h"
#include "platform/rt/signals.h"
#include "platform/scene/toml.h"
#include "platform/session/passivity.h"

namespace godobject {
namespace {

std::string lines(const std::vector<std::string>& all) {
  std::string text;
  for (const std::string& line : all) text += line + "\n";
  return text;
}

/// One period of the loop, from booting to the end.
class RigCycle {
 public:
  RigCycle(const SceneConfig& scene, RigDevice& device, const RigRun::Step& step, const StopSignals& signals)
      : device_(device),
        step_(step),
        signals_(signals),
        phases_(scene.step),
        deadlines_(scene.step),
        samples_(scene.bodies.size()),
        F_hand_W_(scene.bodies.size()) {
    phases_.add(device_);
    phases_.start(usual_boot_limit_s);
  }

  /// Returns false after the last period.
  bool operator()(const Wake& wake) noexcept GODOBJECT_NONBLOCKING {
    if (signals_.requested().load(std::memory_order_relaxed)) phases_.stop();
    if (signals_.insisted().load(std::memory_order_relaxed)) phases_.quick_stop();
    if (phases_.phase() == RunPhase::running) {
      step(wake);
    } else {
      phases_.advance(t());
      deadlines_.reset();
    }
    return phases_.phase() != RunPhase::ended;
  }

  std::uint64_t steps() const noexcept { return steps_; }

 private:
  double t() const noexcept { return static_cast<double>(steps_) * phases_.period().step; }

  void step(const Wake& wake) noexcept {
    deadlines_.add(wake.late_before, wake.skipped);
    if (deadlines_.lost()) device_.tell(RunTrouble::deadlines_missed);
    ++steps_;
    Period& period = phases_.begin(t());
    device_.read(period, samples_);
    if (deadlines_.holds() || deadlines_.lost())
      for (BodySample& sample : samples_) sample.valid = false;
    std::ranges::fill(F_hand_W_, Wrench{});
    const bool goes_on =
        loop::call(step_, std::span<const BodySample>(samples_), std::span<Wrench>(F_hand_W_));
    Shown shown;
    device_.command(period, F_hand_W_, shown);
    if (!goes_on || any(shown.faults)) phases_.stop();
  }

  RigDevice& device_;
  const RigRun::Step& step_;
  const StopSignals& signals_;
  DevicePhases phases_;
  DeadlineWatch deadlines_;
  std::vector<BodySample> samples_;
  std::vector<Wrench> F_hand_W_;
  std::uint64_t steps_ = 0;
};

}  // namespace

RigRun::RigRun(const std::string& scene_file, std::span<const std::string> addresses) {
  if (!keep_standard_descriptors()) {
    errors_.emplace_back(
        "a standard stream is closed, and /dev/null cannot be opened in its place: mount /dev");
    return;
  }
  LoadResult loaded = load_scene(scene_file);
  errors_ = std::move(loaded.errors);
  if (!loaded.scene || !errors_.empty()) return;
  scene_ = *std::move(loaded.scene);
  if (!scene_.device || !scene_.device->rig) {
    errors_.push_back(scene_file + ": the scene's device has no buses: add them, with encoders and joints");
    return;
  }
  errors_ = RigDevice::complaints(scene_);
  profiles_ = checked_profiles(scene_, scene_file, errors_);
  const RigParams& rig = *scene_.device->rig;
  if (errors_.empty())
    for (const BusLoad& load : bus_load(rig, scene_.step, usual_load(rig)))
      if (is_overloaded(load)) errors_.push_back(scene_file + ": " + load_advice(load));
  where_ = rig_addresses(addresses, scene_, "", errors_);
  if (where_.are_logs())
    errors_.push_back(scene_file + ": a log is no device: run it with godobject run " + scene_file +
                      " --bus replay:FILE");
  if (!errors_.empty()) return;
  auto link = make_link(where_, rig, scene_.step, false);
  link_ = link.get();
  const JointVector at_zero = JointVector::Zero(static_cast<Eigen::Index>(rig.tree.joints.size()));
  device_ = std::make_unique<RigDevice>(scene_, std::move(link), passivity_controllers(scene_, at_zero));
  errors_ = open_buses(*link_, where_, rig);
}

RigRun::Result RigRun::run(const Step& step) {
  Result result;
  guard_process();
  const StopSignals signals(Suspension::stops);
  const RigParams& rig = *scene_.device->rig;
  result.why_not = lines(bring_up({*link_, where_, rig, scene_.step, profiles_}, signals.requested()));
  if (result.why_not.empty() && !signals.requested()) {
    const LastResort last_resort(last_words(rig, scene_.step, *link_));
    const SignalStack stack;
    const RtProcess process;
    static_cast<void>(set_up_rt_thread());
    if (device_->rig().needs_homing()) std::fprintf(stderr, "%s\n", homing_request(rig).c_str());
    RigCycle cycle(scene_, *device_, step, signals);
    MonotonicClock clock;
    Cyclic loop(clock, to_ns(scene_.step));
    loop.run(cycle);
    result.steps = cycle.steps();
    result.missed_deadlines = loop.statistics().missed();
    result.faults = device_->rig().fault_text();
    if (result.steps == 0) result.why_not = lines(bus_troubles(*link_, where_, rig)) + result.faults;
  }
  result.signal = signals.name();
  return result;
}

}  // namespace godobject
