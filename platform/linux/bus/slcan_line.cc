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
  std::size_t written = 0;
  while (written < out_size_) {
    const auto queued = std::span(out_).first(out_size_).subspan(written);
    const auto end = std::ranges::find(queued, static_cast<std::uint8_t>('\r'));
    const auto line = queued.first(
        std::min<std::size_t>(static_cast<std::size_t>(end - queued.begin()) + 1, queued.size()));
    const BusWrite one_piece;  // with rest_: the last frames come after both
    const std::size_t size = port_.write(line);
    if (size == 0) break;
    rest_.store({reinterpret_cast<const char*>(line.data()) + size, line.size() - size});
    written += size;
    if (size < line.size()) break;
  }
  if (written == 0) return;
  std::copy(out_.begin() + static_cast<std::ptrdiff_t>(written),
            out_.begin() + static_cast<std::ptrdiff_t>(out_size_), out_.begin());
  out_size_ -= written;
}

std::string SlcanLine::text_of(const CanFrame& frame) {
  std::array<char, slcan::max_line> text{};
  const std::size_t size = slcan::format_frame(frame, text);
  return {text.data(), size};
}

bool SlcanLine::next(std::string_view& line) noexcept {
  constexpr int max_reads = 8;  // reads of in_.size() bytes: bounds the time of one call
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

void SlcanLine::discard_input() noexcept {
  in_begin_ = in_end_ = 0;
  reader_ = {};
}

void SlcanLine::clear() noexcept {
  out_size_ = 0;
  rest_.store({});
  discard_input();
}

}  // namespace godobject
