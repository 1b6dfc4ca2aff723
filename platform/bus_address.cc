// From the text of --bus to a bus.
#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "platform/linux_bus.h"
#include "platform/pty_bus.h"
#include "platform/replay_bus.h"
#include "platform/slcan_bus.h"
#include "platform/socket_can_bus.h"

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
    KindText{BusKind::replay, "replay", "FILE[,INTERFACE], e.g. replay:run.log"},
};

constexpr std::size_t max_interface_length = 15;  // IFNAMSIZ - 1

/// Levenshtein's: the least number of characters to be put in, left out or exchanged.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string unknown_kind(std::string_view kind) {
  constexpr std::size_t resemblance = 2;  // characters
  std::string text = "no kind of bus is called '" + std::string(kind) + "'";
  const auto nearest =
      std::ranges::min_element(kinds, {}, [&](const KindText& k) { return distance(kind, k.name); });
  if (distance(kind, nearest->name) <= resemblance)
    text += "; did you mean '" + std::string(nearest->name) + "'?";
  text += " There are";
  for (const KindText& k : kinds) text += (&k == kinds.data() ? " " : ", ") + std::string(k.name) + ":";
  return text;
}

}  // namespace

std::optional<BusAddress> parse_bus_address(std::string_view text, std::string& error) {
  const std::size_t colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  const std::string_view where = colon == text.npos ? std::string_view() : text.substr(colon + 1);
  const auto kind = std::ranges::find(kinds, name, &KindText::name);
  error = "'" + std::string(text) + "': ";
  if (kind == kinds.end()) {
    // The commonest slip: the bare name of what there is.
    if (colon == text.npos && name.starts_with('/')) {
      error += "say what it is: slcan:" + std::string(text) + " or replay:" + std::string(text);
    } else if (colon == text.npos && (name.starts_with("can") || name.starts_with("vcan"))) {
      error += "say what it is: socketcan:" + std::string(text);
    } else {
      error += unknown_kind(name);
    }
    return std::nullopt;
  }
  if (kind->where.empty() != where.empty()) {
    error += where.empty() ? std::string(name) + ": is followed by " + std::string(kind->where)
                           : "nothing follows pty: the system chooses the terminal, and its name is printed";
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
    case BusKind::replay: return std::make_unique<ReplayBus>(address.where, settings);
  }
  return nullptr;
}

}  // namespace godobject
