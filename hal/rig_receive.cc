// Rig: from received frames to nodes, encoders and drives.
#include "hal/cia406.h"
#include "hal/rig.h"

namespace godobject {

namespace {

constexpr bool is_emergency(std::uint32_t cob_id) noexcept {
  return cob_id > canopen::emcy_cob_id(0) && cob_id <= canopen::emcy_cob_id(canopen::max_node_id);
}
constexpr bool is_position(std::uint32_t cob_id) noexcept {
  return cob_id > canopen::tpdo_cob_id(1, 0) && cob_id <= canopen::tpdo_cob_id(1, canopen::max_node_id);
}
constexpr bool is_heartbeat(std::uint32_t cob_id) noexcept {
  return cob_id > canopen::heartbeat_cob_id(0) && cob_id <= canopen::heartbeat_cob_id(canopen::max_node_id);
}

}  // namespace

void Rig::receive(Nanoseconds now) noexcept {
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

// In the predefined connection set the node id is the low seven bits of the COB-ID.
void Rig::decode(std::size_t bus, const ReceivedFrame& received, Nanoseconds now) noexcept {
  const CanFrame& frame = received.frame;
  const SyncAttribution::Answer answer = buses_[bus].syncs.on_frame(received);
  const std::size_t node_plus_1 = buses_[bus].node_of_id[frame.id & canopen::max_node_id];
  if (!canopen::is_canopen(frame) || node_plus_1 == 0) {
    ++counters_.foreign;
    return;
  }
  RigNode& node = nodes_[node_plus_1 - 1];
  if (is_position(frame.id)) {
    on_position(node, frame, answer);
  } else if (is_heartbeat(frame.id)) {
    on_heartbeat(node, frame, now);
  } else if (is_emergency(frame.id)) {
    on_emergency(node, frame);
  }
}

void Rig::on_position(RigNode& node, const CanFrame& frame, const SyncAttribution::Answer& answer) noexcept {
  if (answer.sync == 0) return;
  ParseResult result;
  if (node.kind == NodeKind::encoder) {
    EncoderOnBus& encoder = encoders_[node.device];
    std::uint32_t position_counts = 0;
    result = cia406::parse_position(frame, node.id, position_counts);
    if (result == ParseResult::ok) {
      encoder.encoder.update(position_counts, answer.t_ns);
      encoder.answered_sync = answer.sync;
    }
  } else {
    DriveOnBus& drive = drives_[node.device];
    result = drive.drive.on_status(frame, answer.t_ns);
    if (result == ParseResult::ok) drive.answered_sync = answer.sync;
  }
  if (result != ParseResult::ok) ++counters_.malformed;
}

void Rig::on_heartbeat(RigNode& node, const CanFrame& frame, Nanoseconds now) noexcept {
  canopen::Heartbeat heartbeat;
  if (canopen::parse_heartbeat(frame, heartbeat) != ParseResult::ok) {
    ++counters_.malformed;
    return;
  }
  node.heard = true;
  node.heartbeat_ns = now;
  node.state = heartbeat.state;
  if (heartbeat.state == canopen::NmtState::boot_up) node.start_sent = false;
  if (running() && heartbeat.state != canopen::NmtState::operational) raise(RigFault::node_restarted, node);
}

void Rig::on_emergency(RigNode& node, const CanFrame& frame) noexcept {
  canopen::Emergency emergency;
  if (canopen::parse_emergency(frame, emergency) != ParseResult::ok) {
    ++counters_.malformed;
    return;
  }
  // while booting, nodes report what happened before; what still holds shows in their state
  if (running() && emergency.error_code != canopen::emcy_no_error) {
    raise(RigFault::emergency, node.bus, node.id, emergency.error_code);
  }
}

}  // namespace godobject
