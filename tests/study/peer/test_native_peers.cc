#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/bench/peer/native_peers.h"
#include "tests/oracle/target.h"
#include "tests/study/peer/native.h"

namespace godobject::study::test_native_peers {
namespace {

using bench::native_peers;

bool is_missing(const std::string& engine) {
  return native_peers().missing.find(engine) != std::string::npos;
}

TEST(NativePeers, AreInTheListOrNamedAsMissing) {
  std::set<std::string> names;
  for (const bench::FreePeer& peer : native_peers().free) {
    EXPECT_TRUE(names.insert(peer.engine).second) << peer.engine;
    EXPECT_EQ(peer.engine.find(','), std::string::npos) << "a field of a CSV file ends there";
  }
  for (const std::string engine : {"ODE", "Bullet", "MuJoCo", "Simbody"}) {
    const bool is_listed =
        std::ranges::any_of(names, [&](const std::string& name) { return name.starts_with(engine); });
    EXPECT_NE(is_listed, is_missing(engine)) << engine;
  }
}

TEST(NativePeers, ReceiveTheTargetAtTheirInstant) {
  const oracle::Case problem = scene_s1().problem;
  const oracle::Target& target = *problem.bodies[0].coupling->target;
  constexpr double h = 2e-3;
  const auto second = [&](const bench::Aim& aim) { return bench::targets_of(problem, aim, h, 2)[1][0]; };
  EXPECT_EQ(second({}).p, target.at(2 * h).p);
  EXPECT_EQ(second({.share = 0}).v, target.at(h).v);
  EXPECT_EQ(second({.share = 0.5}).p, target.at(1.5 * h).p);
  EXPECT_EQ(second({.mean = true}).p, target.at(2 * h).p);
  EXPECT_LT((second({.mean = true}).v - (target.at(2 * h).p - target.at(h).p) / h).norm(), 1e-12);
  EXPECT_EQ(second({.mean = true}).w, target.at(1.5 * h).w);
  EXPECT_TRUE(bench::targets_of(reference_chain().problem, {}, h, 2).empty());
}

/// S1, S3 and S5 for a short while.
std::vector<ReferenceScene> short_scenes() {
  std::vector<ReferenceScene> scenes{scene_s1(), reference_s3(), reference_chain()};
  for (ReferenceScene& scene : scenes) scene.duration = std::min(scene.duration, 0.6);
  return scenes;
}

/// A peer on a scene: order of convergence between steps of 0.5 and 0.25 ms, bound of the error at 0.5 ms.
struct Expected {
  const char *engine, *scene;
  double order, position;
};

constexpr Expected expected[] = {{"ODE 0.16 motor rows", "S1", 1, 1.2e-5},
                                 {"ODE 0.16 motor rows (mean velocity)", "S1", 1, 6e-7},
                                 {"ODE 0.16 explicit force", "S1", 1, 1.2e-5},
                                 {"ODE 0.16 motor rows", "S3", 1, 1e-5},
                                 {"ODE 0.16 motor rows", "S5", 1, 6e-4},
                                 {"Bullet 3.24 multibody", "S1", 1, 6e-7},
                                 {"Bullet 3.24 multibody", "S5", 1, 8e-4},
                                 {"Bullet 3.24 rigid 50 it", "S1", 1, 6e-7},
                                 {"Bullet 3.24 rigid 50 it", "S3", 1, 2e-3},
                                 {"Bullet 3.24 rigid 50 it", "S5", 1, 6e-4},
                                 {"Bullet 3.24 rigid direct", "S5", 1, 6e-4},
                                 {"MuJoCo 2.2 Euler", "S1", 1, 1.2e-5},
                                 {"MuJoCo 2.2 Euler", "S5", 1, 8e-4},
                                 {"MuJoCo 2.2 implicit", "S1", 1, 1.2e-5},
                                 {"MuJoCo 2.2 implicit", "S3", 1, 6e-6},
                                 {"MuJoCo 2.2 implicit", "S5", 1, 6e-4},
                                 {"MuJoCo 2.2 RK4 (mid-step target)", "S1", 2, 4e-8},
                                 {"MuJoCo 2.2 RK4 (mid-step target)", "S5", 4, 1e-10},
                                 {"Simbody 3.7 Merson", "S5", 4, 2e-11}};

/// Explicit methods on the roll of S3, which decays at 4e4 1/s.
constexpr const char* too_stiff[] = {"MuJoCo 2.2 Euler", "MuJoCo 2.2 RK4 (mid-step target)",
                                     "Simbody 3.7 Merson"};

bool is_too_stiff(const std::string& engine) {
  return std::ranges::find(too_stiff, engine) != std::end(too_stiff);
}

/// Every peer starts where the scene starts, and has its target.
TEST(NativePeers, ConvergeToTheReference) {
  if (native_peers().free.empty()) GTEST_SKIP() << "missing: " << native_peers().missing;
  const std::vector<PeerError> rows =
      native_errors(short_scenes(), {0.5e-3, 0.25e-3}, [](const std::string&) {});
  for (const Expected& e : expected) {
    SCOPED_TRACE(std::string(e.engine) + ", " + e.scene);
    if (is_missing(std::string(e.engine).substr(0, std::string(e.engine).find(' ')))) continue;
    const PeerError* const coarse = find_row(rows, e.scene, e.engine, 0.5e-3);
    const PeerError* const fine = find_row(rows, e.scene, e.engine, 0.25e-3);
    ASSERT_TRUE(coarse != nullptr && fine != nullptr);
    EXPECT_LT(coarse->position, e.position);
    EXPECT_NEAR(std::log2(coarse->position / fine->position), e.order, 0.2);
  }
  for (const PeerError& r : rows) {
    SCOPED_TRACE(r.engine + ", " + r.scene);
    EXPECT_EQ(std::isinf(r.position), r.scene == "S3" && is_too_stiff(r.engine));
    if (r.engine == "Simbody 3.7 CPodes" && r.scene != "S5") {
      EXPECT_LT(r.position, 1e-8);
    }
  }
}

TEST(NativePeers, RepeatTheirRunAfterARestart) {
  for (const ReferenceScene& scene : short_scenes())
    for (const bench::FreePeer& peer : native_peers().free) {
      if (!peer.can(scene.problem) || (scene.name == "S3" && is_too_stiff(peer.engine))) continue;
      constexpr std::size_t steps = 50;
      constexpr double h = 0.25e-3;
      const bench::Targets targets = bench::targets_of(scene.problem, peer.aim, h, steps);
      const std::unique_ptr<bench::Peer> run = peer.make(scene.problem, targets, h);
      std::vector<Vec3> ends;
      for (int repeat = 0; repeat < 2; ++repeat) {
        run->restart();
        for (std::size_t n = 0; n < steps; ++n) run->step(n);
        ends.push_back(run->pose(0).p);
      }
      EXPECT_LT((ends[0] - ends[1]).norm(), 1e-12) << scene.name << ", " << peer.engine;
    }
}

/// An engine that ends the program, or repeats its start, would hide a failure.
TEST(NativePeers, ReportAFailureAtAStepThatIsTooLong) {
  ReferenceScene scene = scene_s1();
  scene.duration = 2;
  for (const PeerError& r : native_errors({scene}, {4e-3}, [](const std::string&) {})) {
    SCOPED_TRACE(r.engine);
    if (r.engine == "ODE 0.16 explicit force" || r.engine.starts_with("MuJoCo 2.2 RK4")) {
      EXPECT_TRUE(std::isinf(r.position) && std::isinf(r.rotation));
    }
  }
}

TEST(NativePeers, ReportAFailureOfAStiffSpring) {
  for (const PeerStability& r : native_stability({1e6}, {2e-3}, 0.5)) {
    SCOPED_TRACE(r.engine);
    const bool is_implicit = r.engine.starts_with("ODE 0.16 motor rows") || r.engine.starts_with("Bullet") ||
                             r.engine == "Simbody 3.7 CPodes";
    EXPECT_EQ(r.distance < 1e-3, is_implicit) << r.distance;
  }
}

TEST(NativePeers, ArePressedAsDeepAsTheLawHasIt) {
  for (const auto& run : native_contacts({1e4})) {
    const PeerContact row = run();
    SCOPED_TRACE(row.engine);
    EXPECT_GT(row.depth, -1e-4);
    EXPECT_LT(row.depth, 2e-3);
    EXPECT_GT(row.native_us.value(), 0);
    if (row.engine == "ODE 0.16 step with spring contacts") {
      EXPECT_NEAR(row.depth, 1e-4, 1e-6);
    }
  }
}

TEST(NativePeers, HangTheNet) {
  for (const bench::HangingPeer& peer : native_peers().hanging) {
    if (peer.is_slow) continue;
    const std::unique_ptr<bench::NetPeer> net = peer.make();
    net->restart();
    for (int n = 0; n < 20; ++n) net->step(0);
    EXPECT_LT(bench::stretch_error([&](std::uint32_t n) { return net->node(n); }), 0.5) << peer.engine;
  }
}

class CountedRun final : public TimedRun {
 public:
  explicit CountedRun(std::size_t num_steps) : num_steps_(num_steps) {}
  std::size_t num_steps() const override { return num_steps_; }
  void restart() override { next = 0; }
  void advance(std::size_t first, std::size_t end) override {
    EXPECT_EQ(first, next) << "steps follow each other";
    EXPECT_LE(end, num_steps_);
    EXPECT_LT(first, end);
    next = end;
    ++blocks;
  }

