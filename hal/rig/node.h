// What a rig knows of one node on its buses.
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
  bool canopen = true;     // takes part in NMT; any other node is supervised by what it sends of itself

  canopen::NmtState state = canopen::NmtState::pre_operational;
  bool heard = false;            // a heartbeat has come: its consumer runs from the first one on (CiA 301)
  Nanoseconds heartbeat_ns = 0;  // or what stands for it (DriveMessage::alive)
  bool answered = false;         // its PDO, or an answer to a request, has come
  std::uint64_t malformed = 0;   // of its frames
  MalformedFrame last_malformed{};
  bool start_sent = false;
  Nanoseconds start_sent_ns = 0;

  bool operational() const noexcept { return heard && (!canopen || state == canopen::NmtState::operational); }
};

}  // namespace godobject
