#include "hal/canopen/sdo/sequence.h"

#include <algorithm>
#include <cstdio>

namespace godobject {

using sdo::AbortCode;
using sdo::TransferState;

namespace {

std::string formatted(const char* format, auto... values) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

/// Formats a number in decimal, above FFh also in hexadecimal.
std::string number(std::int64_t value) {
  std::string text = std::to_string(value);
  if (value > 0xFF) text += formatted(" (%08llXh)", static_cast<unsigned long long>(value));
  return text;
}

bool is_write(SdoAction action) noexcept {
  return action == SdoAction::write || action == SdoAction::write_if_other || action == SdoAction::switch_on;
}

}  // namespace

std::string to_string(canopen::ObjectAddress address) {
  return formatted("%04Xh:%02X", static_cast<unsigned>(address.index), static_cast<unsigned>(address.sub));
}

SdoSequence::SdoSequence(std::uint8_t node, std::vector<SdoStep> steps, Nanoseconds sdo_timeout_ns,
                         Nanoseconds wait_timeout_ns)
    : client_(node, sdo_timeout_ns),
      sdo_timeout_ns_(sdo_timeout_ns),
      steps_(std::move(steps)),
      wait_timeout_ns_(wait_timeout_ns) {}

void SdoSequence::restart() noexcept {
  client_ = sdo::Client(client_.node(), sdo_timeout_ns_);
  current_ = 0;
  failure_ = SdoFailure::none;
  begun_ = differs_ = stayed_on_ = false;
  read_again_ns_ = 0;
}

void SdoSequence::poll(Nanoseconds now, CanBus& bus) noexcept {
  if (!done() && !failed()) {
    if (!begun_) begin(now);
    else if (!client_.busy()) finish_transfer(now);
    if (!done() && !failed() && !begun_) begin(now);
  }
  client_.poll(now, bus);
}

void SdoSequence::skip_what_is_right() noexcept {
  while (!done()) {
    const SdoStep& step = steps_[current_];
    if (step.action == SdoAction::skip_if_same) {
      const std::size_t skipped = differs_ ? 0 : static_cast<std::size_t>(step.low);
      current_ = std::min(current_ + 1 + skipped, steps_.size());
      differs_ = false;
    } else if (step.action == SdoAction::switch_on && stayed_on_) {
      ++current_;
    } else {
      return;
    }
  }
}

void SdoSequence::begin(Nanoseconds now) noexcept {
  skip_what_is_right();
  if (done()) return;
  const SdoStep& step = steps_[current_];
  begun_ = true;
  wait_began_ns_ = now;
  if (step.action == SdoAction::switch_on) {
    write(step.low | static_cast<std::int64_t>(cob_id_flags_));
  } else if (step.action == SdoAction::write) {
    write(step.low);
  } else {
    writing_ = false;
    static_cast<void>(client_.read(step.address));
  }
}

void SdoSequence::write(std::int64_t value) noexcept {
  std::array<std::uint8_t, 4> bytes{};
  const auto used = std::span(bytes).first(canopen::size_of(steps_[current_].type));
  canopen::encode_number(value, used);
  writing_ = true;
  written_value_ = value;
  static_cast<void>(client_.write(steps_[current_].address, used));
}

void SdoSequence::finish_transfer(Nanoseconds now) noexcept {
  const SdoStep& step = steps_[current_];
  const AbortCode code = client_.abort_code();
  const bool absent = client_.state() == TransferState::aborted &&
                      (code == AbortCode::no_object || code == AbortCode::no_sub_index);
  const bool cannot = client_.state() == TransferState::aborted &&
                      (code == AbortCode::read_only || code == AbortCode::unsupported_access);
  // NOLINTNEXTLINE(bugprone-branch-clone): for another reason
  if (absent && !writing_ && step.action == SdoAction::switch_off_if_there) next();
  else if (absent && step.action == SdoAction::compare) {
    differs_ = true;
    next();
  } else if (cannot && writing_ && step.action == SdoAction::switch_off) {
    stayed_on_ = true;
    next();
  } else if (client_.state() != TransferState::done) failure_ = SdoFailure::transfer;
  else if (writing_) next();
  else on_read(now);
}

void SdoSequence::on_read(Nanoseconds now) noexcept {
  const SdoStep& step = steps_[current_];
  const std::size_t size = canopen::size_of(step.type);
  const std::span<const std::uint8_t> data = client_.data(size);
  if (data.size() != size) {
    failure_ = SdoFailure::wrong_size;
    return;
  }
  const std::int64_t raw = canopen::decode_number(data, canopen::is_signed(step.type));
  read_value_ = raw & ~static_cast<std::int64_t>(step.ignored_bits);
  const bool fits = read_value_ >= step.low && read_value_ <= step.high;
  switch (step.action) {
    case SdoAction::check:
      if (fits) next();
      else failure_ = SdoFailure::wrong_value;
      break;
    case SdoAction::wait_for:
      if (fits) {
        next();
      } else if (now - wait_began_ns_ >= wait_timeout_ns_) {
        failure_ = SdoFailure::never_the_value;
      } else if (now >= read_again_ns_) {
        read_again_ns_ = now + wait_interval_ns;
        static_cast<void>(client_.read(step.address));
      }
      break;
    case SdoAction::compare:
      differs_ = differs_ || !fits;
      next();
      break;
    case SdoAction::write_if_other:
      if (fits) next();
      else write(step.low);
      break;
    case SdoAction::switch_off:
    case SdoAction::switch_off_if_there:
      stayed_on_ = false;
      cob_id_flags_ = static_cast<std::uint32_t>(raw) & pdo_no_rtr;
      if ((static_cast<std::uint32_t>(raw) & pdo_invalid) != 0) next();
      else write(raw | static_cast<std::int64_t>(pdo_invalid));
      break;
    case SdoAction::write:
    case SdoAction::skip_if_same:
    case SdoAction::switch_on: break;
  }
}

void SdoSequence::next() noexcept {
  ++current_;
  begun_ = false;
  read_again_ns_ = 0;
}

std::string SdoSequence::error_text() const {
  if (!failed()) return "";
  const SdoStep& step = steps_[current_];
  std::string text = to_string(step.address);
  const std::string wanted =
      number(step.low) + (step.low == step.high || is_write(step.action) ? "" : " to " + number(step.high));
  switch (failure_) {
    case SdoFailure::transfer:
      text +=
          (writing_ ? " <- " + number(written_value_) : std::string(" read:")) + " " + client_.failure_text();
      break;
    case SdoFailure::wrong_value: text += " is " + number(read_value_) + ", not " + wanted; break;
    case SdoFailure::wrong_size:
      text += " has " + std::to_string(client_.data().size()) + " bytes, not the " +
              std::to_string(canopen::size_of(step.type)) + " of " +
              canopen::object_type_names[static_cast<std::size_t>(step.type)];
      break;
    case SdoFailure::never_the_value:
      text += " stays " + number(read_value_) + " for " + std::to_string(wait_timeout_ns_ / 1'000'000) +
              " ms, not " + wanted;
      break;
    case SdoFailure::none: break;
  }
  if (!step.hint.empty()) text += ": " + step.hint;
  return text;
}

}  // namespace godobject
