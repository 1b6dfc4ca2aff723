#include "hal/rig/rig.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "hal/rig/slip.h"

namespace godobject {

namespace {

constexpr int max_refused_in_a_row = 3;

/// Converts a time to periods, rounded up.
std::uint64_t periods_of(double time_s, double cycle_s) noexcept {
  constexpr double rounding = 1e-9;
  return static_cast<std::uint64_t>(std::ceil(time_s / cycle_s * (1 - rounding)));
}

/// Returns the measurement of a node's delay up to the greatest delay of interest. Longer ones are stale in
/// any case.
AnswerDelay delay_within(const RigParams& params, double cycle_s, std::uint64_t every_nth) noexcept {
  return {every_nth, periods_of(params.stale_after_s, cycle_s) + every_nth - 1};
}

/// Returns the longest measurement of a delay on a bus, periods.
std::uint64_t longest_measurement(const RigParams& params, double cycle_s, std::size_t bus) noexcept {
  std::uint64_t longest = delay_within(params, cycle_s, 1).longest();
  for (const DriveParams& drive : params.drives)
    if (drive.bus == bus)
      longest = std::max(longest, delay_within(params, cycle_s, drive.status_every_nth_sync).longest());
  return longest;
}

}  // namespace

Rig::Rig(const RigParams& params, double cycle_s, std::span<CanBus* const> buses)
    : params_(params), tree_(params.tree), transmission_(params.transmissions, params.tree.joints) {
  assert(validate(params, cycle_s).empty() && buses.size() == params.buses.size());
  for (std::size_t i = 0; i < buses.size(); ++i) {
    const std::uint64_t longest = longest_measurement(params, cycle_s, i);
    buses_.push_back({.bus = buses[i],
                      .protocol = bus_protocol(protocol_of_bus(params, i)),
                      .syncs = SyncAttribution(params.buses[i], longest + 1),
                      .longest_measurement = longest,
                      .mark_distance = std::max(AnswerDelay::min_distance, longest)});
  }
  const Nanoseconds stale_after_ns = to_ns(params.stale_after_s);
  for (const EncoderParams& encoder : params.encoders) {
    const std::size_t node = add_node(encoder.bus, encoder.node_id, NodeKind::encoder, encoders_.size());
    encoders_.push_back({.encoder = Encoder(encoder.calibration, encoder.max_speed, stale_after_ns),
                         .node = node,
                         .delay = delay_within(params, cycle_s, 1)});
  }
  for (const DriveParams& drive : params.drives) {
    const std::size_t node = add_node(drive.bus, drive.node_id, NodeKind::drive, drives_.size());
    drives_.push_back({.drive = Drive(drive, cycle_s, stale_after_ns),
                       .node = node,
                       .joint = joint_named(drive.joint),
                       .every_nth_sync = drive.status_every_nth_sync,
                       .delay = delay_within(params, cycle_s, drive.status_every_nth_sync),
                       .motor_per_joint = drive.sign * drive.joint_per_motor_rad,
                       .max_slip = allowed_slip(params, drive)});
    const CompensationParams& own = params.compensation;
    drives_.back().inertia = InertiaCompensation(
        carried_inertia(own, static_cast<std::size_t>(drives_.back().joint)), own.inertia_cutoff, cycle_s);
  }
  add_buttons();
  // an encoder on the joint takes precedence over the drive's position
  for (DriveOnBus& drive : drives_) {
    sensors_[static_cast<std::size_t>(drive.joint)] = &drive.drive.position();
    measured_[static_cast<std::size_t>(drive.joint)] = {.every_nth_sync = drive.every_nth_sync,
                                                        .node = drive.node};
  }
  for (std::size_t i = 0; i < encoders_.size(); ++i) {
    const auto joint = static_cast<std::size_t>(joint_named(params.encoders[i].joint));
    sensors_[joint] = &encoders_[i].encoder;
    measured_[joint] = {.every_nth_sync = 1, .node = encoders_[i].node};
  }
  add_homed_joints();
  q_dot_ = JointVector::Zero(static_cast<Eigen::Index>(num_joints()));
  configuration_ = tree_.at(q_dot_);
}

std::size_t Rig::add_node(std::size_t bus, std::uint8_t id, NodeKind kind, std::size_t device) {
  nodes_.push_back(
      {.bus = bus, .id = id, .kind = kind, .device = device, .canopen = buses_[bus].protocol.canopen});
  buses_[bus].node_of_id[id] = static_cast<std::uint8_t>(nodes_.size());
  return nodes_.size() - 1;
}

// Adds the buttons. Several buttons may be bits of one node.
void Rig::add_buttons() {
  for (const ButtonParams& button : params_.buttons) {
    const std::size_t known = buses_[button.bus].node_of_id[button.node_id];
    const std::size_t node =
        known != 0 ? known - 1 : add_node(button.bus, button.node_id, NodeKind::button, buttons_.size());
    buttons_.push_back({.params = button, .node = node});
  }
}

Eigen::Index Rig::joint_named(const std::string& name) const {
  const auto& joints = params_.tree.joints;
  return std::ranges::find(joints, name, &DeviceJoint::name) - joints.begin();
}

void Rig::start(Nanoseconds now) noexcept {
  if (!supervisor_.on(RigEvent::start)) return;
  now_ns_ = now;
  begin_boot(now);
  heartbeat_due_ns_ = now;
}

bool Rig::arm() noexcept { return supervisor_.on(RigEvent::arm); }

void Rig::disarm() noexcept { static_cast<void>(supervisor_.on(RigEvent::disarm)); }

void Rig::clear_faults(Nanoseconds now) noexcept {
  if (!supervisor_.on(RigEvent::clear)) return;
  fault_log_.clear();
  for (Bus& bus : buses_) bus.refused_in_a_row = 0;
  begin_boot(now);
}

void Rig::quick_stop() noexcept { raise({.fault = RigFault::quick_stop}); }

void Rig::deadlines_missed() noexcept { raise({.fault = RigFault::deadlines_missed}); }

void Rig::force_oscillates(std::optional<std::size_t> drive) noexcept {
  if (state() != RigState::armed) return;
  if (drive) raise(RigFault::force_oscillates, nodes_[drives_[*drive].node]);
  else raise({.fault = RigFault::force_oscillates});
}

void Rig::energy_gained() noexcept {
  if (state() == RigState::armed) raise({.fault = RigFault::energy_gained});
}

void Rig::stop() noexcept {
  if (state() == RigState::off) return;
  for (DriveOnBus& drive : drives_) send(drive, drive.drive.plan(0, DriveGoal::off, 0), 0);
  for (const RigNode& node : nodes_) {
    if (!node.canopen) continue;
    send(node.bus, canopen::make_nmt(canopen::NmtCommand::enter_pre_operational, node.id));
  }
  static_cast<void>(supervisor_.on(RigEvent::switch_off));
}

bool Rig::complete() const noexcept {
  const auto last_sync = [this](std::size_t node) { return buses_[nodes_[node].bus].syncs.num_syncs(); };
  const auto encoder_answered = [&](const EncoderOnBus& e) { return e.answered_sync == last_sync(e.node); };
  // a drive may skip every_nth_sync - 1 SYNCs, in its own phase
  const auto drive_answered = [&](const DriveOnBus& d) {
    return last_sync(d.node) - d.answered_sync < d.every_nth_sync;
  };
  return std::ranges::all_of(encoders_, encoder_answered) && std::ranges::all_of(drives_, drive_answered);
}

DeviceSample Rig::read(Nanoseconds now) noexcept {
  supervise(now);
  const auto n = static_cast<Eigen::Index>(num_joints());
  DeviceSample out;
  out.q.resize(n);
  out.q_dot.resize(n);
  // after a jump the sensor does not show the hand: the last good pose is held until the fault is cleared
  out.valid = !any(faults() & RigFault::sample_implausible) &&
              std::ranges::none_of(drives_, [now](const DriveOnBus& d) { return d.drive.silent(now); });
  out.fresh = true;
  out.t_ns = now;
  for (Eigen::Index i = 0; i < n; ++i) {
    const JointSample joint = sensors_[static_cast<std::size_t>(i)]->sample(now);
    out.q(i) = joint.q;
    out.q_dot(i) = joint.q_dot;
    out.valid = out.valid && joint.valid;
    out.fresh = measured_anew(static_cast<std::size_t>(i), joint) && out.fresh;
    out.t_ns = std::min(out.t_ns, joint.t_ns);
  }
  out.q = transmission_.joints(out.q);
  out.q_dot = transmission_.joints(out.q_dot);
  check_ranges(out, now);
  q_dot_ = out.q_dot;
  configuration_ = tree_.at(out.q);
  const double ahead_s = params_.compensation.ahead_s;
  const TreeConfiguration shown = ahead_s > 0 ? tree_.at(out.q + ahead_s * out.q_dot) : configuration_;
  for (std::size_t i = 0; i < num_handles(); ++i) out.handles[i] = {shown.X_WH(i), shown.twist(i, out.q_dot)};
  out.buttons = buttons();
  out.age = now - out.t_ns;
  out.faults = faults();
  return out;
}

bool Rig::measured_anew(std::size_t joint, const JointSample& sample) noexcept {
  Measured& measured = measured_[joint];
  measured.reads_ago = sample.t_ns > measured.t_ns ? 0 : measured.reads_ago + 1;
  measured.t_ns = sample.t_ns;
  measured.q = sample.q;
  measured.valid = sample.valid;
  return measured.reads_ago < measured.every_nth_sync;
}

CommandReport Rig::command(std::span<const Wrench> F_hand_W, Nanoseconds now) noexcept {
  assert(F_hand_W.size() <= num_handles());
  CommandReport report;
  if (state() == RigState::off) return report;
  now_ns_ = now;
  JointVector tau = transmission_.actuator_torques(configuration_.joint_torques(F_hand_W));
  JointVector beside =
      transmission_.actuator_torques(compensating_torques(params_.compensation, configuration_, q_dot_));
  if (!tau.allFinite() || !beside.allFinite()) raise({.fault = RigFault::command_not_finite});
  if (torque_output() != TorqueOutput::normal) {
    tau.setZero();
    beside.setZero();
  }
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    DriveOnBus& drive = drives_[i];
    const DriveCommand planned = plan(drive, tau(drive.joint), beside(drive.joint), now);
    const bool sent = send(drive, planned, now);
    drive.passivity.sent(drive.drive.commanded_torque_Nm() / drive.motor_per_joint - beside(drive.joint));
    const auto bit = [i](bool on) { return (on ? 1u : 0u) << i; };
    report.torque_limited |= bit(planned.torque_limited);
    report.rate_limited |= bit(planned.rate_limited);
    report.drive_limited |= bit(drive.drive.feedback(now).internal_limit);
    report.not_sent |= bit(!sent || drive.request_refused);
  }
  return report;
}

