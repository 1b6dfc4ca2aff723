// godobject monitor: prints the messages on buses, decoded.
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "platform/cli/bus/messages.h"
#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/linux/bus/bus.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/signals.h"
#include "platform/scene/toml.h"

namespace godobject {
namespace {

constexpr Nanoseconds redraw_period = 250'000'000;

struct MonitorOptions {
  std::vector<std::string> buses;
  std::string scene;
  double bit_rate = 0;  // 0: the scene's, else 1 Mbit/s
  std::optional<double> duration;
  bool plain = false;
  FaultChecks faults{};  // simulation of the program
};

/// Buses in the order of the options, and the table of their messages.
struct Monitor {
  std::optional<RigParams> rig;
  std::vector<const BusBackend*> backends;
  std::vector<std::unique_ptr<LinuxBus>> buses;
  std::optional<MessageTable> table;
};

bool load_rig(const std::string& path, const FaultChecks& checks, std::optional<RigParams>& rig) {
  if (path.empty()) return true;
  LoadResult loaded = load_scene(path, checks);
  for (const std::string& error : loaded.errors) std::fprintf(stderr, "%s\n", error.c_str());
  if (!loaded.scene) return false;
  if (loaded.scene->device && loaded.scene->device->rig) {
    rig = std::move(loaded.scene->device->rig);
    return true;
  }
  std::fprintf(stderr, "--scene: scene '%s' describes no buses\n", path.c_str());
  return false;
}

/// Returns the index of the scene's bus and removes its name from `text`: "can1=replay:run.log" is bus can1.
/// Without a name the buses follow the scene's order. Returns none if there is no such bus.
std::optional<std::size_t> take_bus_of_scene(std::string& text, const std::optional<RigParams>& rig,
                                             std::size_t position) {
  const NamedAddress given = split_name(text, ':');
  if (given.address.size() == text.size()) return position;
  text = given.address;
  for (std::size_t i = 0; rig && i < rig->buses.size(); ++i)
    if (rig->buses[i].name == given.name) return i;
  return std::nullopt;
}

bool add_bus(const MonitorOptions& options, std::string text, Monitor& monitor,
             std::vector<MonitoredBus>& shown) {
  const std::string given = text;
  const std::optional<std::size_t> of_scene = take_bus_of_scene(text, monitor.rig, shown.size());
  if (!of_scene) {
    std::fprintf(
        stderr, "--bus %s: %s\n", given.c_str(),
        monitor.rig ? "the scene has no bus of that name" : "a name requires the scene's: give --scene");
    return false;
  }
  std::string error;
  const std::optional<BusAddress> address = parse_bus_address(text, error);
  if (!address) {
    std::fprintf(stderr, "--bus: %s\n", error.c_str());
    return false;
  }
  const bool has_nodes = monitor.rig && *of_scene < monitor.rig->buses.size();
  BusSettings settings;
  MonitoredBus bus{.name = "bus" + std::to_string(shown.size()), .bit_rates = {}, .decoder = {}};
  if (has_nodes) {
    const BusParams& params = monitor.rig->buses[*of_scene];
    settings.bit_rate = params.bit_rate;
    settings.data_bit_rate = params.data_bit_rate;
    bus.name = params.name;
    bus.decoder = MessageDecoder(*monitor.rig, *of_scene);
  }
  if (options.bit_rate > 0) settings.bit_rate = options.bit_rate;
  bus.bit_rates = {.nominal = settings.bit_rate,
                   .data = settings.data_bit_rate > 0 ? settings.data_bit_rate : settings.bit_rate};
  monitor.backends.push_back(address->backend);
  monitor.buses.push_back(make_bus(*address, settings));
  shown.push_back(std::move(bus));
  return true;
}

ExitCode open_buses(Monitor& monitor) {
  for (std::size_t i = 0; i < monitor.buses.size(); ++i) {
    LinuxBus& bus = *monitor.buses[i];
    if (!bus.open()) {
      std::fprintf(stderr, "--bus: %s\n", bus.trouble().c_str());
      return monitor.backends[i]->is_file ? ExitCode::usage : ExitCode::not_available;
    }
    if (monitor.backends[i]->makes_terminal) std::fprintf(stderr, "%s\n", bus.trouble().c_str());
  }
  return ExitCode::ok;
}

/// True if the bus is gone or its log is at its end, so that no more frames arrive.
bool has_ended(const Monitor& monitor, std::size_t i) {
  const BusState state = monitor.buses[i]->state();
  return state == BusState::gone || (state == BusState::down && !monitor.backends[i]->comes_back);
}

bool all_ended(const Monitor& monitor) {
  for (std::size_t i = 0; i < monitor.buses.size(); ++i)
    if (!has_ended(monitor, i)) return false;
  return true;
}

std::string bus_line(const Monitor& monitor, std::size_t i) {
  const MonitoredBus& shown = monitor.table->bus(i);
  const LinuxBus& bus = *monitor.buses[i];
  const BusCounters counters = bus.counters();
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(),
                "%-8s %s: %s, %llu frames, load %.1f %% of %g kbit/s, %llu errors, %llu lost ",
                shown.name.c_str(), bus.name().c_str(), std::string(name_of(bus.state())).c_str(),
                static_cast<unsigned long long>(shown.count), shown.load_percent(),
                1e-3 * shown.bit_rates.nominal, static_cast<unsigned long long>(counters.error_frames),
                static_cast<unsigned long long>(counters.receive_overflow));
  std::string line = text.data();
  if (counters.last_error != BusError::none)
    line += "last: " + std::string(name_of(counters.last_error)) + " ";
  const std::string trouble = bus.trouble();
  return trouble.empty() ? line : line + "- " + trouble;
}

std::vector<std::string> screen(const Monitor& monitor) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < monitor.buses.size(); ++i) lines.push_back(bus_line(monitor, i));
  lines.emplace_back();
  for (std::string& line : monitor.table->lines()) lines.push_back(std::move(line));
  return lines;
}

