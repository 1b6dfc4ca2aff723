#include "platform/rt/background_file.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <new>
#include <system_error>

#include "platform/rt/signals.h"

namespace godobject {
namespace {

constexpr std::size_t chunk = 1 << 16;  // bytes in one write, and so the resolution of `progress`

std::uint64_t lines_in(std::string_view text) {
  return static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
}

}  // namespace

struct BackgroundFile::State {
  std::mutex mutex;
  std::condition_variable changed;
  std::string path;  // empty: the caller owns the descriptor
  Source source;
  Clock::time_point gathered;  // time of the last call
  int descriptor = -1;
  std::size_t room = 0;
  std::string waiting, writing;
  std::size_t written = 0;     // bytes of `writing` that are written
  std::uint64_t progress = 0;  // bytes written in all
  std::uint64_t lost_lines = 0;
  std::string why;
  bool failed = false, closing = false, ended = false;
  bool wanted = false;  // a writer found no space

  void run() noexcept;
  /// True if the thread must write now: a writer needs space, the buffer is a quarter full, or it is for a
  /// console.
  bool is_urgent() const noexcept {
    return wanted || (path.empty() && !waiting.empty()) || waiting.size() > room / 4;
  }
  void gather(std::unique_lock<std::mutex>& lock);
  bool open_file();
  bool write_some(std::unique_lock<std::mutex>& lock);
  void fail(std::string reason);
  std::uint64_t unwritten_lines() const {
    return lines_in(std::string_view(writing).substr(written)) + lines_in(waiting);
  }
};

BackgroundFile::BackgroundFile(const std::string& path, std::size_t room, Source source)
    : state_(std::make_shared<State>()) {
  state_->path = path;
  state_->source = std::move(source);
  state_->room = room;
  start();
}

BackgroundFile::BackgroundFile(int descriptor, std::size_t room) : state_(std::make_shared<State>()) {
  state_->descriptor = descriptor;
  state_->room = room;
  start();
}

BackgroundFile::~BackgroundFile() { static_cast<void>(close(Clock::now())); }

void BackgroundFile::start() {
  try {
    thread_ = std::thread([state = state_] { state->run(); });
  } catch (const std::system_error& error) {
    const std::lock_guard lock(state_->mutex);
    state_->fail(std::string("its writer thread cannot be started: ") + error.what());
    state_->ended = true;
  }
}

bool BackgroundFile::write(std::string_view text, std::chrono::milliseconds patience) {
  std::unique_lock lock(state_->mutex);
  const auto has_room = [&] {
    return state_->failed || state_->waiting.empty() || state_->waiting.size() + text.size() <= state_->room;
  };
  state_->wanted = !has_room();
  if (state_->wanted) state_->changed.notify_all();
  while (!has_room() && patience.count() > 0) {
    const std::uint64_t before = state_->progress;
    state_->changed.wait_for(lock, patience, [&] { return has_room() || state_->progress != before; });
    if (!has_room() && state_->progress == before)
      state_->fail("it accepted no bytes for " + std::to_string(patience.count()) + " ms");
  }
  if (state_->failed || state_->closing || !has_room()) {
    state_->lost_lines += lines_in(text);
    return false;
  }
  state_->waiting += text;
  if (state_->is_urgent()) state_->changed.notify_all();
  return true;
}

BackgroundFile::Result BackgroundFile::close(Clock::time_point until) {
  std::unique_lock lock(state_->mutex);
  state_->closing = true;
  state_->changed.notify_all();
  state_->changed.wait_until(lock, until, [&] { return state_->ended || state_->failed; });
  if (!state_->ended && !state_->failed)
    state_->fail("it accepted no more bytes in time, and writing was given up");
  const bool ended = state_->ended;
  Result result{.why = state_->why, .lost_lines = state_->lost_lines, .written_bytes = state_->progress};
  lock.unlock();
  if (thread_.joinable()) ended ? thread_.join() : thread_.detach();
  return result;
}

/// Abandons the file: all unwritten and all later text is lost.
void BackgroundFile::State::fail(std::string reason) {
  if (failed) return;
  failed = true;
  why = std::move(reason);
  lost_lines += unwritten_lines();
  waiting.clear();
  changed.notify_all();
}

void BackgroundFile::State::run() noexcept {
  const ThreadSetup setup(path.empty() ? "console" : "file");
  std::unique_lock lock(mutex);
  try {
    lock.unlock();
    const bool is_open = open_file();
    const int error = errno;
    lock.lock();
    if (!is_open) fail(std::generic_category().message(error));
    while (!failed) {
      changed.wait_for(lock, gather_period, [this] { return failed || closing || is_urgent(); });
      if (!failed) gather(lock);
      if (failed || (waiting.empty() && closing)) break;
      writing.clear();
      wanted = false;
      written = 0;
      writing.swap(waiting);
      changed.notify_all();
      while (!failed && write_some(lock)) continue;
    }
  } catch (const std::exception& error) {
    if (!lock.owns_lock()) lock.lock();
    failed = true;
    why = error.what();
  }
  if (!path.empty() && descriptor >= 0 && ::close(descriptor) != 0 && !failed)
    fail(std::generic_category().message(errno));
  ended = true;
  changed.notify_all();
}

void BackgroundFile::State::gather(std::unique_lock<std::mutex>& lock) {
  const Clock::time_point now = Clock::now();
  if (!source || now - gathered < gather_period) return;
  gathered = now;
  lock.unlock();
  source([&](std::string_view text) {
    const std::lock_guard appending(mutex);
    waiting += text;
  });
  lock.lock();
}

bool BackgroundFile::State::open_file() {
  if (path.empty()) return true;
  do {
    descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  } while (descriptor < 0 && errno == EINTR);
  return descriptor >= 0;
}

/// Writes one chunk. Returns false if all is written or the file has failed.
bool BackgroundFile::State::write_some(std::unique_lock<std::mutex>& lock) {
  const std::string_view rest = std::string_view(writing).substr(written, chunk);
  if (rest.empty()) return false;
  lock.unlock();
  const ssize_t size = ::write(descriptor, rest.data(), rest.size());
  const int error = errno;
  lock.lock();
  if (size < 0 && (error == EINTR || error == EAGAIN)) {
    if (error == EAGAIN) changed.wait_for(lock, std::chrono::milliseconds(10));
    return true;
  }
  if (size < 0) {
    fail(std::generic_category().message(error));
    return false;
  }
  written += static_cast<std::size_t>(size);
  progress += static_cast<std::uint64_t>(size);
  changed.notify_all();
  return true;
}

std::optional<std::uint64_t> free_bytes(const std::filesystem::path& folder) {
  struct statvfs disk {};
  if (statvfs(folder.c_str(), &disk) != 0) return std::nullopt;
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

RtStep disk_check(const std::filesystem::path& folder, std::optional<std::uint64_t> free,
                  double bytes_per_s) {
  constexpr double hour = 3600, minute = 60;  // s
  RtStep step{.name = "disk", .result = RtResult::failed, .detail = "", .remedy = ""};
  const std::string name = folder.string();
  if (!free || eaccess(folder.c_str(), W_OK | X_OK) != 0) {
    step.detail = name + (free ? " cannot be written" : " is no folder");
    step.remedy = free ? "chown $USER " + name : "mkdir -p " + name;
    return step;
  }
  const double bytes = static_cast<double>(*free), seconds = bytes / bytes_per_s;
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), ": %.3g GB free, %.3g h of a trace of %.2g MB/s", 1e-9 * bytes,
                seconds / hour, 1e-6 * bytes_per_s);
  step.detail = name + text.data();
  step.result = seconds >= hour ? RtResult::ok : seconds >= minute ? RtResult::degraded : RtResult::failed;
  if (step.result != RtResult::ok)
    step.remedy =
        "delete old records (du -sh " + name + "/*), write to another disk, or run with --trace-every 10";
  return step;
}

}  // namespace godobject
