#include "platform/rt/background_file.h"

#include <fcntl.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <new>
#include <system_error>
#include <utility>

#include "platform/rt/signals.h"

namespace godobject {
namespace {

constexpr std::size_t chunk = 1 << 16;  // bytes in one write, and so the resolution of `progress`

std::uint64_t lines_in(std::string_view text) {
  return static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
}

std::string message_of(int error) { return std::generic_category().message(error); }

int open_again(const char* path, int flags) noexcept {
  int descriptor = -1;
  do {
    descriptor = ::open(path, flags | O_CLOEXEC, 0666);
  } while (descriptor < 0 && errno == EINTR);
  return descriptor;
}

/// Copies all bytes of an open file, also of a removed one. Returns false with errno on failure.
bool copy_all(int from, int to) noexcept {
  // A descriptor for reading, with an offset of its own.
  const int source = open_again(("/proc/self/fd/" + std::to_string(from)).c_str(), O_RDONLY);
  if (source < 0) return false;
  ssize_t size = 0;
  do {
    size = ::sendfile(to, source, nullptr, std::size_t{1} << 20);
  } while (size > 0 || (size < 0 && errno == EINTR));
  const int error = errno;
  ::close(source);
  errno = error;
  return size == 0;
}

}  // namespace

struct BackgroundFile::State {
  std::mutex mutex;
  std::condition_variable changed;
  std::string path;  // empty: the caller owns the descriptor
  Source source;
  Content content = Content::lines;
  Clock::time_point gathered;  // time of the last call
  int descriptor = -1;
  std::size_t room = 0;
  std::string waiting, writing;
  std::size_t written = 0;     // bytes of `writing` that are written
  std::uint64_t progress = 0;  // bytes written in all
  std::uint64_t written_lines = 0, lost_lines = 0;
  std::string trouble;  // why the last write failed; empty if it did not
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
  bool open_file() noexcept;
  bool write_some(std::unique_lock<std::mutex>& lock);
  bool is_removed() const noexcept;
  std::string create_again();
  void restore(std::unique_lock<std::mutex>& lock);
  void cut_back();
  void fail(std::string reason);
  std::uint64_t unwritten_lines() const {
    return lines_in(std::string_view(writing).substr(written)) + lines_in(waiting);
  }
};

BackgroundFile::BackgroundFile(const std::string& path, std::size_t room, Source source, Content content)
    : state_(std::make_shared<State>()) {
  state_->path = path;
  state_->content = content;
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
      state_->fail("it accepted no bytes for " + std::to_string(patience.count()) + " ms" +
                   (state_->trouble.empty() ? "" : ": " + state_->trouble));
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
    if (!is_open) fail(message_of(error));
    while (!failed) {
      changed.wait_for(lock, gather_period, [this] { return failed || closing || is_urgent(); });
      if (!failed) gather(lock);
      restore(lock);
      if (failed || (waiting.empty() && closing)) break;
      writing.clear();
      wanted = false;
      written = 0;
      writing.swap(waiting);
      changed.notify_all();
      while (!failed && write_some(lock)) continue;
    }
    if (failed) cut_back();
  } catch (const std::exception& error) {
    if (!lock.owns_lock()) lock.lock();
    failed = true;
    why = error.what();
  }
  if (!path.empty() && descriptor >= 0 && ::close(descriptor) != 0 && !failed) fail(message_of(errno));
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

bool BackgroundFile::State::open_file() noexcept {
  if (path.empty()) return true;
  descriptor = open_again(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC);
  return descriptor >= 0;
}

/// Writes one chunk; waits after a failed attempt. Returns false if all is written or the file has failed.
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
    trouble = message_of(error);
    // A full disk may have space again; a terminal or a pipe without a reader stays closed.
    const bool may_recover = !path.empty() && error != EPIPE;
    if (may_recover && !closing) changed.wait_for(lock, gather_period, [this] { return failed || closing; });
    else fail(trouble);
    return !failed;
  }
  trouble.clear();
  written_lines += lines_in(rest.substr(0, static_cast<std::size_t>(size)));
  written += static_cast<std::size_t>(size);
  progress += static_cast<std::uint64_t>(size);
  changed.notify_all();
  return true;
}

/// True if the file has no name any more, so that it ends with the program.
bool BackgroundFile::State::is_removed() const noexcept {
  struct stat now {};
  return !path.empty() && ::fstat(descriptor, &now) == 0 && S_ISREG(now.st_mode) && now.st_nlink == 0;
}

/// Creates the file again with its bytes so far. Returns why this failed; empty on success.
std::string BackgroundFile::State::create_again() {
  std::error_code ignored;  // open() reports the error
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
  const int created = open_again(path.c_str(), O_WRONLY | O_CREAT | O_EXCL);
  if (created < 0) return message_of(errno);
  if (!copy_all(descriptor, created)) {
    std::string reason = message_of(errno);
    ::unlink(path.c_str());
    ::close(created);
    return reason;
  }
  ::close(std::exchange(descriptor, created));
  return "";
}

/// Restores a removed file. The text of one that cannot be restored is lost at the end.
void BackgroundFile::State::restore(std::unique_lock<std::mutex>& lock) {
  if (failed || !is_removed()) return;
  lock.unlock();
  const std::string reason = create_again();
  lock.lock();
  if (reason.empty() || !closing) return;
  lost_lines += written_lines;
  progress = 0;
  fail("it was removed, and cannot be created again: " + reason);
}

/// Removes an incomplete line from the end of a file that has failed.
void BackgroundFile::State::cut_back() {
  const std::string_view text = std::string_view(writing).substr(0, written);
  const std::size_t cut = text.size() - (text.rfind('\n') + 1);  // npos + 1 is 0
  if (content != Content::lines || cut == 0 || descriptor < 0) return;
  if (::ftruncate(descriptor, static_cast<off_t>(progress - cut)) == 0) progress -= cut;
}

}  // namespace godobject
