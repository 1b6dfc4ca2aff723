#include "platform/linux/bus/socket_can.h"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "platform/rt/cyclic.h"
#include "platform/rt/signals.h"

namespace godobject {

static_assert(can_error::transmit_timeout == CAN_ERR_TX_TIMEOUT &&
              can_error::lost_arbitration == CAN_ERR_LOSTARB && can_error::controller == CAN_ERR_CRTL &&
              can_error::protocol == CAN_ERR_PROT && can_error::transceiver == CAN_ERR_TRX &&
              can_error::no_acknowledge == CAN_ERR_ACK && can_error::bus_off == CAN_ERR_BUSOFF &&
              can_error::bus_error == CAN_ERR_BUSERROR && can_error::restarted == CAN_ERR_RESTARTED &&
              can_error::error_counters == CAN_ERR_CNT);
static_assert(can_error::receive_overflow == CAN_ERR_CRTL_RX_OVERFLOW &&
              can_error::transmit_overflow == CAN_ERR_CRTL_TX_OVERFLOW &&
              can_error::warning == (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING) &&
              can_error::passive == (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE) &&
              can_error::active == CAN_ERR_CRTL_ACTIVE);
static_assert(can_error::bit == CAN_ERR_PROT_BIT && can_error::form == CAN_ERR_PROT_FORM &&
              can_error::stuff == CAN_ERR_PROT_STUFF && can_error::bit_dominant == CAN_ERR_PROT_BIT0 &&
              can_error::bit_recessive == CAN_ERR_PROT_BIT1 &&
              can_error::location_crc_sequence == CAN_ERR_PROT_LOC_CRC_SEQ &&
              can_error::location_crc_delimiter == CAN_ERR_PROT_LOC_CRC_DEL &&
              can_error::location_acknowledge == CAN_ERR_PROT_LOC_ACK);

namespace {

constexpr Nanoseconds oldest = 1'000'000'000;  // largest plausible age of a frame; above it the wall clock
                                               // was set
constexpr Nanoseconds close_enough = 50'000;   // between two readings of the clock: the error is half as much

Nanoseconds nanoseconds(const timespec& t) noexcept {
  return Nanoseconds{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

struct TwoClocks {
  Nanoseconds monotonic = 0;
  Nanoseconds wall = 0;
};

/// Reads both clocks at the same instant. Repeats interrupted readings, because an interruption appears as
/// age.
TwoClocks read_clocks() noexcept {
  TwoClocks best;
  Nanoseconds shortest = oldest;
  for (int i = 0; i < 3 && shortest > close_enough; ++i) {
    const Nanoseconds before = MonotonicClock{}.now();
    const timespec wall = loop::now(CLOCK_REALTIME);
    const Nanoseconds after = MonotonicClock{}.now();
    if (i != 0 && after - before >= shortest) continue;
    shortest = after - before;
    best = {.monotonic = before + shortest / 2, .wall = nanoseconds(wall)};
  }
  return best;
}

// Maximum of error frames and own frames that one call skips on the way to the next frame.
constexpr int max_messages_per_call = 64;
// Reduced by the kernel to its own limit (net.core.rmem_max).
constexpr int receive_buffer_bytes = 4 << 20;

template <class T>
bool set_option(int fd, int level, int name, const T& value) noexcept {
  return setsockopt(fd, level, name, &value, sizeof value) == 0;
}

can_filter kernel_filter(const CanFilter& filter) noexcept {
  return {.can_id = filter.id | (filter.extended ? CAN_EFF_FLAG : 0u),
          .can_mask = filter.mask | CAN_EFF_FLAG | CAN_RTR_FLAG};
}

}  // namespace

bool enable_receive_stamps(int socket) noexcept {
  const int wanted = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_HARDWARE |
                     SOF_TIMESTAMPING_RAW_HARDWARE;
  return setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPING, &wanted, sizeof wanted) == 0;
}

Nanoseconds ReceiveStamp::of(const msghdr& message) noexcept {
  scm_timestamping stamps{};  // [0] software, [2] raw hardware, 0: none
  for (const cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = loop::next(message, part)) {
    if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SCM_TIMESTAMPING)
      std::memcpy(&stamps, CMSG_DATA(part), sizeof stamps);
  }
  const TwoClocks now = read_clocks();
  const Nanoseconds software = nanoseconds(stamps.ts[0]);
  const Nanoseconds age = now.wall - software;
  const bool plausible = software != 0 && age >= 0 && age < oldest;
  Nanoseconds t = plausible ? now.monotonic - age : now.monotonic;
  if (const Nanoseconds hardware = nanoseconds(stamps.ts[2]); hardware != 0)
    t = controller_.to_local(hardware, t);
  last_ = std::max(last_, t);
  return last_;
}

/// One message of recvmsg.
struct SocketCanBus::Message {
  KernelFrame frame{};
  std::size_t size = 0;
  bool own = false;
  std::optional<std::uint32_t> dropped_in_all;
  Nanoseconds t_ns = 0;
};

SocketCanBus::SocketCanBus(const std::string& interface, const BusSettings& settings)
    : interface_(interface), bit_rate_(settings.bit_rate), data_bit_rate_(settings.data_bit_rate) {
  for (const CanFilter& filter : settings.filters) filters_.push_back(kernel_filter(filter));
}

SocketCanBus::~SocketCanBus() { close(); }

bool SocketCanBus::open() noexcept {
  close();
  failed_call_ = nullptr;
  fit_ = LinkFit::fits;
  fd_ = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (fd_ < 0) return fail("socket");
  // Options are set before bind, so that no frame passes unfiltered.
  return check_link() && set_options() && bind_to_interface();
}

void SocketCanBus::close() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  state_ = BusState::closed;
  dropped_in_all_ = 0;
}

