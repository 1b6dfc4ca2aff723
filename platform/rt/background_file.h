// A file that a thread of its own opens and writes.
// Writers never wait for a stalled disk, an unread pipe or a stopped terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

namespace godobject {

/// Used by one thread at a time, never by the real-time thread.
class BackgroundFile {
 public:
  using Clock = std::chrono::steady_clock;

  /// Text that did not get into the file. A write that has not returned counts as lost.
  struct Result {
    std::string why;               // empty: all accepted text has been written
    std::uint64_t lost_lines = 0;  // lines that were refused, or accepted and not written
    std::uint64_t written_bytes = 0;
  };

  /// Appends text that its writers kept back. The file's thread calls Source every gather_period.
  using Append = std::function<void(std::string_view text)>;
  using Source = std::function<void(const Append& append)>;

  /// Content of a file, which determines its end after a failure.
  enum class Content : std::uint8_t {
    lines,   // ends with the last whole line
    chunks,  // ends with the last byte written; its reader finds the last whole chunk
  };

  /// Creates or truncates the file. Text is written at most gather_period after write(), unless the file
  /// stalls. Errors are reported by close().
  /// A failed write, as on a full disk, is repeated until close(), and accepted text waits. A file that was
  /// removed is created again with its text so far, as are its folders.
  /// room: capacity for waiting text, bytes. source: further text, polled every gather_period; may outlive
  /// this object.
  BackgroundFile(const std::string& path, std::size_t room, Source source = nullptr,
                 Content content = Content::lines);
  /// Writes to an open descriptor and leaves it open, for standard error.
  BackgroundFile(int descriptor, std::size_t room);
  /// Does not wait: text that is still unwritten may be lost.
  ~BackgroundFile();
  BackgroundFile(const BackgroundFile&) = delete;
  BackgroundFile& operator=(const BackgroundFile&) = delete;

  /// Appends the text, or counts it as lost if it does not fit. Wakes the file's thread only if little space
  /// is left, so nearly always without a system call.
  /// patience: time without progress of the file after which it is given up, ms; 0 does not wait, and later
  /// calls try again.
  bool write(std::string_view text, std::chrono::milliseconds patience = std::chrono::milliseconds(0));
  static constexpr std::chrono::milliseconds gather_period{100};

  /// Waits until everything is written, or until the time `until`, and reports losses. Repeated calls return
  /// the same.
  Result close(Clock::time_point until);

 private:
  struct State;
  void start();

  std::shared_ptr<State> state_;  // shared with the thread, which may outlive this object in a blocked write
  std::thread thread_;
};

}  // namespace godobject
