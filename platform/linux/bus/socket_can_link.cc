// Configuration of a CAN interface, read over rtnetlink, and remedies for its conflicts and the states of its
// bus.
#include "platform/linux/bus/socket_can.h"

#include <linux/can/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <span>
#include <string_view>

namespace godobject {
namespace {

using Bytes = std::span<const char>;

template <class T>
bool copy_to(T& value, Bytes bytes) noexcept {
  if (bytes.size() < sizeof value) return false;
  std::memcpy(&value, bytes.data(), sizeof value);
  return true;
}

constexpr std::size_t aligned(std::size_t size) noexcept { return (size + 3u) & ~std::size_t{3}; }

/// Calls `use(type, payload)` for each attribute.
template <class Use>
void for_each_attribute(Bytes bytes, Use&& use) noexcept {
  rtattr head{};
  while (copy_to(head, bytes) && head.rta_len >= sizeof head && head.rta_len <= bytes.size()) {
    use(head.rta_type & NLA_TYPE_MASK, bytes.subspan(sizeof head, head.rta_len - sizeof head));
    bytes = bytes.subspan(std::min(aligned(head.rta_len), bytes.size()));
  }
}

BusState bus_state(std::uint32_t state) noexcept {
  switch (state) {
    case CAN_STATE_ERROR_ACTIVE: return BusState::error_active;
    case CAN_STATE_ERROR_WARNING: return BusState::error_warning;
    case CAN_STATE_ERROR_PASSIVE: return BusState::error_passive;
    case CAN_STATE_BUS_OFF: return BusState::bus_off;
    default: return BusState::down;
  }
}

void read_controller(Bytes data, CanController& controller) noexcept {
  for_each_attribute(data, [&](int type, Bytes value) {
    can_bittiming timing{};
    can_berr_counter errors{};
    std::uint32_t state = 0;
    if (type == IFLA_CAN_BITTIMING && copy_to(timing, value)) controller.bit_rate = timing.bitrate;
    if (type == IFLA_CAN_DATA_BITTIMING && copy_to(timing, value)) controller.data_bit_rate = timing.bitrate;
    if (type == IFLA_CAN_RESTART_MS) copy_to(controller.restart_ms, value);
    if (type == IFLA_CAN_STATE && copy_to(state, value)) controller.state = bus_state(state);
    if (type == IFLA_CAN_BERR_COUNTER && copy_to(errors, value)) {
      controller.transmit_error_counter = errors.txerr;
      controller.receive_error_counter = errors.rxerr;
    }
  });
}

void read_link_info(Bytes info, CanLink& link) noexcept {
  std::string_view kind;
  Bytes data;
  for_each_attribute(info, [&](int type, Bytes value) {
    if (type == IFLA_INFO_KIND) kind = {value.data(), strnlen(value.data(), value.size())};
    if (type == IFLA_INFO_DATA) data = value;
  });
  if (kind == "can") read_controller(data, link.controller.emplace());
}

void read_attributes(Bytes attributes, CanLink& link) noexcept {
  for_each_attribute(attributes, [&](int type, Bytes value) {
    if (type == IFLA_MTU) copy_to(link.mtu, value);
    if (type == IFLA_TXQLEN) copy_to(link.transmit_queue_length, value);
    if (type == IFLA_QDISC) {
      const std::size_t size = std::min(value.size(), link.qdisc.size() - 1);
      std::copy_n(value.begin(), size, link.qdisc.begin());
    }
    if (type == IFLA_LINKINFO) read_link_info(value, link);
  });
}

int parse_reply(Bytes reply, CanLink& link) noexcept {
  nlmsghdr head{};
  if (!copy_to(head, reply) || head.nlmsg_len > reply.size()) return EPROTO;
  const Bytes body = reply.first(head.nlmsg_len).subspan(sizeof head);
  if (head.nlmsg_type == NLMSG_ERROR) {
    nlmsgerr error{};
    return copy_to(error, body) && error.error != 0 ? -error.error : EPROTO;
  }
  ifinfomsg info{};
  if (head.nlmsg_type != RTM_NEWLINK || !copy_to(info, body)) return EPROTO;
  if (info.ifi_type != ARPHRD_CAN) return EMEDIUMTYPE;
  link = {};
  link.up = (info.ifi_flags & IFF_UP) != 0;
  read_attributes(body.subspan(aligned(sizeof info)), link);
  return 0;
}

bool agrees(std::uint32_t is, double wanted) noexcept {
  return std::abs(static_cast<double>(is) - wanted) <= 0.005 * wanted;  // two oscillators may differ by 0.5 %
}

std::string number(double value) { return std::to_string(std::llround(value)); }

std::string up_command(const std::string& interface, const CanLink& link, const BusSettings& settings) {
  if (!link.controller) return "ip link set " + interface + " up";
  std::string command = "ip link set " + interface + " up type can bitrate " + number(settings.bit_rate);
  if (settings.data_bit_rate > 0) command += " dbitrate " + number(settings.data_bit_rate) + " fd on";
  return command + " restart-ms 100";
}

std::string down_up(const std::string& interface, const CanLink& link, const BusSettings& settings) {
  return "ip link set " + interface + " down && " + up_command(interface, link, settings);
}

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

int read_can_link(const char* interface, CanLink& link) noexcept {
  struct {
    nlmsghdr head;
    ifinfomsg info;
  } request{};
  const unsigned index = if_nametoindex(interface);
  if (index == 0) return ENODEV;
  request.head.nlmsg_len = sizeof request;
  request.head.nlmsg_type = RTM_GETLINK;
  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.info.ifi_index = static_cast<int>(index);

  const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (fd < 0) return errno;
  // The kernel answers before send() returns, so there is no wait.
  std::array<char, 16384> reply;
  ssize_t size = send(fd, &request, sizeof request, 0);
  if (size >= 0) size = recv(fd, reply.data(), reply.size(), MSG_DONTWAIT);
  const int error = size < 0 ? errno : parse_reply(Bytes(reply).first(static_cast<std::size_t>(size)), link);
  close(fd);
  return error;
}

LinkFit fit(const CanLink& link, const BusSettings& settings) noexcept {
  if (!link.up) return LinkFit::down;
  if (link.controller && !agrees(link.controller->bit_rate, settings.bit_rate)) return LinkFit::bit_rate;
  if (settings.data_bit_rate <= 0) return LinkFit::fits;
  if (!link.carries_fd()) return LinkFit::classic_only;
  if (link.controller && !agrees(link.controller->data_bit_rate, settings.data_bit_rate))
    return LinkFit::data_bit_rate;
  return LinkFit::fits;
}

std::string text_of(LinkFit fit, const std::string& interface, const CanLink& link,
                    const BusSettings& settings) {
  const CanController controller = link.controller.value_or(CanController{});
  switch (fit) {
    case LinkFit::fits: return {};
    case LinkFit::down: return interface + " is down: " + up_command(interface, link, settings);
    case LinkFit::bit_rate:
      return interface + " runs at " + number(controller.bit_rate) + " bit/s, the scene has " +
             number(settings.bit_rate) +
             ": correct bit_rate of the scene, or: " + down_up(interface, link, settings);
    case LinkFit::data_bit_rate:
      return interface + " has a data bit rate of " + number(controller.data_bit_rate) +
             " bit/s, the scene has " + number(settings.data_bit_rate) +
             ": correct data_bit_rate of the scene, or: " + down_up(interface, link, settings);
    case LinkFit::classic_only:
      if (link.controller)
        return interface + " carries classic frames only, the scene requires CAN FD: " +
               down_up(interface, link, settings) + " (only with a CAN FD adapter)";
      return interface + " carries classic frames only, the scene requires CAN FD: ip link set " + interface +
             " down && ip link set " + interface + " mtu 72 && ip link set " + interface + " up";
  }
  return {};
}

std::string why_no_link(const std::string& interface, int error) {
  switch (error) {
    case EAFNOSUPPORT:
      return "this kernel has no SocketCAN: modprobe can_raw (as root), or a kernel built with CONFIG_CAN; "
             "an "
             "adapter on a serial port works without: slcan:/dev/ttyACM0";
    case ENODEV:
      return "there is no interface " + interface +
             ": plug the adapter in; `ip link show type can` lists those there "
             "are. A virtual one: ip link add dev " +
             interface + " type vcan && ip link set " + interface + " up";
    case EMEDIUMTYPE:
      return interface + " is no CAN interface: `ip link show type can` lists those there are";
    default: return {};
  }
}

std::string bus_off_text(const std::string& interface, const CanLink& link) {
  return interface + " is bus-off: check cable, termination and bit rate of all nodes; then " +
         restart_command(interface, link);
}

std::string link_warnings(const std::string& interface, const CanLink& link) {
  std::string text;
  if (link.controller && link.controller->restart_ms == 0)
    text += interface + " stays off after a bus-off (restart-ms 0): ip link set " + interface +
            " down && ip link set " + interface + " type can restart-ms 100 && ip link set " + interface +
            " up\n";
  // fq_codel may drop a waiting frame in favour of a later one without an error.
  if (std::string_view(link.qdisc.data()).starts_with("fq_codel"))
    text += interface +
            " has the queueing discipline fq_codel, which drops frames silently: tc qdisc replace dev " +
            interface + " root pfifo_fast\n";
  return text;
}

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
    case BusState::bus_off: text = bus_off_text(interface, known ? link : CanLink{}) + "\n"; break;
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
  if (failed_errno_ == ENODEV && present_name() != interface_)
    return renamed_text(interface_, present_name());
  if (std::string text = why_no_link(interface_, failed_errno_); !text.empty()) return text;
  return interface_ + ": " + failed_call_ + ": " + std::strerror(failed_errno_);
}

}  // namespace godobject
