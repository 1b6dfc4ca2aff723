// godobject view: shows a trace, a recording of buses or a scene, in a browser or as a picture. Also the view
// of a run.
#include "platform/cli/run/options.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <thread>

#include <nlohmann/json.hpp>

#include "platform/cli/command_line.h"
#include "platform/cli/fault_texts.h"
#include "platform/cli/program.h"
#include "platform/rt/signals.h"
#include "platform/scene/toml.h"
#include "platform/trace/trace.h"
#include "platform/view/picture/picture.h"
#include "platform/view/recorded/recording.h"
#include "platform/view/server/server.h"

namespace godobject {
namespace {

constexpr std::size_t view_console_bytes = 1 << 16;

template <class Text>
BitText words_of(const Text& text) {
  return {.name = std::string(text.name),
          .text = std::string(text.meaning) + ": " + std::string(text.remedy)};
}

namespace fs = std::filesystem;

constexpr double picture_rate_hz = 12;  // rate of an animation

struct ViewOptions {
  std::string file, scene, picture, nets;
  std::optional<double> time;      // s
  std::optional<double> duration;  // s, length of an animation
  std::uint16_t port = 0;
  std::string address = "127.0.0.1";
  FaultChecks faults{};  // simulation of the program
  std::vector<std::uint32_t> size{960, 600};
};

int complain(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) std::fprintf(stderr, "%s\n", line.c_str());
  return static_cast<int>(lines.size());
}

bool is(const std::string& path, const char* extension) { return fs::path(path).extension() == extension; }

/// Returns the path of a file named by the report beside a trace or a log, under these keys; empty if there
/// is none. Paths in the report are relative to the folder of the run, which it names.
std::string of_report(const std::string& file, const std::vector<std::string>& keys) {
  const fs::path folder = fs::path(file).parent_path();
  std::ifstream in(folder / "report.json");
  nlohmann::json value = nlohmann::json::parse(in, nullptr, false);
  fs::path of_run;
  if (value.is_object() && value.contains("folder") && value["folder"].is_string())
    of_run = value["folder"].get<std::string>();
  for (const std::string& key : keys) {
    if (!value.is_object() || !value.contains(key)) return "";
    value = value[key];
  }
  if (!value.is_string() || value.get<std::string>().empty()) return "";
  const std::string named = value;
  std::error_code ignored;
  for (const fs::path& path : {of_run / named, fs::path(named), folder / named})
    if (fs::exists(path, ignored)) return path.string();
  return "";
}

/// Reads the node positions of the trace's nets from --nets, or from the file named by the report beside the
/// trace. Returns false if the file of --nets does not fit.
bool add_nets(const ViewOptions& options, Recording& recording) {
  const bool is_trace = is(options.file, ".csv");
  if (!options.nets.empty() && !is_trace) {
    complain({"--nets: requires a trace (.csv) as FILE; " + options.file + " is not one"});
    return false;
  }
  std::string path = options.nets;
  if (path.empty() && is_trace && !recording.scene.nets.empty())
    path = of_report(options.file, {"files", "nets"});
  if (path.empty()) return true;
  NetRecordingResult result = read_nets(path, recording.scene);
  const double begin = recording.samples.front().record.t, end = recording.samples.back().record.t;
  if (result.nets && (result.nets->begin() > end || result.nets->end() < begin))
    result.errors.push_back(path + ": its times do not overlap those of " + options.file +
                            ": give the file of the same run");
  complain(result.errors);
  recording.nets = std::move(result.nets);
  return result.errors.empty() || options.nets.empty();
}

/// Reads a trace of the scene, or, if its columns differ, of the scene moved by a page's pointer.
RecordingResult read_trace_of(const std::string& path, const SceneConfig& scene) {
  RecordingResult result = read_trace(path, scene);
  if (result.recording) return result;
  SceneConfig moved = scene;
  lead_by_pointer(moved);
  RecordingResult of_pointer = read_trace(path, moved);
  return of_pointer.recording ? of_pointer : result;
}

std::optional<Recording> load(const ViewOptions& options) {
  const bool is_scene = is(options.file, ".toml");
  const std::string path = is_scene                 ? options.file
                           : !options.scene.empty() ? options.scene
                                                    : of_report(options.file, {"scene_file"});
  if (path.empty()) {
    complain({options.file + ": its scene is unknown: give the scene file with --scene, or put the run's "
                             "--report beside it as report.json"});
    return std::nullopt;
  }
  const LoadResult loaded = load_scene(path, options.faults);
  complain(loaded.errors);
  if (!loaded.scene) return std::nullopt;
  RecordingResult result;
  if (is_scene) result.recording = recording_of(*loaded.scene);
  else
    result = is(options.file, ".csv") ? read_trace_of(options.file, *loaded.scene)
                                      : replay_log(options.file, path, *loaded.scene);
  complain(result.errors);
  for (const std::string& note : result.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  if (result.recording && !add_nets(options, *result.recording)) return std::nullopt;
  return std::move(result.recording);
}

std::vector<Image> frames_of(const ViewOptions& options, const Recording& recording, const Drawing& drawing) {
  std::vector<Image> images;
  const double begin = options.time.value_or(recording.samples.front().record.t);
  const auto num = static_cast<int>(*options.duration * picture_rate_hz);
  for (int i = 0; i < std::max(1, num); ++i)
    images.push_back(drawn(picture_of(recording, drawing, sample_at(recording, begin + i / picture_rate_hz)),
                           options.size[0], options.size[1]));
  return images;
}

ExitCode leave_picture(const ViewOptions& options, const Recording& recording) {
  const Drawing drawing = drawing_of(recording.scene);
  std::string bytes;
  if (is(options.picture, ".gltf"))
    bytes = gltf_of(picture_of(recording, drawing, sample_at(recording, options.time)));
  else if (options.duration) bytes = png_of(frames_of(options, recording, drawing), 1 / picture_rate_hz);
  else
    bytes = png_of({drawn(picture_of(recording, drawing, sample_at(recording, options.time)), options.size[0],
                          options.size[1])});
  return write_file("--picture", options.picture, bytes) ? ExitCode::ok : ExitCode::fault;
}

ExitCode serve(const ViewOptions& options, const Recording& recording) {
  ViewAbout about{.title = options.file, .live = false, .warning = view_warning(options.address)};
  add_words(about);
  RecordedView source(recording, about);
  const ServerSettings settings{.address = options.address, .port = options.port, .token = view_token()};
  const StopSignals stop;
  std::string why_not;
  const std::unique_ptr<ViewServer> server = ViewServer::start(
      settings, source, [](const std::string& line) { std::fprintf(stderr, "view: %s\n", line.c_str()); },
      why_not);
  if (!server) {
    complain({why_not});
    return ExitCode::not_available;
  }
  complain(view_lines(server->url(), options.address));
  std::fputs("view: press Ctrl-C to end it\n", stderr);
  while (!stop.requested()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return ExitCode::ok;
}

ExitCode view(const ViewOptions& options) {
  if (!options.picture.empty() && !is(options.picture, ".png") && !is(options.picture, ".gltf")) {
    complain({"--picture: '" + options.picture + "' must end in .png or .gltf"});
    return ExitCode::usage;
  }
  const std::optional<Recording> recording = load(options);
  if (!recording) return ExitCode::usage;
  return options.picture.empty() ? serve(options, *recording) : leave_picture(options, *recording);
}

/// True if pages may pause the run: its only device is the page or simulated, and no one expects wall time.
bool may_pause(const RunOptions& options, const PreparedRun& prepared) {
  return !has_hardware(options, prepared) && (options.view_input || !options.realtime);
}

}  // namespace

void add_words(ViewAbout& about) {
  for (const CoreFaultText& fault : core_fault_texts) about.faults.push_back(words_of(fault.text));
  for (const RigFaultText& fault : rig_fault_texts()) about.rig_faults.push_back(words_of(fault));
  for (const RunLimit& limit : run_limits)
    about.limits.push_back({.name = std::string(limit.name), .text = std::string(limit.remedy)});
}

std::string view_warning(const std::string& address) {
  if (is_loopback(address)) return "";
  return "served on " + address +
         ", unencrypted: everybody who reaches this address and sees the token can watch";
}

std::string RunView::start(const RunOptions& options, PreparedRun& prepared) {
  ViewAbout about{.title = options.scene,
                  .takes_pointer = options.view_input,
                  .takes_pace = may_pause(options, prepared),
                  .fast = !options.realtime,
                  .no_reset = why_no_reset(options, prepared),
                  .warning = view_warning(options.view_address)};
  add_words(about);
  for (const BusLoad& load : prepared.bus_loads)
    about.buses.push_back({.name = load.bus, .percent = load.worst_percent});
  address_ = options.view_address;
  console_ = std::make_unique<BackgroundFile>(STDERR_FILENO, view_console_bytes);
  live_ = std::make_unique<LiveView>(*prepared.session, about, prepared.pointer.get(),
                                     prepared.joint_pointer.get());
  const ServerSettings settings{.address = address_, .port = *options.view, .token = view_token()};
  const auto log = [this](const std::string& line) {
    static_cast<void>(console_->write("view: " + line + "\n"));
  };
  std::string why_not;
  server_ = ViewServer::start(settings, *live_, log, why_not);
  if (server_) prepared.plan.tap = &live_->tap();
  return why_not;
}

std::string RunView::start_again(const RunOptions& options, PreparedRun& prepared) {
  PreparedRun next = prepare_again(options, prepared);
  if (!next.session) return next.errors.front();
  live_->restart(*next.session, next.pointer.get(), next.joint_pointer.get());
  prepared.session = std::move(next.session);  // the former one, before its devices
  prepared.pointer = std::move(next.pointer);
  prepared.joint_pointer = std::move(next.joint_pointer);
  return "";
}

std::vector<std::string> view_lines(const std::string& url, const std::string& address) {
  std::vector<std::string> lines{"view: " + url};
  if (const std::string warning = view_warning(address); !warning.empty())
    lines.push_back("view: WARNING: " + warning);
  if (!has_page())
    lines.push_back(
        "view: this program was built without its page, which requires npm and esbuild: run ./dev setup "
        "view, then build again");
  return lines;
}

void add_view(CLI::App& app, const FaultChecks& checks, ExitCode& code) {
  CLI::App* verb = app.add_subcommand(
      "view", "Show a trace, a recording of buses or a scene in a browser or as a picture.");
  const auto options = std::make_shared<ViewOptions>();
  options->faults = checks;
  verb->add_option("FILE", options->file,
                   "show this file: a trace of `run --trace` (.csv), a log of `run --record`, or the start "
                   "of a scene (.toml)")
      ->required();
  verb->add_option("--scene", options->scene,
                   "use this scene for the trace or the log; default: the one named by report.json beside it")
      ->type_name("SCENE");
  verb->add_option(
          "--nets", options->nets,
          "read the positions of the nets' nodes from this file of `run --nets`; default: the file named by "
          "report.json beside the trace. Without one nets are drawn at rest on their bodies")
      ->type_name("FILE");
  verb->add_option("--picture", options->picture, "write a picture to this file, .png or .gltf, and end")
      ->type_name("FILE");
  verb->add_option("--time", options->time, "draw this instant, s; default: the last one")
      ->check(number_in(0, 1e9));
  verb->add_option("--duration", options->duration,
                   "draw an animation (.png) of this length from --time or the beginning on, s")
      ->check(number_above(0, 60));
  verb->add_option("--size", options->size, "draw a picture of WIDTH HEIGHT pixels")
      ->expected(2)
      ->check(CLI::Range(16, 8192))
      ->type_name("N");
  verb->add_option("--port", options->port,
                   "serve the page on this port; default: 7780, or the next free one")
      ->check(CLI::Range(1, 65535))
      ->type_name("PORT");
  verb->add_option("--address", options->address, "listen on this address instead of 127.0.0.1")
      ->type_name("ADDRESS");
  verb->callback([options, &code] { code = view(*options); });
}

}  // namespace godobject
