// A pseudo-terminal: a serial line with another program at its other end.
#pragma once

#include <string>

namespace godobject {

/// The caller owns the descriptors. `slave` must stay open, because reading the master without an open slave
/// is an error.
struct Pty {
  int master = -1, slave = -1;
  std::string name{};  // path of the other end
  std::string why{};   // empty: it is open
};

/// Makes a pseudo-terminal: raw, non-blocking, not inherited.
Pty make_pty();

}  // namespace godobject
