// The files a run fills while it goes: trace and bus log, each only where asked for.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "platform/cli/bus/candump_log.h"
#include "platform/rt/background_file.h"
#include "platform/session/session.h"
#include "platform/trace/contacts.h"
#include "platform/trace/nets.h"
#include "platform/trace/trace.h"

namespace godobject {

/// What a run is asked to write while it goes.
struct RunFileNames {
  std::string trace, contacts, nets, record;
  std::uint64_t trace_every =
      1;  // of trace and contacts: every so many rows, and where a fault comes up or ends
  std::uint64_t nets_every = 40;  // of nets: every so many rows
};

/// A file that lacks something.
struct FileLoss {
  std::string path;
  std::string why;               // empty: the writer of a real-time run was too slow
  std::uint64_t lost_lines = 0;  // as far as known
};

class RunFiles {
 public:
  /// Empty paths: not wanted. log_origin_ns is added to the times of frames.
  RunFiles(const RunFileNames& names, const SceneConfig& scene, Nanoseconds log_origin_ns);

  bool wants_contacts() const noexcept { return contacts_.has_value(); }
  bool wants_net_nodes() const noexcept { return nets_.has_value(); }
  bool wants_frames() const noexcept { return record_ != nullptr; }
  void add(const CycleRecord& record);
  void add(const BusFrame& frame) {
    if (!record_) return;
    BusFrame logged = frame;
    logged.received.t_ns += log_origin_ns_;
    record_->add(logged);
  }
  /// How long add() waits for a file that takes nothing before it gives it up; 0: it waits for none, and leaves out what
  /// finds no room. At first 2 s.
  void set_patience(std::chrono::milliseconds patience) noexcept { patience_ = patience; }
  /// Waits for what is left, 2 s at most, and names the files that are not complete.
  std::vector<FileLoss> close();

 private:
  void add_start();
  void write(const CycleRecord& record);
  bool is_kept(const CycleRecord& record) noexcept;
  void add_row(const CycleRecord& record);

  RunFileNames names_;
  Nanoseconds log_origin_ns_;
  std::vector<std::size_t> driven_, children_;  // bodies with a target; of each joint
  std::vector<TraceBody> bodies_;               // the row being written
  std::vector<TraceDriven> pulls_;
  std::vector<Wrench> joints_;
  std::optional<CycleRecord> start_;  // waits for the time at which the motion starts
  std::uint64_t num_rows_ = 0;        // so far, with those that were left out
  Fault fault_ = Fault::none;         // of the row before
  RigFault rig_faults_ = RigFault::none;
  std::chrono::milliseconds patience_{2000};
  std::optional<BackgroundFile> trace_file_, contacts_file_, nets_file_, record_file_;
  std::optional<TraceWriter> trace_;
  std::optional<ContactTraceWriter> contacts_;
  std::optional<NetTraceWriter> nets_;
  std::shared_ptr<CandumpLog> record_;  // of the thread that writes it, too
};

}  // namespace godobject
