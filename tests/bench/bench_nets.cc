// Our step on nets: S6, the tube pressed on a bar, of 100 to 10 000 nodes. Also the hanging net of 1024 nodes
// with a ball pressed into it, compared with the peers.
#include <memory>

#include "tests/bench/bench.h"
#include "tests/bench/hanging_run.h"
#include "tests/bench/peer/native_peers.h"
#include "tests/study/net/tube.h"

namespace godobject::bench {
namespace {

template <class S>
std::string name_of() {
  return "net-tool-" + std::to_string(study::capacity_of<S>()) + " " + S::Integrator::name;
}

/// A tube in steps with complete iterations.
template <Scene S>
study::TubeRun<S> solved_tube(std::uint32_t round, double spacing) {
  study::TubeRun<S> tube(round, spacing);
  auto& net = tube.running().par->net;
  net.max_iterations = 400;
  net.tolerance = 1e-3;
  return tube;
}

template <Scene S>
Real farthest_apart(const State<S>& a, const State<S>& b, std::size_t num_nodes) {
  Real most = 0;
  for (std::size_t n = 0; n < num_nodes; ++n)
    most = std::max(most, (a.net.nodes[n].p_W - b.net.nodes[n].p_W).norm());
  return most;
}

/// iterations: maximum in a stage, if not the default; the error is then reported.
template <Scene S>
void run_tube(benchmark::State& state, const std::string& scene, const std::string& who, std::uint32_t round,
              double spacing, std::optional<int> iterations) {
  study::TubeRun<S> tube(round, spacing);
  if (!tube.is_valid()) return state.SkipWithError("the net is not valid");
  NetQuality quality;
  if (iterations) {
    tube.running().par->net.max_iterations = *iterations;
    quality.node_error = 0;
  }
  std::optional<study::TubeRun<S>> solved;
  if (iterations) solved = solved_tube<S>(round, spacing);
  if (solved) solved->press();
  tube.press();
  const double share = 1 / static_cast<double>(tube.num_pressed);
  for (std::size_t n = 0; n < tube.num_pressed; ++n) {
    tube.step();
    quality.iterations += share * tube.report().iterations;
    quality.contacts += share * static_cast<double>(tube.report().num_contacts);
    if (!solved) continue;
    solved->step();
    *quality.node_error +=
        share * farthest_apart<S>(*tube.running().x, *solved->running().x, tube.num_nodes());
  }
  state.counters["scratch_bytes"] = sizeof(Scratch<S>);
  Row row{.scene = scene,
          .who = who,
          .num_bodies = tube.num_nodes(),
          .times = {},
          .instructions = {},
          .errors = {},
          .contacts = {}};
  row.net = quality;
  if (scene == "S6/1024" && !iterations) row.instructions = counter().per_step(name_of<S>(), "s6");
  measure(
      state, row, tube.num_pressed, [&] { tube.press(); }, [&](std::size_t) { tube.step(); });
}

/// is_finer: true for as many nodes in a tube of the usual size.
template <Scene S>
void add_tube(std::uint32_t round, bool is_finer = false, std::optional<int> iterations = {}) {
  using Tube = study::TubeRun<S>;
  const std::string who = (iterations ? std::to_string(*iterations) + " it, " : "") + name_of<S>();
  const std::string scene = (is_finer ? "S6 fine/" : "S6/") + std::to_string(round * round);
  const double spacing = is_finer ? Tube::usual_spacing * 32 / round : Tube::usual_spacing;
  add(scene + "/" + who, long_scene,
      [=](benchmark::State& state) { run_tube<S>(state, scene, who, round, spacing, iterations); });
}

const int usual_iterations = NetParams<1, 1>{}.max_iterations;

/// Times the pressing and measures the stretch at the end.
template <class Peer>
void run_hanging(benchmark::State& state, const std::string& who, Peer& peer, bool is_peer,
                 std::optional<NetQuality>& known) {
  if (!known) {
    known.emplace();
    peer.restart();
    for (std::size_t n = 0; n < HangingNet::num_steps; ++n) {
      peer.step(n);
      if (n < HangingNet::first_pressed || n >= HangingNet::first_pressed + HangingNet::num_pressed) continue;
      known->contacts += static_cast<double>(peer.num_contacts()) / HangingNet::num_pressed;
      if constexpr (requires { peer.report(); })
        known->iterations += peer.report().iterations / static_cast<double>(HangingNet::num_pressed);
    }
    known->stretch_error = stretch_error([&](std::uint32_t n) { return peer.node(n); });
  }
  Row row{.scene = "S6 hanging",
          .who = who,
          .num_bodies = HangingNet::num_nodes,
          .peer = is_peer,
          .times = {},
          .instructions = {},
          .errors = {},
          .contacts = {}};
  row.net = known;
  measure(
      state, row, HangingNet::num_pressed,
      [&] {
        peer.restart();
        for (std::size_t n = 0; n < HangingNet::first_pressed; ++n) peer.step(n);
      },
      [&](std::size_t n) { peer.step(HangingNet::first_pressed + n); });
}

/// max_iterations: fewer than usual to compare the error at the time of a peer.
template <Scene S>
void add_hanging(int max_iterations = usual_iterations) {
  const auto known = std::make_shared<std::optional<NetQuality>>();
  std::string who = name_of<S>();
  if (max_iterations != usual_iterations) who = std::to_string(max_iterations) + " it, " + who;
  add("S6 hanging/" + who, long_scene, [=](benchmark::State& state) {
    HangingRun<S> run(max_iterations);
    if (!run.is_valid()) return state.SkipWithError("the net is not valid");
    run_hanging(state, who, run, false, *known);
  });
}

}  // namespace

void add_our_nets() {
  using study::NetTool;
  for (const std::uint32_t round : {10, 18, 32}) {
    add_tube<NetTool<ImplicitEuler, 1024>>(round);
    add_tube<NetTool<TrBdf2, 1024>>(round);
  }
  for (const int iterations : {3, 6, 12}) {
    add_tube<NetTool<ImplicitEuler, 1024>>(32, false, iterations);
    add_tube<NetTool<TrBdf2, 1024>>(32, false, iterations);
  }
  for (const std::uint32_t round : {55, 100}) {
    add_tube<NetTool<ImplicitEuler, 10000>>(round);
    add_tube<NetTool<TrBdf2, 10000>>(round);
  }
  add_tube<NetTool<ImplicitEuler, 10000>>(100, true);
  add_hanging<NetTool<ImplicitEuler, 1024>>();
  add_hanging<NetTool<TrBdf2, 1024>>();
  for (const int iterations : {1, 4}) add_hanging<NetTool<ImplicitEuler, 1024>>(iterations);
}

void add_net_peers() {
  for (const HangingPeer& peer : native_peers().hanging) {
    const auto known = std::make_shared<std::optional<NetQuality>>();
    add("S6 hanging/" + peer.engine, peer.is_slow ? slow_scene : long_scene,
        [=, &peer](benchmark::State& state) {
          const std::unique_ptr<NetPeer> run = peer.make();
          run_hanging(state, peer.engine, *run, true, *known);
        });
  }
}

}  // namespace godobject::bench
