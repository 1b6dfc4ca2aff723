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

constexpr double boot_limit_s =
    10;  // of bus time; the rig's own boot_timeout_s is shorter and says which node
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

/// To the point where the first cycle can run, in this thread.
bool boot(Session& session, RunFiles& files) {
  session.set_step_clock([]() noexcept { return MonotonicClock{}.now(); });
  if (files.wants_frames()) session.set_bus_observer(observer_into(files));
  if (!session.boot(boot_limit_s)) {
    session.shut_down();
    return false;
  }
  files.add(session.at_start());
  return true;
}

/// In this thread: the simulated buses have a clock of their own.
void shut_down(Session& session, RunFiles& files) {
  if (files.wants_frames()) session.set_bus_observer(observer_into(files));
  session.shut_down();
}

/// The ring's other end: to the files and the status line.
class Drain {
 public:
  Drain(Ring<CycleEntry>& cycles, Ring<BusFrame>& frames, RunFiles& files)
      : cycles_(cycles), frames_(frames), files_(files) {}

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

}  // namespace

RunResult run_fast(Session& session, std::uint64_t num_cycles, RunFiles& files) {
  const StopSignals stop;
  RunResult result;
  result.ready = boot(session, files);
  if (!result.ready) return result;
  const MonotonicClock clock;
  CycleRecord record;
  for (std::uint64_t i = 0; i < num_cycles && !stop.requested(); ++i) {
    const Nanoseconds start = clock.now();
    session.cycle(record);
    result.timing.compute_ns.add(clock.now() - start);
    result.statistics.add(record);
    files.add(record);
  }
  session.shut_down();
  result.stopped_by = stop.name();
  return result;
}

std::optional<RunResult> run_realtime(Session& session, std::uint64_t num_cycles, RunFiles& files) {
  const StopSignals stop;
  RunResult result;
  result.ready = boot(session, files);
  if (!result.ready) return result;
  Ring<CycleEntry> cycles = make_cycle_ring(session);
  Ring<BusFrame> frames(frame_ring);
  if (files.wants_frames()) session.set_bus_observer(observer_into(frames));

  const RtProcess process;
  RealtimeCycle cycle(session, num_cycles, stop.requested(), cycles);
  MonotonicClock clock;
  const auto loop = std::make_unique<Cyclic<MonotonicClock>>(clock, std::llround(1e9 * session.scene().step));
  std::promise<std::vector<RtStep>> thread_setup;
  std::atomic<bool> ended{false};
  std::thread thread;
  try {
    thread = std::thread([&] {
      thread_setup.set_value(set_up_rt_thread());
      loop->run(cycle);
      ended.store(true, std::memory_order_release);
    });
  } catch (const std::system_error&) {
    shut_down(session, files);
    return std::nullopt;
  }

  result.setup = process.steps();
  for (RtStep& step : thread_setup.get_future().get()) result.setup.push_back(std::move(step));
  std::fputs(("real-time set-up\n" + rt_table(result.setup)).c_str(), stderr);
  Drain drain(cycles, frames, files);
  while (!ended.load(std::memory_order_acquire)) {
    drain.run();
    std::this_thread::sleep_for(drain_interval);
  }
  thread.join();
  drain.end();
  shut_down(session, files);
  result.stopped_by = stop.name();
  result.statistics = cycle.statistics();
  result.timing = loop->statistics();
  result.lost_cycles = cycles.lost();
  result.lost_frames = frames.lost();
  return result;
}

}  // namespace godobject