bool SocketCanBus::fail(const char* what) noexcept {
  failed_errno_ = errno;
  failed_call_ = what;
  close();
  return false;
}

bool SocketCanBus::check_link() noexcept {
  CanLink link;
  errno = read_can_link(interface_.c_str(), link);
  if (errno != 0) return fail("rtnetlink");
  fit_ = fit(link, settings());
  if (fit_ != LinkFit::fits) {
    close();
    return false;
  }
  carries_fd_ = link.carries_fd();
  // Some drivers never report that their controller has started.
  const bool reported = link.controller && link.controller->state != BusState::down;
  state_ = reported ? link.controller->state : BusState::error_active;
  return true;
}

bool SocketCanBus::set_options() noexcept {
  const int on = 1;
  const can_err_mask_t all_errors = CAN_ERR_MASK;
  if (!filters_.empty() && setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FILTER, filters_.data(),
                                      static_cast<socklen_t>(filters_.size() * sizeof(can_filter))) != 0)
    return fail("CAN_RAW_FILTER");
  if (!set_option(fd_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, all_errors)) return fail("CAN_RAW_ERR_FILTER");
  if (!set_option(fd_, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, on)) return fail("CAN_RAW_RECV_OWN_MSGS");
  if (!set_option(fd_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, on)) return fail("CAN_RAW_FD_FRAMES");
  if (!set_option(fd_, SOL_SOCKET, SO_RXQ_OVFL, on)) return fail("SO_RXQ_OVFL");
  if (!set_option(fd_, SOL_SOCKET, SO_RCVBUF, receive_buffer_bytes)) return fail("SO_RCVBUF");
  if (!enable_receive_stamps(fd_)) return fail("SO_TIMESTAMPING");
  return true;
}

bool SocketCanBus::bind_to_interface() noexcept {
  sockaddr_can address{};
  address.can_family = AF_CAN;
  index_ = if_nametoindex(interface_.c_str());
  // Index 0 would mean all interfaces.
  if (index_ == 0) return fail("if_nametoindex");
  address.can_ifindex = static_cast<int>(index_);
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return fail("bind");
  return true;
}

SendResult SocketCanBus::try_send(const CanFrame& frame) noexcept {
  const SendResult result = send_now(frame);
  if (result != SendResult::queued) ++counters_.send_refused;
  return result;
}

SendResult SocketCanBus::send_now(const CanFrame& frame) noexcept {
  if (!is_valid(frame) || (frame.fd && !carries_fd_)) return SendResult::invalid;
  if (fd_ < 0 || state_ == BusState::gone) return SendResult::down;
  if (state_ == BusState::bus_off) return SendResult::off;
  KernelFrame out;
  const std::size_t size = to_kernel(frame, out);
  const BusWrite write;
  if (!write.allowed()) return SendResult::down;
  if (loop::send(fd_, &out, size) < 0) return refused(loop::error());
  if (state_ == BusState::down) state_ = BusState::error_active;  // the interface is up again
  return SendResult::queued;
}

