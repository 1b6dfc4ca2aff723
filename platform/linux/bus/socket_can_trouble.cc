// Remedies for the states of a SocketCAN bus.
#include <net/if.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "platform/linux/bus/socket_can.h"

namespace godobject {
namespace {

std::string restart_command(const std::string& interface, const CanLink& link) {
  if (link.controller && link.controller->restart_ms > 0)
    return "wait: it restarts by itself " + std::to_string(link.controller->restart_ms) +
           " ms after each bus-off";
  return "ip link set " + interface + " type can restart";
}

std::string renamed_text(const std::string& before, const std::string& now) {
  return before + " has been renamed and is called " + now + " now: rename it back (ip link set " + now +
         " name " + before + "), or give --bus the new name";
}

}  // namespace

std::string SocketCanBus::trouble() const {
  if (state_ == BusState::closed) return why_not_open();
  return why_state();
}

/// Returns the present name of the interface; the opened name if it is gone.
std::string SocketCanBus::present_name() const {
  std::array<char, IF_NAMESIZE> name{};
  return index_ != 0 && if_indextoname(index_, name.data()) != nullptr ? name.data() : interface_;
}

std::string SocketCanBus::why_state() const {
  CanLink link;
  const std::string interface = present_name();
  const std::string renamed = interface == interface_ ? "" : "\n" + renamed_text(interface_, interface);
  const bool known = read_can_link(interface.c_str(), link) == 0;
  std::string text;
  switch (state_) {
    case BusState::gone:
      return interface + " was unplugged or removed: plug it in again, then reopen it" +
             (known ? " (" + interface + " is there again)" : "");
    case BusState::down:
      return (known ? text_of(LinkFit::down, interface, link, settings()) : interface + " is down") + renamed;
    case BusState::bus_off:
      text = interface + " is bus-off: check cable, termination and bit rate of all nodes; then " +
             restart_command(interface, known ? link : CanLink{}) + "\n";
      break;
    case BusState::error_warning:
    case BusState::error_passive:
      text = interface + " is " + std::string(name_of(state_)) + " (TEC " +
             std::to_string(counters_.transmit_error_counter) + ", REC " +
             std::to_string(counters_.receive_error_counter) + ")";
      if (counters_.last_error != BusError::none)
        text += "; last error " + std::string(name_of(counters_.last_error)) + ": " +
                std::string(text_of(counters_.last_error));
      text += "\n";
      break;
    default: break;
  }
  if (queue_full_ != 0)
    text += interface + ": the transmit queue refused " + std::to_string(queue_full_) +
            " frames: check that another node acknowledges; for more frames in one cycle: ip link set " +
            interface + " txqueuelen 100" +
            (known ? " (now " + std::to_string(link.transmit_queue_length) + ")" : "") + "\n";
  if (known) text += link_warnings(interface, link);
  if (text.empty()) return text;
  text.pop_back();
  return text + renamed;
}

std::string SocketCanBus::why_not_open() const {
  CanLink link;
  if (fit_ != LinkFit::fits) {
    const int error = read_can_link(interface_.c_str(), link);
    return error == 0 ? text_of(fit_, interface_, link, settings())
                      : interface_ + " has just gone: plug it in again";
  }
  if (failed_call_ == nullptr) return {};
  if (failed_errno_ == EAFNOSUPPORT)
    return "this kernel has no SocketCAN: modprobe can_raw (as root), or a kernel built with CONFIG_CAN; an "
           "adapter "
           "on a serial port works without: slcan:/dev/ttyACM0";
  if (failed_errno_ == ENODEV && present_name() != interface_)
    return renamed_text(interface_, present_name());
  if (failed_errno_ == ENODEV)
    return "there is no interface " + interface_ +
           ": plug the adapter in; `ip link show type can` lists those there "
           "are. A virtual one: ip link add dev " +
           interface_ + " type vcan && ip link set " + interface_ + " up";
  if (failed_errno_ == EMEDIUMTYPE)
    return interface_ + " is no CAN interface: `ip link show type can` lists those there are";
  return interface_ + ": " + failed_call_ + ": " + std::strerror(failed_errno_);
}

}  // namespace godobject
