// Session: what it is made of, and the complaints about what cannot be.
#include <algorithm>
#include <cmath>

#include "hal/rig/validate.h"
#include "platform/session/session.h"
#include "sim/tracker/link.h"

namespace godobject {
namespace {

/// Answers to a SYNC are waited for this share of the period; the rest is for the step and the commands.
constexpr double gather_share = 0.75;
constexpr int gather_polls = 16;  // of simulated buses

}  // namespace

Session::Session(const SceneConfig& scene, Motion motion) : scene_(scene), motion_(std::move(motion)) {
  if (scene_.device && scene_.device->rig) scene_.device->rig->cycle_s = scene_.step;
  const auto period_ns = static_cast<double>(std::llround(scene.step * 1e9));
  gather_ns_ = static_cast<Nanoseconds>(gather_share * period_ns) / gather_polls * gather_polls;
}

Session::Made Session::make(const SceneConfig& scene, Motion motion, BusChoice bus, RigProfiles profiles) {
  return make(scene, std::move(motion), bus, RealDevice{}, profiles);
}

Session::Made Session::make(const SceneConfig& scene, Motion motion, std::unique_ptr<RigLink> buses) {
  return make(scene, std::move(motion), RealDevice{.buses = std::move(buses), .trackers = {}});
}

Session::Made Session::make(const SceneConfig& scene, Motion motion, RealDevice device) {
  return make(scene, std::move(motion), BusChoice::real, std::move(device), {});
}

Session::Made Session::make(const SceneConfig& scene, Motion motion, BusChoice bus, RealDevice device,
                            const RigProfiles& profiles) {
  Made made;
  std::unique_ptr<Session> s(new Session(scene, std::move(motion)));
  s->bus_ = bus;
  s->driven_ = driven_bodies(scene);
  s->samples_.resize(scene.bodies.size());
  s->find_imposed_joints(bus == BusChoice::real, made.errors);
  s->take_motion_at_start();
  if (bus != BusChoice::direct && !s->driven_.empty()) s->connect(std::move(device), profiles, made.errors);
  if (!made.errors.empty()) return made;

  std::string why_not;
  s->engine_ = make_engine(scene, s->samples_, why_not);
  if (!s->engine_) {
    made.errors.push_back(why_not);
    return made;
  }
  if (s->bus() == BusChoice::sim) s->exact_engine_ = make_engine(scene, s->samples_, why_not);
  s->exact_samples_ = s->samples_;
  s->swings_.emplace(scene, s->grip_ ? 1 : s->driven_.size());
  made.session = std::move(s);
  return made;
}

void Session::take_motion_at_start() {
  for (std::size_t i = 0; i < driven_.size(); ++i)
    samples_[driven_[i]] = motion_sample(std::min(i, motion_.num_bodies() - 1), 0);
  if (takes_hold(scene_)) {
    grip_.emplace(scene_);
    for (const std::size_t body : driven_) samples_[body].engaged = false;
  }
  if (motion_.has_joints()) impose(motion_.joints(0), true, samples_);
}

void Session::connect(RealDevice device, const RigProfiles& profiles, std::vector<std::string>& errors) {
  const bool has_rig = scene_.device && scene_.device->rig;
  const bool has_trackers = scene_.device && !scene_.device->trackers.empty();
  if (!has_rig && !has_trackers)
    errors.push_back("scene '" + scene_.name +
                     "' describes no buses, encoders and joints: add them, or run it with --bus direct");
  if (has_rig) connect_rig(std::move(device.buses), profiles, errors);
  if (has_trackers) connect_trackers(std::move(device), errors);
}

/// The rig on its buses: simulated ones where none are given.
void Session::connect_rig(std::unique_ptr<RigLink> buses, const RigProfiles& profiles,
                          std::vector<std::string>& errors) {
  const RigParams& rig = *scene_.device->rig;
  for (const std::string& error : validate(rig)) errors.push_back(error);
  if (scene_.device->kind == DeviceKind::admittance)
    errors.push_back("admittance devices run with --bus direct for now");
  if (!errors.empty()) return;
  const std::vector<std::optional<std::size_t>> by_handle = driven_by_handles(scene_);
  for (std::size_t handle = 0; handle < by_handle.size(); ++handle) {
    if (by_handle[handle]) held_.push_back(driven_[*by_handle[handle]]);
    else
      errors.push_back("handle of body '" + rig.tree.handles[handle].body +
                       "': the scene has no such coupled body");
  }
  if (!errors.empty()) return;
  if (buses) {
    link_ = std::move(buses);
  } else {
    const std::string why_not = SimRig::why_not(scene_, motion_);
    if (!why_not.empty()) {
      errors.push_back(why_not);
      return;
    }
    auto sim = std::make_unique<SimLink>(scene_, motion_, std::llround(scene_.step * 1e9),
                                         gather_ns_ / gather_polls, profiles);
    sim_ = sim.get();
    link_ = std::move(sim);
  }
  rig_.emplace(rig, link_->buses());
}

/// A tool is where its tracker says; simulated ones measure the motion.
void Session::connect_trackers(RealDevice device, std::vector<std::string>& errors) {
  const std::vector<TrackerParams>& trackers = scene_.device->trackers;
  std::vector<SimTracker*> far;
  for (std::size_t i = 0; bus_ == BusChoice::sim && i < trackers.size(); ++i) {
    auto link = make_sim_tracker_link(trackers[i], simulated_rate_hz(trackers[i].protocol),
                                      scene_.wire.seed + i, errors);
    if (link) far.push_back(&link->far());
    device.trackers.push_back(std::move(link));
  }
  for (std::size_t i = device.trackers.size(); i < trackers.size(); ++i)
    errors.push_back("tracker '" + trackers[i].name + "' of the scene has no port: give --tracker " +
                     trackers[i].name + "=PORT, or --tracker scene");
  if (!errors.empty()) return;
  for (const TrackerParams& tracker : trackers)
    for (const TrackedToolParams& tool : tracker.tools)
      tracked_bodies_.push_back(driven_[driven_by_tool(scene_, tool)]);
  clock_ = device.clock;
  if (bus_ == BusChoice::sim) sim_trackers_.emplace(scene_, motion_, std::move(far));
  tracked_.emplace(std::move(device.trackers));
}

/// The device's joint for each coordinate of the imposed joints.
void Session::find_imposed_joints(bool real, std::vector<std::string>& errors) {
  for (const JointConfig& joint : scene_.joints) {
    if (!joint.imposed) continue;
    if (!motion_.has_joints() && !real) {
      errors.push_back(
          "joint '" + joint.name +
          "' is imposed: the motion must be one of the device's joints; give --motion a column for "
          "each, or the scene [[motion.joint]] tables");
      continue;
    }
    const std::vector<DeviceJoint>& device = scene_.device->rig->tree.joints;
    ImposedJoint imposed{.body = *body_named(scene_, joint.child),
                         .num_coordinates = joint.coordinates.size()};
    for (std::size_t i = 0; i < imposed.num_coordinates; ++i) {
      imposed.device_joints[i] =
          std::ranges::find(device, joint.coordinates[i], &DeviceJoint::name) - device.begin();
      imposed.turns[i] = is_turn(joint.kind, i);
    }
    imposed_.push_back(imposed);
  }
}

}  // namespace godobject
