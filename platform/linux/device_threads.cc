#include "platform/linux/device_threads.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "hal/tracker/address.h"
#include "platform/rt/signals.h"

namespace godobject {
namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr Nanoseconds wake_period = 1 * ms;
constexpr Nanoseconds open_period = 1000 * ms;
constexpr Nanoseconds expiry_period = 10 * ms;
constexpr Nanoseconds write_patience = 200 * ms;
constexpr int connect_patience_ms = 500;

constexpr const char* default_socket = "/run/spnav.sock";
constexpr Nanoseconds retry_period = 1'000'000'000;

std::string text_of(int error) { return std::generic_category().message(error); }

/// Returns the connection, or -1 with errno.
int connect_to(const std::string& path) noexcept {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) {
    errno = ENAMETOOLONG;
    return -1;
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return -1;
  if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0)
    return descriptor;
  const int error = errno;
  close(descriptor);
  errno = error;
  return -1;
}

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
      if (port_.state() == SerialState::closed) next_open = clock_.now() + open_period;
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
  std::string why_not;
  if (is_on_network(tracker_->params())) why_not = connect();
  else if (!port_.open(tracker_->params().port, settings)) why_not = port_.trouble();
  const Nanoseconds now = clock_.now();
  if (why_not.empty()) {
    tracker_->opened(now);
    return true;
  }
  const bool too_long = now - opening_since_ > to_ns(tracker_->params().boot_timeout_s);
  tracker_->line_lost(why_not, too_long, now);
  return false;
}

std::string TrackerThread::connect() {
  const std::string& port = tracker_->params().port;
  const std::optional<TcpAddress> address =
      parse_tcp_address(port, default_tcp_port(tracker_->params().protocol));
  if (!address) return port + ": is no address; give tcp:HOST:PORT";
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(address->host.c_str(), address->port.c_str(), &wanted, &found);
      error != 0)
    return port + ": " + gai_strerror(error) + "; check the name of the host";
  int error = 0;
  for (const addrinfo* to = found; to != nullptr && port_.state() != SerialState::open; to = to->ai_next) {
    const int descriptor = socket(to->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, to->ai_protocol);
    pollfd waiting{.fd = descriptor, .events = POLLOUT, .revents = 0};
    socklen_t size = sizeof error;
    const int one = 1, idle_s = 2, probes = 3;  // a dead host is noticed after 5 s
    error = ::connect(descriptor, to->ai_addr, to->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS && poll(&waiting, 1, connect_patience_ms) == 0) error = ETIMEDOUT;
    if (error == EINPROGRESS) getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
    setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    setsockopt(descriptor, SOL_SOCKET, SO_KEEPALIVE, &one, sizeof one);
    setsockopt(descriptor, IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof idle_s);
    setsockopt(descriptor, IPPROTO_TCP, TCP_KEEPINTVL, &one, sizeof one);
    setsockopt(descriptor, IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
    if (error == 0) port_.adopt(descriptor, port);
    else if (descriptor >= 0) close(descriptor);
  }
  freeaddrinfo(found);
  if (error == 0) return "";
  return port + ": cannot be connected: " + text_of(error) + "; check that the server runs there";
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
  if (port_.state() == SerialState::open || port_.state() == SerialState::closed) return;
  changed_ = true;
  opening_since_ = clock_.now();
  tracker_->line_lost(port_.trouble(), false, opening_since_);
}

void TrackerThread::carry_out(const LineRequest& request) {
  switch (request.kind) {
    case LineRequest::Kind::none: return;
    case LineRequest::Kind::serial_break: return port_.send_break();
    case LineRequest::Kind::reopen: changed_ = true; return port_.close();
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

std::string spacenav_socket() {
  const char* const given = std::getenv("SPNAV_SOCKET");
  return given != nullptr && *given != '\0' ? given : default_socket;
}

std::unique_ptr<SpaceMouseThread> SpaceMouseThread::start(const std::string& socket, SpaceMouse& device,
                                                          Log log, std::string& why_not) {
  const int descriptor = connect_to(socket);
  if (descriptor < 0) {
    why_not = "--spacemouse: no daemon answers on '" + socket + "': " + text_of(errno) +
              ". Install and start it: apt-get install spacenavd; systemctl start spacenavd. Another socket: "
              "--spacemouse SOCKET, or SPNAV_SOCKET";
    return nullptr;
  }
  return std::unique_ptr<SpaceMouseThread>(new SpaceMouseThread(socket, descriptor, device, std::move(log)));
}

SpaceMouseThread::SpaceMouseThread(std::string socket, int descriptor, SpaceMouse& device, Log log)
    : socket_(std::move(socket)),
      device_(device),
      log_(std::move(log)),
      descriptor_(descriptor),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

SpaceMouseThread::~SpaceMouseThread() {
  thread_.request_stop();
  thread_.join();
  if (descriptor_ >= 0) close(descriptor_);
}

SpaceMouseCounters SpaceMouseThread::counters() const noexcept {
  return {.events = events_, .malformed = malformed_, .connections = connections_, .connected = connected_};
}

void SpaceMouseThread::run(const std::stop_token& stop) {
  const ThreadSetup setup("spacemouse");
  Nanoseconds due = clock_.now();
  while (!stop.stop_requested()) {
    wait(due);
    if (descriptor_ >= 0) read();
    else if (clock_.now() >= next_try_) reconnect();
    const Nanoseconds now = clock_.now();
    if (now < due) continue;
    due = std::max(due + spacemouse_tick_ns, now);
    device_.tick(descriptor_ >= 0);
  }
}

/// Waits for bytes, or until the time `until`.
void SpaceMouseThread::wait(Nanoseconds until) noexcept {
  pollfd waited{.fd = descriptor_, .events = POLLIN, .revents = 0};  // poll ignores -1
  const Nanoseconds left = std::max(until - clock_.now(), Nanoseconds{0});
  const timespec patience{.tv_sec = 0, .tv_nsec = std::min(left, spacemouse_tick_ns)};
  static_cast<void>(ppoll(&waited, 1, &patience, nullptr));
}

void SpaceMouseThread::read() {
  const ssize_t size = recv(descriptor_, bytes_.data() + begun_, bytes_.size() - begun_, 0);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size < 0) return lose(text_of(errno));
  if (size == 0) return lose("the daemon has closed the connection");
  if (!take(begun_ + static_cast<std::size_t>(size))) lose("the received bytes are no event of spacenavd");
}

bool SpaceMouseThread::take(std::size_t size) noexcept {
  std::size_t at = 0;
  for (; size - at >= spacenav_event_bytes; at += spacenav_event_bytes) {
    SpacenavEvent event;
    const ParseResult result = decode(std::span(bytes_).subspan(at, spacenav_event_bytes), event);
    if (result == ParseResult::other_message) continue;
    if (result != ParseResult::ok) {
      ++malformed_;
      return false;
    }
    ++events_;
    device_.take(event);
  }
  begun_ = size - at;
  std::memmove(bytes_.data(), bytes_.data() + at, begun_);
  return true;
}

void SpaceMouseThread::lose(const std::string& why) {
  close(descriptor_);
  descriptor_ = -1;
  begun_ = 0;
  connected_ = false;
  next_try_ = clock_.now() + retry_period;
  if (log_) log_("spacemouse: " + why + ": the target rests; retrying every second");
}

void SpaceMouseThread::reconnect() {
  next_try_ = clock_.now() + retry_period;
  descriptor_ = connect_to(socket_);
  if (descriptor_ < 0) return;
  connected_ = true;
  ++connections_;
  if (log_) log_("spacemouse: the daemon is back");
}

}  // namespace godobject
