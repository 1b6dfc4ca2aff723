// godobject run: runs a scene with its device and its motion.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>

#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/cli/report/report.h"
#include "platform/cli/run/loop.h"
#include "platform/cli/run/options.h"
#include "platform/rt/background_file.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/signals.h"

namespace godobject {
namespace {

void print_lines(std::FILE* out, const char* before, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) std::fprintf(out, "%s%s\n", before, line.c_str());
}

/// Writes all text at once to a file or a terminal, waiting at most 2 s. Returns why this failed; empty on
/// success.
template <class File>
std::string write_whole(const File& to, const std::string& text) {
  constexpr std::chrono::seconds patience{2};
  BackgroundFile file(to, text.size());
  static_cast<void>(file.write(text));
  return file.close(BackgroundFile::Clock::now() + patience).why;
}

std::string write_report(const std::string& path, const RunReport& report) {
  return write_whole(path,
                     to_json(report).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

/// Returns the text at the end of the run: the summary, or with --quiet the faults alone.
std::string summary_of(const RunReport& report) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const out = open_memstream(&text, &size);
  if (!out) throw std::bad_alloc();
  if (report.options.quiet) print_faults(out, report.faults);
  else print_summary(out, report);
  std::fclose(out);
  std::string summary(text, size);
  std::free(text);
  return summary;
}

/// Returns the time of day minus the monotonic clock, whose time stamps the frames of real buses have.
Nanoseconds log_origin_ns() {
  const auto day = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(day).count() - MonotonicClock{}.now();
}

/// Runs the session, again from its start as often as a page resets the run. Returns the result of the last
/// time; nothing if no thread can be started. real: as in run_realtime().
std::optional<RunResult> run_to_end(const RunOptions& options, PreparedRun& prepared, RunFiles& files,
                                    const RigOnBuses* real, RunView& view) {
  for (;;) {
    std::optional<RunResult> result = options.realtime
                                          ? run_realtime(*prepared.session, prepared.plan, files, real)
                                          : run_fast(*prepared.session, prepared.plan, files);
    if (!result || !result->is_reset) return result;
    const std::string why_not = view.start_again(options, prepared);
    print_lines(stderr, "view: ", {why_not.empty() ? "a page has reset the run: it starts again" : why_not});
    if (!why_not.empty()) return result;
  }
}

ExitCode run(RunOptions options) {
  guard_process();
  if (options.require_rt || options.seal || options.core || options.deadline_us > 0) options.realtime = true;
  PreparedRun prepared = prepare(options);
  if (!options.quiet) print_lines(stderr, "note: ", prepared.notes);
  print_lines(stderr, "warning: ", prepared.warnings);
  print_lines(stderr, "", prepared.errors);
  if (!prepared.session) return ExitCode::usage;
  if (const std::string why_not = why_not_real_time(options, prepared); !why_not.empty()) {
    std::fputs(why_not.c_str(), stderr);
    return ExitCode::not_available;
  }

  if (const std::string why_not = options.seal ? Seal::why_not() : ""; !why_not.empty()) {
    print_lines(stderr, "", {"--seal: the kernel seals no thread: " + why_not});
    return ExitCode::not_available;
  }
  options.files.scene = options.scene;
  name_fault_log(options, prepared);
  if (const std::string why_not = make_folders(options); !why_not.empty()) {
    print_lines(stderr, "", {why_not});
    return ExitCode::usage;
  }
  const Session& session = *prepared.session;
  list_recorded(options.files, *prepared.session);  // before anything else takes the size of its records
  std::optional<RigOnBuses> real;
  if ((session.bus() == BusChoice::real && !prepared.log) || prepared.spacemouse || prepared.socket_device ||
      prepared.world || (prepared.has_own_device && !options.fast) ||
      ((options.view || !options.openigtlink.empty()) && !options.fast))
    options.realtime = true;
  if (prepared.link) {
    real.emplace(RigOnBuses{*prepared.link, prepared.buses.real, *session.scene().device->rig,
                            session.scene().step, prepared.profiles});
    const std::vector<std::string> closed = open_buses(real->link, real->where, real->rig);
    print_lines(stderr, "", closed);
    if (!closed.empty()) return ExitCode::not_available;
  }
  if (const std::string why_not = connect_spacemouse(options, prepared); !why_not.empty()) {
    print_lines(stderr, "", {why_not});
    return ExitCode::not_available;
  }
  if (prepared.has_own_device) {
    const std::string why_not = add_own_device(options, prepared);
    print_lines(stderr, "", {why_not.empty() ? "the device is that of this program" : why_not});
    if (!why_not.empty()) return ExitCode::not_available;
  }
  if (prepared.socket_device) {
    const std::string why_not = prepared.socket_device->open(options.device);
    print_lines(stderr, "", {why_not.empty() ? "the device is the program on " + options.device : why_not});
    if (!why_not.empty()) return ExitCode::not_available;
  }
  if (prepared.world) {
    const SceneConfig& scene = session.scene();
    const std::string why_not = prepared.shared_world->open(options.world, scene.world_planes, scene.step);
    print_lines(stderr, "",
                {why_not.empty() ? "the world is the program on /dev/shm/" + options.world : why_not});
    if (!why_not.empty()) return ExitCode::not_available;
  }
  RunView view;
  if (options.view) {
    const std::string why_not = view.start(options, prepared);
    print_lines(stderr, "", why_not.empty() ? view.announcement() : std::vector{why_not});
    if (!why_not.empty()) return ExitCode::not_available;
  }
  const Nanoseconds origin_ns = prepared.log ? 0 : log_origin_ns();  // a log has times of day
  std::string no_openigtlink;
  const std::unique_ptr<OpenIgtLinkServer> openigtlink =
      start_openigtlink(options, prepared, origin_ns, no_openigtlink);
  if (!no_openigtlink.empty()) {
    print_lines(stderr, "", {no_openigtlink});
    return ExitCode::not_available;
  }
  std::optional<Nanoseconds> wall_origin_ns;
  if (session.bus() == BusChoice::real && !prepared.log) wall_origin_ns = origin_ns;
  RunFiles files(options.files, session.scene(), wall_origin_ns.value_or(0));
  const std::optional<RunResult> result = run_to_end(options, prepared, files, real ? &*real : nullptr, view);
  if (!result) {
    std::fputs(
        "--realtime: the program cannot start a thread on this machine; raise the limits of processes and "
        "memory (ulimit -u, ulimit -v)\n",
        stderr);
    return ExitCode::not_available;
  }
  if (prepared.log && result->statistics.cycles < prepared.plan.num_cycles && prepared.log->ended() &&
      !options.quiet)
    print_lines(stderr, "note: ", {"the log ended after step " + std::to_string(result->statistics.cycles)});
  const StopSignals closing(
      Suspension::stops);  // The motors are off; files and summary are completed all the same.
  const std::vector<FileLoss> losses = files.close();
  RunReport report = make_report(options, prepared, *result, losses);
  report.fault_files = files.fault_files();
  report.wall_origin_ns = wall_origin_ns;
  static_cast<void>(make_folders(options));  // some may have been removed during the run
  if (!options.report.empty())
    if (const std::string why = write_report(options.report, report); !why.empty())
      report.faults.push_back(
          {.name = "file_incomplete", .text = options.report + " could not be written: " + why});
  const std::string not_shown =
      write_whole(options.quiet ? STDERR_FILENO : STDOUT_FILENO, summary_of(report));
  if (!not_shown.empty())
    static_cast<void>(write_whole(STDERR_FILENO, "the summary could not be written: " + not_shown + "\n"));
  return not_shown.empty() && report.faults.empty() ? ExitCode::ok : ExitCode::fault;
}

/// Sorts the names of --record by their endings: at most one log of frames and one of inputs.
void take_record(RunFileNames& files, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    std::string& file = is_input_log(name) ? files.inputs : files.record;
    if (!file.empty())
      throw CLI::ValidationError("--record", "'" + file + "' and '" + name +
                                                 "' are of one kind: give one name, or let one end in " +
                                                 std::string(input_log_ending));
    file = name;
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): a list
void add_run_options(CLI::App& verb, RunOptions& options) {
  verb.add_option("SCENE", options.scene, "read this scene file (TOML), see docs/scenes.md")->required();
  auto* realtime = verb.add_flag("--realtime", options.realtime,
                                 "run in wall time: one cycle per period on a real-time thread, with a "
                                 "status line; implied by real buses");
  auto* fast = verb.add_flag("--fast", options.fast,
                             "run on a simulated clock, as fast as the machine allows, with bit-identical "
                             "results (default); excludes --realtime");
  fast->excludes(realtime);
  verb.add_flag("--require-rt", options.require_rt,
                "refuse a machine without any of the real-time requirements that godobject doctor lists; "
                "implies --realtime")
      ->excludes(fast);
  auto* core = verb.add_option("--core", options.core,
                               "run the loop's thread on this core, and the other threads on the others; "
                               "implies --realtime. See docs/how-to/deploy.md")
                   ->type_name("CORE")
                   ->check(CLI::Range(0, 1023))
                   ->excludes(fast);
  verb.add_option("--deadline", options.deadline_us,
                  "schedule the loop's thread by SCHED_DEADLINE instead of SCHED_FIFO 80, with this time to "
                  "compute in each step, us; it needs all cores; implies --realtime")
      ->type_name("RUNTIME_US")
      ->check(number_in(10, 1e5))
      ->excludes(fast)
      ->excludes(core);
  verb.add_flag(
          "--seal", options.seal,
          "refuse every system call of the loop but those of docs/threads.md: a call cuts the torque and "
          "is a fault; implies --realtime")
      ->excludes(fast);
  verb.add_flag("--strict", options.strict,
                "refuse a scene with a driven axis that is not passive; see godobject check");
  verb.add_option("--duration", options.duration,
                  "run for this time, s; default: the motion file's end, else the scene's duration")
      ->check(number_above(0, 1e6));
  verb.add_option("--bus", options.buses,
                  "select the device. sim (default): simulated device; direct: no device, the motion drives "
                  "the core; ADDRESS or NAME=ADDRESS: real bus, once for each bus of the scene. ADDRESS is "
                  "socketcan:can0, slcan:/dev/ttyACM0, board:/dev/ttyACM1, replay:FILE, or pty: for a new "
                  "pseudo-terminal. See docs/running.md")
      ->type_name("BUS")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb.add_option(
          "--tracker", options.trackers,
          "use real trackers. NAME=PORT, once for each tracker of the scene: on this serial line; scene: on "
          "the scene's own ports. Without this option trackers are simulated. See docs/trackers.md")
      ->type_name("TRACKER")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb.add_option_function<std::string>(
          "--spacemouse", [&options](const std::string& socket) { options.spacemouse = socket; },
          "move the tool with the scene's SpaceMouse, until the run is stopped. SOCKET is that of spacenavd; "
          "default: $SPNAV_SOCKET, or /run/spnav.sock. Without this option the scene's motion moves the "
          "tool. See docs/trackers.md")
      ->type_name("[SOCKET]")
      ->expected(0, 1);
  verb.add_option("--device", options.device,
                  "use a program of your own as the device: it connects to this local socket, which is made, "
                  "sends poses and receives the wrench, until the run is stopped. See "
                  "docs/how-to/device-of-your-own.md")
      ->type_name("SOCKET");
  verb.add_option("--world", options.world,
                  "let a slower simulation of your own surround the tool: it writes contact planes to this "
                  "shared memory, which is made, and reads pose and impulses. See docs/how-to/slow-world.md")
      ->type_name("NAME");
  verb.add_option_function<std::string>(
          "--rearm",
          [&options](const std::string& when) {
            options.rearm = when == "auto" ? Rearm::automatic : Rearm::never;
          },
          "select the action after a fault of the device. never (default): the torque stays off; auto: once "
          "its buses are back, set up and boot its nodes and ARM the motors again")
      ->check(CLI::IsMember({"never", "auto"}));
  verb.add_option("--motion", options.motion,
                  "read the motion of the hand from this file instead of the scene: a CSV over time of "
                  "target poses or joint coordinates, and of grip and clutch")
      ->type_name("FILE");
  verb.add_option("--integrator", options.integrator, "use this integrator instead of the scene's")
      ->check(CLI::IsMember(std::vector<std::string>(integrator_names.begin(), integrator_names.end())));
  verb.add_option("--step", options.step, "use this step instead of the scene's, s")
      ->check(number_in(1e-6, 0.1));
  verb.add_option("--trace", options.files.trace,
                  "write a CSV of bodies, wrenches, target, energy and faults at every step")
      ->type_name("FILE");
  verb.add_option("--trace-every", options.files.trace_every,
                  "write to --trace and --contacts only every N-th step, and the steps in which a fault "
                  "begins or ends")
      ->type_name("N")
      ->check(CLI::Range(1, 1'000'000));
  verb.add_option("--contacts", options.files.contacts,
                  "write a CSV of every contact at every step: body, other side, point, normal, force")
      ->type_name("FILE");
  verb.add_option("--nets", options.files.nets,
                  "write a CSV of the positions of all nodes of all nets, one row per frame")
      ->type_name("FILE");
  verb.add_option("--nets-every", options.files.nets_every, "write to --nets a frame every N-th step")
      ->type_name("N")
      ->capture_default_str()
      ->check(CLI::Range(1, 1'000'000));
  verb.add_option_function<std::vector<std::string>>(
          "--record",
          [&options](const std::vector<std::string>& names) { take_record(options.files, names); },
          "write a log of every frame on every bus, in candump's format, or, if the name ends in .godo, all "
          "inputs of rig and engine for godobject replay; give it twice for both")
      ->type_name("FILE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb.add_option_function<std::string>(
          "--on-fault",
          [&options](const std::string& name) {
            options.files.on_fault = name == "none" ? "" : name;
            options.keeps_faults = name != "none";
          },
          "keep the inputs of the last 10 s, at most 64 MB, in memory, and write them at each fault, for "
          "godobject replay; the name ends in .godo, and later files have numbers. none: write nothing. "
          "Default: none, but on real buses and trackers a file named by scene and time, beside the "
          "report, trace or record, or else in this folder")
      ->type_name("FILE");
  verb.add_option("--report", options.report, "write a JSON of everything in the summary, and the histograms")
      ->type_name("FILE");
  verb.add_option_function<std::string>(
          "--view",
          [&options](const std::string& port) {
            options.view = static_cast<std::uint16_t>(std::stoul("0" + port));
          },
          "serve a page that shows the run, on this machine only, and print its address; default port: 7780, "
          "or the next free one. The run is in wall time, unless --fast is given. See docs/view.md")
      ->type_name("[PORT]")
      ->expected(0, 1)
      ->check(port_number());
  verb.add_option("--view-address", options.view_address,
                  "listen on this address instead of 127.0.0.1: everybody who reaches it and has the token "
                  "sees the run")
      ->type_name("ADDRESS");
  verb.add_flag("--view-input", options.view_input,
                "use the pointer in the page as the device: it grips coupled bodies and moves them; without "
                "buses, until the run is stopped");
  verb.add_option("--openigtlink", options.openigtlink,
                  "serve poses, wrenches and state by OpenIGTLink on this TCP port, of this machine only, or "
                  "on ADDRESS:PORT. The run is in wall time, unless --fast is given. See docs/view.md")
      ->type_name("PORT");
  verb.add_option("--openigtlink-rate", options.openigtlink_rate_hz, "send them at this rate, Hz")
      ->capture_default_str()
      ->check(number_in(0.1, 1000));
  verb.add_flag("--quiet", options.quiet, "print only warnings and faults; see the exit code");
}

void add_run(CLI::App& app, const ProgramParts& parts, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("run", "Run a scene.");
  const auto options = std::make_shared<RunOptions>();
  options->parts = parts;
  add_run_options(*verb, *options);
  verb->callback([options, &code] { code = run(*options); });
}

}  // namespace godobject
