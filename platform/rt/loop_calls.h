// System calls of the loop's thread, and other calls that the compiler cannot prove not to block. Each
// is declared here as an exception from the proof (core/nonblocking.h).
#pragma once

#include <poll.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <vector>

#include "core/nonblocking.h"

#if defined(__has_feature)
#if __has_feature(realtime_sanitizer)
#include <sanitizer/rtsan_interface.h>
#define GODOBJECT_REALTIME_SANITIZER
#endif
#endif
#if defined(__has_warning)
#if __has_warning("-Wfunction-effects")
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wfunction-effects"
#endif
#endif

namespace godobject {

/// Page faults of a thread.
struct PageFaults {
  long minor = 0, major = 0;  // without and with a wait for a disk

  PageFaults operator-(const PageFaults& before) const noexcept {
    return {.minor = minor - before.minor, .major = major - before.major};
  }
  void operator+=(const PageFaults& more) noexcept {
    minor += more.minor;
    major += more.major;
  }
};

}  // namespace godobject

namespace godobject::loop {

/// Returns errno of the last call of this thread.
inline int error() noexcept GODOBJECT_NONBLOCKING { return errno; }

// The time: no system call where the kernel offers a vDSO.
inline timespec now(clockid_t clock) noexcept GODOBJECT_NONBLOCKING {
  timespec t{};
  clock_gettime(clock, &t);
  return t;
}

/// Returns the page faults of this thread.
inline PageFaults page_faults() noexcept GODOBJECT_NONBLOCKING {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return {.minor = usage.ru_minflt, .major = usage.ru_majflt};
}

// Waiting: for the next period, and for the answers of buses.
inline int sleep_until(const timespec& t) noexcept GODOBJECT_NONBLOCKING {
  return clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
}
inline int poll(pollfd* waited, nfds_t n, const timespec& timeout) noexcept GODOBJECT_NONBLOCKING {
  return ::ppoll(waited, n, &timeout, nullptr);
}

// Descriptors, all of them non-blocking.
inline ssize_t read(int fd, void* to, std::size_t size) noexcept GODOBJECT_NONBLOCKING {
  return ::read(fd, to, size);
}
inline ssize_t write(int fd, const void* from, std::size_t size) noexcept GODOBJECT_NONBLOCKING {
  return ::write(fd, from, size);
}
inline ssize_t receive(int fd, void* to, std::size_t size, int flags) noexcept GODOBJECT_NONBLOCKING {
  return ::recv(fd, to, size, flags | MSG_DONTWAIT);
}
inline ssize_t receive(int fd, msghdr& message) noexcept GODOBJECT_NONBLOCKING {
  return ::recvmsg(fd, &message, MSG_DONTWAIT);
}
inline ssize_t send(int fd, const void* from, std::size_t size) noexcept GODOBJECT_NONBLOCKING {
  return ::send(fd, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
}
/// Returns the next part of a message's control data.
inline cmsghdr* next(const msghdr& message, const cmsghdr* part) noexcept GODOBJECT_NONBLOCKING {
  return CMSG_NXTHDR(const_cast<msghdr*>(&message), const_cast<cmsghdr*>(part));
}
inline int discard_input(int terminal) noexcept GODOBJECT_NONBLOCKING {
  constexpr int input = 0;  // TCIFLUSH of <termios.h>, which does not go with the kernel's termios2
  return ::ioctl(terminal, TCFLSH, input);
}
inline int set_timer(int fd, int flags, const itimerspec& due) noexcept GODOBJECT_NONBLOCKING {
  return ::timerfd_settime(fd, flags, &due, nullptr);
}

inline int stop_waiting(int epoll, int fd) noexcept GODOBJECT_NONBLOCKING {
  return ::epoll_ctl(epoll, EPOLL_CTL_DEL, fd, nullptr);
}

// The program at the socket of --device, when it connects or ends.
inline int accept(int listener) noexcept GODOBJECT_NONBLOCKING {
  return ::accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
}
inline int set_send_buffer(int fd, int bytes) noexcept GODOBJECT_NONBLOCKING {
  return ::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
}
inline int close(int fd) noexcept GODOBJECT_NONBLOCKING { return ::close(fd); }

// A CAN interface that was down.
template <class Request>
int control(int fd, unsigned long what, Request& request) noexcept GODOBJECT_NONBLOCKING {
  return ::ioctl(fd, what, &request);
}

// Memory that is at hand.

/// Copies into storage of the same size, which does not allocate.
template <class T>
void copy(T& to, const T& from) noexcept GODOBJECT_NONBLOCKING {
  to = from;
}
/// Allocates only if the storage was not made for n items.
template <class T>
void resize(std::vector<T>& items, std::size_t n) noexcept GODOBJECT_NONBLOCKING {
  items.resize(n);
}

/// Scope in a function of the cycle whose calls may wait, since its time is simulated or it runs in another
/// thread. RealtimeSanitizer then reports none of them.
class MayWait {
 public:
  MayWait(const MayWait&) = delete;
  MayWait& operator=(const MayWait&) = delete;
#ifdef GODOBJECT_REALTIME_SANITIZER
  MayWait() noexcept { __rtsan_disable(); }
  ~MayWait() { __rtsan_enable(); }
#else
  MayWait() noexcept {}
  ~MayWait() {}
#endif
};

/// Calls the step of a user's program, which must not block either.
template <class Step, class... Arguments>
bool call(const Step& step, Arguments&&... arguments) noexcept GODOBJECT_NONBLOCKING {
  return step(arguments...);
}

}  // namespace godobject::loop

#if defined(__has_warning)
#if __has_warning("-Wfunction-effects")
#pragma clang diagnostic pop
#endif
#endif
