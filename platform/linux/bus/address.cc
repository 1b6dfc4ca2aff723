// Makes a bus from the text of --bus. Checks interfaces and ports before they are opened.
#include <linux/can.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>

#include "platform/linux/bus/bus.h"
#include "platform/linux/bus/slcan.h"
#include "platform/linux/bus/socket_can.h"
#include "platform/linux/serial_port.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

template <class Bus>
std::unique_ptr<LinuxBus> make(const std::string& where, const BusSettings& settings) {
  return std::make_unique<Bus>(where, settings);
}

std::unique_ptr<LinuxBus> make_pty(const std::string&, const BusSettings& settings) {
  return std::make_unique<PtyBus>(settings);
}

std::vector<RtStep> check_interface(const BusCheck& bus) {
  CanLink link;
  int error = read_can_link(bus.where.c_str(), link);
  if (error == ENODEV) {  // perhaps of a kernel without SocketCAN
    const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    if (fd < 0) error = errno;
    else close(fd);
  }
  return check_can_link(bus, error, link);
}

std::vector<RtStep> check_port(const BusCheck& bus) {
  return {check_serial_port(bus.name, parse_serial_address(bus.where, 0).path, bus.root)};
}

// Kinds of buses, one row each.
constexpr std::array backends{
    BusBackend{.name = "socketcan",
               .where = "INTERFACE, e.g. socketcan:can0",
               .make = make<SocketCanBus>,
               .check = check_interface,
               .max_where = 15,  // IFNAMSIZ - 1
               .comes_back = true},
    BusBackend{.name = "slcan",
               .where = "PATH[,BAUD], e.g. slcan:/dev/ttyACM0",
               .make = make<SlcanBus>,
               .check = check_port},
    BusBackend{.name = "pty", .where = "", .make = make_pty, .makes_terminal = true, .comes_back = true},
    BusBackend{.name = "board",
               .where = "PATH[,BAUD], e.g. board:/dev/ttyACM0",
               .make = make<BoardBus>,
               .check = check_port,
               .no_answers = "an encoder board has no objects",
               .no_device = "an encoder board is a device, not a bus to simulate one on"},
    BusBackend{.name = "replay",
               .where = "FILE[,INTERFACE], e.g. replay:run.log",
               .make = make<ReplayBus>,
               .no_answers = "a log does not answer requests",
               .is_file = true},
};

std::string unknown_kind(std::string_view kind) {
  std::array<std::string_view, backends.size()> names{};
  std::ranges::transform(backends, names.begin(), &BusBackend::name);
  std::string text = "unknown bus kind '";
  text.append(kind).append("'; ");
  if (const auto nearest = nearest_name(kind, names))
    text.append("did you mean '").append(*nearest).append("'? ");
  text.append("expected");
  for (const std::string_view name : names)
    text.append(name == names.front() ? " " : ", ").append(name).append(":");
  return text;
}

}  // namespace

std::optional<BusAddress> parse_bus_address(std::string_view text, std::string& error) {
  const std::size_t colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  const std::string_view where = colon == std::string::npos ? std::string_view() : text.substr(colon + 1);
  const auto backend = std::ranges::find(backends, name, &BusBackend::name);
  error.assign("'").append(text).append("': ");
  if (backend == backends.end()) {
    // The most frequent mistake: a bare path or interface name.
    if (colon == std::string::npos && name.starts_with('/')) {
      error.append("the bus kind is missing: give slcan:").append(text).append(" or replay:").append(text);
    } else if (colon == std::string::npos && (name.starts_with("can") || name.starts_with("vcan"))) {
      error.append("the bus kind is missing: give socketcan:").append(text);
    } else {
      error += unknown_kind(name);
    }
    return std::nullopt;
  }
  if (backend->where.empty() != where.empty()) {
    if (where.empty()) {
      error.append(name).append(": needs ").append(backend->where);
    } else {
      error += "pty takes no address: the system chooses the terminal, and its name is printed";
    }
    return std::nullopt;
  }
  if (where.size() > backend->max_where) {
    error.append(name).append(": needs ").append(backend->where).append("; at most ");
    error += std::to_string(backend->max_where) + " characters";
    return std::nullopt;
  }
  error.clear();
  return BusAddress{.backend = &*backend, .where = std::string(where)};
}

std::vector<RtStep> check_can_link(const BusCheck& bus, int error, const CanLink& link) {
  const std::string& interface = bus.where;
  std::vector<RtStep> steps;
  const auto add = [&](RtResult result, const std::string& message) {  // "trouble: remedy"
    const std::size_t colon = message.find(": ");
    steps.push_back({.name = bus.name,
                     .result = result,
                     .detail = message.substr(0, colon),
                     .remedy = colon == std::string::npos ? "" : message.substr(colon + 2)});
  };
  if (error != 0) {
    const std::string known = why_no_link(interface, error);
    add(RtResult::failed,
        known.empty() ? interface + " (" + std::strerror(error) + "): ip link show " + interface : known);
    return steps;
  }
  const LinkFit conflict = fit(link, bus.settings);
  if (conflict != LinkFit::fits) add(RtResult::failed, text_of(conflict, interface, link, bus.settings));
  const BusState state = link.controller ? link.controller->state : BusState::error_active;
  if (link.up && state == BusState::bus_off) add(RtResult::failed, bus_off_text(interface, link));
  else if (link.up && state != BusState::error_active)
    add(RtResult::degraded, interface + " is " + std::string(name_of(state)) + " (TEC " +
                                std::to_string(link.controller->transmit_error_counter) + ", REC " +
                                std::to_string(link.controller->receive_error_counter) +
                                "): check cable, termination and bit rate of all nodes");
  std::istringstream warnings(link_warnings(interface, link));
  for (std::string line; std::getline(warnings, line);) add(RtResult::degraded, line);
  if (link.transmit_queue_length < bus.frames)
    add(RtResult::degraded, interface + " queues " + std::to_string(link.transmit_queue_length) +
                                " frames of the " + std::to_string(bus.frames) + " in a cycle: ip link set " +
                                interface + " txqueuelen 100");
  if (steps.empty())
    add(RtResult::ok,
        interface + " is up, " +
            (link.controller ? std::to_string(link.controller->bit_rate) + " bit/s, error_active"
                             : std::string("virtual")) +
            ", txqueuelen " + std::to_string(link.transmit_queue_length));
  return steps;
}

std::unique_ptr<LinuxBus> make_bus(const BusAddress& address, const BusSettings& settings) {
  return address.backend->make(address.where, settings);
}

}  // namespace godobject
