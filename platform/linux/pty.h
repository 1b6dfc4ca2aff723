// A pseudo-terminal: a serial line whose other end another program opens.
#pragma once

#include <string>

namespace godobject {

/// Descriptors belong to the caller. `slave` is to be held open: while no slave is, reading the master is an error.
struct Pty {
  int master = -1, slave = -1;
  std::string name{};  // path of the other end
  std::string why{};   // empty: it is open
};

/// Raw, non-blocking, not inherited.
Pty make_pty();

}  // namespace godobject
