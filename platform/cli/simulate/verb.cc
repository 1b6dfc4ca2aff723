// godobject simulate: simulates the other end of the buses for a `godobject run`. Prepares the simulation on
// open buses, or returns all errors with their places.
#include <poll.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/rig/profile_validate.h"
#include "hal/rig/validate.h"
#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/cli/simulate/simulation.h"
#include "platform/linux/bus/bus.h"
#include "platform/rt/background_file.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/setup.h"
#include "platform/rt/signals.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject {
namespace {

struct SimulateOptions {
  std::string scene;                   // path
  std::vector<std::string> buses;      // "ADDRESS" or "NAME=ADDRESS"
  std::vector<std::string> taps;       // as buses
  std::string motion, faults, report;  // paths; empty: the scene's own, none, none
  std::optional<double> duration;      // s; none: until stopped
  bool control = false;                // true: commands on standard input
  bool realtime = false;
  bool start_now = false;  // true: the motion does not wait for the first SYNC
};

struct PreparedSimulation {
  std::unique_ptr<Simulation> simulation;  // null if there are errors
  std::vector<std::string> errors, notes;
  bool not_available = false;  // true if the errors are of this machine's buses and terminals
};

/// Makes closed ends of the buses named by `text`.
void offer(const std::string& option, const std::string& text, bool is_tap, const RigParams& rig,
           PreparedSimulation& out, std::vector<OfferedBus>& offered) {
  const auto complain = [&](const std::string& what) {
    out.errors.push_back(option + " " + text + ": " + what);
  };
  const NamedAddress wanted = split_name(text, ':');  // without a name: all buses
  std::string error;
  const std::optional<BusAddress> address = parse_bus_address(wanted.address, error);
  if (!address) return complain(error);
  if (address->backend->no_device != nullptr) return complain(address->backend->no_device);
  if (wanted.name.empty() && rig.buses.size() > 1 && !address->backend->makes_terminal)
    return complain("the scene has " + std::to_string(rig.buses.size()) + " buses: name one, as in " +
                    rig.buses.front().name + "=" + wanted.address);
  bool found = false;
  for (std::size_t i = 0; i < rig.buses.size(); ++i) {
    const BusParams& bus = rig.buses[i];
    if (!wanted.name.empty() && wanted.name != bus.name) continue;
    found = true;
    const BusSettings settings{.bit_rate = bus.bit_rate, .data_bit_rate = bus.data_bit_rate, .filters = {}};
    offered.push_back({.name = bus.name,
                       .address = wanted.address,
                       .wire = i,
                       .is_tap = is_tap,
                       .bus = make_bus(*address, settings)});
  }
  if (!found) complain("the scene has no bus '" + wanted.name + "'");
}

/// Makes one end for each bus of the scene, in its order, then the taps.
std::vector<OfferedBus> offer_all(const SimulateOptions& options, const RigParams& rig,
                                  PreparedSimulation& out) {
  std::vector<OfferedBus> offered;
  for (const std::string& text : options.buses) offer("--bus", text, false, rig, out, offered);
  std::ranges::stable_sort(offered, {}, &OfferedBus::wire);
  for (std::size_t i = 0; i < rig.buses.size(); ++i) {
    const auto ends = std::ranges::count(offered, i, &OfferedBus::wire);
    if (out.errors.empty() && ends != 1)
      out.errors.push_back("--bus: bus '" + rig.buses[i].name + "' of the scene has " + std::to_string(ends) +
                           " addresses and requires one: give --bus " + rig.buses[i].name + "=ADDRESS");
  }
  for (const std::string& text : options.taps) offer("--tap", text, true, rig, out, offered);
  return offered;
}

void open_all(const std::vector<OfferedBus>& offered, PreparedSimulation& out) {
  for (const OfferedBus& o : offered) {
    if (o.bus->open()) continue;
    out.not_available = true;
    out.errors.push_back("bus " + o.name + " at " + o.address + ": " + o.bus->trouble());
  }
}

/// Loads scene and faults; none if they have errors.
std::optional<SceneConfig> load(const SimulateOptions& options, PreparedSimulation& out) {
  LoadResult loaded = load_scene(options.scene, simulated_faults());
  append(out.errors, loaded.errors);
  append(out.notes, loaded.warnings);
  if (!loaded.scene) return std::nullopt;
  SceneConfig& scene = *loaded.scene;
  if (!scene.device || (!scene.device->rig && scene.device->trackers.empty())) {
    out.errors.push_back(options.scene +
                         ": describes no device on buses and no trackers to simulate: add [[bus]] or "
                         "[[device.tracker]] tables");
    return std::nullopt;
  }
  if (!options.faults.empty()) {
    FaultsResult faults = load_faults(options.faults, scene, simulated_faults());
    append(out.errors, faults.errors);
    scene.faults.insert(scene.faults.end(), faults.faults.begin(), faults.faults.end());
  }
  if (scene.device->rig)
    for (const std::string& error : validate(*scene.device->rig, scene.step))
      out.errors.push_back(options.scene + ": " + error);
  return std::move(loaded.scene);
}

/// Opens a pseudo-terminal for each tracker of the scene.
std::vector<std::unique_ptr<TrackerLine>> offer_trackers(const SceneConfig& scene, PreparedSimulation& out) {
  std::vector<std::unique_ptr<TrackerLine>> lines;
  const std::vector<TrackerParams>& trackers = scene.device->trackers;
  for (std::size_t i = 0; i < trackers.size(); ++i) {
    if (trackers[i].protocol == TrackerProtocol::openigtlink) {
      out.errors.push_back("tracker " + trackers[i].name +
                           ": a server of OpenIGTLink is on no terminal: run simulates it");
      continue;
    }
    lines.push_back(std::make_unique<TrackerLine>(
        trackers[i].name,
        make_sim_tracker(trackers[i], simulated_rate_hz(trackers[i].protocol), scene.wire.seed + i)));
    const std::string why_not = lines.back()->open();
    if (why_not.empty()) continue;
    out.not_available = true;
    out.errors.push_back("tracker " + trackers[i].name + ": " + why_not);
  }
  return lines;
}

PreparedSimulation prepare(const SimulateOptions& options) {
  PreparedSimulation out;
  std::optional<SceneConfig> scene = load(options, out);
  if (!scene) return out;
  const bool has_rig = scene->device->rig.has_value();
  RigProfilesResult devices;
  if (has_rig) {
    devices = load_profiles(*scene->device->rig, scene->step,
                            std::filesystem::path(options.scene).parent_path().string(), options.scene);
    apply_profiles(devices.profiles, *scene->device->rig);
  }
  append(out.errors, devices.errors);
  MotionResult motion;
  if (options.motion.empty()) motion.motion.emplace(*scene);
  else motion = Motion::read(options.motion, *scene);
  append(out.errors, motion.errors);
  append(out.notes, motion.notes);
  if (out.errors.empty() && has_rig) {
    const std::string why_not = SimRig::why_not(scene->device->rig->tree, *hand_of(*motion.motion));
    if (!why_not.empty()) out.errors.push_back(options.scene + ": " + why_not);
  }
  std::vector<OfferedBus> offered = offer_all(options, scene->device->rig.value_or(RigParams{}), out);
  std::vector<std::unique_ptr<TrackerLine>> trackers;
  if (out.errors.empty()) open_all(offered, out);
  if (out.errors.empty()) trackers = offer_trackers(*scene, out);
  if (!out.errors.empty()) return out;
  out.simulation = std::make_unique<Simulation>(*scene, devices.profiles, *motion.motion, std::move(offered),
                                                !options.start_now, std::move(trackers));
  return out;
}

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
    wait(descriptors, start + simulation.next_step());
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
  const nlohmann::ordered_json json = prepared.simulation->to_json();
  const std::string text = json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  return write_file("--report", options.report, text) ? ExitCode::ok : ExitCode::fault;
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
