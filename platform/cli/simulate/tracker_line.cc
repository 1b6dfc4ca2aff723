#include "platform/cli/simulate/tracker_line.h"

#include <unistd.h>

#include "platform/linux/pty.h"

namespace godobject {

TrackerLine::~TrackerLine() {
  if (slave_fd_ >= 0) close(slave_fd_);
}

std::string TrackerLine::open() {
  const Pty pty = make_pty();
  if (!pty.why.empty()) return pty.why;
  slave_fd_ = pty.slave;
  port_.adopt(pty.master, pty.name);
  return "";
}

void TrackerLine::step(Nanoseconds now) noexcept {
  std::array<std::uint8_t, 512> in{};
  while (const std::size_t size = port_.read(in)) {
    num_received_ += size;
    far_->receive({in.data(), size}, now);
  }
  far_->advance(now);
  for (;;) {
    if (unsent_.empty()) unsent_ = {out_.data(), far_->transmit(out_, now)};
    if (unsent_.empty()) return;
    const std::size_t taken = port_.write(unsent_);
    unsent_ = unsent_.subspan(taken);
    if (taken == 0) return;
  }
}

}  // namespace godobject