DriveGoal Rig::goal() const noexcept {
  if (torque_output() == TorqueOutput::at_once) return DriveGoal::quick_stop;
  if (torque_output() == TorqueOutput::none) return DriveGoal::off;
  const bool failed =
      std::ranges::any_of(drives_, [](const DriveOnBus& d) { return d.t_failed_ns.has_value(); });
  return state() == RigState::enabling && !failed ? DriveGoal::enable : DriveGoal::hold;
}

DeviceButtons Rig::buttons() const noexcept {
  DeviceButtons out;
  out.hold = is_pressed(ButtonUse::hold);
  out.clutch = is_pressed(ButtonUse::clutch);
  return out;
}

bool Rig::has_button(ButtonUse use) const noexcept {
  return std::ranges::any_of(buttons_, [use](const ButtonOnBus& b) { return b.params.use == use; });
}

DriveFeedback Rig::drive_feedback(std::size_t index, Nanoseconds now) const noexcept {
  return drives_[index].drive.feedback(now);
}

// Sends the frame of a command, if it has one. Returns false if the bus refused it.
bool Rig::send(DriveOnBus& drive, const DriveCommand& command, Nanoseconds now) noexcept {
  if (command.out.frame && !send(nodes_[drive.node].bus, *command.out.frame)) return false;
  drive.drive.sent(command, now);
  return true;
}

