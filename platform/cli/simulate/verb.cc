// godobject simulate: simulates the other end of the buses for a `godobject run`.
#include <poll.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>

#include "platform/cli/option_checks.h"
#include "platform/cli/simulate/control.h"
#include "platform/cli/simulate/options.h"
#include "platform/cli/verbs.h"
#include "platform/rt/background_file.h"
#include "platform/rt/clock.h"
#include "platform/rt/setup.h"
#include "platform/rt/stop_signals.h"

namespace godobject {
namespace {

/// Sleeps until `until`, or until a descriptor is readable.
void wait(std::vector<pollfd>& descriptors, Nanoseconds until) noexcept {
  const Nanoseconds left = std::max<Nanoseconds>(0, until - MonotonicClock{}.now());
  const timespec timeout{.tv_sec = left / 1'000'000'000, .tv_nsec = left % 1'000'000'000};
  ppoll(descriptors.data(), descriptors.size(), &timeout, nullptr);
}

void announce(const Simulation& simulation) {
  for (const OfferedBus& offered : simulation.buses())
    std::printf("%s %s: %s\n", offered.is_tap ? "tap" : "bus", offered.name.c_str(),
                offered.bus->name().c_str());
  for (const std::unique_ptr<TrackerLine>& tracker : simulation.trackers())
    std::printf("tracker %s: %s\n", tracker->name().c_str(), tracker->path().c_str());
  std::puts("ready");
  std::fflush(stdout);
}

/// Runs in wall time until the duration is over, a command ends it or a signal arrives.
void play(const SimulateOptions& options, PreparedSimulation& prepared) {
  Simulation& simulation = *prepared.simulation;
  const StopSignals stop;
  const std::optional<RtProcess> process =
      options.realtime ? std::optional<RtProcess>(std::in_place) : std::nullopt;
  if (options.realtime) std::fputs(("real-time set-up\n" + rt_table(set_up_rt_thread())).c_str(), stderr);
  prctl(PR_SET_TIMERSLACK, 1UL);  // ns; answers to SYNC are fractions of a millisecond apart
  std::optional<LineInput> input;
  if (options.control) input.emplace(STDIN_FILENO);
  std::vector<pollfd> descriptors;
  for (const int fd : simulation.descriptors())
    descriptors.push_back({.fd = fd, .events = POLLIN, .revents = 0});
  if (input) descriptors.push_back({.fd = STDIN_FILENO, .events = POLLIN, .revents = 0});
  announce(simulation);
  const Nanoseconds start = MonotonicClock{}.now();
  const double end_s = options.duration.value_or(std::numeric_limits<double>::infinity());
  constexpr std::size_t waiting_bytes = 1 << 20;
  constexpr std::chrono::milliseconds patience{500};
  BackgroundFile answers(STDOUT_FILENO, waiting_bytes);  // need not be read
  bool quit = false;
  for (std::string line; !quit && !stop.requested();) {
    simulation.step(MonotonicClock{}.now() - start);
    if (1e-9 * static_cast<double>(simulation.now()) >= end_s) break;
    while (input && !quit && input->try_line(line))
      static_cast<void>(answers.write(answer(line, simulation, quit) + "\n"));
    if (input) descriptors.back().fd = input->descriptor();
    wait(descriptors, start + simulation.next_event());
  }
  const BackgroundFile::Result written = answers.close(BackgroundFile::Clock::now() + patience);
  if (written.lost_lines > 0)
    std::fprintf(stderr, "%llu answers were lost because standard output was not read\n",
                 static_cast<unsigned long long>(written.lost_lines));
}

ExitCode simulate(const SimulateOptions& options) {
  guard_process();
  PreparedSimulation prepared = prepare(options);
  for (const std::string& note : prepared.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  for (const std::string& error : prepared.errors) std::fprintf(stderr, "%s\n", error.c_str());
  if (!prepared.simulation) return prepared.not_available ? ExitCode::not_available : ExitCode::usage;
  play(options, prepared);
  if (options.report.empty()) return ExitCode::ok;
  std::ofstream file(options.report);
  file << prepared.simulation->to_json().dump(2, ' ', false, nlohmann::json::error_handler_t::replace)
       << '\n';
  file.close();
  if (!file.fail()) return ExitCode::ok;
  std::fprintf(stderr, "--report: %s could not be written\n", options.report.c_str());
  return ExitCode::fault;
}

void add_options(CLI::App& verb, SimulateOptions& options) {
  verb.add_option("SCENE", options.scene,
                  "read this scene file (TOML) with a device on buses or with trackers, see docs/scenes.md")
      ->required();
  verb.add_option(
      "--bus", options.buses,
      "offer a bus of the scene at [NAME=]ADDRESS: socketcan:vcan0, slcan:/dev/pts/3, or pty, which makes a "
      "pseudo-terminal for SLCAN and prints its path; trackers get pseudo-terminals of their own");
  verb.add_option("--tap", options.taps,
                  "offer one more end of a bus at [NAME=]ADDRESS: it receives every frame, and frames "
                  "written there arrive as from another node");
  verb.add_option("--motion", options.motion,
                  "read the motion from this CSV of target poses or joint coordinates, as run does");
  verb.add_option("--duration", options.duration, "end after this time, s; default: until stopped")
      ->check(number_above(0, 1e6));
  verb.add_option("--faults", options.faults,
                  "play the [[fault]] tables of this TOML file besides those of the scene");
  verb.add_option_function<std::string>(
          "--control", [&](const std::string& from) { options.control = from == "-"; },
          "read commands from standard input (-), one per line: fault VERB ..., clear, status, quit (see "
          "docs/faults.md); none (default)")
      ->check(CLI::IsMember({"-", "none"}));
  verb.add_flag("--realtime", options.realtime,
                "run with real-time priority, so that answers are in time on a busy machine");
  verb.add_flag("--start-now", options.start_now, "start the motion at once instead of with the first SYNC");
  verb.add_option("--report", options.report, "write a JSON at the end, with the content of `status`");
}

}  // namespace

void add_simulate(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand(
      "simulate",
      "Simulate a scene's device on real buses and serial lines, for a `godobject run` at their other end.");
  const auto options = std::make_shared<SimulateOptions>();
  add_options(*verb, *options);
  verb->callback([options, &code] { code = simulate(*options); });
}

}  // namespace godobject
