// godobject accuracy: error against run time of a scene, for each integrator and step.
#include <algorithm>
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/scene/toml.h"
#include "platform/session/accuracy.h"

namespace godobject {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* accuracy_definitions =
    "Each run has the same motion and no buses. It is compared with a run of tr-bdf2 at an eighth of the "
    "shortest step, at the multiples of the longest step. Position: largest distance of a body or of a node "
    "of a net. Rotation: largest angle of a body. Force: largest difference of a displayed force. The error "
    "of the reference itself is its difference to a run of twice its step; errors near it are not resolved. "
    "Compute time: median of a step, for a simulated second. An asterisk marks runs that no other run "
    "beats in both position and compute time.";

struct AccuracyOptions {
  std::string scene{}, motion{};  // paths; motion: empty for the scene's
  AccuracyPlan plan{};
  std::optional<double> tolerance_m{};
  std::string json{};
};

/// Reads scene and motion and runs them. Returns the errors.
std::vector<std::string> measure(const AccuracyOptions& options, const FaultChecks& faults,
                                 Accuracy& accuracy) {
  const LoadResult loaded = load_scene(options.scene, faults);
  if (!loaded.scene || !loaded.errors.empty()) return loaded.errors;
  if (options.motion.empty())
    return measure_accuracy(*loaded.scene, Motion(*loaded.scene), options.plan, accuracy);
  const MotionResult read = Motion::read(options.motion, *loaded.scene);
  if (!read.motion || !read.errors.empty()) return read.errors;
  return measure_accuracy(*loaded.scene, *read.motion, options.plan, accuracy);
}

Json to_json(const RunDifferences& d) {
  return {{"position_m", d.position_m}, {"rotation_rad", d.rotation_rad}, {"force_N", d.force_N}};
}

Json to_json(const Accuracy& accuracy, const std::string& scene) {
  Json json{{"scene", scene},
            {"from_s", accuracy.span.from_s},
            {"duration_s", accuracy.span.end_s - accuracy.span.from_s},
            {"compared_every_s", accuracy.span.interval_s},
            {"reference", {{"step_s", accuracy.reference.step_s}, {"error", to_json(accuracy.of_reference)}}},
            {"runs", Json::array()}};
  for (std::size_t i = 0; i < accuracy.runs.size(); ++i) {
    const AccuracyRun& run = accuracy.runs[i];
    json["runs"].push_back({{"integrator", run.integrator},
                            {"step_s", run.step_s},
                            {"error", to_json(accuracy.errors[i])},
                            {"first_order_percent", 100 * run.first_order_share},
                            {"step_ns", run.step_ns},
                            {"compute_ms_per_s", run.compute_ms_per_s()},
                            {"on_front", accuracy.is_on_front(i)},
                            {"fault", any(run.fault)}});
  }
  return json;
}

void print(const Accuracy& accuracy, const AccuracyOptions& options) {
  const RunDifferences& r = accuracy.of_reference;
  std::printf("%s: from %g to %g s, compared every %g ms with tr-bdf2 at %g us\n", options.scene.c_str(),
              accuracy.span.from_s, accuracy.span.end_s, 1e3 * accuracy.span.interval_s,
              1e6 * accuracy.reference.step_s);
  std::printf("the reference itself: %.2g m, %.2g rad, %.2g N\n\n", r.position_m, r.rotation_rad, r.force_N);
  std::printf("%-15s %8s %12s %12s %10s %8s %10s %14s\n", "integrator", "step ms", "position m",
              "rotation rad", "force N", "first %", "step us", "compute ms/s");
  for (std::size_t i = 0; i < accuracy.runs.size(); ++i) {
    const AccuracyRun& run = accuracy.runs[i];
    const RunDifferences& e = accuracy.errors[i];
    std::printf("%-15s %8.4g %12.2g %12.2g %10.2g %8.2g %10.3g %13.3g%s%s\n", run.integrator.c_str(),
                1e3 * run.step_s, e.position_m, e.rotation_rad, e.force_N, 100 * run.first_order_share,
                1e-3 * run.step_ns, run.compute_ms_per_s(), accuracy.is_on_front(i) ? " *" : "",
                any(run.fault) ? " FAULT" : "");
  }
  if (options.tolerance_m) {
    const std::optional<std::size_t> best = accuracy.quickest_within(*options.tolerance_m);
    if (best)
      std::printf("\nquickest within %g m: integrator = \"%s\", step = %g\n", *options.tolerance_m,
                  accuracy.runs[*best].integrator.c_str(), accuracy.runs[*best].step_s);
    else std::printf("\nno run is within %g m: give shorter --steps\n", *options.tolerance_m);
  }
}

ExitCode show(const AccuracyOptions& options, const FaultChecks& faults) {
  Accuracy accuracy;
  const std::vector<std::string> errors = measure(options, faults, accuracy);
  for (const std::string& error : errors) std::fprintf(stderr, "%s\n", error.c_str());
  if (!errors.empty()) return ExitCode::usage;
  print(accuracy, options);
  if (accuracy.is_unresolved())
    std::fprintf(stderr,
                 "warning: the reference is no more accurate than the runs: the motion is sensitive, as that "
                 "of bodies that collide, or too short; lower --duration, or give shorter --steps\n");
  if (!options.json.empty() &&
      !write_file("--json", options.json, to_json(accuracy, options.scene).dump(2) + "\n"))
    return ExitCode::fault;
  const bool any_fault = std::ranges::any_of(accuracy.runs, [](const auto& run) { return any(run.fault); });
  return any_fault ? ExitCode::fault : ExitCode::ok;
}

}  // namespace

void add_accuracy(CLI::App& app, const FaultChecks& checks, ExitCode& code) {
  CLI::App* verb = app.add_subcommand(
      "accuracy", "Measure error against run time of a scene, for each integrator and step.");
  verb->footer(accuracy_definitions);
  const auto options = std::make_shared<AccuracyOptions>();
  verb->add_option("SCENE", options->scene, "read this scene file (TOML)")->required();
  verb->add_option("--motion", options->motion, "read the motion of the hand from this file")
      ->type_name("FILE");
  verb->add_option(
          "--from", options->plan.from_s,
          "compare from this time on, s; default: a quarter second after the ramp of engaging, which "
          "begins with the first sample and so depends on the step")
      ->check(number_in(0, 1e4));
  verb->add_option("--duration", options->plan.duration_s, "compare for this time, s; default: 1")
      ->check(number_above(0, 1e4));
  verb->add_option(
          "--steps", options->plan.steps_s,
          "measure these steps, s, separated by commas; each divides the longest. Default: from four "
          "steps of the scene to an eighth of one")
      ->delimiter(',')
      ->check(number_in(1e-5, 0.1));
  verb->add_option("--tolerance-m", options->tolerance_m,
                   "print the quickest integrator and step with a position error below this one, m")
      ->check(number_above(0, 1e3));
  verb->add_option("--json", options->json, "write a JSON of the table")->type_name("FILE");
  verb->callback([options, checks, &code] { code = show(*options, checks); });
}

}  // namespace godobject
