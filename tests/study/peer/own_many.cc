// Many bodies and many nodes: apart from own.cc, since their steps take the longest to compile.
#include <limits>
#include <memory>

#include "tests/bench/contact_quality.h"
#include "tests/bench/hanging_run.h"
#include "tests/bench/peer/native_peers.h"
#include "tests/study/case_errors.h"
#include "tests/study/contact/run.h"
#include "tests/study/peer/own.h"

namespace godobject::study {

PeerPile pile_row(const std::string& engine, const bench::ContactQuality& quality, const StepClock& clock,
                  bool failed) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  return {.engine = engine,
          .overlap = failed ? infinite : quality.overlap,
          .median = failed ? infinite : quality.overlap_median,
          .us_per_step = {},
          .p99_us = {},
          .native_us = clock.median_us(),
          .native_p99_us = clock.p99_us()};
}

PeerPile own_pile() {
  using S = Bricks<ImplicitEuler, 64>;
  constexpr double h = 1e-3;
  const bench::ContactScene scene = bench::scene_s4(64, 20);
  const auto run = std::make_unique<CaseRun<S>>(scene.problem, h);
  set_contacts(scene, run->params());
  // One input for all steps: 20 000 of them would be read from memory instead of the cache.
  const bench::Targets targets = bench::targets_of(scene);
  Input<S> in;
  for (std::size_t i = 1; i < scene.problem.bodies.size(); ++i) in.devices[i].engaged = false;
  bool failed = false;
  StepClock clock;
  const bench::ContactQuality quality = bench::quality_of(scene, targets.size() - 1, [&](std::size_t n) {
    const oracle::RigidState& D = targets[n + 1].front();
    set_input(D, D, in.devices[0]);
    clock.time([&] { run->step(in); });
    failed = failed || any(run->output().fault);
    bench::Snapshot now{{}, run->output().contacts.num_contacts};
    for (std::size_t i = 0; i < scene.problem.bodies.size(); ++i)
      now.bodies.push_back(oracle_state(run->body(i)));
    return now;
  });
  return pile_row(ImplicitEuler::name, quality, clock, failed);
}

template <class Integrator>
PeerNet own_net() {
  bench::HangingRun<NetTool<Integrator, 1024>> run(NetParams<1, 1>{}.max_iterations);
  run.restart();
  StepClock clock;
  for (std::size_t n = 0; n < net_steps; ++n) clock.time([&] { run.step(0); });  // its ball stays away
  return {.engine = Integrator::name,
          .stretch = bench::stretch_error([&](std::uint32_t n) { return run.node(n); }),
          .us_per_step = {},
          .native_us = clock.median_us()};
}

Runs<PeerNet> own_nets() { return {own_net<ImplicitEuler>, own_net<TrBdf2>}; }

namespace {

/// The bag with the bar as a body on a coupling of 1e9 N/m.
template <class Integrator>
class BagRun {
 public:
  using S = NetTool<Integrator, 1024>;

  /// k_contact: stiffness of the contact law, N/m.
  BagRun(const Bag& bag, double k_contact) {
    Params<S>& par = params();
    par.h = Bag::h;
    const Real m = 1, k = 1e9;
    par.bodies[0].body = rigid_body(m, Mat3(1e-3 * Mat3::Identity()));
    par.bodies[0].coupling =
        par.bodies[0].feedback.gains = {.k = k, .g = 2 * std::sqrt(m * k), .k_r = 1e6, .g_r = 100};
    par.bodies[0].device.rise = 0;
    set_net_params(bag.net, par.net);
    par.contacts.num_surfaces = 1;
    par.contacts.surfaces[0] = {.body = 0,
                                .shape = {.kind = ShapeKind::capsule,
                                          .X_WS = {.q = exp_so3(Vec3(pi / 2, 0, 0))},
                                          .radius = Bag::bar_radius,
                                          .half_length = Bag::bar_half}};
    const Real c = std::sqrt(k_contact * bag.net.nodes.front().m) / 2;
    par.contacts.laws[0][0] = {.k = k_contact, .c = c, .k_t = k_contact, .c_t = c};
    run_.hold_at(bar_at(0));
  }
  Params<S>& params() { return *run_.par; }
  void step(std::size_t n) {
    run_.lead(bar_at(static_cast<double>(n + 1) * Bag::h));
    run_.step();
  }
  bool failed() const { return any(run_.out->fault); }
  Vec3 node(std::size_t n) const { return run_.x->net.nodes[n].p_W; }

 private:
  static Target bar_at(double t) {
    const auto [x, v] = Bag::bar_at(t);
    return {.X_WD = {.p = Vec3(x, 0, 0)}, .V_WD = {.v = Vec3(v, 0, 0)}};
  }

  NetRunning<S> run_;
};

constexpr double hard_bar = 1e5;  // N/m: contacts about as hard as those of the peers

template <class Integrator>
PeerBag own_bag(const Bag& bag, const std::vector<Vec3>& rest, double k_contact) {
  BagRun<Integrator> run(bag, k_contact);
  StepClock clock;
  bool failed = false;
  for (std::size_t n = 0; n < steps_in(Bag::duration, Bag::h); ++n) {
    clock.time([&] { run.step(n); });
    failed = failed || run.failed();
  }
  constexpr double infinite = std::numeric_limits<double>::infinity();
  PeerBag row{.engine = Integrator::name + std::string(k_contact == hard_bar ? " (hard contacts)" : ""),
              .error = failed ? infinite : 0,
              .depth = failed ? infinite : -infinite,
              .us_per_step = {},
              .native_us = clock.median_us()};
  for (std::size_t n = 0; n < rest.size(); ++n) {
    row.error = std::max(row.error, (run.node(n) - rest[n]).norm());
    row.depth = std::max(row.depth, bag.depth(run.node(n)));
  }
  return row;
}

}  // namespace

std::vector<Vec3> bag_at_rest(const Bag& bag) {
  BagRun<ImplicitEuler> run(bag, hard_bar);
  run.params().net.max_iterations = 400;
  run.params().net.tolerance = 1e-3;
  for (std::size_t n = 0; n < steps_in(2 * Bag::duration, Bag::h); ++n) run.step(n);
  std::vector<Vec3> rest;
  for (std::size_t n = 0; n < bag.net.nodes.size(); ++n) rest.push_back(run.node(n));
  return rest;
}

Runs<PeerBag> own_bags(const Bag& bag, const std::vector<Vec3>& rest) {
  Runs<PeerBag> runs;
  for (const double k_contact : {Bag::contact_stiffness, hard_bar}) {
    runs.emplace_back([=] { return own_bag<ImplicitEuler>(bag, rest, k_contact); });
    runs.emplace_back([=] { return own_bag<TrBdf2>(bag, rest, k_contact); });
  }
  return runs;
}

}  // namespace godobject::study
