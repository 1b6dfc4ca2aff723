#include "hal/canopen/lss.h"

namespace godobject::lss {

const char* text_of(Command command, std::uint8_t error_code) noexcept {
  constexpr std::uint8_t vendor_specific = 255;
  if (error_code == 0) return "done";
  if (error_code == vendor_specific) return "vendor-specific error: see the device's manual";
  if (error_code == 1) {
    switch (command) {
      case Command::set_node_id: return "node-ID out of range: 1 to 127";
      case Command::set_bit_timing: return "the node does not have this bit rate";
      case Command::store: return "the node cannot store its settings";
      default: break;
    }
  }
  if (command == Command::store && error_code == 2) return "access to the node's memory failed";
  return "error code not defined by CiA 305";
}

bool Master::switch_global(Mode mode) noexcept {
  const Message message = make_message(Command::switch_global, static_cast<std::uint8_t>(mode));
  return begin({&message, 1}, std::nullopt);
}

bool Master::select(const Identity& identity) noexcept {
  const std::array messages{make_select(Command::select_vendor, identity.vendor),
                            make_select(Command::select_product, identity.product),
                            make_select(Command::select_revision, identity.revision),
                            make_select(Command::select_serial, identity.serial)};
  return begin(messages, Command::selected);
}

bool Master::set_node_id(std::uint8_t node_id) noexcept {
  const Message message = make_message(Command::set_node_id, node_id);
  return begin({&message, 1}, Command::set_node_id);
}

bool Master::set_bit_timing(std::uint8_t index) noexcept {
  constexpr std::uint8_t table_of_cia_305 = 0;
  const Message message = make_message(Command::set_bit_timing, table_of_cia_305, index);
  return begin({&message, 1}, Command::set_bit_timing);
}

bool Master::store() noexcept {
  const Message message = make_message(Command::store);
  return begin({&message, 1}, Command::store);
}

bool Master::inquire(Command command) noexcept {
  const Message message = make_message(command);
  if (!begin({&message, 1}, command)) return false;
  inquires_ = true;
  return true;
}

bool Master::activate_bit_timing(std::uint16_t delay_ms) noexcept {
  const Message message = make_activate(delay_ms);
  return begin({&message, 1}, std::nullopt);
}

bool Master::begin(std::span<const Message> messages, std::optional<Command> answer) noexcept {
  if (outcome_ == Outcome::busy) return false;
  std::ranges::copy(messages, messages_.begin());
  count_ = messages.size();
  sent_ = 0;
  answer_ = answer;
  outcome_ = Outcome::busy;
  error_code_ = vendor_error_ = 0;
  num_answers_ = 0;
  inquires_ = false;
  timing_ = false;
  return true;
}

void Master::poll(Nanoseconds now, CanBus& bus) noexcept {
  if (outcome_ != Outcome::busy) return;
  if (!timing_) deadline_ns_ = now + timeout_ns_;
  timing_ = true;
  while (sent_ < count_ && bus.try_send(make_frame(request_cob_id, messages_[sent_])) == SendResult::queued)
    ++sent_;
  const bool all_sent = sent_ == count_;
  if (all_sent && !answer_) outcome_ = Outcome::done;  // NOLINT(bugprone-branch-clone): for another reason
  else if (now < deadline_ns_) return;
  else if (num_answers_ > 0) outcome_ = Outcome::done;
  else outcome_ = all_sent ? Outcome::no_answer : Outcome::not_sent;
}

bool Master::on_frame(const CanFrame& frame) noexcept {
  Message message;
  if (outcome_ != Outcome::busy || sent_ != count_ || !answer_) return false;
  if (parse_frame(frame, response_cob_id, message) != ParseResult::ok) return false;
  if (message[0] != static_cast<std::uint8_t>(*answer_)) return false;
  if (inquires_) {
    std::uint32_t value = 0;
    ByteReader(std::span(message).subspan(1)).get(value);
    if (answer_ == Command::inquire_node_id) value &= 0xFF;  // one byte; the rest is reserved
    if (num_answers_ < answers_.size()) answers_[num_answers_++] = value;
    return true;
  }
  const bool has_error_code = *answer_ != Command::selected;
  error_code_ = has_error_code ? message[1] : std::uint8_t{0};
  vendor_error_ = has_error_code ? message[2] : std::uint8_t{0};
  outcome_ = error_code_ == 0 ? Outcome::done : Outcome::rejected;
  return true;
}

}  // namespace godobject::lss
