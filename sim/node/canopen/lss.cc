#include "sim/node/canopen/lss.h"

namespace godobject {

using lss::Command;
using lss::Message;
using lss::Mode;

namespace {

constexpr std::uint8_t done = 0, out_of_range = 1;
constexpr std::uint8_t no_node_id = 255;

bool known_bit_timing(std::uint8_t table, std::uint8_t index) noexcept {
  constexpr std::uint8_t reserved = 5, last = 8;
  return table == 0 && index <= last && index != reserved;
}

}  // namespace

std::optional<Message> SimLss::answer(const Message& request, const lss::Identity& own) noexcept {
  const auto command = static_cast<Command>(request[0]);
  if (command == Command::switch_global) {
    mode_ =
        request[1] == static_cast<std::uint8_t>(Mode::configuration) ? Mode::configuration : Mode::waiting;
    return std::nullopt;
  }
  if (selects(request, own)) {
    mode_ = Mode::configuration;
    return lss::make_message(Command::selected);
  }
  if (mode_ != Mode::configuration) return std::nullopt;
  switch (command) {
    case Command::set_node_id: {
      const bool valid = (request[1] >= 1 && request[1] <= canopen::max_node_id) || request[1] == no_node_id;
      if (valid) pending_.node_id = request[1];
      return lss::make_message(command, valid ? done : out_of_range);
    }
    case Command::set_bit_timing: {
      const bool valid = known_bit_timing(request[1], request[2]);
      if (valid) pending_.bit_timing = request[2];
      return lss::make_message(command, valid ? done : out_of_range);
    }
    case Command::activate_bit_timing: active_bit_timing_ = pending_.bit_timing; return std::nullopt;
    case Command::inquire_vendor: return lss::make_select(command, own.vendor);
    case Command::inquire_product: return lss::make_select(command, own.product);
    case Command::inquire_revision: return lss::make_select(command, own.revision);
    case Command::inquire_serial: return lss::make_select(command, own.serial);
    case Command::inquire_node_id: return lss::make_message(command, pending_.node_id);
    case Command::store: stored_ = pending_; return lss::make_message(command, done);
    default: return std::nullopt;
  }
}

// True if the request completes a selection: the four identity numbers arrive in order and match.
bool SimLss::selects(const Message& request, const lss::Identity& own) noexcept {
  const std::array wanted{own.vendor, own.product, own.revision, own.serial};
  const std::size_t which = request[0] - static_cast<std::size_t>(Command::select_vendor);
  if (which >= wanted.size()) return false;
  std::uint32_t value = 0;
  ByteReader(std::span(request).subspan(1)).get(value);
  const bool fits = which == matched_ && value == wanted[which];
  matched_ = fits ? matched_ + 1 : 0;
  if (matched_ < wanted.size()) return false;
  matched_ = 0;
  return true;
}

void SimLss::power_cycle() noexcept {
  pending_ = stored_;
  active_bit_timing_ = stored_.bit_timing;
  mode_ = Mode::waiting;
  matched_ = 0;
}

}  // namespace godobject
