// Input logs in files: that of a whole run, and those of the last seconds before each fault.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "platform/rt/background_file.h"
#include "platform/session/record.h"
#include "platform/trace/input_log.h"

namespace godobject {

/// A file that is not complete.
struct FileLoss {
  std::string path;
  std::string why;               // empty: the writer of a real-time run was too slow
  std::uint64_t lost_lines = 0;  // as far as known
};

/// Input log in a file, as its chunks come.
class InputLogOnDisk {
 public:
  explicit InputLogOnDisk(const std::string& path, std::size_t room)
      : path_(path), file_(path, room, nullptr, BackgroundFile::Content::chunks) {}

  void add(std::string_view bytes, std::uint64_t rows, std::chrono::milliseconds patience);
  /// Number of rows that did not fit so far.
  std::uint64_t refused_rows() const noexcept { return refused_rows_; }
  /// Returns the loss, whose lines are rows; none if the file is complete.
  std::optional<FileLoss> close(BackgroundFile::Clock::time_point until);

 private:
  struct End {
    std::uint64_t bytes = 0, rows = 0;  // from the begin of the file
  };
  std::string path_;
  BackgroundFile file_;
  std::vector<End> ends_{{}};  // of each chunk, after that of the begin
  std::uint64_t refused_rows_ = 0;
};

/// File of the seconds before a fault.
struct FaultFile {
  std::string path;
  double kept_s = 0;        // time before the fault that it has, s
  bool is_bounded = false;  // true if the memory holds less than FaultLog::seconds_before
};

/// Input logs of the last 10 s before a fault, and of the second after it. Until then the chunks are in
/// memory. A fault within that second is in the same file; a later one has a file of its own.
class FaultLog {
 public:
  static constexpr double seconds_before = 10, seconds_after = 1;
  static constexpr std::size_t max_files = 10;

  /// path: of the first file; the others have a number before the ending.
  FaultLog(std::string path, const InputLogSizes& sizes, std::uint64_t snapshot_bytes, double step);

  void add(const InputLogWriter::Chunk& chunk, std::chrono::milliseconds patience);
  /// True if a fault now needs a file: none is open, and there are fewer than max_files.
  bool wants_file() const noexcept { return rows_after_ == 0 && files_.size() < max_files; }
  /// Opens the next file and writes the chunks in memory. Flush the log before, so that these are all.
  const FaultFile& write(std::chrono::milliseconds patience);
  const std::vector<FaultFile>& files() const noexcept { return files_; }
  /// Returns the losses as InputLogOnDisk does.
  std::vector<FileLoss> close(BackgroundFile::Clock::time_point until);

 private:
  void close_file(BackgroundFile::Clock::time_point until);

  std::string path_;
  double step_;
  std::string preamble_;  // chunks before the first state
  bool has_state_ = false;
  std::uint64_t rows_after_ = 0;  // number of rows that the open file still takes
  LastChunks last_;
  std::vector<FaultFile> files_;
  std::optional<InputLogOnDisk> file_;  // that of the latest fault
  std::vector<FileLoss> losses_;
};

}  // namespace godobject
