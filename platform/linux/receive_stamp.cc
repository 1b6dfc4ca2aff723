#include "platform/linux/receive_stamp.h"

#include <linux/errqueue.h>
#include <linux/net_tstamp.h>

#include <algorithm>
#include <cstring>
#include <ctime>

#include "platform/rt/clock.h"

namespace godobject {
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
    timespec wall{};
    clock_gettime(CLOCK_REALTIME, &wall);
    const Nanoseconds after = MonotonicClock{}.now();
    if (i != 0 && after - before >= shortest) continue;
    shortest = after - before;
    best = {.monotonic = before + shortest / 2, .wall = nanoseconds(wall)};
  }
  return best;
}

}  // namespace

bool enable_receive_stamps(int socket) noexcept {
  const int wanted = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_HARDWARE |
                     SOF_TIMESTAMPING_RAW_HARDWARE;
  return setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPING, &wanted, sizeof wanted) == 0;
}

Nanoseconds ReceiveStamp::of(const msghdr& message) noexcept {
  scm_timestamping stamps{};  // [0] software, [2] raw hardware, 0: none
  for (const cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(const_cast<msghdr*>(&message), const_cast<cmsghdr*>(part))) {
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

}  // namespace godobject
