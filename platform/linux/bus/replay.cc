#include "platform/linux/bus/bus.h"

#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "hal/base/format.h"
#include "hal/can/candump.h"
#include "platform/rt/cyclic.h"

namespace godobject {
namespace {

constexpr std::size_t max_log_bytes = std::size_t{2} << 30;  // hours of a full bus
constexpr std::size_t max_named_interfaces = 10;

std::string_view line_at(std::string_view text, std::size_t position) noexcept {
  return part_of(text, position, std::min(text.find('\n', position), text.size()) - position);
}

const char* text_of(CandumpResult result) {
  switch (result) {
    case CandumpResult::bad_time: return "the time is not (seconds.fraction) with six or nine decimals";
    case CandumpResult::bad_interface: return "the interface is missing or longer than 15 characters";
    case CandumpResult::bad_identifier: return "the identifier is not three or eight hexadecimal digits";
    case CandumpResult::bad_data: return "the data are not hexadecimal bytes of a size that CAN has";
    case CandumpResult::ok:
    case CandumpResult::ignored:
    case CandumpResult::error_frame:
    case CandumpResult::buffer_too_small: break;
  }
  return "";
}

bool is_wrong(CandumpResult result) { return *text_of(result) != '\0'; }

/// Replaces control characters by '?'.
std::string printable(std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return c < ' ' || c == '\x7F'; }, '?');
  return name;
}

/// Reads a whole file or pipe. Returns false if it is larger than max_bytes.
bool read_up_to(std::istream& file, std::size_t max_bytes, std::string& text) {
  constexpr std::size_t at_a_time = std::size_t{1} << 20;
  text.clear();
  while (file && text.size() <= max_bytes) {
    const std::size_t end = text.size();
    text.resize(end + at_a_time);
    file.read(text.data() + end, at_a_time);
    text.resize(end + static_cast<std::size_t>(file.gcount()));
  }
  return text.size() <= max_bytes;
}

/// Joins the names of a log's interfaces, as many as fit into a message.
std::string joined(const std::set<std::string, std::less<>>& names) {
  std::string text;
  std::size_t listed = 0;
  for (const std::string& name : names) {
    if (listed++ == max_named_interfaces) return text + ", ...";
    text += (text.empty() ? "" : ", ") + printable(name);
  }
  return text;
}

}  // namespace

LogAddress parse_log_address(const std::string& where) {
  const std::size_t comma = where.rfind(',');
  if (comma == std::string::npos || std::filesystem::exists(where)) return {.path = where, .interface = ""};
  return {.path = where.substr(0, comma), .interface = where.substr(comma + 1)};
}

ReplayBus::ReplayBus(const std::string& where, const BusSettings& settings)
    : path_(parse_log_address(where).path),
      interface_(parse_log_address(where).interface),
      filters_(settings.filters.begin(), settings.filters.end()) {}

bool ReplayBus::fail(std::string why) {
  why_ = std::move(why);
  return false;
}

bool ReplayBus::open() noexcept {
  close();
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path_, error);
  if (std::filesystem::is_directory(status)) return fail("is a directory, not a log");
  if (std::filesystem::exists(status) && !is_regular_file(status) && !is_fifo(status))
    return fail("is neither a file nor a pipe");
  std::ifstream file(path_, std::ios::binary);
  if (!file) return fail("cannot be read: " + std::generic_category().message(errno));
  if (!read_up_to(file, max_log_bytes, log_)) return fail("is larger than 2 GB, the limit");
  if (log_.empty()) return fail("is empty");
  if (!check_log()) return false;
  timer_fd_ = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  if (timer_fd_ < 0) return fail("no timer can be created: " + std::generic_category().message(errno));
  state_ = BusState::error_active;
  shift_ = MonotonicClock().now() - begin_ns_;
  if (take_next()) arm();
  return true;
}

