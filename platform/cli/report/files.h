// The files that a run fills: traces, the log of bus frames in candump's format, and input logs, each if
// requested.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/can/candump.h"
#include "platform/rt/background_file.h"
#include "platform/session/session.h"
#include "platform/trace/input_log.h"
#include "platform/trace/trace.h"

namespace godobject {

/// Frame and index of its bus.
struct BusFrame {
  std::size_t bus = 0;
  ReceivedFrame received;
};

/// Writes the frames of all buses sorted by time. Frames arrive at most a few periods out of order. add() and
/// close() are called by one thread, pass_on() by another; neither is the real-time thread.
class CandumpLog {
 public:
  /// sink: receives text; returns false if some of it was not written.
  /// buses: interface names, at most 15 characters.
  CandumpLog(std::function<bool(std::string_view)> sink, std::vector<std::string> buses);

  void add(const BusFrame& frame);
  /// Appends the frames older than the newest frame of two calls ago. Called ten times a second, all frames
  /// of those times have arrived by then. Does nothing while add() or close() runs.
  void pass_on(const std::function<void(std::string_view)>& append);
  /// Writes the remaining frames. Returns false if the sink failed at any time.
  [[nodiscard]] bool close();

 private:
  void sort();
  /// Formats and removes the first `count` frames.
  const std::string& take_first(std::size_t count);
  void write_first(std::size_t count);

  std::mutex mutex_;  // guards the members below
  std::function<bool(std::string_view)> sink_;
  std::vector<std::string> buses_;
  std::vector<BusFrame> waiting_;
  std::string buffer_;
  std::array<Nanoseconds, 2> newest_{};  // newest frame at each of the last two calls of pass_on()
  bool all_written_ = true;
};

/// Names of the files to write during a run; empty: not written.
struct RunFileNames {
  std::string scene;  // path of the scene file, whose folder has the files that it refers to
  std::string trace, contacts, nets;
  CsvRows::Sink trace_rows = nullptr;  // receives the rows of the trace in place of a file
  std::string record;                  // a log of frames, or by its ending an input log
  std::string on_fault;                // input log of the last seconds before the first fault
  std::uint64_t trace_every =
      1;  // write every n-th row of trace and contacts, and rows where a fault begins or ends
  std::uint64_t nets_every = 40;  // write every n-th row of nets

  bool records_inputs() const noexcept { return is_input_log(record) || !on_fault.empty(); }
};

/// A file that is not complete.
struct FileLoss {
  std::string path;
  std::string why;               // empty: the writer of a real-time run was too slow
  std::uint64_t lost_lines = 0;  // as far as known
};

/// Makes the records of a session list all that its files have. Call it before Session::at_start().
void list_recorded(const RunFileNames& names, Session& session) noexcept;

/// Copies the state of the session's engine, but for the cycle. Real-time after the first call.
void take_state(const Session& session, EngineState& state) noexcept GODOBJECT_NONBLOCKING;

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

/// Input log of the last 10 s before the first fault, and of the second after it. Until then the chunks are
/// in memory.
class FaultLog {
 public:
  FaultLog(const std::string& path, const InputLogSizes& sizes, std::uint64_t snapshot_bytes, double step);

  void add(const InputLogWriter::Chunk& chunk, std::chrono::milliseconds patience);
  /// Updates with a row. Returns true if the first fault begins with it; then flush the log and call write().
  bool faults_first(const CycleRecord& record) noexcept;
  /// Opens the file and writes the chunks in memory.
  void write(std::chrono::milliseconds patience);
  /// Returns the loss as InputLogOnDisk does; none if there was no fault.
  std::optional<FileLoss> close(BackgroundFile::Clock::time_point until);
  bool is_written() const noexcept { return file_.has_value(); }

 private:
  std::string path_;
  std::string preamble_;  // chunks before the first state
  bool has_state_ = false, has_fault_ = false;
  std::uint64_t rows_after_;  // number of rows to add after the fault
  LastChunks last_;
  std::optional<InputLogOnDisk> file_;
};

class RunFiles {
 public:
  /// log_origin_ns: added to the times of frames.
  RunFiles(const RunFileNames& names, const SceneConfig& scene, Nanoseconds log_origin_ns);

  const RunFileNames& names() const noexcept { return names_; }
  bool wants_contacts() const noexcept { return contacts_.has_value(); }
  bool wants_net_nodes() const noexcept { return nets_.has_value(); }
  bool wants_frames() const noexcept { return record_ != nullptr; }
  bool wants_inputs() const noexcept { return names_.records_inputs(); }
  /// Adds the state before the first step, and begins input logs.
  void start(const Session& session);
  void add(const CycleRecord& record);
  /// Adds the state of the engine after the last added record, for input logs.
  void add(const EngineState& state) {
    if (inputs_) inputs_->add(state);
  }
  void add(const BusFrame& frame) {
    if (!record_) return;
    BusFrame logged = frame;
    logged.received.t_ns += log_origin_ns_;
    record_->add(logged);
  }
  /// Sets how long add() waits for a blocked file before it stops writing it. 0: add() does not wait, and
  /// drops text without room. Default 2 s.
  void set_patience(std::chrono::milliseconds patience) noexcept { patience_ = patience; }
  /// Waits at most 2 s for pending text, and returns the incomplete files.
  std::vector<FileLoss> close();
  /// True if there was a fault, so that the file RunFileNames::on_fault exists.
  bool wrote_on_fault() const noexcept { return fault_log_ && fault_log_->is_written(); }

 private:
  void start_inputs(const Session& session, const CycleRecord& start);
  void add_start();
  void write(const CycleRecord& record);
  bool is_kept(const CycleRecord& record) noexcept;
  void add_row(const CycleRecord& record);

  RunFileNames names_;
  Nanoseconds log_origin_ns_;
  std::vector<std::size_t> driven_, children_;  // bodies with a target; child of each joint
  std::vector<TraceBody> bodies_;               // row being written
  std::vector<TraceDriven> pulls_;
  std::vector<Wrench> joints_;
  std::optional<CycleRecord> start_;  // waits for the start time of the motion
  std::uint64_t num_rows_ = 0;        // number of rows so far, with omitted ones
  Fault fault_ = Fault::none;         // fault of the previous row
  RigFault rig_faults_ = RigFault::none;
  std::chrono::milliseconds patience_{2000};
  std::optional<BackgroundFile> trace_file_, contacts_file_, nets_file_, record_file_;
  std::optional<TraceWriter> trace_;
  std::optional<ContactTraceWriter> contacts_;
  std::optional<NetTraceWriter> nets_;
  std::shared_ptr<CandumpLog> record_;  // shared with the thread that writes it
  std::optional<InputLogOnDisk> input_log_;
  std::optional<FaultLog> fault_log_;
  std::optional<InputLogWriter> inputs_;  // writes to both
};

}  // namespace godobject
