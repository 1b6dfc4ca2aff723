#include "platform/linux/bus/slcan_line.h"

#include <algorithm>

#include "platform/rt/clock.h"

namespace godobject {

bool SlcanLine::put(std::string_view text) noexcept {
  flush();
  if (out_.size() - out_size_ < text.size()) return false;
  std::ranges::copy(text, out_.begin() + static_cast<std::ptrdiff_t>(out_size_));
  out_size_ += text.size();
  flush();
  return true;
}

void SlcanLine::flush() noexcept {
  if (out_size_ == 0) return;
  const std::size_t written = port_.write(std::span(out_).first(out_size_));
  std::copy(out_.begin() + static_cast<std::ptrdiff_t>(written),
            out_.begin() + static_cast<std::ptrdiff_t>(out_size_), out_.begin());
  out_size_ -= written;
}

std::string SlcanLine::after_anything(const CanFrame& frame) {
  std::array<char, slcan::max_line> text{};
  const std::size_t size = slcan::format_frame(frame, text);
  return size == 0 ? std::string() : "\r" + std::string(text.data(), size);
}

bool SlcanLine::next(std::string_view& line) noexcept {
  constexpr int max_reads = 8;  // of in_.size() bytes: a bound on the time that one call takes
  for (int reads = 0; reads <= max_reads; ++reads) {
    while (in_begin_ < in_end_) {
      if (!reader_.put(in_[in_begin_++])) continue;
      line = reader_.line();
      return true;
    }
    if (reads == max_reads) break;
    in_begin_ = 0;
    in_end_ = port_.read(in_);
    if (in_end_ == 0) break;
    read_at_ = MonotonicClock().now();
  }
  return false;
}

void SlcanLine::clear() noexcept {
  out_size_ = in_begin_ = in_end_ = 0;
  reader_ = {};
}

}  // namespace godobject
