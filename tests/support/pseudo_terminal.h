// A pseudo-terminal with the master held by a test: the device at the other end of a serial line.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <string>

namespace godobject::test {

class PseudoTerminal {
 public:
  PseudoTerminal() : master_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    if (master_ < 0 || grantpt(master_) != 0 || unlockpt(master_) != 0) return;
    const char* const name = ptsname(master_);
    if (name) slave_ = name;
  }
  ~PseudoTerminal() { hang_up(); }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  const std::string& slave() const { return slave_; }

  bool send(const std::string& text) const {
    return write(master_, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  }

  /// Returns the bytes received until there are `size`, or none arrives for timeout_ms.
  std::string receive(std::size_t size, int timeout_ms = 1000) const {
    std::string text;
    pollfd waiting{.fd = master_, .events = POLLIN, .revents = 0};
    char byte = 0;
    while (text.size() < size && poll(&waiting, 1, timeout_ms) > 0 && read(master_, &byte, 1) == 1)
      text += byte;
    return text;
  }

  void hang_up() {
    if (master_ >= 0) close(master_);
    master_ = -1;
  }

 private:
  int master_;
  std::string slave_{};
};

}  // namespace godobject::test
