// Rig: transitions from off to ready, and supervision that leads to fault.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "hal/rig/rig.h"

namespace godobject {

namespace {

constexpr Nanoseconds nmt_retry_ns = 250'000'000;
constexpr double range_margin = 0.1;  // of a joint's range, beyond each end

bool is_enabled(const Drive& drive) noexcept { return drive.state() == MotorState::enabled; }

}  // namespace

void Rig::supervise(Nanoseconds now) noexcept {
  now_ns_ = now;
  check_buses();
  check_stop_inputs();
  if (nodes_were_up()) {
    check_nodes(now);
    check_samples(now);
  }
  if (drives_were_up()) check_drives();
  if (state() == RigState::booting) boot(now);
  if (state() == RigState::homing) home(now);
  if (state() == RigState::enabling) wait_for_drives(now);
}

void Rig::check_buses() noexcept {
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    if (is_cut_off(buses_[i].bus->state())) raise({.fault = RigFault::bus_down, .bus = i});
  }
}

// Raises quick_stop in every cycle while an emergency stop is pressed. Clearing the fault has no effect
// before its release.
void Rig::check_stop_inputs() noexcept {
  for (const ButtonOnBus& button : buttons_)
    if (button.params.use == ButtonUse::stop && button.pressed)
      raise(RigFault::quick_stop, nodes_[button.node]);
}

void Rig::check_nodes(Nanoseconds now) noexcept {
  for (const RigNode& node : nodes_) {
    if (silent(node, now)) raise(RigFault::heartbeat_lost, node);
  }
}

void Rig::check_samples(Nanoseconds now) noexcept {
  for (EncoderOnBus& encoder : encoders_) {
    if (!encoder.encoder.stale(now)) encoder.t_good_ns = now;
    if (lost(encoder.encoder, encoder.delay, encoder.t_good_ns, now))
      raise(RigFault::sample_stale, nodes_[encoder.node]);
    if (!encoder.encoder.trusted()) raise(RigFault::sample_implausible, nodes_[encoder.node]);
  }
  for (DriveOnBus& drive : drives_) {
    check_slip(drive, now);
    const Encoder& position = drive.drive.position();
    if (!drive.drive.silent(now) && !position.stale(now)) drive.t_good_ns = now;
    if (drive.drive.silent(now) && lost(position, drive.delay, drive.t_good_ns, now))
      raise(RigFault::drive_silent, nodes_[drive.node]);
    const bool is_sensor = sensors_[static_cast<std::size_t>(drive.joint)] == &position;
    if (!is_sensor) continue;
    if (position.stale(now) && lost(position, drive.delay, drive.t_good_ns, now))
      raise(RigFault::sample_stale, nodes_[drive.node]);
    if (!position.trusted()) raise(RigFault::sample_implausible, nodes_[drive.node]);
  }
}

// True if a sample is missing for too long. Until then the pose is held and the force fades. Returns true at
// once if the turn would become ambiguous. If a delay exceeds the measured range, the sample counts as
// missing from the first mark on. Between homing and the power of the drives, an incremental sensor is lost
// after stale_after. Nothing else shows the restart of a drive there.
bool Rig::lost(const Encoder& encoder, const AnswerDelay& delay, Nanoseconds t_good,
               Nanoseconds now) const noexcept {
  const Nanoseconds since = delay.beyond_reach() ? std::min(t_good, delay.t_beyond_ns()) : t_good;
  const bool may_restart = encoder.is_incremental() && state() == RigState::enabling;
  const double lost_after_s = may_restart ? 0 : params_.lost_after_s;
  return now - since > to_ns(std::max(lost_after_s, params_.stale_after_s)) || encoder.turn_is_lost(now);
}

// Compares drive and encoder relative to their difference before ready, because a drive's zero may be its
// position at power-on. Missing and implausible samples raise their own faults.
void Rig::check_slip(DriveOnBus& drive, Nanoseconds now) noexcept {
  if (drive.max_slip <= 0) return;
  const Encoder* const sensor = sensors_[static_cast<std::size_t>(drive.joint)];
  const JointSample joint = sensor->sample(now), motor = drive.drive.position().sample(now);
  const double later_s = 1e-9 * static_cast<double>(joint.t_ns - motor.t_ns);
  const double apart = joint.q - joint.q_dot * later_s - motor.q;
  const double travel = std::max(std::abs(joint.q_dot), std::abs(motor.q_dot)) * params_.stale_after_s;
  const bool known = joint.valid && motor.valid;
  if (known && !drives_were_up()) drive.apart = apart;
  if (!known || std::abs(apart - drive.apart) <= drive.max_slip + travel) drive.t_agreed_ns = now;
  else if (static_cast<double>(now - drive.t_agreed_ns) > 1e9 * params_.stale_after_s)
    raise(RigFault::sensors_disagree, nodes_[drive.node]);
}

// Compares joints with their ranges. The margin is for ends that yield. Beyond it the zero, the sign or
// the scale of a sensor is wrong, and forces would act in wrong places. A joint without a range has no
// bounds.
void Rig::check_ranges(const DeviceSample& sample, Nanoseconds now) noexcept {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < num_joints(); ++i) {
    const DeviceJoint& joint = params_.tree.joints[i];
    const double lower = joint.lower.value_or(-infinity), upper = joint.upper.value_or(infinity);
    const double margin = range_margin * (upper - lower), q = sample.q(static_cast<Eigen::Index>(i));
    const bool is_beyond = q < lower - margin || q > upper + margin;
    if (!sample.valid || !nodes_were_up() || !is_beyond) measured_[i].t_within_ns = now;
    else if (static_cast<double>(now - measured_[i].t_within_ns) > 1e9 * params_.stale_after_s)
      raise(RigFault::joint_beyond_range, nodes_[measured_[i].node]);
  }
}

