#include "platform/cli/report/fault_log.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace godobject {
namespace {

constexpr std::size_t file_room = 16u << 20;
/// Time to wait for the file of an earlier fault, which had its last row seconds ago.
constexpr std::chrono::milliseconds patience_before{100};

std::uint64_t rows_in(double time_s, double step) {
  return static_cast<std::uint64_t>(std::llround(time_s / step));
}

/// Returns the path of the file of this number, from 1: "fault.godo", "fault-2.godo".
std::string numbered(const std::string& path, std::size_t number) {
  if (number == 1) return path;
  return path.substr(0, path.size() - input_log_ending.size()) + "-" + std::to_string(number) +
         std::string(input_log_ending);
}

}  // namespace

void InputLogOnDisk::add(std::string_view bytes, std::uint64_t rows, std::chrono::milliseconds patience) {
  if (!file_.write(bytes, patience)) {
    refused_rows_ += rows;
    return;
  }
  ends_.push_back({.bytes = ends_.back().bytes + bytes.size(), .rows = ends_.back().rows + rows});
}

std::optional<FileLoss> InputLogOnDisk::close(BackgroundFile::Clock::time_point until) {
  const BackgroundFile::Result result = file_.close(until);
  FileLoss loss{.path = path_, .why = result.why, .lost_lines = refused_rows_};
  const auto last = std::ranges::upper_bound(ends_, result.written_bytes, {}, &End::bytes) - 1;
  loss.lost_lines += ends_.back().rows - last->rows;
  if (loss.why.empty() && loss.lost_lines == 0) return std::nullopt;
  return loss;
}

FaultLog::FaultLog(std::string path, const InputLogSizes& sizes, std::uint64_t snapshot_bytes, double step)
    : path_(std::move(path)),
      step_(step),
      last_(sizes, snapshot_bytes, rows_in(seconds_before, step), cycles_between_states(step)) {}

void FaultLog::add(const InputLogWriter::Chunk& chunk, std::chrono::milliseconds patience) {
  has_state_ = has_state_ || chunk.is_state;
  if (!has_state_) preamble_ += chunk.bytes;
  else last_.add(chunk);
  if (rows_after_ == 0) return;
  file_->add(chunk.bytes, chunk.num_rows, patience);
  rows_after_ -= std::min(rows_after_, chunk.num_rows);
  if (rows_after_ == 0) file_->add(InputLogWriter::end_of(0), 0, patience);
}

const FaultFile& FaultLog::write(std::chrono::milliseconds patience) {
  close_file(BackgroundFile::Clock::now() + patience_before);
  std::uint64_t rows = last_.num_rows();
  files_.push_back({.path = numbered(path_, files_.size() + 1),
                    .kept_s = static_cast<double>(rows) * step_,
                    .is_bounded = last_.is_bounded()});
  file_.emplace(files_.back().path, preamble_.size() + LastChunks::max_bytes + file_room);
  file_->add(preamble_, 1, patience);
  last_.each([&](std::string_view piece) { file_->add(piece, std::exchange(rows, 0), patience); });
  rows_after_ = std::max<std::uint64_t>(1, rows_in(seconds_after, step_));
  return files_.back();
}

void FaultLog::close_file(BackgroundFile::Clock::time_point until) {
  if (!file_) return;
  if (std::exchange(rows_after_, 0) > 0)
    file_->add(InputLogWriter::end_of(0), 0, std::chrono::milliseconds(0));
  if (std::optional<FileLoss> loss = file_->close(until)) losses_.push_back(*std::move(loss));
  file_.reset();
}

std::vector<FileLoss> FaultLog::close(BackgroundFile::Clock::time_point until) {
  close_file(until);
  return losses_;
}

}  // namespace godobject
