
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "platform/cli/run/options.h"
#include "platform/linux/bus/bus.h"
#include "platform/rt/background_file.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

void plan_port(const std::string& text, std::vector<TrackerParams>& trackers, std::vector<bool>& has_port,
               std::vector<std::string>& errors) {
  const NamedAddress given = split_name(text, '/');  // a port is a path
  const auto tracker = given.name.empty() && trackers.size() == 1
                           ? trackers.begin()
                           : std::ranges::find(trackers, given.name, &TrackerParams::name);
  if (tracker == trackers.end()) {
    errors.push_back("--tracker " + text + ": the scene's trackers are " + quoted_names(trackers) +
                     ": give " + trackers.front().name + "=PORT");
    return;
  }
  const auto index = static_cast<std::size_t>(tracker - trackers.begin());
  if (has_port[index])
    errors.push_back("--tracker: tracker '" + tracker->name + "' is given twice: remove one");
  if (given.address.empty()) errors.push_back("--tracker " + text + ": the port is missing: give NAME=PORT");
  has_port[index] = true;
  tracker->port = given.address;
}

}  // namespace

BusPlan plan_buses(std::span<const std::string> given, const SceneConfig& scene,
                   std::vector<std::string>& errors, std::vector<std::string>& notes) {
  BusPlan plan;
  const auto is_choice = [](const std::string& text) { return text == "sim" || text == "direct"; };
  if (given.empty()) {
    if (scene.device && (scene.device->rig || !scene.device->trackers.empty())) return plan;
    const bool has_other_hand = scene.device && scene.device->spacemouse;
    if (!has_other_hand)
      notes.push_back("scene '" + scene.name + "' describes no buses: this run uses --bus direct");
    plan.choice = BusChoice::direct;
  } else if (std::ranges::any_of(given, is_choice)) {
    if (given.size() > 1) errors.push_back("--bus: sim and direct apply to all buses: give --bus once");
    plan.choice = given.front() == "sim" ? BusChoice::sim : BusChoice::direct;
  } else {
    plan.choice = BusChoice::real;
    if (scene.device && scene.device->rig) plan.real = rig_addresses(given, scene, "--bus", errors);
    else
      errors.push_back("--bus: scene '" + scene.name +
                       "' describes no buses: add them, with encoders and joints, or use --bus direct");
  }
  return plan;
}

void plan_trackers(std::span<const std::string> given, bool buses_are_given, SceneConfig& scene,
                   BusPlan& plan, std::vector<std::string>& errors) {
  if (given.empty()) return;
  if (!scene.device || scene.device->trackers.empty()) {
    errors.push_back("--tracker: scene '" + scene.name +
                     "' has no trackers: remove --tracker, or add [[device.tracker]] tables");
    return;
  }
  if (plan.choice != BusChoice::real && (scene.device->rig || buses_are_given)) {
    errors.push_back(
        "--tracker: real trackers run in wall time, and the buses of this run do not: give --bus the "
        "addresses of real buses, or remove --tracker");
    return;
  }
  plan.choice = BusChoice::real;
  std::vector<TrackerParams>& trackers = scene.device->trackers;
  std::vector<bool> has_port(trackers.size(), false);
  for (const std::string& text : given) {
    if (text == "scene") has_port.assign(trackers.size(), true);
    else plan_port(text, trackers, has_port, errors);
  }
  for (std::size_t i = 0; i < trackers.size(); ++i)
    if (!has_port[i] && errors.empty())
      errors.push_back("--tracker: tracker '" + trackers[i].name +
                       "' of the scene has no port: give --tracker " + trackers[i].name + "=PORT");
}

ToolDefinitions read_tool_definitions(const TrackerParams& params, const std::filesystem::path& folder,
                                      std::vector<std::string>& errors) {
  constexpr std::string_view magic("NDI\0", 4);
  constexpr std::size_t max_definition_bytes = 1 << 20;  // real files have some hundred bytes
  ToolDefinitions definitions(params.tools.size());
  for (std::size_t i = 0; i < params.tools.size(); ++i) {
    const std::string& tool = params.tools[i].tool;
    if (!needs_definition(params.protocol, tool)) continue;
    const std::string where = "tracker '" + params.name + "': tool " + excerpt(tool) + " ";
    const FilePath path = path_below(folder.string(), tool);
    FileText file;
    if (!path.path.empty()) file = read_file(path.path, max_definition_bytes);
    if (!file.text) {
      errors.push_back(where + (path.path.empty() ? path.why_not : file.why_not) +
                       "; give the two digits of a port handle (\"0A\"), or a tool definition file");
    } else if (!file.text->starts_with(magic)) {
      errors.push_back(where +
                       "is not a tool definition file (.rom), which begins with NDI: give another file");
    } else {
      definitions[i].assign(file.text->begin(), file.text->end());
    }
  }
  return definitions;
}

std::vector<std::unique_ptr<TrackerThread>> start_trackers(const std::vector<TrackerParams>& trackers,
                                                           const std::filesystem::path& folder,
                                                           std::vector<std::string>& errors) {
  std::vector<std::unique_ptr<Tracker>> made;
  for (const TrackerParams& params : trackers) {
    const std::size_t before = errors.size();
    ToolDefinitions definitions = read_tool_definitions(params, folder, errors);
    if (errors.size() > before) continue;
    MadeTracker tracker = make_tracker(params, std::move(definitions));
    errors.insert(errors.end(), tracker.errors.begin(), tracker.errors.end());
    made.push_back(std::move(tracker.tracker));
  }
  std::vector<std::unique_ptr<TrackerThread>> threads;
  if (!errors.empty()) return threads;
  for (std::unique_ptr<Tracker>& tracker : made)
    threads.push_back(std::make_unique<TrackerThread>(std::move(tracker)));
  return threads;
}

