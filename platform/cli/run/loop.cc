#include "platform/cli/run/loop.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <future>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

#include "platform/cli/report/console.h"
#include "platform/rig/buses.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/loop_calls.h"
#include "platform/rt/signals.h"
#include "platform/rt/stop_key.h"

namespace godobject {
namespace {

// About three seconds at 1 kHz, so that the disk may stall for this time; less for long chains.
constexpr std::size_t cycle_ring = 4096, frame_ring = 65536;
constexpr std::size_t cycle_ring_bytes = 64u << 20;
constexpr std::size_t state_ring = 4;  // there is a state each second, or more often
constexpr std::size_t link_ring = 65536;
constexpr std::chrono::milliseconds drain_interval{10};
// Interval in runs that a page slows down, shorter than a step.
constexpr std::chrono::microseconds paused_interval{200};
// Text kept for a blocked terminal or pipe, and the time to wait for it at the end.
constexpr std::size_t console_bytes = 1 << 16;
constexpr std::chrono::milliseconds console_patience{500};

/// Returns an observer that writes frames to the files directly: only in a thread that may write.
BusObserver observer_into(RunFiles& files) {
  return {.on_frame =
              [](void* context, std::size_t bus, const ReceivedFrame& frame) {
                const loop::MayWait scope;
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
  const std::size_t bytes =
      sizeof entry + entry.record.bodies.size() * sizeof(BodyView) +
      entry.record.touching.size() * sizeof(ContactView) + entry.record.net_nodes.size() * sizeof(Vec3) +
      entry.record.targets.size() * sizeof(TargetSample) + entry.record.samples.size() * sizeof(BodySample) +
      (entry.record.joint_q.size() + entry.record.device_q.size() + 2 * entry.record.drive_torque.size()) *
          sizeof(double);
  return Ring<CycleEntry>(std::min(cycle_ring, cycle_ring_bytes / bytes), entry);
}

void prepare(Session& session, RunFiles& files) {
  session.set_stage_clock([]() noexcept GODOBJECT_NONBLOCKING { return MonotonicClock{}.now(); });
  if (files.wants_frames()) session.set_bus_observer(observer_into(files));
  list_recorded(files.names(), session);
  files.start(session);
}

/// Writes the seconds before each fault, and prints the file's name.
void keep_faults(RunFiles& files, RunEvents& events) {
  events.at_faults([&files, &events](const RunEvent& fault) {
    const FaultFile* const file = files.write_on_fault();
    if (file == nullptr) return;
    std::array<char, 48> kept{"the boot before it is"};
    if (file->kept_s > 0)
      std::snprintf(kept.data(), kept.size(), "the last %.3g s before it are", file->kept_s);
    const std::string bound =
        file->is_bounded ? " (" + std::to_string(LastChunks::max_bytes >> 20) + " MB hold no more)" : "";
    const bool is_last = files.fault_files().size() == FaultLog::max_files;
    events.tell(RunEventKind::kept, fault.t_s, std::string(kept.data()) + " kept in " + file->path + bound,
                is_last ? "no further file is written" : "godobject replay repeats them");
  });
}

/// Returns a ring of states, with one slot of no size unless an input log is written.
Ring<EngineState> make_state_ring(const Session& session, const RunFiles& files) {
  if (!files.wants_inputs()) return Ring<EngineState>(1, EngineState{});
  return Ring<EngineState>(state_ring, state_of(session));
}

/// Inputs of the rig on their way to the input logs.
class LinkEvents {
 public:
  LinkEvents(Session& session, RunFiles& files)
      : session_(session),
        files_(files),
        ring_(files.wants_inputs() && session.rig() != nullptr ? link_ring : 1),
        event_(ring_.record()) {
    if (ring_.capacity() == 1) return;
    session.record_rig({.push =
                            [](void* context, const LinkEvent& event) noexcept GODOBJECT_NONBLOCKING {
                              return static_cast<Ring<LinkEvent>*>(context)->try_push(event);
                            },
                        .context = &ring_});
  }
  ~LinkEvents() { session_.record_rig({}); }
  LinkEvents(const LinkEvents&) = delete;
  LinkEvents& operator=(const LinkEvents&) = delete;

  /// Moves the events to the files. A row is added after its own events.
  void drain() {
    while (ring_.try_pop(event_)) files_.add(event_);
  }

 private:
  Session& session_;
  RunFiles& files_;
  Ring<LinkEvent> ring_;
  LinkEvent event_;
};

/// Prints once that a signal ends the run, and once that a second one, the space bar or a broken seal stops
/// the motors.
class StopNotices {
 public:
  /// seal: null for a run without one.
  StopNotices(const StopSignals& signals, RunEvents& events, const Seal* seal = nullptr)
      : signals_(signals), events_(events), seal_(seal) {}

  void look(double t_s) {
    if (signals_.requested() && !signals_.key_pressed() && !std::exchange(announced_, true))
      events_.tell(RunEventKind::stop, t_s,
                   std::string(signals_.name()) + ": the torque runs down, then the drives are turned off",
                   "send it again for a quick stop");
    if (signals_.insisted() && !std::exchange(insisted_, true))
      events_.tell(RunEventKind::quick_stop, t_s,
                   std::string(signals_.key_pressed() ? "space bar" : "second signal") +
                       ": QUICK STOP, the torque is cut at once",
                   "");
    if (!seal_ || !seal_->is_broken() || std::exchange(broken_, true)) return;
    const FaultText& broken = text_of(RunFault::seal_broken);
    events_.tell(RunEventKind::run_fault, t_s, seal_->text(), std::string(broken.remedy),
                 std::string(broken.name));
    events_.tell(RunEventKind::quick_stop, t_s, "broken seal: QUICK STOP, the torque is cut at once", "");
  }

 private:
  const StopSignals& signals_;
  RunEvents& events_;
  const Seal* seal_;
  bool announced_ = false, insisted_ = false, broken_ = false;
};

/// Moves cycles, states and frames from the rings to the files, the status line and the console.
class Drain {
 public:
  Drain(Ring<CycleEntry>& cycles, Ring<EngineState>& states, Ring<BusFrame>& frames, LinkEvents& links,
        RunFiles& files, RunEvents& events, const StopSignals& signals, const Seal* seal,
        BackgroundFile& console, bool quiet)
      : cycles_(cycles),
        states_(states),
        links_(links),
        frames_(frames),
        files_(files),
        events_(events),
        notices_(signals, events, seal),
        status_(console, quiet),
        entry_(cycles.record()),
        state_(states.record()) {}

  void run() {
    notices_.look(t_s_);
    events_.drain();
    while (cycles_.try_pop(entry_)) {
      t_s_ = entry_.record.t;
      links_.drain();
      if (files_.wants_inputs()) add_state_before(entry_.record.cycle);
      files_.add(entry_.record);
      status_.update(entry_.record, entry_.wake_ns);
    }
    while (frames_.try_pop(frame_)) files_.add(frame_);
    links_.drain();
  }
  void end() {
    run();
    status_.end();
  }

 private:
  /// Adds the state after the previous cycle, if there is one. Its ring receives it before the row of this
  /// cycle.
  void add_state_before(std::uint64_t cycle) {
    while (state_.cycle + 1 < cycle)
      if (!states_.try_pop(state_)) return;
    if (state_.cycle > 0 && state_.cycle + 1 == cycle) files_.add(state_);
  }

  Ring<CycleEntry>& cycles_;
  Ring<EngineState>& states_;
  LinkEvents& links_;
  Ring<BusFrame>& frames_;
  RunFiles& files_;
  RunEvents& events_;
  StopNotices notices_;
  StatusLine status_;
  double t_s_ = 0;  // time of the latest cycle
  CycleEntry entry_;
  EngineState state_;  // latest one
  BusFrame frame_;
};

/// Runs the real-time thread, once per start of the session, with this thread draining its rings.
class RealtimeRun {
 public:
  /// real: null for simulated buses.
  RealtimeRun(Session& session, const RunPlan& plan, RunFiles& files, const StopSignals& signals,
              RunEvents& events, BackgroundFile& console, const RigOnBuses* real)
      : session_(session),
        files_(files),
        signals_(signals),
        console_(console),
        real_(real),
        cycles_(make_cycle_ring(session)),
        states_(make_state_ring(session, files)),
        frames_(frame_ring),
        links_(session, files),
        seal_(plan.seal ? std::make_unique<Seal>() : nullptr),
        drain_(cycles_, states_, frames_, links_, files, events, signals, seal_.get(), console, plan.quiet),
        quiet_(plan.quiet),
        thread_(plan.thread),
        process_({}, thread_),
        watch_(events.ring()),
        cycle_(session, plan, signals.requested(), cycles_, files.wants_inputs() ? &states_ : nullptr),
        loop_(clock_, to_ns(session.scene().step)) {
    cycle_.cycle().quick_stop_on(signals.insisted());
    cycle_.cycle().tell(watch_);
    if (seal_) cycle_.cycle().quick_stop_on(*seal_);
  }

  /// Runs the session from start to end. Returns false if no thread can be started.
  bool run() {
    if (files_.wants_frames()) session_.set_bus_observer(observer_into(frames_));
    session_.start(usual_boot_limit_s);
    ended_ = false;
    std::optional<LastResort> last_resort;
    if (real_) last_resort.emplace(last_words(real_->rig, real_->cycle_s, real_->link));
    std::promise<std::vector<RtStep>> thread_setup;
    std::thread thread;
    try {
      thread = std::thread([&] { run_loop(thread_setup); });
    } catch (const std::system_error&) {
      return false;
    }
    try {
      show(thread_setup.get_future().get());
      while (!ended_.load(std::memory_order_acquire)) {
        drain_.run();
        std::this_thread::sleep_for(drain_interval);
      }
    } catch (...) {  // stop the motors and the loop before the exception continues
      signals_.request();
      thread.join();
      throw;
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
    result.page_faults = cycle_.page_faults();
    result.first_page_fault = cycle_.first_page_fault();
    if (!seal_) return;
    result.seal_broken = seal_->text();
    result.refused_calls = seal_->num_refused();
  }

 private:
  void run_loop(std::promise<std::vector<RtStep>>& thread_setup) {
    const ThreadSetup setup("loop");
    try {
      std::vector<RtStep> steps = set_up_rt_thread({}, thread_);
      if (seal_) steps.push_back(seal_->close());
      const bool is_ready = !seal_ || steps.back().result == RtResult::ok;
      thread_setup.set_value(std::move(steps));
      if (is_ready) loop_.run(cycle_);
      cycle_.thread_ends();
      if (seal_) seal_->loop_ended();
    } catch (...) {  // thrown before the loop, which throws nothing
      thread_setup.set_exception(std::current_exception());
    }
    ended_.store(true, std::memory_order_release);
  }

  /// Prints the set-up once, because it is equal for each thread.
  void show(const std::vector<RtStep>& of_thread) {
    if (!setup_.empty()) return;
    setup_ = process_.steps();
    setup_.insert(setup_.end(), of_thread.begin(), of_thread.end());
    if (!quiet_) static_cast<void>(console_.write("real-time set-up\n" + rt_table(setup_)));
  }

  Session& session_;
  RunFiles& files_;
  const StopSignals& signals_;
  BackgroundFile& console_;
  const RigOnBuses* real_;
  Ring<CycleEntry> cycles_;
  Ring<EngineState> states_;
  Ring<BusFrame> frames_;
  LinkEvents links_;
  std::unique_ptr<Seal> seal_;  // null without --seal
  Drain drain_;
  bool quiet_;
  RtThreadPlan thread_;
  RtProcess process_;
  EventWatch watch_;
  RealtimeCycle cycle_;
  MonotonicClock clock_;
  Cyclic<MonotonicClock> loop_;
  std::vector<RtStep> setup_;
  std::atomic<bool> ended_{false};
};

void finish(RunResult& result, const RunCycle& cycle, const StopSignals& stop, const Recoveries& recoveries,
            RunEvents& events, BackgroundFile& console) {
  events.drain();
  result.recoveries = recoveries.list();
  result.events = events.list();
  result.lost_events = events.left_out();
  result.ready = result.statistics.cycles > 0;
  result.stopped_by = stop.name();
  result.is_reset = cycle.is_reset();
  result.lost_console_lines = console.close(BackgroundFile::Clock::now() + console_patience).lost_lines;
}

}  // namespace

RunResult run_fast(Session& session, const RunPlan& plan, RunFiles& files) {
  const StopSignals stop(Suspension::stops);
  BackgroundFile console(STDERR_FILENO, console_bytes);
  RunEvents events(session, console);
  StopNotices notices(stop, events);
  RunResult result;
  prepare(session, files);
  keep_faults(files, events);
  LinkEvents links(session, files);
  EventWatch watch(events.ring());
  RunCycle cycle(session, plan, stop.requested());
  cycle.quick_stop_on(stop.insisted());
  cycle.tell(watch);
  Recoveries recoveries(session, cycle, plan, nullptr, stop.requested(), events);
  const MonotonicClock clock;
  FastProgress progress(console, static_cast<double>(plan.num_cycles) * session.scene().step, plan.quiet);
  CycleRecord record = session.at_start();
  EngineState state = state_of(session);
  const std::uint64_t state_every = cycles_between_states(session.scene().step);
  do {
    session.start(usual_boot_limit_s);
    while (!cycle.ended()) {
      notices.look(record.t);
      if (!cycle.may_run(record)) {
        std::this_thread::sleep_for(paused_interval);
        continue;
      }
      const Nanoseconds start = clock.now();
      const bool stepped = cycle.run(record);
      const Nanoseconds end = clock.now();
      if (stepped) cycle.end_stages();
      links.drain();
      events.drain();
      if (!stepped) continue;
      result.timing.cycle_ns.add(end - start);
      progress.update(record.t, end);
      files.add(record);
      if (!files.wants_inputs() || record.cycle % state_every != 0) continue;
      state.cycle = record.cycle;
      take_state(session, state);
      files.add(state);
    }
  } while (!cycle.is_reset() && recoveries.again());
  progress.end();
  result.statistics = cycle.statistics();
  finish(result, cycle, stop, recoveries, events, console);
  return result;
}

std::optional<RunResult> run_realtime(Session& session, const RunPlan& plan, RunFiles& files,
                                      const RigOnBuses* real) {
  const StopSignals stop(Suspension::stops);
  BackgroundFile console(STDERR_FILENO, console_bytes);
  RunEvents events(session, console);
  RunResult result;
  const StopKey key(stop);
  if (key.works() && !plan.quiet) static_cast<void>(console.write("emergency stop: press the space bar\n"));
  files.set_patience(std::chrono::milliseconds(0));
  prepare(session, files);
  keep_faults(files, events);
  if (real) result.not_set_up = bring_up(*real, stop.requested());
  result.stopped_by = stop.name();
  if (!result.not_set_up.empty() || stop.requested()) return result;
  const auto run = std::make_unique<RealtimeRun>(session, plan, files, stop, events, console, real);
  Recoveries recoveries(session, run->cycle(), plan, real, stop.requested(), events);
  do {
    if (!run->run()) return std::nullopt;
  } while (!run->cycle().is_reset() && recoveries.again());
  run->add_to(result);
  finish(result, run->cycle(), stop, recoveries, events, console);
  return result;
}

}  // namespace godobject
