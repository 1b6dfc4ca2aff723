#include "platform/session/session.h"

#include <algorithm>
#include <cmath>

namespace godobject {
namespace {

PoseError difference(const Pose& a, const Pose& b) noexcept {
  return {.m = (a.p - b.p).norm(), .rad = rotation_error(a.q, b.q, Vec3::Zero()).phi_B.norm()};
}

PoseError worst(const PoseError& a, const PoseError& b) noexcept {
  return {.m = std::max(a.m, b.m), .rad = std::max(a.rad, b.rad)};
}

}  // namespace

/// A joint that the device leads is held and let go with its body's handle, or else the first. Beyond +-pi a
/// turn rests where it was.
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

std::optional<PoseError> Session::offset_at_start(std::size_t body) const noexcept {
  const bool relative = scene_.device && scene_.device->kind == DeviceKind::relative;
  if (!follows() || relative || grip_ || bus_ == BusChoice::real) return std::nullopt;
  if (scene_.coupling != CouplingMode::god_object || !scene_.bodies[body].coupling) return std::nullopt;
  const std::size_t driven = static_cast<std::size_t>(std::ranges::find(driven_, body) - driven_.begin());
  const BodySample sample = motion_sample(std::min(driven, motion_.num_bodies() - 1), 0);
  if (!sample.engaged) return std::nullopt;
  return difference(scene_.bodies[body].X_WB, sample.X_WD);
}

std::optional<JointTarget> Session::joints_at_start() const noexcept {
  if (!motion_.has_joints() || bus_ == BusChoice::real) return std::nullopt;
  return motion_.joints(0);
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
  record.on_hold = on_hold_ || deadlines_missed_;
  act(record);

  if (exact_engine_) static_cast<void>(exact_engine_->step(exact_samples_));
  observe(record);
}

CycleRecord Session::at_start() const {
  CycleRecord record;
  record.bodies.resize(scene_.bodies.size());
  if (lists_contacts_) record.touching.resize(engine_->composition().max_contacts);
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
  record.num_touching = engine_->contacts(record.touching);
  if (follows()) measure(record);
}

/// What the core is told, and what it would be told by a perfect device.
void Session::sense(double t) noexcept {
  for (std::size_t i = 0; i < motion_.num_bodies(); ++i) samples_[driven_[i]] = motion_sample(i, t);
  if (motion_.has_joints()) impose(motion_.joints(t), true, samples_);
  exact_samples_ = samples_;
  const Nanoseconds t_before = t_bus_ns_;
  if (rig_) sense_through_rig();
  if (tracked_) sense_through_trackers();
  if (grip_) grip(t);
  for (const std::size_t body : driven_)
    if (let_go_) samples_[body].engaged = exact_samples_[body].engaged = false;
  if (bus() == BusChoice::real) pass_missed_time(t_before);
  let_go_ = false;
  if (!on_hold_ && !deadlines_missed_) return;
  for (BodySample& sample : samples_) sample.valid = false;
}

/// Periods that the loop has left out are a gap in the samples. The motion of a simulated device has none: it goes on by
/// the step.
void Session::pass_missed_time(Nanoseconds t_before) noexcept {
  if (let_go_ || cycle_ == 1) return;
  const double periods = 1e-9 * static_cast<double>(t_bus_ns_ - t_before) / scene_.step;
  const double missed = std::floor(periods - 0.5);
  if (missed >= 1) engine_->pass_time(missed * scene_.step);
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
    sample.valid = device.valid && device.fresh;
    const MotionSample handle =
        sim_ ? sim_->rig().handle(k) : MotionSample{.X_WD = sample.X_WD, .V_WD = sample.V_WD};
    exact_samples_[held_[k]].X_WD = handle.X_WD;
    exact_samples_[held_[k]].V_WD = handle.V_WD;
    if (has_clutch) sample.clutch = exact_samples_[held_[k]].clutch = buttons_.clutch;
  }
  const JointTarget joints{.q = device.q, .q_dot = device.q_dot};
  impose(joints, device.valid && device.fresh, samples_);
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
  if (grip_) record.hand_W = grip_->feel(samples_[driven_.front()], *engine_, record.limited);
  if (!rig_) {
    watch_force(record);
    return;
  }
  std::array<Wrench, max_handles> F_hand_W;
  for (std::size_t k = 0; k < held_.size(); ++k)
    F_hand_W[k] = grip_ ? record.hand_W : engine_->feedback(held_[k]);
  record.drives = command(std::span(F_hand_W).first(held_.size()));
  watch_force(record);
  record.rig_faults = rig_->faults();
}

/// Each wrench that is shown, and the motors' commands.
void Session::watch_force(CycleRecord& record) noexcept {
  bool swings = false;
  if (grip_) {
    swings = swings_->shows(0, record.hand_W);
  } else {
    for (std::size_t i = 0; i < driven_.size(); ++i)
      swings = swings_->shows(i, engine_->feedback(driven_[i])) || swings;
  }
  const std::optional<std::size_t> drive =
      rig_ ? swings_->commands(*rig_, record.drives) : std::optional<std::size_t>{};
  record.force_oscillates = swings || drive;
  if (record.force_oscillates && rig_) rig_->force_oscillates(drive);
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
