// State of one node on a rig's buses.
#pragma once

#include "hal/canopen/canopen.h"
#include "hal/rig/fault.h"

namespace godobject {

enum class NodeKind : std::uint8_t { encoder, drive, button };

struct RigNode {
  std::size_t bus = 0;
  std::uint8_t id = 0;
  NodeKind kind = NodeKind::encoder;
  std::size_t device = 0;  // index into the rig's encoders, drives or (the node's first) buttons
  bool canopen = true;     // takes part in NMT; any other node is supervised by its own messages

  canopen::NmtState state = canopen::NmtState::pre_operational;
  // a heartbeat was received; the heartbeat consumer starts with the first (CiA 301)
  bool heard = false;
  Nanoseconds heartbeat_ns = 0;  // time of the last heartbeat, or of its replacement (DriveMessage::alive)
  bool answered = false;         // its PDO or an answer to a request was received
  std::uint64_t malformed = 0;   // number of its unusable frames
  MalformedFrame last_malformed{};
  bool start_sent = false;
  Nanoseconds start_sent_ns = 0;

  bool operational() const noexcept { return heard && (!canopen || state == canopen::NmtState::operational); }
};

}  // namespace godobject