/// Checks that every line can be parsed, and that the log has one interface to replay.
bool ReplayBus::check_log() {
  std::set<std::string, std::less<>> interfaces;
  std::map<std::uint32_t, std::uint8_t> sizes;  // size of the last frame with an identifier
  std::size_t line_number = 1;
  bool has_frames = false;
  for (std::size_t at = 0; at < log_.size(); ++line_number) {
    const std::string_view line = line_at(log_, at);
    const std::size_t begin = std::exchange(at, at + line.size() + 1);
    ReceivedFrame frame;
    std::string_view name;
    const CandumpResult result = parse_candump(line, frame, name);
    // A last line without an end was cut off when its writer died, perhaps between two bytes of its data.
    const auto size = sizes.find(frame.frame.id);
    if (at > log_.size() && line.starts_with('(') &&
        (is_wrong(result) || (size != sizes.end() && size->second != frame.frame.size))) {
      log_.resize(begin);
      is_cut_ = true;
      break;
    }
    if (is_wrong(result))
      return fail("line " + std::to_string(line_number) + ": " + text_of(result) +
                  "; a log is written by candump -l or godobject run --record");
    if (result != CandumpResult::ok) continue;
    sizes[frame.frame.id] = frame.frame.size;
    if (interfaces.empty()) begin_ns_ = frame.t_ns;
    if (!interfaces.contains(name)) interfaces.emplace(name);
    has_frames = has_frames || interface_.empty() || name == interface_;
  }
  if (interfaces.empty()) return fail("holds no frame: is it a log of candump -l?");
  if (!has_frames) return fail("holds no frame of " + interface_ + ", only of " + joined(interfaces));
  if (interface_.empty() && interfaces.size() > 1)
    return fail("holds frames of " + joined(interfaces) + ": choose one, e.g. replay:" + path_ + "," +
                *interfaces.begin());
  return true;
}

void ReplayBus::close() noexcept {
  if (timer_fd_ >= 0) ::close(timer_fd_);
  timer_fd_ = -1;
  log_.clear();
  position_ = 0;
  has_next_ = is_cut_ = false;
  next_ = {};
  state_ = BusState::closed;
  why_.clear();
}

/// Parses up to the next frame of the interface that passes the filters. Time never decreases: logs of
/// several interfaces have lines out of order by some microseconds.
bool ReplayBus::take_next() noexcept {
  has_next_ = false;
  while (!has_next_ && position_ < log_.size()) {
    const std::string_view line = line_at(log_, position_);
    position_ += line.size() + 1;
    ReceivedFrame frame;
    std::string_view name;
    const CandumpResult result = parse_candump(line, frame, name);
    if (result == CandumpResult::error_frame) ++counters_.error_frames;
    if (result != CandumpResult::ok || (!interface_.empty() && name != interface_)) continue;
    if (!passes(filters_, frame.frame)) continue;
    if (shift_ > 0 && frame.t_ns > std::numeric_limits<Nanoseconds>::max() - shift_)
      continue;  // after the largest representable time
    frame.t_ns = std::max(frame.t_ns + shift_, next_.t_ns);
    next_ = frame;
    has_next_ = true;
  }
  if (!has_next_) state_ = BusState::down;
  return has_next_;
}

void ReplayBus::arm() noexcept {
  itimerspec when{};
  when.it_value.tv_sec = static_cast<time_t>(next_.t_ns / 1'000'000'000);
  when.it_value.tv_nsec = static_cast<long>(next_.t_ns % 1'000'000'000);
  loop::set_timer(timer_fd_, TFD_TIMER_ABSTIME, when);
}

SendResult ReplayBus::try_send(const CanFrame& frame) noexcept {
  SendResult result = SendResult::queued;
  if (is_cut_off(state_)) {
    result = SendResult::down;
  } else if (!is_valid(frame)) {
    result = SendResult::invalid;
  }
  ++(result == SendResult::queued ? counters_.sent : counters_.send_refused);
  return result;
}

bool ReplayBus::try_receive(ReceivedFrame& out) noexcept {
  if (!has_next_) return false;
  if (MonotonicClock().now() < next_.t_ns) {
    arm();
    return false;
  }
  out = next_;
  ++counters_.received;
  (void)take_next();
  return true;
}

std::string ReplayBus::trouble() const {
  if (!why_.empty()) return path_ + ": " + why_;
  switch (state_) {
    case BusState::closed: return path_ + ": closed";
    case BusState::down:
      return path_ +
             (is_cut_ ? ": end of the log; its last line is cut off and was left out" : ": end of the log");
    default: return "";
  }
}

}  // namespace godobject
