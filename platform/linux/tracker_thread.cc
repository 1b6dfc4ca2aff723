#include "platform/linux/tracker_thread.h"

#include <array>
#include <cmath>
#include <string_view>

#include "platform/rt/stop_signals.h"

namespace godobject {
namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr Nanoseconds wake_period = 1 * ms;
constexpr Nanoseconds open_period = 1000 * ms;
constexpr Nanoseconds expiry_period = 10 * ms;
constexpr Nanoseconds write_patience = 200 * ms;

}  // namespace

TrackerThread::TrackerThread(std::unique_ptr<Tracker> tracker)
    : tracker_(std::move(tracker)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

bool TrackerThread::try_read(TrackerReport& out, Nanoseconds) noexcept {
  bool any = false;
  while (reports_.try_pop(out)) any = true;
  return any;
}

void TrackerThread::run(const std::stop_token& stop) {
  const ThreadSetup setup("tracker");
  opening_since_ = clock_.now();
  Nanoseconds next_open = opening_since_;
  while (!stop.stop_requested()) {
    if (port_.state() == SerialState::open) {
      serve();
    } else if (clock_.now() >= next_open) {
      if (!open()) next_open = clock_.now() + open_period;
    } else {
      clock_.sleep_until(clock_.now() + expiry_period);
    }
    hand_over();
  }
  port_.close();
}

bool TrackerThread::open() {
  changed_ = true;
  port_.close();
  const SerialSettings settings{.baud = tracker_->first_baud()};
  if (port_.open(tracker_->params().port, settings)) {
    tracker_->opened(clock_.now());
    return true;
  }
  const Nanoseconds now = clock_.now();
  const bool too_long = now - opening_since_ > to_ns(tracker_->params().boot_timeout_s);
  tracker_->line_lost(port_.trouble(), too_long, now);
  return false;
}

/// Receives bytes, sends requests, and waits for at most a millisecond.
void TrackerThread::serve() {
  std::array<std::uint8_t, 512> bytes{};
  if (port_.wait_readable(wake_period)) {
    const std::size_t size = port_.read(bytes);
    if (size > 0) {
      tracker_->receive({bytes.data(), size}, clock_.now());
      changed_ = true;
    }
  }
  for (LineRequest request = tracker_->next(clock_.now()); request.kind != LineRequest::Kind::none;
       request = tracker_->next(clock_.now()))
    carry_out(request);
  if (port_.state() == SerialState::open) return;
  changed_ = true;
  opening_since_ = clock_.now();
  tracker_->line_lost(port_.trouble(), false, opening_since_);
}

void TrackerThread::carry_out(const LineRequest& request) {
  switch (request.kind) {
    case LineRequest::Kind::none: return;
    case LineRequest::Kind::serial_break: return port_.send_break();
    case LineRequest::Kind::set_baud: static_cast<void>(port_.set_baud(request.baud)); return;
    case LineRequest::Kind::send: break;
  }
  std::span<const std::uint8_t> rest = request.bytes;
  const Nanoseconds until = clock_.now() + write_patience;
  while (!rest.empty() && port_.state() == SerialState::open && clock_.now() < until) {
    const std::size_t taken = port_.write(rest);
    rest = rest.subspan(taken);
    if (taken == 0) clock_.sleep_until(clock_.now() + wake_period);
  }
}

/// Passes the report to the loop. If the ring is full, the loop does not read yet and the report waits.
void TrackerThread::hand_over() {
  const Nanoseconds now = clock_.now();
  if (now - last_expiry_ >= expiry_period) {
    last_expiry_ = now;
    tracker_->expire(now);
    changed_ = true;
  }
  if (changed_ && reports_.try_push(tracker_->report())) changed_ = false;
}

}  // namespace godobject
