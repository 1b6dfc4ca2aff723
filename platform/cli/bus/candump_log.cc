#include "platform/cli/bus/candump_log.h"

#include <algorithm>
#include <array>
#include <utility>

namespace godobject {
namespace {

constexpr std::size_t batch = 4096;  // frames: far more than come in a few periods

}  // namespace

CandumpLog::CandumpLog(std::function<bool(std::string_view)> sink, std::vector<std::string> buses)
    : sink_(std::move(sink)), buses_(std::move(buses)) {
  waiting_.reserve(2 * batch);
}

void CandumpLog::add(const BusFrame& frame) {
  waiting_.push_back(frame);
  if (waiting_.size() == 2 * batch) write_first(batch);
}

bool CandumpLog::close() {
  write_first(waiting_.size());
  return all_written_;
}

void CandumpLog::write_first(std::size_t count) {
  std::ranges::stable_sort(waiting_, {}, [](const BusFrame& f) { return f.received.t_ns; });
  buffer_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    std::array<char, max_candump_line> line{};
    std::size_t length = 0;
    const CandumpResult result = format_candump(waiting_[i].received, buses_[waiting_[i].bus], line, length);
    all_written_ = all_written_ && result == CandumpResult::ok;
    buffer_.append(line.data(), length) += '\n';
  }
  if (!buffer_.empty()) all_written_ = sink_(buffer_) && all_written_;
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace godobject
