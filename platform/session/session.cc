#include "platform/session/session.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "platform/scene/joint/joints.h"

namespace godobject {

// --- one period -----------------------------------------------------------------------------------

void Session::cycle(CycleRecord& record) noexcept {
  StageWatch& stages = phases_.period().stages;
  ++cycle_;
  stages.start(Stage::decode);
  read();
  check();
  if (world_ != nullptr) world_->begin(*engine_);
  step(record);
  limit(record);
  stages.enter(Stage::encode);
  command(record);
  if (truth_) {
    const InStage stage(stages, Stage::wait);
    truth_->step(phases_.period().t, samples_);
  }
  stages.enter(Stage::observe);
  observe(record);
}

/// Reads the samples of the devices.
void Session::read() noexcept {
  Period& period = phases_.begin(motion_time());
  for (BodySample& sample : samples_) sample.valid = true;  // also of bodies without a device
  for (HandDevice* const device : phases_.devices()) device->read(period, samples_);
}

/// Validates the samples: selects the held body, disengages after restart(), marks missed periods and holds
/// as invalid.
void Session::check() noexcept {
  if (grip_) update_grip();
  for (const std::size_t body : driven_)
    if (disengages_) samples_[body].engaged = false;
  if (real_) pass_missed_time();
  disengages_ = false;
  if (on_hold_ || deadlines_missed_)
    for (BodySample& sample : samples_) sample.valid = false;
  phases_.hold(!std::ranges::all_of(samples_, &BodySample::valid));
}

void Session::step(CycleRecord& record) noexcept {
  StageWatch& stages = phases_.period().stages;
  stages.enter(Stage::step);
  const StepReport report = engine_->step(samples_);
  stages.enter(Stage::limit);
  record.step_ns = stages.spent(Stage::step);
  if (world_ != nullptr) world_->end(*engine_, motion_time());
  record.fault = report.fault;
  record.limited = report.limited;
  record.contacts = report.contacts;
  record.nets = report.nets;
  record.on_hold = on_hold_ || deadlines_missed_;
  if (!has(report.fault, Fault::energy_gained)) return;
  for (HandDevice* const device : phases_.devices()) device->tell(RunTrouble::energy_gained);
}

/// Computes the wrench to display: the gripped body's wrench at the device's origin, else each body's own,
/// which the step has limited.
void Session::limit(CycleRecord& record) noexcept {
  if (grip_) record.hand_W = grip_->feel(samples_[driven_.front()], *engine_, record.limited);
  for (const std::size_t body : driven_) F_hand_W_[body] = grip_ ? record.hand_W : engine_->feedback(body);
}

/// Commands the devices to display the wrenches, and watches these for oscillation between their bounds.
void Session::command(CycleRecord& record) noexcept {
  Shown shown;
  const std::size_t num_wrenches = grip_ ? 1 : driven_.size();
  for (std::size_t i = 0; i < num_wrenches; ++i)
    shown.oscillates = swings_->shows(i, F_hand_W_[driven_[i]]) || shown.oscillates;
  for (HandDevice* const device : phases_.devices()) device->command(phases_.period(), F_hand_W_, shown);
  if (any(shown.faults) || deadlines_missed_) phases_.fault();
  record.drives = shown.drives;
  record.force_oscillates = shown.oscillates;
  record.rig_faults = shown.faults;
}

void Session::observe(CycleRecord& record) const noexcept {
  record.cycle = cycle_;
  record.t = motion_time();
  record.engaged = grip_ ? grip_->body().has_value() : !driven_.empty() && samples_[driven_.front()].engaged;
  if (grip_) record.held = grip_->body();
  loop::resize(record.bodies, scene_.bodies.size());
  for (std::size_t i = 0; i < record.bodies.size(); ++i) record.bodies[i] = engine_->view(i);
  record.energy = engine_->energy();
  record.num_touching = engine_->contacts(record.touching);
  engine_->net_nodes(record.net_nodes);
  engine_->term_forces(record.term_forces);
  record.net_stretch = engine_->net_stretch();
  observe_device(record);
  if (lists_inputs_) {
    loop::copy(record.samples, samples_);
    record.passed_s = passed_s_;
    record.state_hash = engine_->state_hash();
  }
  if (!follows()) return;
  const bool relative = scene_.device && scene_.device->kind == DeviceKind::relative;
  const Followed followed_now{
      .bodies = followed(), .samples = samples_, .by_an_offset = relative || grip_.has_value()};
  record.following = record.sensing = record.exact_following = record.encoders = {};
  for (const std::size_t body : followed_now.bodies) {
    const BodyView& view = record.bodies[body];
    record.following = worst(record.following, between(view.X_WB, view.target.X_WD));
  }
  if (truth_) truth_->measure(followed_now, record);
}

/// Writes the devices' samples, joint coordinates and torques, as far as the record has space.
void Session::observe_device(CycleRecord& record) const noexcept {
  record.t_bus_ns = bus_time_ns();
  record.motion_start_ns = motion_start_ns_;
  for (std::size_t i = 0; i < record.targets.size(); ++i) {
    const BodySample& sample = samples_[driven_[i]];
    record.targets[i] = {
        .X_WD = sample.target.X_WD, .F_WB = sample.F_WB, .engaged = sample.engaged, .clutch = sample.clutch};
  }
  if (grip_ && !record.targets.empty()) record.targets.front().engaged = grip_->body().has_value();
  if (record.joint_q.size() == joint_coordinates_.size())
    joint_coordinates_.read(record.bodies, record.joint_q);
  const JointVector q = rig_                   ? rig_->q()
                        : motion_.has_joints() ? motion_.joints(motion_time()).q
                                               : JointVector();
  for (std::size_t i = 0; i < record.device_q.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    record.device_q[i] = k < q.size() ? q[k] : std::numeric_limits<double>::quiet_NaN();
  }
  for (std::size_t i = 0; i < record.drive_torque.size(); ++i)
    record.drive_torque[i] = rig_ ? rig_->rig().commanded_torque_Nm(i) : 0;
  for (std::size_t i = 0; i < record.drive_energy.size(); ++i)
    record.drive_energy[i] = rig_ ? rig_->rig().generated_energy_J(i) : 0;
}

/// Returns the driven bodies; for a device that grips bodies only the held one.
std::span<const std::size_t> Session::followed() const noexcept {
  if (!grip_) return driven_;
  if (!grip_->body()) return {};
  return std::span(driven_).subspan(
      static_cast<std::size_t>(std::ranges::find(driven_, *grip_->body()) - driven_.begin()), 1);
}

/// Selects the held body. All bodies that can be held receive the device's sample; only the held one is
/// engaged.
void Session::update_grip() noexcept {
  const BodySample device = samples_[driven_.front()];
  const double t = phases_.period().t;
  const bool has_button = std::ranges::any_of(phases_.devices(), &HandDevice::has_hold_button);
  HoldWish wish = motion_.hold(t);
  for (const HandDevice* const of : phases_.devices()) wish = of->hold().value_or(wish);
  if (device.valid) p_WD_ = device.target.X_WD.p;
  grip_->update(wish, !has_button && motion_.button(t), p_WD_, *engine_);
  for (const HandDevice* const of : phases_.devices())
    if (of->hold_pressed()) grip_->press(p_WD_, *engine_);
  for (const std::size_t body : driven_) {
    samples_[body] = device;
    samples_[body].engaged = grip_->holds(body);
  }
}

/// Reports periods that the loop left out to the engine as a gap in the samples. A simulated device has no
/// gap, because its time advances by the step.
void Session::pass_missed_time() noexcept {
  passed_s_ = 0;
  if (disengages_ || cycle_ == 1) return;
  const Period& period = phases_.period();
  const double periods = 1e-9 * static_cast<double>(period.began - period.began_before) / scene_.step;
  const double missed = std::floor(periods - 0.5);
  if (missed < 1) return;
  passed_s_ = missed * scene_.step;
  engine_->pass_time(passed_s_);
}

// --- from the first period to the last --------------------------------------------------------------

bool Session::advance(CycleRecord& record) noexcept {
  if (phase() == RunPhase::running) {
    cycle(record);
    return true;
  }
  const bool first_boot = phase() == RunPhase::booting && cycle_ == 0;
  phases_.advance(motion_time());
  if (first_boot) motion_start_ns_ = bus_time_ns();
  return false;
}

bool Session::boot(double limit_s) {
  start(limit_s);
  CycleRecord none;
  while (phase() == RunPhase::booting) static_cast<void>(advance(none));
  return phase() == RunPhase::running;
}

void Session::shut_down() noexcept {
  stop();
  while (phase() != RunPhase::ended) phases_.advance(motion_time());
}

void Session::deadlines_missed() noexcept {
  deadlines_missed_ = true;
  for (HandDevice* const device : phases_.devices()) device->tell(RunTrouble::deadlines_missed);
}

void Session::restart() {
  if (phase() != RunPhase::ended) return;
  phases_.restart();
  on_hold_ = deadlines_missed_ = false;
  if (!phases_.makes_torque()) return;
  swings_->reset();
  disengages_ = true;
}

CycleRecord Session::at_start() const {
  CycleRecord record;
  record.bodies.resize(scene_.bodies.size());
  record.targets.resize(std::min(motion_.num_bodies(), driven_.size()));
  record.joint_q = joint_coordinates_.at_start();
  record.term_forces.resize(term_names(scene_).size());
  if (scene_.device && scene_.device->rig) {
    record.device_q.resize(scene_.device->rig->tree.joints.size());
    record.drive_torque.resize(scene_.device->rig->drives.size());
    record.drive_energy.resize(scene_.device->rig->drives.size());
  }
  if (lists_contacts_) record.touching.resize(engine_->composition().all_contacts());
  if (lists_net_nodes_) record.net_nodes.resize(engine_->nets().nodes.size());
  if (lists_inputs_) record.samples.resize(samples_.size());
  observe(record);
  return record;
}

bool Session::follows() const noexcept {
  return !driven_.empty() && scene_.bodies[driven_.front()].coupling &&
         !(scene_.device && scene_.device->kind == DeviceKind::admittance);
}

std::optional<PoseError> Session::offset_at_start(std::size_t body) const noexcept {
  const bool relative = scene_.device && scene_.device->kind == DeviceKind::relative;
  if (!follows() || relative || grip_ || real_) return std::nullopt;
  if (scene_.coupling != CouplingMode::god_object || !scene_.bodies[body].coupling) return std::nullopt;
  const std::size_t driven = static_cast<std::size_t>(std::ranges::find(driven_, body) - driven_.begin());
  const BodySample sample = handed_.sample(std::min(driven, motion_.num_bodies() - 1), 0);
  if (!sample.engaged) return std::nullopt;
  return between(scene_.bodies[body].X_WB, sample.target.X_WD);
}

std::optional<JointTarget> Session::joints_at_start() const noexcept {
  if (!motion_.has_joints() || real_) return std::nullopt;
  return motion_.joints(0);
}

// --- coordinates of the joints in a record --------------------------------------------------------

namespace {

JointFrames frames_of(const JointParams& joint, const Pose& X_WP, const Pose& X_WC) noexcept {
  const Mat3 R_WP = X_WP.q.toRotationMatrix(), R_WC = X_WC.q.toRotationMatrix();
  return {.R_WP = R_WP * joint.P.R,
          .R_WC = R_WC * joint.C.R,
          .d_W = (X_WC.p + R_WC * joint.C.p) - (X_WP.p + R_WP * joint.P.p)};
}

}  // namespace

JointCoordinatesOf::JointCoordinatesOf(const SceneConfig& scene) {
  for (const JointConfig& joint : scene.joints) {
    joints_.push_back(
        {.params = joint_params(scene.bodies, joint), .child = body_named(scene, joint.child).value()});
    const JointCoordinates q = coordinates_at_start(scene.bodies, joint);
    at_start_.insert(at_start_.end(), q.begin(), q.begin() + num_coordinates(joint.kind));
  }
}

void JointCoordinatesOf::read(std::span<const BodyView> bodies, std::span<double> q) const noexcept {
  std::size_t next = 0;
  for (const Joint& joint : joints_) {
    const std::size_t n = num_coordinates(joint.params.kind);
    const Pose X_WP = joint.params.parent == world ? Pose{} : bodies[joint.params.parent].X_WB;
    const JointFrames X = frames_of(joint.params, X_WP, bodies[joint.child].X_WB);
    with_joint(joint.params.kind, [&](auto kind) {
      if constexpr (requires { kind.coordinates(X); }) {
        const JointCoordinates now = kind.coordinates(X);
        for (std::size_t i = 0; i < n; ++i) {
          double& before = q[next + i];
          const double x = now[static_cast<Eigen::Index>(i)];
          before = is_turn(joint.params.kind, i) ? x + 2 * pi * std::round((before - x) / (2 * pi)) : x;
        }
      }
    });
    next += n;
  }
}

}  // namespace godobject
