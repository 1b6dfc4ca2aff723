#include "platform/linux/bus/slcan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "platform/rt/cyclic.h"

namespace godobject {
namespace {

constexpr std::uint32_t default_baud = 115'200;
constexpr Nanoseconds quiet_time = 50'000'000;

}  // namespace

SlcanBus::SlcanBus(const std::string& where, const BusSettings& settings)
    : path_(parse_serial_address(where, default_baud).path),
      baud_(parse_serial_address(where, default_baud).baud),
      bit_rate_(settings.bit_rate),
      data_bit_rate_(settings.data_bit_rate),
      filters_(settings.filters.begin(), settings.filters.end()) {}

bool SlcanBus::fail(std::string why) {
  why_ = std::move(why);
  line_.port().close();
  state_ = BusState::closed;
  return false;
}

bool SlcanBus::open() noexcept {
  close();
  const std::string_view rate = slcan::bit_rate_command(bit_rate_);
  if (data_bit_rate_ > 0)
    return fail("SLCAN carries no CAN FD: use SocketCAN, or a bus without data_bit_rate");
  if (rate.empty())
    return fail("SLCAN has no bit rate of " + std::to_string(std::lround(bit_rate_)) +
                " bit/s, only 10, 20, 50, 100, 125, 250, 500, 800 kbit/s and 1 Mbit/s");
  if (baud_ == 0) return fail("the baud rate after the comma is not a number above 0");
  if (!line_.port().open(path_, {.baud = baud_})) return false;
  line_.clear();
  // Ends an incomplete line of an earlier host. Not by a bare CR, upon which some adapters repeat their last
  // command. V is no digit, so it completes no frame.
  for (const std::string_view first : {slcan::version_command, slcan::close_command})
    if (line_.put(first)) wait_for_quiet();
  version_.clear();
  if (!command(rate, "the bit rate") || !command(slcan::open_command, "to open its channel")) return false;
  has_flags_ = ask(slcan::flags_command, patience()) == Answer::flags;
  flags_due_ = MonotonicClock().now() + flags_period;
  state_ = BusState::error_active;
  num_unanswered_ = num_garbled_ = num_fd_ = 0;
  dropped_at_open_ = line_.reader().num_overlong() + line_.reader().num_cut();
  reports_state_ = false;
  return true;
}

void SlcanBus::close() noexcept {
  if (state_ != BusState::closed && !line_.put(slcan::close_command)) line_.flush();
  line_.port().close();
  earlier_garbled_ += num_garbled();
  num_garbled_ = dropped_at_open_ = 0;
  line_.clear();
  state_ = BusState::closed;
  why_.clear();
}

/// Waits until no byte has come for quiet_time, at most answer_timeout.
void SlcanBus::wait_for_quiet() {
  const Nanoseconds deadline = MonotonicClock().now() + answer_timeout;
  std::string_view ignored;
  while (line_.port().wait_readable(quiet_time) && MonotonicClock().now() < deadline)
    while (line_.next(ignored)) continue;
  line_.discard_input();
}

/// Returns the time to wait for an answer: short for an adapter that acknowledges no commands.
Nanoseconds SlcanBus::patience() const noexcept { return version_.empty() ? answer_timeout : quiet_time; }

/// Sends a command and returns the answer. Other lines, mostly frames, are dropped because the bus is not
/// open yet.
SlcanBus::Answer SlcanBus::ask(std::string_view command, Nanoseconds patience) {
  const Nanoseconds deadline = MonotonicClock().now() + patience;
  if (!line_.put(command)) return Answer::none;
  while (line_.port().wait_readable(deadline - MonotonicClock().now())) {
    std::string_view line;
    while (line_.next(line)) {
      slcan::Reply reply;
      if (slcan::parse_reply(line, reply) != ParseResult::ok) continue;
      if (reply.kind == slcan::ReplyKind::ok) return Answer::ok;
      if (reply.kind == slcan::ReplyKind::refused) return Answer::refused;
      if (reply.kind == slcan::ReplyKind::flags) return Answer::flags;
    }
    if (line_.port().state() != SerialState::open || MonotonicClock().now() >= deadline) break;
  }
  return Answer::none;
}

/// Returns the first text received after V, or its beginning if it is longer than a line; empty if none came.
/// Ignores an echo. Waits for the given text, or for any if that is empty.
std::string SlcanBus::ask_version(const std::string& wanted) {
  const Nanoseconds deadline = MonotonicClock().now() + answer_timeout;
  const std::uint64_t num_overlong = line_.reader().num_overlong();
  const auto fits = [&](std::string_view text) {
    return wanted.empty() ? text != slcan::version_command.substr(0, 1) : text == wanted;
  };
  if (!line_.put(slcan::version_command)) return {};
  while (line_.port().wait_readable(deadline - MonotonicClock().now())) {
    std::string_view line;
    while (line_.next(line)) {
      slcan::Reply reply;
      const ParseResult result = slcan::parse_reply(line, reply);
      const bool is_text = result != ParseResult::ok || reply.kind == slcan::ReplyKind::identity;
      if (is_text && fits(line)) return std::string(line);
      if (result == ParseResult::ok && reply.kind == slcan::ReplyKind::refused) return {};
    }
    if (line_.reader().num_overlong() > num_overlong && fits(line_.reader().overlong_begin()))
      return std::string(line_.reader().overlong_begin());
    if (line_.port().state() != SerialState::open || MonotonicClock().now() >= deadline) break;
  }
  return {};
}

/// True if V is answered twice with the same text: the adapter is present and acknowledges no commands.
bool SlcanBus::answers_version() {
  const std::string first = ask_version(version_);
  if (first.empty() || (version_.empty() && ask_version(first) != first)) return false;
  version_ = first;
  return true;
}

bool SlcanBus::command(std::string_view command, const std::string& what) {
  switch (ask(command, patience())) {
    case Answer::ok: return true;
    case Answer::refused: return fail("the adapter refuses " + what);
    case Answer::flags:
    case Answer::none: break;
  }
  if (line_.port().state() != SerialState::open) return fail(line_.port().trouble());
  if (answers_version()) return true;
  if (!version_.empty())
    return fail("the adapter acknowledges no commands and does not answer V after " + what);
  return fail("no adapter answers: check that it is an SLCAN adapter, and its rate of " +
              std::to_string(baud_) + " baud; give another rate as PATH,BAUD");
}

SendResult SlcanBus::try_send(const CanFrame& frame) noexcept {
  std::array<char, slcan::max_line> text{};
  const std::size_t size = slcan::format_frame(frame, text);
  const BusState now = state();
  SendResult result = SendResult::queued;
  if (size == 0) {
    result = SendResult::invalid;
  } else if (now == BusState::bus_off) {
    result = SendResult::off;
  } else if (is_cut_off(now)) {  // NOLINT(bugprone-branch-clone): checked again after the write
    result = SendResult::down;
  } else if (!line_.put({text.data(), size})) {
    result = SendResult::full;
  } else if (is_cut_off(state())) {  // the write found the line hung up
    result = SendResult::down;
  }
  if (result == SendResult::queued) {
    ++num_unanswered_;
  } else {
    ++counters_.send_refused;
  }
  return result;
}

bool SlcanBus::try_receive(ReceivedFrame& out) noexcept {
  if (state_ == BusState::closed) return false;
  line_.flush();
  std::string_view line;
  while (line_.next(line))
    if (handle(line, out)) return true;
  if (has_flags_ && MonotonicClock().now() >= flags_due_ && line_.put(slcan::flags_command))
    flags_due_ = MonotonicClock().now() + flags_period;
  return false;
}

/// Handles one line. Returns true if `out` is a frame for the receiver.
bool SlcanBus::handle(std::string_view line, ReceivedFrame& out) noexcept {
  slcan::Reply reply;
  if (slcan::parse_reply(line, reply) != ParseResult::ok) {
    ++num_garbled_;
    return false;
  }
  switch (reply.kind) {
    case slcan::ReplyKind::frame:
      if (!passes(filters_, reply.frame)) return false;
      out = {.frame = reply.frame, .t_ns = line_.read_at()};
      ++counters_.received;
      return true;
    case slcan::ReplyKind::ok:
    case slcan::ReplyKind::taken: acknowledge(true); return false;
    case slcan::ReplyKind::refused: acknowledge(false); return false;
    case slcan::ReplyKind::flags: handle_flags(reply.flags); return false;
    case slcan::ReplyKind::error_report:
      reports_state_ = reports_state_ || reply.report.state.has_value();
      apply(reply.report, state_, counters_);
      return false;
    case slcan::ReplyKind::fd_frame: ++num_fd_; return false;
    case slcan::ReplyKind::identity: return false;
  }
  return false;
}

void SlcanBus::acknowledge(bool taken) noexcept {
  if (num_unanswered_ == 0) return;
  --num_unanswered_;
  ++(taken ? counters_.sent : counters_.send_dropped);
}

std::uint64_t SlcanBus::num_garbled() const noexcept {
  const std::uint64_t dropped = line_.reader().num_overlong() + line_.reader().num_cut();
  return num_garbled_ + dropped - std::min(dropped, dropped_at_open_);
}

BusCounters SlcanBus::counters() const noexcept {
  BusCounters counters = counters_;
  counters.error_frames += earlier_garbled_ + num_garbled();
  if (num_garbled() > 0) counters.last_error = BusError::form;
  return counters;
}

void SlcanBus::handle_flags(std::uint8_t flags) noexcept {
  const auto has = [flags](std::uint8_t mask) { return (flags & mask) != 0; };
  if (has(slcan::status::bus_error)) {
    ++counters_.error_frames;
    counters_.last_error = BusError::other;
  }
  if (has(slcan::status::transmit_queue_full)) counters_.last_error = BusError::transmit_overflow;
  if (has(slcan::status::receive_queue_full | slcan::status::data_overrun)) {
    ++counters_.receive_overflow;  // at least one: the flag does not count
    counters_.last_error = BusError::receive_overflow;
  }
  if (reports_state_) return;
  state_ = BusState::error_active;
  if (has(slcan::status::error_warning)) state_ = BusState::error_warning;
  if (has(slcan::status::error_passive)) state_ = BusState::error_passive;
}

BusState SlcanBus::state() const noexcept {
  if (state_ == BusState::closed) return state_;
  switch (line_.port().state()) {
    case SerialState::open: return state_;
    case SerialState::hung_up: return BusState::gone;
    case SerialState::closed:
    case SerialState::failed: break;
  }
  return BusState::down;
}

std::string SlcanBus::as_written(const CanFrame& frame) const { return SlcanLine::text_of(frame); }

std::string SlcanBus::trouble() const {
  if (!why_.empty()) return path_ + ": " + why_;
  if (line_.port().state() != SerialState::open) return line_.port().trouble();
  if (state_ == BusState::bus_off)
    return path_ +
           ": bus-off: check wiring, termination and bit rate, then reopen it; SLCAN has no automatic "
           "restart";
  if (state_ != BusState::error_active)
    return path_ + ": " + std::string(name_of(state_)) + ": check wiring, termination and bit rate";
  if (num_garbled() > 0)
    return path_ + ": " + std::to_string(num_garbled()) +
           " lines were garbled: check the serial cable and its baud rate";
  if (const std::uint64_t num_fd = num_fd_ + line_.reader().num_fd(); num_fd > 0)
    return path_ + ": " + std::to_string(num_fd) +
           " CAN FD frames arrived, which SLCAN cannot carry: use SocketCAN, or a bus without CAN FD nodes";
  if (counters_.send_dropped > 0)
    return path_ + ": the adapter refused " + std::to_string(counters_.send_dropped) +
           " frames: send fewer, or check that another node acknowledges them";
  return "";
}

}  // namespace godobject
