// Lines of SLCAN, and the adapter's end of the protocol on a pseudo-terminal.
#include "platform/linux/bus/slcan.h"

#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "platform/linux/serial_port.h"
#include "platform/rt/cyclic.h"

namespace godobject {

bool SlcanLine::put(std::string_view text) noexcept {
  flush();
  if (out_.size() - out_size_ < text.size()) return false;
  std::ranges::copy(text, out_.begin() + static_cast<std::ptrdiff_t>(out_size_));
  out_size_ += text.size();
  flush();
  return true;
}

void SlcanLine::flush() noexcept {
  std::size_t written = 0;
  while (written < out_size_) {
    const auto queued = std::span(out_).first(out_size_).subspan(written);
    const auto end = std::ranges::find(queued, static_cast<std::uint8_t>('\r'));
    const auto line = queued.first(
        std::min<std::size_t>(static_cast<std::size_t>(end - queued.begin()) + 1, queued.size()));
    const BusWrite one_piece;  // with rest_: the last frames come after both
    const std::size_t size = port_.write(line);
    if (size == 0) break;
    rest_.store({reinterpret_cast<const char*>(line.data()) + size, line.size() - size});
    written += size;
    if (size < line.size()) break;
  }
  if (written == 0) return;
  std::copy(out_.begin() + static_cast<std::ptrdiff_t>(written),
            out_.begin() + static_cast<std::ptrdiff_t>(out_size_), out_.begin());
  out_size_ -= written;
}

std::string SlcanLine::text_of(const CanFrame& frame) {
  std::array<char, slcan::max_line> text{};
  const std::size_t size = slcan::format_frame(frame, text);
  return {text.data(), size};
}

bool SlcanLine::next(std::string_view& line) noexcept {
  constexpr int max_reads = 8;  // reads of in_.size() bytes: bounds the time of one call
  for (int reads = 0; reads <= max_reads; ++reads) {
    while (in_begin_ < in_end_) {
      if (!reader_.put(in_[in_begin_++])) continue;
      line = reader_.line();
      return true;
    }
    if (reads == max_reads) break;
    in_begin_ = 0;
    in_end_ = port_.read(in_);
    if (in_end_ == 0) break;
    read_at_ = MonotonicClock().now();
  }
  return false;
}

void SlcanLine::discard_input() noexcept {
  in_begin_ = in_end_ = 0;
  reader_ = {};
}

void SlcanLine::clear() noexcept {
  out_size_ = 0;
  rest_.store({});
  discard_input();
}

PtyBus::PtyBus(const BusSettings& settings)
    : bit_rate_(settings.bit_rate), filters_(settings.filters.begin(), settings.filters.end()) {}

bool PtyBus::open() noexcept {
  close();
  const Pty pty = make_pty();
  why_ = pty.why;
  if (!why_.empty()) return false;
  slave_fd_ = pty.slave;
  line_.port().adopt(pty.master, pty.name);
  line_.clear();
  return true;
}

void PtyBus::close() noexcept {
  line_.port().close();
  if (slave_fd_ >= 0) ::close(slave_fd_);
  slave_fd_ = -1;
  channel_ = Channel::closed;
  requested_bit_rate_ = 0;
  why_.clear();
}

SendResult PtyBus::try_send(const CanFrame& frame) noexcept {
  std::array<char, slcan::max_line> text{};
  const std::size_t size = slcan::format_frame(frame, text);
  SendResult result = SendResult::queued;
  if (size == 0) {
    result = SendResult::invalid;
  } else if (is_cut_off(state())) {
    result = SendResult::down;
  } else if (!line_.put({text.data(), size})) {
    result = SendResult::full;
  }
  ++(result == SendResult::queued ? counters_.sent : counters_.send_refused);
  return result;
}

bool PtyBus::try_receive(ReceivedFrame& out) noexcept {
  line_.flush();
  std::string_view line;
  while (line_.next(line))
    if (handle(line, out)) return true;
  return false;
}

/// Answers one line. Returns true if `out` is a frame for the receiver.
bool PtyBus::handle(std::string_view line, ReceivedFrame& out) noexcept {
  if (line.empty()) return false;  // hosts send empty lines to end an incomplete one
  slcan::Request request;
  if (slcan::parse_request(line, request) != ParseResult::ok) {
    answer(slcan::refused_reply);
    return false;
  }
  const bool is_open = channel_ != Channel::closed;
  switch (request.kind) {
    case slcan::RequestKind::send: return receive(request.frame, out);
    case slcan::RequestKind::set_bit_rate:
      if (!is_open) requested_bit_rate_ = slcan::bit_rates[request.value];
      answer(is_open ? slcan::refused_reply : slcan::ok_reply);
      break;
    case slcan::RequestKind::open: open_channel(Channel::open); break;
    case slcan::RequestKind::listen: open_channel(Channel::listening); break;
    case slcan::RequestKind::close: close_channel(); break;
    case slcan::RequestKind::flags: answer(is_open ? "F00\r" : slcan::refused_reply); break;
    case slcan::RequestKind::version: answer("V1013\r"); break;
    case slcan::RequestKind::serial_number: answer("NGODO\r"); break;
    case slcan::RequestKind::timestamps:
      answer(request.value == 0 ? slcan::ok_reply : slcan::refused_reply);
      break;
  }
  return false;
}

bool PtyBus::receive(const CanFrame& frame, ReceivedFrame& out) noexcept {
  if (channel_ != Channel::open) {
    answer(slcan::refused_reply);
    return false;
  }
  answer(frame.extended ? slcan::taken_extended_reply : slcan::taken_reply);
  if (!passes(filters_, frame)) return false;
  out = {.frame = frame, .t_ns = line_.read_at()};
  ++counters_.received;
  return true;
}

void PtyBus::answer(std::string_view text) noexcept {
  if (!line_.put(text)) ++counters_.send_dropped;
}

/// Refuses O while the channel is open, as an adapter does. Hosts send O twice and ignore the refusal.
void PtyBus::open_channel(Channel channel) noexcept {
  const bool was_closed = channel_ == Channel::closed;
  if (was_closed) channel_ = channel;
  answer(was_closed ? slcan::ok_reply : slcan::refused_reply);
}

/// Discards output that a dead host did not read, so that the next host does not receive it.
void PtyBus::close_channel() noexcept {
  channel_ = Channel::closed;
  line_.discard_output();
  loop::discard_input(slave_fd_);
  answer(slcan::ok_reply);
}

BusState PtyBus::state() const noexcept {
  switch (line_.port().state()) {
    case SerialState::closed: return BusState::closed;
    case SerialState::open: break;
    case SerialState::hung_up: return BusState::gone;
    case SerialState::failed: return BusState::down;
  }
  return channel_ == Channel::closed ? BusState::down : BusState::error_active;
}

std::string PtyBus::as_written(const CanFrame& frame) const {
  const std::string line = SlcanLine::text_of(frame);
  return line.empty()
             ? line
             : "\r" + line;  // ends an incomplete line before it; a host takes it for an acknowledgement
}

std::string PtyBus::trouble() const {
  if (!why_.empty()) return why_;
  if (line_.port().state() != SerialState::open) return line_.port().trouble();
  if (channel_ == Channel::closed)
    return name() + ": waits for the other end to open it, e.g. godobject monitor --bus slcan:" + name();
  if (requested_bit_rate_ > 0 && std::abs(requested_bit_rate_ - bit_rate_) > 0.5)
    return name() + ": the other end expects " + std::to_string(std::lround(requested_bit_rate_)) +
           " bit/s, this bus has " + std::to_string(std::lround(bit_rate_)) +
           ": a real bus would fail; set one bit rate at both ends";
  return "";
}

std::string PtyBus::name() const {
  return line_.port().state() == SerialState::closed ? std::string() : line_.port().path();
}

}  // namespace godobject