/// Draws over the previous table, cut to the size of the terminal.
void redraw(const Monitor& monitor) {
  winsize size{.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
  ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
  std::vector<std::string> lines = screen(monitor);
  const std::size_t room = size.ws_row > 2 ? size.ws_row - 1u : 1u;
  if (lines.size() > room) {
    const std::size_t hidden = lines.size() - room + 1;
    lines.resize(room - 1);
    lines.push_back("... " + std::to_string(hidden) + " more lines: enlarge the terminal, or use --plain");
  }
  std::string text = "\033[H";
  for (const std::string& line : lines) text += line.substr(0, size.ws_col) + "\033[K\n";
  std::fputs((text + "\033[J").c_str(), stdout);
  std::fflush(stdout);
}

/// Waits for frames, at most until `until`.
void wait(const Monitor& monitor, Nanoseconds until) {
  std::vector<pollfd> waiting;
  for (std::size_t i = 0; i < monitor.buses.size(); ++i)
    waiting.push_back(
        {.fd = has_ended(monitor, i) ? -1 : monitor.buses[i]->descriptor(), .events = POLLIN, .revents = 0});
  const Nanoseconds left = std::max<Nanoseconds>(until - MonotonicClock().now(), 0);
  const timespec limit{.tv_sec = static_cast<time_t>(left / 1'000'000'000),
                       .tv_nsec = static_cast<long>(left % 1'000'000'000)};
  ppoll(waiting.data(), waiting.size(), &limit, nullptr);
}

void watch(Monitor& monitor, const MonitorOptions& options) {
  const StopSignals stop;
  const bool live = !options.plain && isatty(STDOUT_FILENO) == 1;
  const Nanoseconds start = MonotonicClock().now();
  const auto end = [&](Nanoseconds now) {
    return stop.requested() || all_ended(monitor) ||
           (options.duration && 1e-9 * static_cast<double>(now - start) >= *options.duration);
  };
  if (live) std::fputs("\033[2J", stdout);
  Nanoseconds next_redraw = start;
  for (Nanoseconds now = start; !end(now); now = MonotonicClock().now()) {
    if (live && now >= next_redraw) {
      redraw(monitor);
      next_redraw = now + redraw_period;
    }
    const Nanoseconds last =
        options.duration ? start + static_cast<Nanoseconds>(1e9 * *options.duration) : now + redraw_period;
    wait(monitor, std::min(last, std::max(next_redraw, now + redraw_period)));
    ReceivedFrame received;
    for (std::size_t i = 0; i < monitor.buses.size(); ++i)
      while (monitor.buses[i]->try_receive(received)) monitor.table->add(i, received);
  }
  if (live) std::fputs("\033[H\033[J", stdout);
  for (const std::string& line : screen(monitor)) std::printf("%s\n", line.c_str());
}

ExitCode run_monitor(const MonitorOptions& options) {
  Monitor monitor;
  if (!load_rig(options.scene, options.faults, monitor.rig)) return ExitCode::usage;
  std::vector<MonitoredBus> shown;
  for (const std::string& bus : options.buses)
    if (!add_bus(options, bus, monitor, shown)) return ExitCode::usage;
  monitor.table.emplace(std::move(shown));
  if (const ExitCode code = open_buses(monitor); code != ExitCode::ok) return code;
  watch(monitor, options);
  const bool lost =
      std::ranges::any_of(monitor.buses, [](const auto& bus) { return bus->state() == BusState::gone; });
  return lost ? ExitCode::fault : ExitCode::ok;
}

}  // namespace

void add_monitor(CLI::App& app, const FaultChecks& checks, ExitCode& code) {
  CLI::App* verb = app.add_subcommand(
      "monitor", "Print a table of the decoded messages of buses or logs, with their periods.");
  const auto options = std::make_shared<MonitorOptions>();
  options->faults = checks;
  verb->add_option("--bus", options->buses,
                   "read this bus: socketcan:IFACE, slcan:PATH, board:PATH, pty: or replay:FILE[,IFACE]; "
                   "several in the order of the scene's buses, or each as NAME=ADDRESS; see docs/buses.md")
      ->required();
  verb->add_option("--scene", options->scene, "name the messages after the joints of this scene file");
  verb->add_option("--bit-rate", options->bit_rate,
                   "set the bit rate where no scene gives it, bit/s (1000000)")
      ->check(CLI::PositiveNumber);
  verb->add_option("--duration", options->duration,
                   "end after this time, s; default: until Ctrl-C, or the end of the log")
      ->check(CLI::PositiveNumber);
  verb->add_flag("--plain", options->plain, "print the table once, at the end");
  verb->callback([options, &code] { code = run_monitor(*options); });
}

}  // namespace godobject
