// A file that a thread of its own opens and writes: whoever has something to write is never kept by a disk that
// stalls, a pipe that nobody reads or a terminal that was stopped.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

namespace godobject {

/// One thread at a time, never the real-time one.
class BackgroundFile {
 public:
  using Clock = std::chrono::steady_clock;

  /// What did not get into the file.
  struct Result {
    std::string why;               // empty: all that was taken has been written
    std::uint64_t lost_lines = 0;  // lines that were not taken, or taken and not written
  };

  /// Appends text whose writers have kept it back: called every gather_period, in the file's thread.
  using Append = std::function<void(std::string_view text)>;
  using Source = std::function<void(const Append& append)>;

  /// Makes the file anew. room: how many bytes may wait. Text is written gather_period after write() at the latest, unless the
  /// file takes nothing. source: more text, at the same times; it may outlive this. Errors show in close().
  BackgroundFile(const std::string& path, std::size_t room, Source source = nullptr);
  /// Writes to what is open already, and leaves it open: standard error.
  BackgroundFile(int descriptor, std::size_t room);
  /// Waits for nothing: what has not been written by now may never be.
  ~BackgroundFile();
  BackgroundFile(const BackgroundFile&) = delete;
  BackgroundFile& operator=(const BackgroundFile&) = delete;

  /// All of it or, where it finds no room, none of it, which is counted. patience: with a file that takes nothing;
  /// when that is over it is given up for good. 0: does not wait, and tries again next time.
  /// Wakes the file's thread only where little room is left: nearly always without a system call.
  bool write(std::string_view text, std::chrono::milliseconds patience = std::chrono::milliseconds(0));
  static constexpr std::chrono::milliseconds gather_period{100};

  /// Waits until everything is written, until then at the latest, and says what is not. The second time: the same.
  Result close(Clock::time_point until);

 private:
  struct State;
  void start();

  std::shared_ptr<State> state_;  // the thread's as well: it may outlive this, stuck in a write
  std::thread thread_;
};

}  // namespace godobject
