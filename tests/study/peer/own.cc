#include "tests/study/peer/own.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "tests/bench/contact_quality.h"
#include "tests/oracle/scenes.h"
#include "tests/study/case_errors.h"
#include "tests/study/contact/run.h"
#include "tests/study/joint/scene.h"
#include "tests/study/reference_solution.h"

namespace godobject::study {
namespace {

constexpr double contact_step = 1e-3;  // s, as that of the peers
constexpr double infinite = std::numeric_limits<double>::infinity();

constexpr double hard = 1e8;  // N/m: contacts about as hard as those of the peers

/// law_k: stiffness of the contacts, N/m; damped in the ratio of the scene.
template <class Integrator>
PeerContact own_contact(double k, std::optional<double> law_k) {
  using S = PressedTool<Integrator, 1>;
  bench::ContactScene scene = bench::scene_s2(k);
  if (law_k) {
    const double root = std::sqrt(*law_k / scene.law.k);
    scene.law.k = scene.law.k_t = *law_k;
    scene.law.c *= root;
    scene.law.c_t *= root;
  }
  const auto run = std::make_unique<CaseRun<S>>(scene.problem, contact_step);
  set_contacts(scene, run->params());
  const std::vector<Input<S>> inputs = run->inputs(steps_in(scene.duration, contact_step), scene.duration);
  bool failed = false;
  StepClock clock;
  const bench::ContactQuality quality = bench::quality_of(scene, inputs.size(), [&](std::size_t n) {
    clock.time([&] { run->step(inputs[n]); });
    failed = failed || any(run->output().fault);
    return bench::Snapshot{{oracle_state(run->body(0))}, run->output().contacts.num_contacts};
  });
  return {.engine = Integrator::name + std::string(law_k ? " (hard contacts)" : ""),
          .k = k,
          .depth = failed ? infinite : quality.average.mean,
          .jitter = failed ? infinite : quality.average.jitter,
          .us_per_step = {},
          .native_us = clock.median_us()};
}

template <class Integrator>
PeerStability own_distance(double k, double h, double duration) {
  const oracle::Case first = oracle::scene_s1();
  const oracle::Case problem = stiffened(first, k / first.bodies[0].coupling->k_t);
  CaseRun<Follower<Integrator, 1>> run(problem, h);
  PeerStability result{.engine = Integrator::name, .k = k, .h = h};
  const auto inputs = run.inputs(steps_in(duration, h), duration);
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    run.step(inputs[n]);
    const Vec3 target = problem.bodies[0].coupling->target->at(static_cast<double>(n + 1) * h).p;
    result.distance = std::max(result.distance, (run.body(0).X_WB.p - target).norm());
    if (any(run.output().fault)) result.distance = infinite;
  }
  return result;
}

/// Returns the target at t with the mean velocity of the step that ends there, as some peers receive it.
Target mean_target(const oracle::Target& target, double t, double h) {
  oracle::RigidState D = target.at(t);
  D.v = (D.p - target.at(t - h).p) / h;
  D.w = target.at(t - h / 2).w;
  return target_of(D);
}

/// Returns the errors of implicit Euler on S1 with mean velocities of the target.
PeerError mean_velocity_error(const ReferenceScene& scene, const oracle::Solution& reference, double h) {
  using S = Follower<ImplicitEuler, 1>;
  CaseRun<S> run(scene.problem, h);
  const auto every = static_cast<std::size_t>(std::lround(comparison_step / h));
  Errors worst;
  for (std::size_t n = 1; n <= steps_in(scene.duration, h); ++n) {
    Input<S> in;
    in.devices[0] = {
        .target = mean_target(*scene.problem.bodies[0].coupling->target, static_cast<double>(n) * h, h)};
    run.step(in);
    if (n % every == 0 && reference.times[n / every] >= scene.from)
      compare(run, reference.states[n / every], worst);
  }
  return {.scene = scene.name,
          .engine = std::string(ImplicitEuler::name) + " (mean velocity)",
          .h = h,
          .position = worst.position,
          .rotation = worst.rotation,
          .us_per_step = {}};
}

/// A scene of the core on the start of a case.
template <Scene S>
class OwnRun final : public TimedRun {
 public:
  OwnRun(const ReferenceScene& scene, double h, std::size_t max_steps)
      : run_(scene.problem, h),
        inputs_(run_.inputs(std::min(max_steps, steps_in(scene.duration, h)), scene.duration)) {}

  std::size_t num_steps() const override { return inputs_.size(); }
  void restart() override { run_.restart(); }
  void advance(std::size_t first, std::size_t end) override {
    for (std::size_t n = first; n < end; ++n) run_.step(inputs_[n]);
  }

 private:
  CaseRun<S> run_;
  std::vector<Input<S>> inputs_;
};

/// Returns the smallest composition that holds the scene, as study_error() does.
template <class Integrator>
std::unique_ptr<TimedRun> own_timed_run_of(const ReferenceScene& scene, double h, std::size_t max_steps) {
  if (!scene.is_articulated()) return std::make_unique<OwnRun<Follower<Integrator, 1>>>(scene, h, max_steps);
  if (scene.is_coupled()) return std::make_unique<OwnRun<Tool<Integrator, 4>>>(scene, h, max_steps);
  return std::make_unique<OwnRun<FreeJoints<Integrator, 8>>>(scene, h, max_steps);
}

}  // namespace

std::unique_ptr<TimedRun> own_timed_run(const ReferenceScene& scene, const std::string& integrator, double h,
                                        std::size_t max_steps) {
  return integrator == ImplicitEuler::name ? own_timed_run_of<ImplicitEuler>(scene, h, max_steps)
                                           : own_timed_run_of<TrBdf2>(scene, h, max_steps);
}

std::vector<PeerError> own_errors(const std::vector<ReferenceScene>& scenes, bool quick,
                                  const Progress& progress) {
  InstructionCounter no_counter{std::filesystem::path()};
  std::vector<PeerError> rows;
  for (const ErrorRow& r : study_error(scenes, quick, no_counter, progress))
    rows.push_back({.scene = r.scene,
                    .engine = r.integrator,
                    .h = r.h,
                    .position = r.errors.position,
                    .rotation = r.errors.rotation,
                    .us_per_step = {}});
  const oracle::Solution reference = reference_of(scenes.front());
  for (const double h : error_steps(quick)) rows.push_back(mean_velocity_error(scenes.front(), reference, h));
  return rows;
}

Runs<PeerContact> own_contacts(const std::vector<double>& stiffnesses) {
  Runs<PeerContact> runs;
  for (const double k : stiffnesses) {
    for (const std::optional<double> law_k : {std::optional<double>(), std::optional(hard)}) {
      runs.emplace_back([=] { return own_contact<ImplicitEuler>(k, law_k); });
      runs.emplace_back([=] { return own_contact<TrBdf2>(k, law_k); });
    }
  }
  return runs;
}

std::vector<PeerStability> own_stability(const std::vector<double>& stiffnesses,
                                         const std::vector<double>& steps, double duration) {
  std::vector<PeerStability> rows;
  for (const double k : stiffnesses)
    for (const double h : steps) {
      rows.push_back(own_distance<ImplicitEuler>(k, h, duration));
      rows.push_back(own_distance<TrBdf2>(k, h, duration));
    }
  return rows;
}

}  // namespace godobject::study