bool Rig::send(std::size_t bus, const CanFrame& frame) noexcept {
  Bus& to = buses_[bus];
  if (to.bus->try_send(frame) == SendResult::queued) {
    to.refused_in_a_row = 0;
    return true;
  }
  ++to.refused_in_a_row;
  // bus_down reports the refusals of a bus that is cut off
  if (to.refused_in_a_row >= max_refused_in_a_row && !is_cut_off(to.bus->state()))
    raise({.fault = RigFault::send_refused, .bus = bus});
  return false;
}

void Rig::raise(const RigFaultPlace& place, std::uint32_t identifier) noexcept {
  if (!supervisor_.on(event_of(place.fault))) return;
  drop_zeros(place);
  const RigNode* const node = node_at(place);
  fault_log_.raise(place, now_ns_, identifier, node != nullptr ? evidence_of(*node) : NodeEvidence{});
}

const RigNode* Rig::node_at(const RigFaultPlace& place) const noexcept {
  const std::size_t node_plus_1 = place.bus ? buses_[*place.bus].node_of_id[place.node_id] : 0;
  return node_plus_1 == 0 ? nullptr : &nodes_[node_plus_1 - 1];
}

NodeEvidence Rig::evidence_of(const RigNode& node) const noexcept {
  NodeEvidence out{.heard = node.heard,
                   .silent = silent(node, now_ns_),
                   .nmt_state = static_cast<std::uint8_t>(node.state),
                   .answered = node.answered,
                   .malformed = node.malformed,
                   .last_malformed = node.last_malformed};
  if (node.kind == NodeKind::encoder) out.delay_unknown = !is_known(encoders_[node.device].delay, node);
  if (node.kind != NodeKind::drive) return out;
  out.delay_unknown = !is_known(drives_[node.device].delay, node);
  const DriveTelemetry& drive = drives_[node.device].drive.telemetry();
  out.own_state = drive.own_state;
  out.error_code = drive.error_code;
  out.has_own_state = drive.has_own_state;
  return out;
}

}  // namespace godobject
