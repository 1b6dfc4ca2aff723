#include "platform/cli/bus/candump_log.h"

#include <algorithm>
#include <array>
#include <utility>

namespace godobject {
namespace {

constexpr std::size_t batch = 4096;  // frames; far more than arrive in a few periods

}  // namespace

CandumpLog::CandumpLog(std::function<bool(std::string_view)> sink, std::vector<std::string> buses)
    : sink_(std::move(sink)), buses_(std::move(buses)) {
  waiting_.reserve(2 * batch);
}

void CandumpLog::add(const BusFrame& frame) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back(frame);
  if (waiting_.size() == 2 * batch) write_first(batch);
}

void CandumpLog::pass_on(const std::function<void(std::string_view)>& append) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock() || waiting_.empty()) return;
  sort();
  const auto time = [](const BusFrame& f) { return f.received.t_ns; };
  const auto end = std::ranges::upper_bound(waiting_, newest_[0], {}, time);
  append(take_first(static_cast<std::size_t>(end - waiting_.begin())));
  newest_ = {newest_[1], waiting_.empty() ? newest_[1] : time(waiting_.back())};
}

bool CandumpLog::close() {
  const std::lock_guard lock(mutex_);
  write_first(waiting_.size());
  return all_written_;
}

void CandumpLog::sort() {
  std::ranges::stable_sort(waiting_, {}, [](const BusFrame& f) { return f.received.t_ns; });
}

const std::string& CandumpLog::take_first(std::size_t count) {
  buffer_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    std::array<char, max_candump_line> line{};
    std::size_t length = 0;
    const CandumpResult result = format_candump(waiting_[i].received, buses_[waiting_[i].bus], line, length);
    all_written_ = all_written_ && result == CandumpResult::ok;
    buffer_.append(line.data(), length) += '\n';
  }
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
  return buffer_;
}

void CandumpLog::write_first(std::size_t count) {
  sort();
  const std::string& text = take_first(count);
  if (!text.empty()) all_written_ = sink_(text) && all_written_;
}

}  // namespace godobject
