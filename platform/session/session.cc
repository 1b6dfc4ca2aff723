#include "platform/session/session.h"

#include <algorithm>
#include <array>
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

// --- one period -----------------------------------------------------------------------------------

void Session::cycle(CycleRecord& record) noexcept {
  ++cycle_;
  read();
  check();
  step(record);
  limit(record);
  command(record);
  if (truth_) truth_->step(period_.t, samples_);
  observe(record);
}

/// What the devices know of the hand.
void Session::read() noexcept {
  Period& period = begin_period();
  for (BodySample& sample : samples_) sample.valid = true;  // also of bodies of which no device speaks
  for (HandDevice* const device : devices_) device->read(period, samples_);
}

/// What of it counts: one body at a time is held, what was let go is engaged anew, gaps are gaps.
void Session::check() noexcept {
  if (grip_) take_hold();
  for (const std::size_t body : driven_)
    if (let_go_) samples_[body].engaged = false;
  if (real_) pass_missed_time();
  let_go_ = false;
  if (!on_hold_ && !deadlines_missed_) return;
  for (BodySample& sample : samples_) sample.valid = false;
}

void Session::step(CycleRecord& record) noexcept {
  const Nanoseconds start = step_clock_();
  const StepReport report = engine_->step(samples_);
  record.step_ns = step_clock_() - start;
  record.fault = report.fault;
  record.limited = report.limited;
  record.contacts = report.contacts;
  record.nets = report.nets;
  record.on_hold = on_hold_ || deadlines_missed_;
  if (has(report.fault, Fault::energy_gained) && rig_) rig_->rig().energy_gained();
}

/// What the hand feels of a body that it has taken hold of; bodies that are tied to a handle have been limited by the step.
void Session::limit(CycleRecord& record) noexcept {
  if (grip_) record.hand_W = grip_->feel(samples_[driven_.front()], *engine_, record.limited);
}

/// The drives show it. What is shown is watched for swinging between its bounds: each wrench, and the motors' commands.
void Session::command(CycleRecord& record) noexcept {
  if (rig_) {
    std::array<Wrench, max_handles> F_hand_W;
    const std::span<const std::size_t> bodies = rig_->bodies();
    for (std::size_t k = 0; k < bodies.size(); ++k)
      F_hand_W[k] = grip_ ? record.hand_W : engine_->feedback(bodies[k]);
    record.drives = rig_->command(period_, std::span(F_hand_W).first(bodies.size()));
  }
  bool swings = false;
  if (grip_) {
    swings = swings_->shows(0, record.hand_W);
  } else {
    for (std::size_t i = 0; i < driven_.size(); ++i)
      swings = swings_->shows(i, engine_->feedback(driven_[i])) || swings;
  }
  const std::optional<std::size_t> drive =
      rig_ ? swings_->commands(rig_->rig(), record.drives) : std::optional<std::size_t>{};
  record.force_oscillates = swings || drive;
  if (record.force_oscillates && rig_) rig_->rig().force_oscillates(drive);
  if (rig_) record.rig_faults = rig_->rig().faults();
}

void Session::observe(CycleRecord& record) const noexcept {
  record.cycle = cycle_;
  record.t = motion_time();
  record.engaged = grip_ ? grip_->body().has_value() : !driven_.empty() && samples_[driven_.front()].engaged;
  if (grip_) record.held = grip_->body();
  record.bodies.resize(scene_.bodies.size());
  for (std::size_t i = 0; i < record.bodies.size(); ++i) record.bodies[i] = engine_->view(i);
  record.energy = engine_->energy();
  record.num_touching = engine_->contacts(record.touching);
  engine_->net_nodes(record.net_nodes);
  record.net_stretch = engine_->net_stretch();
  if (follows()) measure(record);
}

/// Where no truth is known the handles are where the samples say.
void Session::measure(CycleRecord& record) const noexcept {
  record.following = record.sensing = record.exact_following = record.encoders = {};
  const bool relative = scene_.device && scene_.device->kind == DeviceKind::relative;
  const bool offset = relative || grip_;  // between handle and target
  for (const std::size_t body : driven_) {
    if (grip_ && !grip_->holds(body)) continue;
    const BodyView& view = record.bodies[body];
    const Pose& X_WH = truth_ ? truth_->handle(body) : samples_[body].target.X_WD;
    record.following = worst(record.following, difference(view.X_WB, offset ? view.target.X_WD : X_WH));
    if (!truth_) continue;
    const BodyView exact = truth_->exact(body);
    record.sensing = worst(record.sensing, difference(samples_[body].target.X_WD, X_WH));
    record.exact_following =
        worst(record.exact_following, difference(exact.X_WB, offset ? exact.target.X_WD : X_WH));
    record.encoders = worst(record.encoders, difference(view.X_WB, exact.X_WB));
  }
}

/// All that can be held get the device's sample; engaged for the one that is.
void Session::take_hold() noexcept {
  const BodySample device = samples_[driven_.front()];
  const bool has_button = rig_ && rig_->rig().has_button(ButtonUse::hold);
  HoldWish wish = motion_.hold(period_.t);
  for (const HandDevice* const of : devices_) wish = of->hold().value_or(wish);
  grip_->update(wish, !has_button && motion_.button(period_.t), device.target.X_WD.p, *engine_);
  for (const HandDevice* const of : devices_)
    if (of->hold_pressed()) grip_->press(device.target.X_WD.p, *engine_);
  for (const std::size_t body : driven_) {
    samples_[body] = device;
    samples_[body].engaged = grip_->holds(body);
  }
}

/// Periods that the loop has left out are a gap in the samples. The motion of a simulated device has none: it goes on by
/// the step.
void Session::pass_missed_time() noexcept {
  if (let_go_ || cycle_ == 1) return;
  const double periods = 1e-9 * static_cast<double>(period_.began - t_before_ns_) / scene_.step;
  const double missed = std::floor(periods - 0.5);
  if (missed >= 1) engine_->pass_time(missed * scene_.step);
}

// --- before and after -------------------------------------------------------------------------------

CycleRecord Session::at_start() const {
  CycleRecord record;
  record.bodies.resize(scene_.bodies.size());
  if (lists_contacts_) record.touching.resize(engine_->composition().all_contacts());
  if (lists_net_nodes_) record.net_nodes.resize(engine_->nets().nodes.size());
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
  return difference(scene_.bodies[body].X_WB, sample.target.X_WD);
}

std::optional<JointTarget> Session::joints_at_start() const noexcept {
  if (!motion_.has_joints() || real_) return std::nullopt;
  return motion_.joints(0);
}

}  // namespace godobject