std::unique_ptr<OpenIgtLinkServer> start_openigtlink(const RunOptions& options, PreparedRun& prepared,
                                                     Nanoseconds wall_origin_ns, std::string& why_not) {
  if (options.openigtlink.empty()) return nullptr;
  OpenIgtLinkServer::Settings settings{.rate_hz = options.openigtlink_rate_hz,
                                       .wall_origin_ns = wall_origin_ns};
  const std::size_t colon = options.openigtlink.rfind(':');
  if (colon != std::string::npos) settings.address = options.openigtlink.substr(0, colon);
  const std::string port = options.openigtlink.substr(colon == std::string::npos ? 0 : colon + 1);
  const char* const end = port.data() + port.size();
  if (const auto [stop, error] = std::from_chars(port.data(), end, settings.port);
      error != std::errc() || stop != end || settings.port == 0) {
    why_not = "--openigtlink: '" + port + "' is no TCP port: give PORT or ADDRESS:PORT, 1 to 65535";
    return nullptr;
  }
  std::unique_ptr<OpenIgtLinkServer> server = OpenIgtLinkServer::start(settings, *prepared.session, why_not);
  if (server) prepared.plan.poses_tap = &server->tap();
  return server;
}

void check_spacemouse(const RunOptions& options, const SceneConfig& scene, PreparedRun& run) {
  const bool has_one = scene.device && scene.device->spacemouse;
  if (!options.spacemouse) {
    if (has_one && !options.view_input)
      run.notes.push_back("scene '" + scene.name +
                          "' has a SpaceMouse, which --spacemouse uses: this run uses the scene's motion");
    return;
  }
  if (!has_one)
    run.errors.push_back("--spacemouse: scene '" + scene.name +
                         "' has no SpaceMouse: add [device.spacemouse] (docs/scenes.md)");
  if (options.fast) run.errors.push_back("--spacemouse: requires wall time: remove --fast");
  if (!options.motion.empty()) run.errors.push_back("--spacemouse: replaces --motion: remove either");
  if (options.view_input)
    run.errors.push_back("--spacemouse: excludes --view-input, since both move the tool: remove either");
}

void check_socket_device(const RunOptions& options, const SceneConfig& scene,
                         std::vector<std::string>& errors) {
  if (options.device.empty()) return;
  const std::string of_scene = "--device: scene '" + scene.name + "' ";
  if (!scene.device) errors.push_back(of_scene + "has no [device]: add one (docs/scenes.md)");
  else if (scene.device->kind == DeviceKind::admittance)
    errors.push_back(of_scene + "has an admittance device, and the program sends poses: give another kind");
  if (driven_bodies(scene).empty()) errors.push_back(of_scene + "has no coupled body: add a [body.coupling]");
  const std::pair<bool, const char*> others[] = {{options.fast, "--fast"},
                                                 {!options.motion.empty(), "--motion"},
                                                 {!options.buses.empty(), "--bus"},
                                                 {!options.trackers.empty(), "--tracker"},
                                                 {options.spacemouse.has_value(), "--spacemouse"},
                                                 {options.view_input, "--view-input"}};
  for (const auto& [given, name] : others)
    if (given)
      errors.push_back(std::string("--device: excludes ") + name +
                       ", since the program moves the tool in wall time: remove either");
}

void check_world(const RunOptions& options, SceneConfig& scene, std::vector<std::string>& errors) {
  if (options.world.empty()) return;
  const std::string of_scene = "--world: scene '" + scene.name + "' ";
  const std::size_t materials = materials_of(scene).size();  // each plane has a material of its own
  scene.world_planes = std::min(max_world_planes, max_materials - std::min(materials, max_materials));
  if (scene.world_planes == 0)
    errors.push_back(of_scene + "has " + std::to_string(materials) + " materials, and the core holds " +
                     std::to_string(max_materials) + " with one for each plane: use fewer");
  else if (contact_scope(scene) == ContactScope::none)
    errors.push_back(of_scene +
                     "has no body with spheres or shapes that touch planes: add a [[body.sphere]]");
  if (options.fast) errors.push_back("--world: requires wall time: remove --fast");
  if (options.files.records_inputs())
    errors.push_back(
        "--world: excludes input logs (--record FILE.godo, --on-fault), since replay has no planes of "
        "another "
        "simulation: remove either");
}

std::string add_own_device(const RunOptions& options, PreparedRun& run) {
  std::string why_not;
  run.own_device = options.parts.device(run.session->scene(), why_not);
  if (run.own_device) run.session->add(*run.own_device);
  else if (why_not.empty()) why_not = "the device of this program cannot be made";
  return run.own_device ? "" : why_not;
}

std::string connect_spacemouse(const RunOptions& options, PreparedRun& run) {
  if (!run.spacemouse) return "";
  constexpr std::size_t console_bytes = 1 << 12;
  const auto console = std::make_shared<BackgroundFile>(STDERR_FILENO, console_bytes);
  const auto log = [console](const std::string& line) { static_cast<void>(console->write(line + "\n")); };
  const std::string socket = options.spacemouse->empty() ? spacenav_socket() : *options.spacemouse;
  std::string why_not;
  run.spacemouse_thread = SpaceMouseThread::start(socket, *run.spacemouse, log, why_not);
  return why_not;
}

}  // namespace godobject
