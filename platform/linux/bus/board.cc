#include "platform/linux/bus/slcan.h"

#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "platform/rt/cyclic.h"

namespace godobject {

BoardBus::BoardBus(const std::string& where, const BusSettings& settings)
    : address_(parse_serial_address(where, default_baud)),
      bit_rate_(settings.bit_rate),
      filters_(settings.filters.begin(), settings.filters.end()),
      nodes_(settings.bit_rate) {}

bool BoardBus::fail(const char* what) {
  const std::string why = address_.path + ": " + what + ": " + std::generic_category().message(errno);
  close();
  why_ = why;
  return false;
}

bool BoardBus::open() noexcept {
  close();
  if (address_.baud == 0) {
    why_ = address_.path + ": the baud rate after the comma is not a number above 0";
    return false;
  }
  if (!port_.open(address_.path, {.baud = address_.baud})) return false;
  timer_fd_ = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  waiting_fd_ = epoll_create1(EPOLL_CLOEXEC);
  if (timer_fd_ < 0 || waiting_fd_ < 0) return fail("no timer can be created");
  for (const int fd : {port_.descriptor(), timer_fd_}) {
    epoll_event event{.events = EPOLLIN, .data = {.fd = fd}};
    if (epoll_ctl(waiting_fd_, EPOLL_CTL_ADD, fd, &event) != 0) return fail("epoll cannot wait for it");
  }
  return true;
}

void BoardBus::close() noexcept {
  if (port_.state() != SerialState::closed) {
    const BoardCounters& board = nodes_.board().counters();
    earlier_.frames += board.frames;
    earlier_.lost += board.lost;
    earlier_.bad_crc += board.bad_crc;
    earlier_.malformed += board.malformed;
    nodes_ = BoardNodes(bit_rate_);
  }
  for (int* const fd : {&waiting_fd_, &timer_fd_}) {
    if (*fd >= 0) ::close(*fd);
    *fd = -1;
  }
  port_.close();
  why_.clear();
}

SendResult BoardBus::try_send(const CanFrame& frame) noexcept {
  SendResult result = SendResult::queued;
  if (!is_valid(frame)) result = SendResult::invalid;
  else if (is_cut_off(state())) result = SendResult::down;
  ++(result == SendResult::queued ? counters_.sent : counters_.send_refused);
  if (result != SendResult::queued) return result;
  read_port();  // to get the newest counts
  nodes_.send(frame, MonotonicClock{}.now());
  arm_timer();
  return result;
}

bool BoardBus::try_receive(ReceivedFrame& out) noexcept {
  if (port_.state() == SerialState::closed) return false;
  read_port();
  while (nodes_.try_receive(out, MonotonicClock{}.now())) {
    if (!passes(filters_, out.frame)) continue;
    ++counters_.received;
    return true;
  }
  arm_timer();
  return false;
}

void BoardBus::read_port() noexcept {
  constexpr int max_reads = 8;  // bounds the time of one call
  std::array<std::uint8_t, 512> bytes{};
  for (int reads = 0; reads < max_reads; ++reads) {
    const std::size_t size = port_.read(bytes);
    if (size == 0) break;
    nodes_.receive({bytes.data(), size}, MonotonicClock{}.now());
  }
  // A missing port is always readable and would keep the loop awake.
  if (port_.state() != SerialState::open) loop::stop_waiting(waiting_fd_, port_.descriptor());
}

/// Sets the timer to the next answer of the nodes, or switches it off. Setting it makes it unreadable until
/// then.
void BoardBus::arm_timer() noexcept {
  itimerspec when{};
  if (const auto due = nodes_.next_due())
    when.it_value = {.tv_sec = *due / 1'000'000'000, .tv_nsec = *due % 1'000'000'000};
  loop::set_timer(timer_fd_, TFD_TIMER_ABSTIME, when);
}

BusState BoardBus::state() const noexcept {
  switch (port_.state()) {
    case SerialState::closed: return BusState::closed;
    case SerialState::open: return BusState::error_active;
    case SerialState::hung_up: return BusState::gone;
    case SerialState::failed: break;
  }
  return BusState::down;
}

BusCounters BoardBus::counters() const noexcept {
  const BoardCounters& board = nodes_.board().counters();
  BusCounters counters = counters_;
  const std::uint64_t bad_crc = earlier_.bad_crc + board.bad_crc;
  counters.error_frames = bad_crc + earlier_.malformed + board.malformed;
  counters.receive_overflow = earlier_.lost + board.lost + nodes_.num_lost();
  if (counters.error_frames > 0) counters.last_error = bad_crc > 0 ? BusError::crc : BusError::form;
  return counters;
}

std::string BoardBus::trouble() const {
  if (!why_.empty()) return why_;
  if (port_.state() != SerialState::open) return port_.trouble();
  const BoardCounters& board = nodes_.board().counters();
  const BusCounters counters = this->counters();
  if (board.frames == 0)
    return address_.path + ": no frame of an encoder board yet" +
           (board.malformed > 0 ? ", but other bytes: check that it is one, and its rate of "
                                : ": check that it is one, and its rate of ") +
           std::to_string(address_.baud) + " baud; give another rate as PATH,BAUD";
  std::string text;
  const auto add = [&text](const std::string& trouble) { text += (text.empty() ? "" : "; ") + trouble; };
  if (nodes_.silent(MonotonicClock{}.now()))
    add("the board sends nothing, or fewer than 500 frames a second: check its supply");
  if ((nodes_.board().frame().status & board_status::overrun) != 0)
    add("the board missed edges: its counts are wrong until it is referenced again");
  if (counters.error_frames + counters.receive_overflow > 0)
    add(std::to_string(counters.error_frames) + " frames were broken and " +
        std::to_string(counters.receive_overflow) +
        " lost: check the serial cable, its earth and its baud rate");
  return text.empty() ? "" : address_.path + ": " + text;
}

}  // namespace godobject
