// From the text of --bus to a bus.
#include <algorithm>
#include <array>

#include "platform/linux/board_bus.h"
#include "platform/linux/bus.h"
#include "platform/linux/nearest_name.h"
#include "platform/linux/pty_bus.h"
#include "platform/linux/replay_bus.h"
#include "platform/linux/slcan_bus.h"
#include "platform/linux/socket_can_bus.h"

namespace godobject {
namespace {

struct KindText {
  BusKind kind;
  std::string_view name;
  std::string_view where;  // what stands after the colon; empty: nothing
};

constexpr std::array kinds{
    KindText{BusKind::socketcan, "socketcan", "INTERFACE, e.g. socketcan:can0"},
    KindText{BusKind::slcan, "slcan", "PATH[,BAUD], e.g. slcan:/dev/ttyACM0"},
    KindText{BusKind::pty, "pty", ""},
    KindText{BusKind::board, "board", "PATH[,BAUD], e.g. board:/dev/ttyACM0"},
    KindText{BusKind::replay, "replay", "FILE[,INTERFACE], e.g. replay:run.log"},
};

constexpr std::size_t max_interface_length = 15;  // IFNAMSIZ - 1

std::string unknown_kind(std::string_view kind) {
  std::array<std::string_view, kinds.size()> names{};
  std::ranges::transform(kinds, names.begin(), &KindText::name);
  std::string text = "no kind of bus is called '";
  text.append(kind).append("'");
  if (const auto nearest = nearest_name(kind, names))
    text.append("; did you mean '").append(*nearest).append("'?");
  text.append(" There are");
  for (const std::string_view name : names)
    text.append(name == names.front() ? " " : ", ").append(name).append(":");
  return text;
}

}  // namespace

std::optional<BusAddress> parse_bus_address(std::string_view text, std::string& error) {
  const std::size_t colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  const std::string_view where = colon == std::string::npos ? std::string_view() : text.substr(colon + 1);
  const auto kind = std::ranges::find(kinds, name, &KindText::name);
  error.assign("'").append(text).append("': ");
  if (kind == kinds.end()) {
    // The commonest slip: the bare name of what there is.
    if (colon == std::string::npos && name.starts_with('/')) {
      error.append("say what it is: slcan:").append(text).append(" or replay:").append(text);
    } else if (colon == std::string::npos && (name.starts_with("can") || name.starts_with("vcan"))) {
      error.append("say what it is: socketcan:").append(text);
    } else {
      error += unknown_kind(name);
    }
    return std::nullopt;
  }
  if (kind->where.empty() != where.empty()) {
    if (where.empty()) {
      error.append(name).append(": is followed by ").append(kind->where);
    } else {
      error += "nothing follows pty: the system chooses the terminal, and its name is printed";
    }
    return std::nullopt;
  }
  if (kind->kind == BusKind::socketcan && where.size() > max_interface_length) {
    error += "the name of an interface has at most 15 characters";
    return std::nullopt;
  }
  error.clear();
  return BusAddress{.kind = kind->kind, .where = std::string(where)};
}

std::unique_ptr<LinuxBus> make_bus(const BusAddress& address, const BusSettings& settings) {
  switch (address.kind) {
    case BusKind::socketcan: return std::make_unique<SocketCanBus>(address.where, settings);
    case BusKind::slcan: return std::make_unique<SlcanBus>(address.where, settings);
    case BusKind::pty: return std::make_unique<PtyBus>(settings);
    case BusKind::board: return std::make_unique<BoardBus>(address.where, settings);
    case BusKind::replay: return std::make_unique<ReplayBus>(address.where, settings);
  }
  return nullptr;
}

}  // namespace godobject
