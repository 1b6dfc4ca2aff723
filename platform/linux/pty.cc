#include "platform/linux/pty.h"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace godobject {
namespace {

Pty fail(Pty pty, const std::string& what) {
  pty.why = "no pseudo-terminal: " + what + ": " + std::generic_category().message(errno);
  for (int* const fd : {&pty.master, &pty.slave}) {
    if (*fd >= 0) close(*fd);
    *fd = -1;
  }
  return pty;
}

}  // namespace

Pty make_pty() {
  Pty pty{.master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (pty.master < 0) return fail(pty, "posix_openpt");
  std::array<char, 64> name{};
  if (grantpt(pty.master) != 0 || unlockpt(pty.master) != 0 ||
      ptsname_r(pty.master, name.data(), name.size()) != 0)
    return fail(pty, "its other end cannot be made ready");
  pty.name = name.data();
  pty.slave = open(name.data(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  termios raw{};
  cfmakeraw(&raw);
  if (pty.slave < 0 || tcsetattr(pty.slave, TCSANOW, &raw) != 0) return fail(pty, pty.name);
  return pty;
}

}  // namespace godobject
