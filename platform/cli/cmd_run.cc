// godobject run: a scene, its device and its motion, for a while.
#include <cstdio>
#include <fstream>
#include <memory>

#include "platform/cli/option_checks.h"
#include "platform/cli/run_loop.h"
#include "platform/cli/run_options.h"
#include "platform/cli/run_report.h"
#include "platform/cli/verbs.h"

namespace godobject {
namespace {

void print_lines(std::FILE* out, const char* before, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) std::fprintf(out, "%s%s\n", before, line.c_str());
}

bool write_report(const std::string& path, const RunReport& report) {
  std::ofstream file(path);
  file << to_json(report).dump(2) << '\n';
  file.close();
  return !file.fail();
}

ExitCode run(const RunOptions& options) {
  PreparedRun prepared = prepare(options);
  print_lines(stderr, "note: ", prepared.notes);
  print_lines(stderr, "", prepared.errors);
  if (!prepared.session) return ExitCode::usage;

  Session& session = *prepared.session;
  RunFiles files(options.trace, options.record, session.scene());
  const std::optional<RunResult> result = options.realtime ? run_realtime(session, prepared.num_cycles, files)
                                                           : run_fast(session, prepared.num_cycles, files);
  if (!result) {
    std::fputs("--realtime: this machine lets the program start no thread\n", stderr);
    return ExitCode::not_available;
  }
  RunReport report = make_report(options, session, *result, files.close());
  if (!options.report.empty() && !write_report(options.report, report))
    report.faults.push_back({.name = "file_incomplete", .text = options.report + " could not be written"});
  print_summary(stdout, report);
  return report.faults.empty() ? ExitCode::ok : ExitCode::fault;
}

void add_options(CLI::App& verb, RunOptions& options, bool& fast) {
  verb.add_option("SCENE", options.scene, "scene file (TOML), see docs/scenes.md")->required();
  auto* realtime = verb.add_flag("--realtime", options.realtime,
                                 "one cycle a period on a real-time thread, with a live status line");
  verb.add_flag("--fast", fast,
                "simulated clock, as fast as the machine allows, bit-identical each time (default)")
      ->excludes(realtime);
  verb.add_option("--duration", options.duration,
                  "s; default: the motion file's end, else the scene's duration")
      ->check(number_above(0, 1e6));
  verb.add_option_function<std::string>(
          "--bus",
          [&](const std::string& bus) { options.bus = bus == "sim" ? BusChoice::sim : BusChoice::direct; },
          "sim: through simulated encoders, wires and drives (default); direct: the motion as it is")
      ->check(CLI::IsMember({"sim", "direct"}));
  verb.add_option(
      "--motion", options.motion,
      "CSV of the target's poses or the device's joints over time, and of letting go and the clutch");
  verb.add_option("--integrator", options.integrator, "in place of the scene's")
      ->check(CLI::IsMember(std::vector<std::string>(integrator_names.begin(), integrator_names.end())));
  verb.add_option("--step", options.step, "s, in place of the scene's")->check(number_in(1e-6, 0.1));
  verb.add_option("--trace", options.trace, "CSV to write: bodies, wrenches, target, faults at every step");
  verb.add_option("--record", options.record, "log to write: every frame on every bus, in candump's format");
  verb.add_option("--report", options.report,
                  "JSON to write: everything the summary shows, and the histograms");
}

}  // namespace

void add_run(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("run", "Run a scene.");
  const auto options = std::make_shared<RunOptions>();
  const auto fast = std::make_shared<bool>();  // says what is the default
  add_options(*verb, *options, *fast);
  verb->callback([options, fast, &code] { code = run(*options); });
}

}  // namespace godobject
