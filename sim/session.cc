#include "sim/session.h"

#include <algorithm>
#include <cmath>

#include "sim/sim_tracker_link.h"

namespace godobject {
namespace {

/// Answers to a SYNC are waited for this share of the period; the rest is for the step and the commands.
constexpr double gather_share = 0.75;
constexpr int gather_polls = 16;  // of simulated buses

PoseError difference(const Pose& a, const Pose& b) noexcept {
  return {.m = (a.p - b.p).norm(), .rad = rotation_error(a.q, b.q, Vec3::Zero()).phi_B.norm()};
}

PoseError worst(const PoseError& a, const PoseError& b) noexcept {
  return {.m = std::max(a.m, b.m), .rad = std::max(a.rad, b.rad)};
}

}  // namespace

Session::Session(const SceneConfig& scene, Motion motion) : scene_(scene), motion_(std::move(motion)) {
  if (scene_.device && scene_.device->rig) scene_.device->rig->cycle_s = scene_.step;
  const auto period_ns = static_cast<double>(std::llround(scene.step * 1e9));
  gather_ns_ = static_cast<Nanoseconds>(gather_share * period_ns) / gather_polls * gather_polls;
}

Session::Made Session::make(const SceneConfig& scene, Motion motion, BusChoice bus) {
  return make(scene, std::move(motion), bus, {});
}

Session::Made Session::make(const SceneConfig& scene, Motion motion, std::unique_ptr<RigLink> buses) {
  return make(scene, std::move(motion), RealDevice{.buses = std::move(buses), .trackers = {}});
}

Session::Made Session::make(const SceneConfig& scene, Motion motion, RealDevice device) {
  return make(scene, std::move(motion), BusChoice::real, std::move(device));
}

Session::Made Session::make(const SceneConfig& scene, Motion motion, BusChoice bus, RealDevice device) {
  Made made;
  std::unique_ptr<Session> s(new Session(scene, std::move(motion)));
  s->bus_ = bus;
  s->driven_ = driven_bodies(scene);
  s->samples_.resize(scene.bodies.size());
  s->find_imposed_joints(bus == BusChoice::real, made.errors);
  s->take_motion_at_start();
  if (bus != BusChoice::direct && !s->driven_.empty()) s->connect(std::move(device), made.errors);
  if (!made.errors.empty()) return made;

  std::string why_not;
  s->engine_ = make_engine(scene, s->samples_, why_not);
  if (!s->engine_) {
    made.errors.push_back(why_not);
    return made;
  }
  if (s->bus() == BusChoice::sim) s->exact_engine_ = make_engine(scene, s->samples_, why_not);
  s->exact_samples_ = s->samples_;
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

void Session::connect(RealDevice device, std::vector<std::string>& errors) {
  const bool has_rig = scene_.device && scene_.device->rig;
  const bool has_trackers = scene_.device && !scene_.device->trackers.empty();
  if (!has_rig && !has_trackers)
    errors.push_back("scene '" + scene_.name +
                     "' describes no buses, encoders and joints: add them, or run it with --bus direct");
  if (has_rig) connect_rig(std::move(device.buses), errors);
  if (has_trackers) connect_trackers(std::move(device), errors);
}

/// The rig on its buses: simulated ones where none are given.
void Session::connect_rig(std::unique_ptr<RigLink> buses, std::vector<std::string>& errors) {
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
                                         gather_ns_ / gather_polls);
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

/// A joint that the device leads is held and let go with its body's handle, or else the first. Beyond +-pi a turn rests where it was.
void Session::impose(const JointTarget& device, bool valid, std::span<BodySample> samples) const noexcept {
  for (const ImposedJoint& joint : imposed_) {
    BodySample& sample = samples[joint.body];
    sample.valid = valid;
    for (std::size_t i = 0; i < joint.num_coordinates; ++i) {
      const Real q = device.q[joint.device_joints[i]];
      if (joint.turns[i] && !(std::abs(q) <= pi)) {
        sample.valid = false;
        continue;
      }
      sample.joint.q[static_cast<Eigen::Index>(i)] = q;
      sample.joint.q_dot[static_cast<Eigen::Index>(i)] = device.q_dot[joint.device_joints[i]];
    }
    const bool driven = scene_.bodies[joint.body].coupling.has_value();
    if (!driven && !driven_.empty()) sample.engaged = samples[driven_.front()].engaged;
  }
}

bool Session::follows() const noexcept {
  return !driven_.empty() && scene_.bodies[driven_.front()].coupling &&
         !(scene_.device && scene_.device->kind == DeviceKind::admittance);
}

void Session::cycle(CycleRecord& record) noexcept {
  ++cycle_;
  sense(motion_time(cycle_));
  const Nanoseconds step_start = step_clock_();
  const StepReport report = engine_->step(samples_);
  record.step_ns = step_clock_() - step_start;
  record.fault = report.fault;
  record.limited = report.limited;
  record.contacts = report.contacts;
  act(record);

  if (exact_engine_) static_cast<void>(exact_engine_->step(exact_samples_));
  observe(record);
}

CycleRecord Session::at_start() const {
  CycleRecord record;
  record.bodies.resize(scene_.bodies.size());
  observe(record);
  return record;
}

void Session::observe(CycleRecord& record) const noexcept {
  record.cycle = cycle_;
  record.t = motion_time(cycle_);
  record.engaged = grip_ ? grip_->body().has_value() : !driven_.empty() && samples_[driven_.front()].engaged;
  if (grip_) record.held = grip_->body();
  record.bodies.resize(scene_.bodies.size());
  for (std::size_t i = 0; i < record.bodies.size(); ++i) record.bodies[i] = engine_->view(i);
  record.energy = engine_->energy();
  if (follows()) measure(record);
}

/// What the core is told, and what it would be told by a perfect device.
void Session::sense(double t) noexcept {
  for (std::size_t i = 0; i < motion_.num_bodies(); ++i) samples_[driven_[i]] = motion_sample(i, t);
  if (motion_.has_joints()) impose(motion_.joints(t), true, samples_);
  exact_samples_ = samples_;
  if (rig_) sense_through_rig();
  if (tracked_) sense_through_trackers();
  if (grip_) grip(t);
  for (const std::size_t body : driven_)
    if (let_go_) samples_[body].engaged = exact_samples_[body].engaged = false;
  let_go_ = false;
}

void Session::sense_through_rig() noexcept {
  const DeviceSample device = exchange();
  buttons_before_ = buttons_;
  buttons_ = device.buttons;
  const bool has_clutch = rig_->has_button(ButtonUse::clutch);
  for (std::size_t k = 0; k < held_.size(); ++k) {
    BodySample& sample = samples_[held_[k]];
    sample.X_WD = device.handles[k].X_WH;
    sample.V_WD = device.handles[k].V_WH;
    sample.valid = device.valid;
    const MotionSample handle =
        sim_ ? sim_->rig().handle(k) : MotionSample{.X_WD = sample.X_WD, .V_WD = sample.V_WD};
    exact_samples_[held_[k]].X_WD = handle.X_WD;
    exact_samples_[held_[k]].V_WD = handle.V_WD;
    if (has_clutch) sample.clutch = exact_samples_[held_[k]].clutch = buttons_.clutch;
  }
  const JointTarget joints{.q = device.q, .q_dot = device.q_dot};
  impose(joints, device.valid, samples_);
  impose(sim_ ? sim_->rig().joints() : joints, true, exact_samples_);
}

/// Nothing is engaged that has not been seen. Where trackers are real nobody knows where the tools are: what they say
/// is taken for it.
void Session::sense_through_trackers() noexcept {
  if (!rig_) pass_period();
  track();
  for (std::size_t i = 0; i < tracked_bodies_.size(); ++i) {
    const TrackedPose& pose = tracked_->poses()[i];
    BodySample& sample = samples_[tracked_bodies_[i]];
    sample.X_WD = pose.target.X_WD;
    sample.V_WD = pose.target.V_WD;
    sample.valid = pose.valid;
    BodySample& exact = exact_samples_[tracked_bodies_[i]];
    sample.engaged = exact.engaged = sample.engaged && pose.seen;
    if (sim_trackers_) continue;
    exact.X_WD = sample.X_WD;
    exact.V_WD = sample.V_WD;
  }
}

/// All that can be held get the device's sample; engaged for the one that is.
void Session::grip(double t) noexcept {
  const BodySample device = samples_[driven_.front()], exact = exact_samples_[driven_.front()];
  const bool has_button = rig_ && rig_->has_button(ButtonUse::hold);
  grip_->update(motion_.hold(t), !has_button && motion_.button(t), device.X_WD.p, *engine_);
  if (buttons_.hold && !buttons_before_.hold) grip_->press(device.X_WD.p, *engine_);
  for (const std::size_t body : driven_) {
    samples_[body] = device;
    exact_samples_[body] = exact;
    samples_[body].engaged = exact_samples_[body].engaged = grip_->holds(body);
  }
}

void Session::act(CycleRecord& record) noexcept {
  if (grip_) record.hand_W = grip_->feel(samples_[driven_.front()].X_WD.p, *engine_, record.limited);
  if (!rig_) return;
  std::array<Wrench, max_handles> F_hand_W;
  for (std::size_t k = 0; k < held_.size(); ++k)
    F_hand_W[k] = grip_ ? record.hand_W : engine_->feedback(held_[k]);
  record.drives = command(std::span(F_hand_W).first(held_.size()));
  record.rig_faults = rig_->faults();
}

BodySample Session::motion_sample(std::size_t driven, double t) const noexcept {
  const MotionSample target = motion_.target(driven, t);
  const MotionSwitches switches = motion_.switches(driven, t);
  return {.X_WD = target.X_WD,
          .V_WD = target.V_WD,
          .F_WB = motion_.wrench(driven, t),
          .engaged = switches.engaged,
          .clutch = switches.clutch,
          .joint = {}};
}

void Session::measure(CycleRecord& record) const noexcept {
  record.following = record.sensing = record.exact_following = record.encoders = {};
  const bool relative = scene_.device && scene_.device->kind == DeviceKind::relative;
  const bool offset = relative || grip_;  // between handle and target
  for (const std::size_t body : driven_) {
    if (grip_ && !grip_->holds(body)) continue;
    const BodyView& view = record.bodies[body];
    const Pose& X_WH = exact_samples_[body].X_WD;
    record.following = worst(record.following, difference(view.X_WB, offset ? view.target.X_WD : X_WH));
    record.sensing = worst(record.sensing, difference(samples_[body].X_WD, X_WH));
    if (!exact_engine_) continue;
    const BodyView exact = exact_engine_->view(body);
    record.exact_following =
        worst(record.exact_following, difference(exact.X_WB, offset ? exact.target.X_WD : X_WH));
    record.encoders = worst(record.encoders, difference(view.X_WB, exact.X_WB));
  }
}

std::vector<double> Session::bus_load_percent() const {
  std::vector<double> loads;
  if (sim_)
    for (std::size_t i = 0; i < scene_.device->rig->buses.size(); ++i) loads.push_back(sim_->load_percent(i));
  return loads;
}

}  // namespace godobject