void Rig::check_drives() noexcept {
  if (goal() == DriveGoal::quick_stop) return;  // a quick stop disables the drives
  for (const DriveOnBus& drive : drives_) {
    if (!is_enabled(drive.drive)) raise(RigFault::drive_not_enabled, nodes_[drive.node]);
  }
}

// Sends NMT start to every node that is not operational, at most one frame per bus and cycle.
void Rig::boot(Nanoseconds now) noexcept {
  std::array<bool, max_buses> start_sent{};
  for (RigNode& node : nodes_) {
    const bool due = !node.start_sent || now - node.start_sent_ns >= nmt_retry_ns;
    if (!node.canopen || !due || start_sent[node.bus]) continue;
    if (node.operational() && !silent(node, now)) continue;
    node.start_sent = send(node.bus, canopen::make_nmt(canopen::NmtCommand::start, node.id));
    node.start_sent_ns = now;
    start_sent[node.bus] = true;
  }
  if (std::ranges::all_of(nodes_, [&](const RigNode& node) { return booted(node, now); })) {
    static_cast<void>(supervisor_.on(RigEvent::nodes_up));
    begin_homing(now);
    settled_cycles_ = 0;
    for (EncoderOnBus& encoder : encoders_) encoder.t_good_ns = now;
    for (DriveOnBus& drive : drives_) {
      drive.t_good_ns = now;
      drive.was_well = drive.was_powered = false;
      drive.t_failed_ns.reset();
    }
    return;
  }
  if (!boot_is_over(now)) return;
  for (const RigNode& node : nodes_)
    if (!booted(node, now)) raise(RigFault::boot_timeout, node);
}

void Rig::wait_for_drives(Nanoseconds now) noexcept {
  bool failed = false;
  for (DriveOnBus& drive : drives_) failed = failed_on_the_way(drive, now) || failed;
  if (std::ranges::all_of(drives_, [](const DriveOnBus& d) { return is_enabled(d.drive); })) {
    ++settled_cycles_;
    if (drives_.empty() || settled_cycles_ > settle_cycles)
      static_cast<void>(supervisor_.on(RigEvent::drives_up));
    return;
  }
  settled_cycles_ = 0;
  if (failed || !boot_is_over(now)) return;
  for (const DriveOnBus& drive : drives_)
    if (!is_enabled(drive.drive)) raise(RigFault::boot_timeout, nodes_[drive.node]);
}

// True if a drive fails while it is being enabled. A fault from before is reset. A new fault, or the loss of
// a power stage that was on, would recur, so the drive is not powered a second time. The fault is raised once
// its code has arrived, because TPDO2 with the code may come later than TPDO1 with the state.
bool Rig::failed_on_the_way(DriveOnBus& drive, Nanoseconds now) noexcept {
  const DriveTelemetry& seen = drive.drive.telemetry();
  const bool in_fault = seen.state == MotorState::fault;
  if (!drive.t_failed_ns) {
    const bool failed = in_fault ? drive.was_well : drive.was_powered && !seen.powered;
    if (!in_fault) {
      drive.was_well = true;
      drive.was_powered = drive.was_powered || seen.powered;
      drive.error_code_before = seen.error_code;
    }
    if (!failed) return false;
    drive.t_failed_ns = now;
  }
  const bool code_is_here = seen.error_code != 0 && seen.error_code != drive.error_code_before;
  if (!code_is_here && now - *drive.t_failed_ns <= to_ns(params_.lost_after_s)) return true;
  if (in_fault || code_is_here) raise_drive_error(nodes_[drive.node], seen.error_code);
  else raise(RigFault::drive_not_enabled, nodes_[drive.node]);
  return true;
}

bool Rig::boot_is_over(Nanoseconds now) const noexcept {
  return static_cast<double>(now - boot_started_ns_) > 1e9 * params_.boot_timeout_s;
}

bool Rig::booted(const RigNode& node, Nanoseconds now) const noexcept {
  if (!node.operational() || silent(node, now)) return false;
  if (node.kind == NodeKind::button) return buttons_[node.device].heard;
  if (node.kind == NodeKind::drive) {
    const DriveOnBus& drive = drives_[node.device];
    return !drive.drive.silent(now) && is_known(drive.delay, node);
  }
  const EncoderOnBus& at = encoders_[node.device];
  return !at.encoder.stale(now) && at.encoder.trusted() && is_known(at.delay, node);
}

// True if the delay is measured, or cannot be: in a log, and if nodes send positions without a request.
bool Rig::is_known(const AnswerDelay& delay, const RigNode& node) const noexcept {
  const Bus& on = buses_[node.bus];
  return delay.is_measured() || !on.bus->is_live() || !on.protocol.answers_only;
}

bool Rig::silent(const RigNode& node, Nanoseconds now) const noexcept {
  return !node.heard || static_cast<double>(now - node.heartbeat_ns) > 1e9 * params_.heartbeat_timeout_s;
}

}  // namespace godobject
