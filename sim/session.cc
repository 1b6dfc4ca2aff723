#include "sim/session.h"

#include <algorithm>
#include <cmath>

namespace godobject {
namespace {

/// Answers to a SYNC are waited for this share of the period; the rest is for the step and the commands.
constexpr double gather_share = 0.75;
constexpr int gather_polls = 16;
/// The last frames are no more than a few cycles': a command to each drive, a message to each node.
constexpr int flush_periods = 10;

PoseError difference(const Pose& a, const Pose& b) noexcept {
  return {.m = (a.p - b.p).norm(), .rad = rotation_error(a.q, b.q, Vec3::Zero()).phi_B.norm()};
}

PoseError worst(const PoseError& a, const PoseError& b) noexcept {
  return {.m = std::max(a.m, b.m), .rad = std::max(a.rad, b.rad)};
}

}  // namespace

Session::Made Session::make(const SceneConfig& scene, Motion motion, BusChoice bus) {
  Made made;
  std::unique_ptr<Session> s(new Session(scene, std::move(motion)));
  s->period_ns_ = std::llround(scene.step * 1e9);
  s->driven_ = driven_bodies(scene);
  s->samples_.resize(scene.bodies.size());
  s->find_imposed_joints(made.errors);
  for (std::size_t i = 0; i < s->driven_.size(); ++i)
    s->samples_[s->driven_[i]] = s->motion_sample(std::min(i, s->motion_.num_bodies() - 1), 0);
  if (takes_hold(scene)) {
    s->grip_.emplace(scene);
    for (const std::size_t body : s->driven_) s->samples_[body].engaged = false;
  }
  s->impose(s->motion_.joints(0), true, s->samples_);

  if (bus == BusChoice::sim && !s->driven_.empty()) {
    if (!scene.device || !scene.device->rig) {
      made.errors.push_back(
          "scene '" + scene.name +
          "' describes no buses, encoders and joints: add them, or run it with --bus direct");
      return made;
    }
    RigParams rig = *scene.device->rig;
    rig.cycle_s = scene.step;
    for (const std::string& error : validate(rig)) made.errors.push_back(error);
    if (scene.device->kind == DeviceKind::admittance)
      made.errors.push_back("admittance devices run with --bus direct for now");
    if (made.errors.empty()) {
      const std::string why_not = SimRig::why_not(s->scene_, s->motion_);
      if (!why_not.empty()) made.errors.push_back(why_not);
    }
    if (!made.errors.empty()) return made;
    for (const std::optional<std::size_t>& driven : driven_by_handles(s->scene_))
      s->held_.push_back(s->driven_[*driven]);
    s->sim_rig_ = std::make_unique<SimRig>(s->scene_, s->motion_);
    s->rig_.emplace(rig, s->sim_rig_->host_buses());
  }
  std::string why_not;
  if (made.errors.empty()) s->engine_ = make_engine(scene, s->samples_, why_not);
  if (!s->engine_ && made.errors.empty()) made.errors.push_back(why_not);
  if (!made.errors.empty()) return made;
  if (s->rig_) s->exact_engine_ = make_engine(scene, s->samples_, why_not);
  s->exact_samples_ = s->samples_;
  made.session = std::move(s);
  return made;
}

/// The device's joint for each coordinate of the imposed joints.
void Session::find_imposed_joints(std::vector<std::string>& errors) {
  for (const JointConfig& joint : scene_.joints) {
    if (!joint.imposed) continue;
    if (!motion_.has_joints()) {
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

bool Session::boot(double limit_s) {
  if (!rig_) return true;
  rig_->start(t_bus_ns_);
  const std::int64_t cycles = std::llround(limit_s / scene_.step);
  for (std::int64_t i = 0; i < cycles; ++i) {
    static_cast<void>(exchange(0));
    static_cast<void>(rig_->command({}, t_now_ns_));
    if (rig_->state() == RigState::fault) return false;
    motion_start_ns_ = t_bus_ns_;
    if (rig_->state() == RigState::ready) return rig_->arm();
  }
  return false;
}

void Session::shut_down() noexcept {
  if (!rig_) return;
  rig_->disarm();
  const std::int64_t limit = std::llround(shut_down_limit_s / scene_.step);
  for (std::int64_t i = 0; i < limit && commands_torque(); ++i) {
    static_cast<void>(exchange(motion_time(cycle_)));
    static_cast<void>(rig_->command({}, t_now_ns_));
  }
  t_bus_ns_ += period_ns_;
  sim_rig_->run_wires(t_bus_ns_);  // room in the transmit queues
  rig_->stop();
  t_bus_ns_ += flush_periods * period_ns_;
  sim_rig_->run_wires(t_bus_ns_);
}

bool Session::commands_torque() const noexcept {
  for (std::size_t i = 0; i < rig_->num_drives(); ++i)
    if (rig_->commanded_torque_Nm(i) != 0) return true;
  return false;
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
  const JointTarget hand = motion_.joints(t);
  impose(hand, true, samples_);
  exact_samples_ = samples_;
  if (rig_) sense_through_rig(t);
  if (grip_) grip(t);
}

void Session::sense_through_rig(double t) noexcept {
  const DeviceSample device = exchange(t);
  for (std::size_t k = 0; k < held_.size(); ++k) {
    BodySample& sample = samples_[held_[k]];
    sample.X_WD = device.handles[k].X_WH;
    sample.V_WD = device.handles[k].V_WH;
    sample.valid = device.valid;
    const MotionSample handle = sim_rig_->handle(k);
    exact_samples_[held_[k]].X_WD = handle.X_WD;
    exact_samples_[held_[k]].V_WD = handle.V_WD;
  }
  impose({.q = device.q, .q_dot = device.q_dot}, device.valid, samples_);
  impose(sim_rig_->joints(), true, exact_samples_);
}

/// All that can be held get the device's sample; engaged for the one that is.
void Session::grip(double t) noexcept {
  const BodySample device = samples_[driven_.front()], exact = exact_samples_[driven_.front()];
  grip_->update(motion_.hold(t), motion_.button(t), device.X_WD.p, *engine_);
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
  record.drives = rig_->command(std::span(F_hand_W).first(held_.size()), t_now_ns_);
  record.rig_faults = rig_->faults();
}

/// The rest of the last bus period, with the mechanics up to its end (the hand is then where the motion is at
/// motion_time); then SYNC, and its answers: until all are in or their share of the period is over.
DeviceSample Session::exchange(double motion_time) noexcept {
  t_bus_ns_ += period_ns_;
  sim_rig_->run_wires(t_bus_ns_ - 1);
  sim_rig_->run_plant(t_bus_ns_, motion_time);

  rig_->sync(t_bus_ns_);
  t_now_ns_ = t_bus_ns_;
  const Nanoseconds poll =
      static_cast<Nanoseconds>(gather_share * static_cast<double>(period_ns_)) / gather_polls;
  for (int i = 0; i < gather_polls && !rig_->complete(); ++i) {
    t_now_ns_ += poll;
    sim_rig_->run_wires(t_now_ns_);
    rig_->receive(t_now_ns_);
  }
  return rig_->read(t_now_ns_);
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
  if (sim_rig_)
    for (std::size_t i = 0; i < scene_.device->rig->buses.size(); ++i)
      loads.push_back(sim_rig_->load_percent(i, t_bus_ns_));
  return loads;
}

}  // namespace godobject
