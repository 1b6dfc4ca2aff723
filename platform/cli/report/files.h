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
#include "platform/cli/report/fault_log.h"
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
  std::string record;                  // a log of the frames of all buses
  std::string inputs;                  // input log of the whole run
  std::string on_fault;                // input logs of the last seconds before each fault: the first one
  std::uint64_t trace_every =
      1;  // write every n-th row of trace and contacts, and rows where a fault begins or ends
  std::uint64_t nets_every = 40;  // write every n-th row of nets

  bool records_inputs() const noexcept { return !inputs.empty() || !on_fault.empty(); }
};

/// Makes the records of a session list all that its files have. Call it before Session::at_start().
void list_recorded(const RunFileNames& names, Session& session) noexcept;

/// Returns the state of the session's engine, but for the cycle. Allocates.
EngineState state_of(const Session& session);

/// Copies the state of the session's engine, but for the cycle, into one that state_of() made.
void take_state(const Session& session, EngineState& state) noexcept GODOBJECT_NONBLOCKING;

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
  /// Adds an input of the rig, for input logs.
  void add(const LinkEvent& event) {
    if (inputs_) inputs_->add(event);
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
  /// Writes the input log of the last seconds at a fault. Returns null without such a log, or if the fault
  /// is in the file of the one before.
  const FaultFile* write_on_fault();
  /// Waits at most 2 s for pending text, and returns the incomplete files.
  std::vector<FileLoss> close();
  /// Files written by write_on_fault() so far.
  std::vector<FaultFile> fault_files() const {
    return fault_log_ ? fault_log_->files() : std::vector<FaultFile>{};
  }

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