  std::size_t next = 0;
  int blocks = 0;

 private:
  std::size_t num_steps_;
};

TEST(InterleavedTimes, TakeStepsInOrderAndAsManyBlocksOfEachRun) {
  std::vector<std::unique_ptr<TimedRun>> runs;
  std::vector<CountedRun*> counted;
  for (const std::size_t steps : {1u, 7u, 1000u}) {
    auto run = std::make_unique<CountedRun>(steps);
    counted.push_back(run.get());
    runs.push_back(std::move(run));
  }
  const std::vector<double> times = interleaved_us(runs, 10, 1e-6);
  ASSERT_EQ(times.size(), 3u);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_EQ(counted[i]->blocks, counted[0]->blocks);
    EXPECT_GE(counted[i]->blocks, 10);
    EXPECT_GE(times[i], 0);
  }
}

TEST(InterleavedRuns, KeepTheFastestOfEach) {
  int calls = 0;
  const auto row = [&](const char* engine, double first, double second) {
    return [=, &calls, round = 0]() mutable {
      ++calls;
      return PeerNet{
          .engine = engine, .stretch = 0, .us_per_step = {}, .native_us = round++ == 0 ? first : second};
    };
  };
  const std::vector<PeerNet> rows = interleaved(Runs<PeerNet>{row("a", 2, 1), row("b", 3, 4)}, 2);
  EXPECT_EQ(calls, 4);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].native_us, 1);
  EXPECT_EQ(rows[1].native_us, 3);
}

}  // namespace
}  // namespace godobject::study::test_native_peers
