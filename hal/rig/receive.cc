// Rig: decodes received frames for nodes, encoders and drives.
#include <algorithm>

#include "hal/canopen/cia401.h"
#include "hal/canopen/cia406.h"
#include "hal/rig/rig.h"

namespace godobject {

void Rig::receive(Nanoseconds now) noexcept {
  now_ns_ = now;
  ReceivedFrame received;
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    int num_frames = 0;
    while (num_frames < max_frames_per_receive && buses_[i].bus->try_receive(received)) {
      ++num_frames;
      decode(i, received, now);
    }
    counters_.frames += static_cast<std::uint64_t>(num_frames);
    if (num_frames == max_frames_per_receive) ++counters_.receive_truncated;
  }
}

void Rig::decode(std::size_t bus, const ReceivedFrame& received, Nanoseconds now) noexcept {
  const CanFrame& frame = received.frame;
  Bus& on = buses_[bus];
  const SyncAttribution::Answer answer = on.syncs.on_frame(received);
  const std::size_t node_plus_1 = on.node_of_id[on.protocol.sender(frame)];
  if (from_second_host(bus, frame) || node_plus_1 == 0) {
    ++counters_.foreign;
    return;
  }
  RigNode& node = nodes_[node_plus_1 - 1];
  if (node.canopen && frame.id == canopen::heartbeat_cob_id(node.id)) return on_heartbeat(node, frame, now);
  if (node.canopen && frame.id == canopen::emcy_cob_id(node.id)) return on_emergency(node, frame);
  switch (node.kind) {
    case NodeKind::encoder: return on_position(node, frame, answer);
    case NodeKind::drive: return on_drive(node, frame, answer, now);
    case NodeKind::button: return on_inputs(node, frame);
  }
}

// Records a frame that was not used, unless it is of another service.
void Rig::note_malformed(RigNode& node, const CanFrame& frame, ParseResult why) noexcept {
  if (why == ParseResult::other_message) return;
  ++counters_.malformed;
  ++node.malformed;
  node.last_malformed = {.identifier = frame.id, .size = frame.size, .why = why};
}

/// True if the frame is one that only this host may send. The host does not receive its own frames.
bool Rig::from_second_host(std::size_t bus, const CanFrame& frame) noexcept {
  const Bus& on = buses_[bus];
  if (on.protocol.canopen && canopen::is_from_master(frame, params_.host_node_id)) {
    raise({.fault = RigFault::second_host, .bus = bus}, frame.id);
    return true;
  }
  const std::size_t node_plus_1 = on.node_of_id[on.protocol.commanded(frame)];
  if (node_plus_1 == 0 || nodes_[node_plus_1 - 1].kind != NodeKind::drive) return false;
  raise({.fault = RigFault::second_host, .bus = bus, .node_id = nodes_[node_plus_1 - 1].id}, frame.id);
  return true;
}

// Returns the sampling time of an answer: the end of the SYNC that it answers, given the delay of its node.
Nanoseconds Rig::sampled_at(const RigNode& node, const AnswerDelay& delay,
                            const SyncAttribution::Answer& answer) const noexcept {
  const std::uint64_t late = std::min(delay.periods(), answer.sync);
  return std::min(answer.t_ns, buses_[node.bus].syncs.end_of(answer.sync - late));
}

void Rig::on_position(RigNode& node, const CanFrame& frame, const SyncAttribution::Answer& answer) noexcept {
  if (answer.sync == 0) return;
  EncoderOnBus& encoder = encoders_[node.device];
  std::uint32_t position_counts = 0;
  const ParseResult result = cia406::parse_position(frame, node.id, position_counts);
  if (result != ParseResult::ok) return note_malformed(node, frame, result);
  node.answered = true;
  // a repeated frame is no second measurement: its time differs, which would appear as a jump
  if (answer.sync <= encoder.answered_sync) {
    ++counters_.repeated;
    encoder.delay.answered_again();
    return;
  }
  encoder.delay.answered(answer.sync, buses_[node.bus].syncs.num_syncs());
  encoder.encoder.update(position_counts, sampled_at(node, encoder.delay, answer));
  encoder.answered_sync = answer.sync;
}

void Rig::on_drive(RigNode& node, const CanFrame& frame, const SyncAttribution::Answer& answer,
                   Nanoseconds now) noexcept {
  if (answer.sync == 0) return;
  DriveOnBus& drive = drives_[node.device];
  const bool answered = answer.sync <= drive.answered_sync;
  const DriveMessage message = drive.drive.on_frame(frame, sampled_at(node, drive.delay, answer), answered);
  if (message.result != ParseResult::ok) return note_malformed(node, frame, message.result);
  node.answered = node.answered || message.position;
  if (message.position && answered) {
    ++counters_.repeated;
    drive.delay.answered_again();
  } else if (message.position) {
    drive.answered_sync = answer.sync;
    if (buses_[node.bus].protocol.answers_only)
      drive.delay.answered(answer.sync, buses_[node.bus].syncs.num_syncs());
  }
  if (drives_were_up()) check_drive_error(drive);
  if (node.canopen || !message.alive) return;
  node.heard = true;
  node.heartbeat_ns = now;
}

// Raises drive_error, unless the CANopen drive has sent an EMCY for it.
void Rig::check_drive_error(const DriveOnBus& drive) noexcept {
  const RigNode& node = nodes_[drive.node];
  const std::uint32_t error_code = drive.drive.error_code();
  if (drive.drive.state() != MotorState::fault || error_code == 0) return;
  const bool has_emergency = std::ranges::any_of(fault_log_.records(), [&](const RigFaultRecord& record) {
    const RigFaultPlace& place = record.place;
    return place.fault == RigFault::emergency && place.bus == node.bus && place.node_id == node.id;
  });
  if (!has_emergency) raise_drive_error(node, error_code);
}

void Rig::on_inputs(RigNode& node, const CanFrame& frame) noexcept {
  std::uint8_t inputs = 0;
  const ParseResult result = cia401::parse_inputs(frame, node.id, inputs);
  if (result != ParseResult::ok) return note_malformed(node, frame, result);
  node.answered = true;
  for (ButtonOnBus& button : buttons_) {
    if (&nodes_[button.node] != &node) continue;
    button.heard = true;
    button.pressed = (((inputs >> button.params.bit) & 1u) != 0) != button.params.active_low;
  }
}

void Rig::on_heartbeat(RigNode& node, const CanFrame& frame, Nanoseconds now) noexcept {
  canopen::Heartbeat heartbeat;
  const ParseResult result = canopen::parse_heartbeat(frame, heartbeat);
  if (result != ParseResult::ok) return note_malformed(node, frame, result);
  node.heard = true;
  node.heartbeat_ns = now;
  node.state = heartbeat.state;
  if (heartbeat.state == canopen::NmtState::boot_up) node.start_sent = false;
  if (nodes_were_up() && heartbeat.state != canopen::NmtState::operational)
    raise(RigFault::node_restarted, node);
}

void Rig::on_emergency(RigNode& node, const CanFrame& frame) noexcept {
  canopen::Emergency emergency;
  const ParseResult result = canopen::parse_emergency(frame, emergency);
  if (result != ParseResult::ok) return note_malformed(node, frame, result);
  // while booting, nodes report past errors; those that persist appear in their state
  if (nodes_were_up() && emergency.error_code != canopen::emcy_no_error)
    raise({.fault = RigFault::emergency,
           .bus = node.bus,
           .node_id = node.id,
           .emcy_code = emergency.error_code});
}

}  // namespace godobject
