#include "platform/rt/stop_key.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

namespace godobject {
namespace {

/// True if no shell has put this process in the background, where it may not read keys. A terminal that
/// controls no process has no background.
bool is_in_foreground() noexcept {
  const pid_t group = tcgetpgrp(STDIN_FILENO);
  return group < 0 || group == getpgrp();
}

}  // namespace

StopKey::StopKey(const StopSignals& signals) noexcept : signals_(signals) {
  if (isatty(STDIN_FILENO) == 0 || !is_in_foreground()) return;
  if (tcgetattr(STDIN_FILENO, &former_) != 0 || (former_.c_lflag & ICANON) == 0) return;
  end_ = eventfd(0, EFD_CLOEXEC);
  if (end_ < 0) return;
  try {
    thread_ = std::thread([this] { read_keys(); });
  } catch (const std::system_error&) {
    return;
  }
  termios by_keys = former_;
  by_keys.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  by_keys.c_cc[VMIN] = 1;
  by_keys.c_cc[VTIME] = 0;
  LastResort::keep(&former_);
  tcsetattr(STDIN_FILENO, TCSANOW, &by_keys);
}

StopKey::~StopKey() {
  if (works()) {
    static_cast<void>(eventfd_write(end_, 1));
    thread_.join();
    tcsetattr(STDIN_FILENO, TCSANOW, &former_);
    LastResort::keep(nullptr);
  }
  if (end_ >= 0) ::close(end_);
}

void StopKey::read_keys() const noexcept {
  const ThreadSetup setup("keys");
  std::array<pollfd, 2> ends{
      {{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0}, {.fd = end_, .events = POLLIN, .revents = 0}}};
  std::array<char, 64> keys{};
  while (ends[1].revents == 0) {
    if (::poll(ends.data(), ends.size(), -1) < 0 && errno != EINTR) return;
    if (ends[0].revents == 0) continue;
    const ssize_t num_keys = ::read(STDIN_FILENO, keys.data(), keys.size());
    if (num_keys < 0 && errno == EINTR) continue;
    if (num_keys <= 0) return;  // the terminal is gone
    if (std::find(keys.begin(), keys.begin() + num_keys, ' ') != keys.begin() + num_keys)
      signals_.press_key();
  }
}

}  // namespace godobject
