#include "platform/cli/run_loop.h"

#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <system_error>
#include <thread>

#include "platform/cli/status_line.h"
#include "platform/cli/stop_signals.h"
#include "platform/clock.h"

namespace godobject {
namespace {

// Of bus time; the rig's own boot_timeout_s is shorter and says which node.
constexpr double boot_limit_s = 10;
// About three seconds at 1 kHz: so long may the disk stall. Of long chains less.
constexpr std::size_t cycle_ring = 4096, frame_ring = 65536;
constexpr std::size_t cycle_ring_bytes = 64u << 20;
constexpr std::chrono::milliseconds drain_interval{10};

/// Frames straight to the files, while the thread that runs the wires may write.
BusObserver observer_into(RunFiles& files) {
  return {.on_frame =
              [](void* context, std::size_t bus, const ReceivedFrame& frame) {
                static_cast<RunFiles*>(context)->add(BusFrame{.bus = bus, .received = frame});
              },
          .context = &files};
}

BusObserver observer_into(Ring<BusFrame>& ring) {
  return {.on_frame =
              [](void* context, std::size_t bus, const ReceivedFrame& frame) {
                static_cast<void>(
                    static_cast<Ring<BusFrame>*>(context)->try_push({.bus = bus, .received = frame}));
              },
          .context = &ring};
}

Ring<CycleEntry> make_cycle_ring(const Session& session) {
  const CycleEntry entry = entry_of(session);
  const std::size_t bytes = sizeof entry + entry.record.bodies.size() * sizeof(BodyView);
  return Ring<CycleEntry>(std::min(cycle_ring, cycle_ring_bytes / bytes), entry);
}

void prepare(Session& session, RunFiles& files) {
  session.set_step_clock([]() noexcept { return MonotonicClock{}.now(); });
  if (files.wants_frames()) session.set_bus_observer(observer_into(files));
  files.add(session.at_start());
}

/// The ring's other end: to the files and the status line.
class Drain {
 public:
  Drain(Ring<CycleEntry>& cycles, Ring<BusFrame>& frames, RunFiles& files, bool quiet)
      : cycles_(cycles), frames_(frames), files_(files), status_(quiet) {}

  void run() {
    while (cycles_.try_pop(entry_)) {
      files_.add(entry_.record);
      status_.update(entry_.record, entry_.wake_ns);
    }
    while (frames_.try_pop(frame_)) files_.add(frame_);
  }
  void end() {
    run();
    status_.end();
  }

 private:
  Ring<CycleEntry>& cycles_;
  Ring<BusFrame>& frames_;
  RunFiles& files_;
  StatusLine status_;
  CycleEntry entry_;
  BusFrame frame_;
};

/// The real-time thread, once for every time the session is started, and this thread beside it.
class RealtimeRun {
 public:
  RealtimeRun(Session& session, const RunPlan& plan, RunFiles& files, const std::atomic<bool>& stop)
      : session_(session),
        files_(files),
        cycles_(make_cycle_ring(session)),
        frames_(frame_ring),
        drain_(cycles_, frames_, files, plan.quiet),
        quiet_(plan.quiet),
        cycle_(session, plan, stop, cycles_),
        loop_(clock_, to_ns(session.scene().step)) {}

  /// From start to end of the session. False where no thread can be started.
  bool run() {
    if (files_.wants_frames()) session_.set_bus_observer(observer_into(frames_));
    session_.start(boot_limit_s);
    ended_ = false;
    std::promise<std::vector<RtStep>> thread_setup;
    std::thread thread;
    try {
      thread = std::thread([&] {
        thread_setup.set_value(set_up_rt_thread());
        loop_.run(cycle_);
        ended_.store(true, std::memory_order_release);
      });
    } catch (const std::system_error&) {
      return false;
    }
    show(thread_setup.get_future().get());
    while (!ended_.load(std::memory_order_acquire)) {
      drain_.run();
      std::this_thread::sleep_for(drain_interval);
    }
    thread.join();
    drain_.end();
    if (files_.wants_frames()) session_.set_bus_observer(observer_into(files_));
    return true;
  }

  RunCycle& cycle() noexcept { return cycle_.cycle(); }
  void add_to(RunResult& result) const {
    result.setup = setup_;
    result.statistics = cycle_.statistics();
    result.timing = loop_.statistics();
    result.lost_cycles = cycles_.lost();
    result.lost_frames = frames_.lost();
  }

 private:
  /// Once: it is the same for each thread.
  void show(const std::vector<RtStep>& of_thread) {
    if (!setup_.empty()) return;
    setup_ = process_.steps();
    setup_.insert(setup_.end(), of_thread.begin(), of_thread.end());
    if (!quiet_) std::fputs(("real-time set-up\n" + rt_table(setup_)).c_str(), stderr);
  }

  Session& session_;
  RunFiles& files_;
  Ring<CycleEntry> cycles_;
  Ring<BusFrame> frames_;
  Drain drain_;
  bool quiet_;
  RtProcess process_;
  RealtimeCycle cycle_;
  MonotonicClock clock_;
  Cyclic<MonotonicClock> loop_;
  std::vector<RtStep> setup_;
  std::atomic<bool> ended_{false};
};

}  // namespace

RunResult run_fast(Session& session, const RunPlan& plan, RunFiles& files) {
  const StopSignals stop;
  RunResult result;
  prepare(session, files);
  RunCycle cycle(session, plan, stop.requested());
  Recoveries recoveries(session, cycle, plan, nullptr, stop.requested());
  const MonotonicClock clock;
  FastProgress progress(static_cast<double>(plan.num_cycles) * session.scene().step, plan.quiet);
  CycleRecord record = session.at_start();
  do {
    session.start(boot_limit_s);
    while (!cycle.ended()) {
      const Nanoseconds start = clock.now();
      if (!cycle.run(record)) continue;
      const Nanoseconds end = clock.now();
      result.timing.compute_ns.add(end - start);
      progress.update(record.t, end);
      files.add(record);
    }
  } while (recoveries.again());
  progress.end();
  result.statistics = cycle.statistics();
  result.recoveries = recoveries.list();
  result.ready = result.statistics.cycles > 0;
  result.stopped_by = stop.name();
  return result;
}

std::optional<RunResult> run_realtime(Session& session, const RunPlan& plan, RunFiles& files,
                                      const RunLink* real) {
  const StopSignals stop;
  RunResult result;
  prepare(session, files);
  if (real) result.not_set_up = bring_up(*real, stop.requested());
  result.stopped_by = stop.name();
  if (!result.not_set_up.empty() || stop.requested()) return result;
  const auto run = std::make_unique<RealtimeRun>(session, plan, files, stop.requested());
  Recoveries recoveries(session, run->cycle(), plan, real, stop.requested());
  do {
    if (!run->run()) return std::nullopt;
  } while (recoveries.again());
  run->add_to(result);
  result.recoveries = recoveries.list();
  result.ready = result.statistics.cycles > 0;
  result.stopped_by = stop.name();
  return result;
}

}  // namespace godobject
