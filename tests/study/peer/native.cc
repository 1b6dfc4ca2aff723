#include "tests/study/peer/native.h"

#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "tests/bench/contact_quality.h"
#include "tests/bench/peer/native_peers.h"
#include "tests/oracle/target.h"
#include "tests/study/case_errors.h"
#include "tests/study/joint/scene.h"
#include "tests/study/peer/own.h"
#include "tests/study/reference_solution.h"

namespace godobject::study {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double lost = 0.1;               // m: an engine with a larger error has failed, as in error.mjs
constexpr std::size_t timed_steps = 1000;  // of the start of a scene, over and over

using bench::FreePeer;
using bench::native_peers;

/// Returns the worst errors; infinite for an engine that failed.
Errors errors_of(const FreePeer& peer, const ReferenceScene& scene, const oracle::Solution& reference,
                 double h) {
  const std::size_t steps = steps_in(scene.duration, h);
  const bench::Targets targets = bench::targets_of(scene.problem, peer.aim, h, steps);
  const std::unique_ptr<bench::Peer> run = peer.make(scene.problem, targets, h);
  const auto every = static_cast<std::size_t>(std::lround(comparison_step / h));
  Errors worst;
  for (std::size_t n = 1; n <= steps; ++n) {
    run->step(n - 1);
    if (n % every != 0 || n / every >= reference.times.size()) continue;
    const std::vector<oracle::RigidState>& exact = reference.states[n / every];
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const oracle::RigidState x = run->pose(i);
      const double distance = (x.p - exact[i].p).norm();
      if (!(distance < lost))
        return {.position = infinite, .rotation = infinite, .energy = {}, .momentum = {}, .drift = {}};
      if (reference.times[n / every] < scene.from) continue;
      worst.position = std::max(worst.position, distance);
      worst.rotation = std::max(worst.rotation, angle_between(Quat(x.q), Quat(exact[i].q)));
    }
  }
  return worst;
}

/// A native peer on the start of a scene.
class PeerRun final : public TimedRun {
 public:
  PeerRun(const FreePeer& peer, const ReferenceScene& scene, double h)
      : num_steps_(std::min(timed_steps, steps_in(scene.duration, h))),
        targets_(bench::targets_of(scene.problem, peer.aim, h, num_steps_)),
        run_(peer.make(scene.problem, targets_, h)) {}

  std::size_t num_steps() const override { return num_steps_; }
  void restart() override { run_->restart(); }
  void advance(std::size_t first, std::size_t end) override {
    for (std::size_t n = first; n < end; ++n) run_->step(n);
  }

 private:
  std::size_t num_steps_;
  bench::Targets targets_;
  std::unique_ptr<bench::Peer> run_;
};

/// Returns the run that gives a row its native time; null if the row is of an engine in WASM or failed.
std::unique_ptr<TimedRun> timed_run(const PeerError& row, const ReferenceScene& scene) {
  if (!std::isfinite(row.position)) return nullptr;
  if (row.engine == ImplicitEuler::name || row.engine == TrBdf2::name)
    return own_timed_run(scene, row.engine, row.h, timed_steps);
  const auto peer = std::ranges::find(native_peers().free, row.engine, &FreePeer::engine);
  return peer == native_peers().free.end() ? nullptr : std::make_unique<PeerRun>(*peer, scene, row.h);
}

/// Returns the quality of a peer on a scene with contacts; its times go into the clock.
/// failed: set if a pose is not finite.
bench::ContactQuality quality_of(const bench::PressedPeer& peer, bench::ContactScene scene, StepClock& clock,
                                 bool& failed) {
  scene.duration = std::min(scene.duration, peer.longest);
  const std::size_t steps = steps_in(scene.duration, bench::h);
  const bench::Targets targets = bench::targets_of(scene);
  const std::unique_ptr<bench::ContactPeer> run = peer.make(scene, targets);
  return bench::quality_of(scene, steps, [&](std::size_t n) {
    clock.time([&] { run->step(n); });
    bench::Snapshot now{{}, run->num_contacts()};
    for (std::size_t i = 0; i < scene.problem.bodies.size(); ++i) {
      now.bodies.push_back(run->pose(i));
      failed = failed || !now.bodies.back().p.allFinite();
    }
    return now;
  });
}

/// Returns a run that runs once and then repeats its row: for peers that take minutes.
template <class Row>
std::function<Row()> once(std::function<Row()> run) {
  return [run, row = std::optional<Row>()]() mutable {
    if (!row) row = run();
    return *row;
  };
}

PeerContact contact_of(const bench::PressedPeer& peer, double k) {
  StepClock clock;
  bool failed = false;
  const bench::ContactQuality quality = quality_of(peer, bench::scene_s2(k), clock, failed);
  return {.engine = peer.engine,
          .k = k,
          .depth = failed ? infinite : quality.average.mean,
          .jitter = failed ? infinite : quality.average.jitter,
          .us_per_step = {},
          .native_us = clock.median_us()};
}

PeerPile pile_of(const bench::PressedPeer& peer, const bench::ContactScene& scene) {
  StepClock clock;
  bool failed = false;
  const bench::ContactQuality quality = quality_of(peer, scene, clock, failed);
  const bool is_short = peer.longest < scene.duration;
  return pile_row(
      peer.engine + (is_short ? " (first " + std::to_string(std::lround(peer.longest)) + " s)" : ""), quality,
      clock, failed);
}

PeerNet net_of(const bench::HangingPeer& peer) {
  const std::unique_ptr<bench::NetPeer> run = peer.make();
  run->restart();
  StepClock clock;
  for (std::size_t n = 0; n < net_steps; ++n) clock.time([&] { run->step(0); });  // its ball stays away
  return {.engine = peer.engine,
          .stretch = bench::stretch_error([&](std::uint32_t n) { return run->node(n); }),
          .us_per_step = {},
          .native_us = clock.median_us()};
}

