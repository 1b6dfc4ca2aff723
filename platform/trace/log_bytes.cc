#include "platform/trace/log_bytes.h"

#include <algorithm>
#include <array>

namespace godobject {
namespace {

// Bits of the flags of a frame.
constexpr unsigned extended = 1, remote = 2, fd = 4, bit_rate_switch = 8;

// States of a rig by their numbers in a log, which stay the same in each version.
constexpr std::array<RigState, num_rig_states> states_by_number = [] {
  using enum RigState;
  return std::array{off, booting, enabling, ready, armed, hold, fault, stopping, closing, ended, homing};
}();

std::uint8_t number_of(RigState state) noexcept {
  return static_cast<std::uint8_t>(std::ranges::find(states_by_number, state) - states_by_number.begin());
}

}  // namespace

void put_link(std::string& out, const LinkEvent& event, Nanoseconds before) {
  put(out, static_cast<std::uint8_t>(event.kind));
  put_short(out, event.results);
  switch (event.kind) {
    case LinkEvent::Kind::call:
      put(out, static_cast<std::uint8_t>(event.call));
      put(out, event.value);
      put(out, number_of(event.rig_state));
      put(out, event.sent);
      return put_short(out, event.cycle);
    case LinkEvent::Kind::began:
    case LinkEvent::Kind::waited: return put_difference(out, event.t_ns - before);
    case LinkEvent::Kind::received: {
      const CanFrame& frame = event.frame;
      put(out, event.bus);
      put_difference(out, event.t_ns - before);
      put(out,
          static_cast<std::uint8_t>((frame.extended ? extended : 0) | (frame.remote ? remote : 0) |
                                    (frame.fd ? fd : 0) | (frame.bit_rate_switch ? bit_rate_switch : 0)));
      put_short(out, frame.id);
      put(out, frame.size);
      for (const std::uint8_t byte : frame.bytes()) put(out, byte);
      return;
    }
    case LinkEvent::Kind::refused:
    case LinkEvent::Kind::state:
    case LinkEvent::Kind::live: put(out, event.bus); return put(out, event.value);
  }
}

LinkEvent take_link(LogBytes& bytes, Nanoseconds before) {
  LinkEvent event{.kind = bytes.choice<LinkEvent::Kind>(num_link_event_kinds)};
  event.results = static_cast<std::uint32_t>(bytes.short_number());
  switch (event.kind) {
    case LinkEvent::Kind::call:
      event.call = bytes.choice<RigCall>(num_rig_calls);
      event.value = bytes.number<std::uint8_t>();
      event.rig_state = states_by_number[bytes.choice<std::uint8_t>(num_rig_states)];
      event.sent = bytes.number<std::uint32_t>();
      event.cycle = static_cast<std::uint32_t>(bytes.short_number());
      break;
    case LinkEvent::Kind::began:
    case LinkEvent::Kind::waited: event.t_ns = bytes.after(before); break;
    case LinkEvent::Kind::received: {
      CanFrame& frame = event.frame;
      event.bus = bytes.number<std::uint8_t>();
      event.t_ns = bytes.after(before);
      const auto flags = bytes.number<std::uint8_t>();
      frame.extended = (flags & extended) != 0;
      frame.remote = (flags & remote) != 0;
      frame.fd = (flags & fd) != 0;
      frame.bit_rate_switch = (flags & bit_rate_switch) != 0;
      frame.id = static_cast<std::uint32_t>(bytes.short_number());
      frame.size = bytes.choice<std::uint8_t>(static_cast<std::uint8_t>(frame.data.size() + 1));
      std::ranges::copy(bytes.text(frame.size), frame.data.begin());
      break;
    }
    case LinkEvent::Kind::refused:
    case LinkEvent::Kind::state:
    case LinkEvent::Kind::live:
      event.bus = bytes.number<std::uint8_t>();
      event.value = bytes.number<std::uint8_t>();
      break;
  }
  return event;
}

}  // namespace godobject