SendResult SocketCanBus::refused(int error) noexcept {
  switch (error) {
    case ENOBUFS:  // txqueuelen frames are waiting
    case EAGAIN:   // the socket's own send buffer is full
      ++queue_full_;
      return SendResult::full;
    case EINVAL:
    case EMSGSIZE: return SendResult::invalid;
    default: lose_interface(error); return SendResult::down;
  }
}

void SocketCanBus::lose_interface(int error) noexcept {
  state_ = error == ENODEV || error == ENXIO ? BusState::gone : BusState::down;
}

std::string SocketCanBus::as_written(const CanFrame& frame) const {
  if (!is_valid(frame) || (frame.fd && !carries_fd_)) return {};
  KernelFrame out;
  const std::size_t size = to_kernel(frame, out);
  return {reinterpret_cast<const char*>(&out), size};
}

bool SocketCanBus::is_up() const noexcept {
  ifreq request{};
  request.ifr_ifindex = static_cast<int>(index_);  // its name may have changed
  return loop::control(fd_, SIOCGIFNAME, request) == 0 && loop::control(fd_, SIOCGIFFLAGS, request) == 0 &&
         (request.ifr_flags & IFF_UP) != 0;
}

bool SocketCanBus::try_receive(ReceivedFrame& out) noexcept {
  for (int i = 0; i < max_messages_per_call; ++i) {
    Message message;
    if (!read_message(message)) return false;
    if (take(message, out)) return true;
  }
  return false;
}

bool SocketCanBus::read_message(Message& message) noexcept {
  if (fd_ < 0) return false;
  iovec data{.iov_base = &message.frame, .iov_len = sizeof message.frame};
  alignas(cmsghdr) std::array<char, 256> control;
  msghdr head{};
  head.msg_iov = &data;
  head.msg_iovlen = 1;
  head.msg_control = control.data();
  head.msg_controllen = control.size();
  const ssize_t size = loop::receive(fd_, head);
  if (size < 0) {
    if (loop::error() != EAGAIN && loop::error() != EINTR) lose_interface(loop::error());
    return false;
  }
  message.size = static_cast<std::size_t>(size);
  message.own = (head.msg_flags & MSG_CONFIRM) != 0;
  // Costs three readings of clocks, so unobserved own frames get no stamp.
  if (!message.own || observer_.on_frame) message.t_ns = stamp_.of(head);
  for (cmsghdr* part = CMSG_FIRSTHDR(&head); part != nullptr; part = loop::next(head, part)) {
    if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SO_RXQ_OVFL)
      std::memcpy(&message.dropped_in_all.emplace(), CMSG_DATA(part), sizeof(std::uint32_t));
  }
  return true;
}

/// Handles one message. Returns true if `out` is a frame for the caller.
bool SocketCanBus::take(const Message& message, ReceivedFrame& out) noexcept {
  if (message.dropped_in_all) count_overflow(*message.dropped_in_all);
  // The kernel reports the loss before it delivers earlier frames, so a message alone does not prove that the
  // interface is up.
  if (state_ == BusState::down && is_up()) state_ = BusState::error_active;
  if ((message.frame.can_id & CAN_ERR_FLAG) != 0) {
    const std::span<const std::uint8_t> data(message.frame.data, CAN_ERR_DLC);
    apply(decode_can_error(message.frame.can_id & CAN_ERR_MASK, data), state_, counters_);
    return false;
  }
  const std::optional<CanFrame> frame = from_kernel(message.frame, message.size);
  if (!frame) return false;
  seen_alive();
  if (observer_.on_frame) observer_.on_frame(observer_.context, {.frame = *frame, .t_ns = message.t_ns});
  if (message.own) {
    ++counters_.sent;
    return false;
  }
  ++counters_.received;
  out = {.frame = *frame, .t_ns = message.t_ns};
  return true;
}

void SocketCanBus::count_overflow(std::uint32_t dropped_in_all) noexcept {
  counters_.receive_overflow += dropped_in_all - dropped_in_all_;
  dropped_in_all_ = dropped_in_all;
}

/// Ends bus-off: a controller that is off neither sends nor receives, so the report of its restart was lost
/// to an overflow.
void SocketCanBus::seen_alive() noexcept {
  if (state_ != BusState::bus_off) return;
  state_ = BusState::error_active;
  ++counters_.restarts;
}

}  // namespace godobject