PeerStability distance_of(const FreePeer& peer, const oracle::Case& problem, double k, double h,
                          double duration) {
  const std::size_t steps = steps_in(duration, h);
  const bench::Targets targets = bench::targets_of(problem, peer.aim, h, steps);
  const std::unique_ptr<bench::Peer> run = peer.make(problem, targets, h);
  PeerStability result{.engine = peer.engine, .k = k, .h = h};
  for (std::size_t n = 1; n <= steps; ++n) {
    run->step(n - 1);
    const Vec3 target = problem.bodies[0].coupling->target->at(static_cast<double>(n) * h).p;
    const double distance = (run->pose(0).p - target).norm();
    result.distance = std::isfinite(distance) ? std::max(result.distance, distance) : infinite;
    if (!(result.distance < lost)) return result;
  }
  return result;
}

}  // namespace

std::vector<PeerError> native_errors(const std::vector<ReferenceScene>& scenes,
                                     const std::vector<double>& steps, const Progress& progress) {
  std::vector<PeerError> rows;
  for (const ReferenceScene& scene : scenes) {
    const oracle::Solution reference = reference_of(scene);
    for (const FreePeer& peer : native_peers().free) {
      if (!peer.can(scene.problem)) continue;
      progress("peers: " + scene.name + ", " + peer.engine);
      for (const double h : steps) {
        const Errors worst = errors_of(peer, scene, reference, h);
        rows.push_back({.scene = scene.name,
                        .engine = peer.engine,
                        .h = h,
                        .position = worst.position,
                        .rotation = worst.rotation,
                        .us_per_step = {}});
      }
    }
  }
  return rows;
}

void add_native_times(const std::vector<ReferenceScene>& scenes, bool quick, const Progress& progress,
                      std::vector<PeerError>& rows) {
  for (const ReferenceScene& scene : scenes) {
    progress("peers: " + scene.name + ", native times");
    std::vector<std::unique_ptr<TimedRun>> runs;
    std::vector<PeerError*> timed;
    for (PeerError& row : rows) {
      if (row.scene != scene.name) continue;
      std::unique_ptr<TimedRun> run = timed_run(row, scene);
      if (run == nullptr) continue;
      runs.push_back(std::move(run));
      timed.push_back(&row);
    }
    const std::vector<double> times = interleaved_us(runs, quick ? 5 : 41, 1e-3);
    for (std::size_t i = 0; i < timed.size(); ++i) timed[i]->native_us = times[i];
  }
}

std::vector<double> interleaved_us(const std::vector<std::unique_ptr<TimedRun>>& runs, int rounds,
                                   double block_s) {
  struct Progressed {
    std::size_t next = 0, block = 1;
    std::vector<double> times_us;
  };
  std::vector<Progressed> all(runs.size());
  const auto time_block = [&](std::size_t i) {
    Progressed& run = all[i];
    if (run.next + run.block > runs[i]->num_steps()) run.next = 0;
    if (run.next == 0) runs[i]->restart();
    StepClock clock;
    clock.time([&] { runs[i]->advance(run.next, run.next + run.block); });
    run.next += run.block;
    return clock.median_us() / static_cast<double>(run.block);
  };
  for (std::size_t i = 0; i < runs.size(); ++i) {  // first touch, then the size of a block
    all[i].block = std::min<std::size_t>(8, runs[i]->num_steps());
    time_block(i);
    const double steps = 1e6 * block_s / time_block(i);
    all[i].block =
        static_cast<std::size_t>(std::clamp(steps, 1.0, static_cast<double>(runs[i]->num_steps())));
    all[i].next = 0;
  }
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < runs.size(); ++i) all[i].times_us.push_back(time_block(i));
  std::vector<double> medians;
  for (Progressed& run : all) medians.push_back(median_of(std::move(run.times_us)));
  return medians;
}

Runs<PeerContact> native_contacts(const std::vector<double>& stiffnesses) {
  Runs<PeerContact> runs;
  for (const double k : stiffnesses)
    for (const bench::PressedPeer& peer : native_peers().pressed)
      if (peer.can(bench::scene_s2(k))) runs.emplace_back([&peer, k] { return contact_of(peer, k); });
  return runs;
}

Runs<PeerPile> native_piles() {
  const bench::ContactScene scene = bench::scene_s4(64, 20);
  Runs<PeerPile> runs;
  for (const bench::PressedPeer& peer : native_peers().pressed)
    if (peer.can(scene)) {
      const std::function<PeerPile()> run = [&peer, scene] { return pile_of(peer, scene); };
      runs.push_back(peer.longest < scene.duration ? once(run) : run);
    }
  return runs;
}

Runs<PeerNet> native_nets() {
  Runs<PeerNet> runs;
  for (const bench::HangingPeer& peer : native_peers().hanging) {
    const std::function<PeerNet()> run = [&peer] { return net_of(peer); };
    runs.push_back(peer.is_slow ? once(run) : run);
  }
  return runs;
}

std::vector<PeerStability> native_stability(const std::vector<double>& stiffnesses,
                                            const std::vector<double>& steps, double duration) {
  const oracle::Case first = scene_s1().problem;
  std::vector<PeerStability> rows;
  for (const double k : stiffnesses) {
    const oracle::Case problem = stiffened(first, k / first.bodies[0].coupling->k_t);
    for (const double h : steps)
      for (const FreePeer& peer : native_peers().free)
        if (peer.can(problem)) rows.push_back(distance_of(peer, problem, k, h, duration));
  }
  return rows;
}

}  // namespace godobject::study
