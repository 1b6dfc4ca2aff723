#include "platform/cli/run/options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "platform/linux/bus/bus.h"
#include "platform/linux/device_threads.h"
#include "platform/rig/buses.h"
#include "platform/rt/cyclic.h"
#include "platform/scene/text/key.h"
#include "platform/scene/toml.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

constexpr double min_stale_steps = 3;

void apply_overrides(const RunOptions& options, SceneConfig& scene) {
  if (!options.integrator.empty()) scene.integrator = options.integrator;
  if (!options.step) return;
  scene.step = *options.step;
  if (!has_rig(scene)) return;
  RigParams& rig = *scene.device->rig;
  // The stale time grows with the step, because there is one sample per step.
  rig.stale_after_s = std::max(rig.stale_after_s, min_stale_steps * scene.step);
  rig.lost_after_s = std::max(rig.lost_after_s, rig.stale_after_s);
}

std::optional<Motion> load_motion(const RunOptions& options, const SceneConfig& scene, PreparedRun& run) {
  if (options.motion.empty()) return Motion(scene);
  MotionResult result = Motion::read(options.motion, scene);
  append(run.errors, result.errors);
  append(run.warnings, result.notes);
  return std::move(result.motion);
}

std::string folder_of_scene(const RunOptions& options) {
  return fs::path(options.scene).parent_path().string();
}

/// Opens the trackers, each with a running thread; for a check simulated ones instead.
std::vector<std::unique_ptr<TrackerLink>> make_trackers(const RunOptions& options, const SceneConfig& scene,
                                                        PreparedRun& run) {
  std::vector<std::unique_ptr<TrackerLink>> links;
  const std::vector<TrackerParams>& trackers = scene.device->trackers;
  if (!options.only_check) {
    for (auto& thread : start_trackers(trackers, folder_of_scene(options), run.errors))
      links.push_back(std::move(thread));
    return links;
  }
  for (const TrackerParams& params : trackers) {
    static_cast<void>(read_tool_definitions(params, folder_of_scene(options), run.errors));
    if (options.parts.simulated.make_resting_tracker != nullptr)
      links.push_back(options.parts.simulated.make_resting_tracker(params, run.errors));
    else
      run.errors.push_back("tracker '" + params.name +
                           "': this build has no simulated trackers to check it with (GODOBJECT_SIM=OFF)");
  }
  if (!run.errors.empty()) links.clear();
  return links;
}

/// Makes the session on logs, in the time of the logs.
Session::Made make_session_on_logs(SceneConfig scene, Motion motion, PreparedRun& run) {
  auto link = std::make_unique<LogLink>(*scene.device->rig, to_ns(scene.step));
  std::vector<LogSource> sources;
  for (const BusAddress& bus : run.buses.real.addresses) {
    const LogAddress log = parse_log_address(bus.where);
    sources.push_back({.path = log.path, .interface = log.interface});
  }
  if (const std::string why_not = link->read(sources); !why_not.empty())
    return {.session = nullptr, .errors = {"--bus: " + why_not}};
  run.log = run.plan.log = link.get();
  return Session::make(std::move(scene), std::move(motion), std::move(link));
}

/// Makes the session on the planned buses and trackers, whose threads are running then.
Session::Made make_session(const RunOptions& options, SceneConfig scene, Motion motion, PreparedRun& run) {
  if (run.buses.choice == BusChoice::direct ||
      (run.buses.choice == BusChoice::sim && driven_bodies(scene).empty()))
    return Session::make(std::move(scene), std::move(motion));
  if (run.buses.choice == BusChoice::sim) {
    if (options.parts.simulated.make_session != nullptr)
      return options.parts.simulated.make_session(std::move(scene), std::move(motion), run.profiles);
    return {
        .session = nullptr,
        .errors = {
            "this build has no simulated devices (GODOBJECT_SIM=OFF): give --bus ADDRESS or --bus direct"}};
  }
  if (run.buses.real.are_logs()) return make_session_on_logs(std::move(scene), std::move(motion), run);
  DeviceParts device{.buses = nullptr,
                     .trackers = {},
                     .clock = []() noexcept GODOBJECT_NONBLOCKING { return MonotonicClock{}.now(); },
                     .truth = nullptr};
  if (has_rig(scene)) {
    auto link = make_link(run.buses.real, *scene.device->rig, scene.step, !options.files.record.empty());
    run.link = link.get();
    device.buses = std::move(link);
  }
  if (!options.trackers.empty()) device.trackers = make_trackers(options, scene, run);
  return Session::make(std::move(scene), std::move(motion), std::move(device));
}

/// Returns the prefix of an error about the scene, with --step if only this step is invalid.
std::string blamed(const RunOptions& options, bool step_is_to_blame) {
  if (!step_is_to_blame) return options.scene + ": ";
  return options.scene + ": with --step " + shortest(*options.step) + ": ";
}

bool is_rig_valid(const SceneConfig& scene) {
  return has_rig(scene) && validate(*scene.device->rig, scene.step).empty();
}

std::vector<BusLoad> loads_of(const SceneConfig& scene) {
  const RigParams& rig = *scene.device->rig;
  return bus_load(rig, scene.step, usual_load(rig));
}

/// Properties of the rig with the step of the scene file, without --step.
struct RigOfFile {
  bool is_valid = false;
  std::vector<BusLoad> loads{};  // empty without a rig
};

void check_bus_loads(const RunOptions& options, const SceneConfig& scene, const RigOfFile& of_file,
                     PreparedRun& run) {
  run.bus_loads = loads_of(scene);
  for (std::size_t i = 0; i < run.bus_loads.size(); ++i) {
    const BusLoad& load = run.bus_loads[i];
    if (!is_overloaded(load)) continue;
    run.errors.push_back(blamed(options, options.step && !is_overloaded(of_file.loads[i])) +
                         load_advice(load));
  }
}

/// Adds the pointer of the page, the SpaceMouse or the program that is the device, and the planes of another
/// simulation, as the options demand.
void add_hand(const RunOptions& options, Session& session, PreparedRun& run) {
  const SceneConfig& scene = session.scene();
  const auto now = []() noexcept GODOBJECT_NONBLOCKING { return MonotonicClock{}.now(); };
  if (options.view_input && scene.device->unmeasured_tree) {
    run.joint_pointer = std::make_unique<JointPointer>(scene, now);
    session.add(*run.joint_pointer);
  } else if (options.view_input) {
    run.pointer = std::make_unique<PointerDevice>(scene, now);
    session.add(*run.pointer);
  }
  if (options.spacemouse) {
    run.spacemouse = std::make_unique<SpaceMouse>(scene, now);
    session.add(*run.spacemouse);
  }
  if (!options.device.empty()) {
    run.socket_device = std::make_unique<SocketDevice>(scene, now);
    session.add(*run.socket_device);
  }
  if (options.world.empty()) return;
  run.shared_world = std::make_unique<SharedWorld>();
  run.world = std::make_unique<WorldPlanes>(scene, session.engine(), *run.shared_world, now);
  session.add(*run.world);
}

/// True if the device of the program moves the tool: it has one, a body follows it, and no option gives
/// another device.
bool moves_by_own_device(const RunOptions& options, const SceneConfig& scene) {
  return options.parts.device != nullptr && !driven_bodies(scene).empty() && options.buses.empty() &&
         options.trackers.empty() && options.motion.empty() && !options.spacemouse &&
         options.device.empty() && !options.view_input;
}

/// Computes passivity within the ranges of the joints, if the rig is valid.
void check_passivity(const RunOptions& options, const SceneConfig& scene, const Motion& motion,
                     PreparedRun& run) {
  if (run.buses.choice == BusChoice::direct || !is_rig_valid(scene)) return;
  run.passivity = worst_passivity(scene, joints_at_start(scene, motion));
  for (const std::string& warning : passivity_warnings(run.passivity))
    if (options.strict) run.errors.push_back(options.scene + ": --strict: " + warning);
    else run.warnings.push_back(options.scene + ": " + warning);
}

}  // namespace

PreparedRun prepare(const RunOptions& options) {
  PreparedRun run;
  LoadResult loaded = load_scene(options.scene, options.parts.simulated.faults);
  append(run.errors, loaded.errors);
  append(run.warnings, loaded.warnings);
  check_outputs(options, run.errors);
  if (!loaded.scene) return run;

  SceneConfig& scene = *loaded.scene;
  RigOfFile of_file{.is_valid = is_rig_valid(scene)};
  if (has_rig(scene)) of_file.loads = loads_of(scene);
  check_view(options, scene, run.errors);
  check_spacemouse(options, scene, run);
  check_socket_device(options, scene, run.errors);
  check_world(options, scene, run.errors);
  if (options.view_input) lead_by_pointer(scene);
  if (options.spacemouse && run.errors.empty()) lead_by_spacemouse(scene);
  run.has_own_device = moves_by_own_device(options, scene);
  const bool moved_by_program = run.has_own_device || !options.device.empty();
  if (moved_by_program) scene.motion.reset();
  if (options.view_input || moved_by_program) run.buses.choice = BusChoice::direct;
  else run.buses = plan_buses(options.buses, scene, run.errors, run.notes);
  plan_trackers(options.trackers, !options.buses.empty(), scene, run.buses, run.errors);
  check_real_buses(options, run);
  check_recorded(options, run.buses.choice, scene, run.errors);
  apply_overrides(options, scene);
  check_scheduling(options, scene.step, run.errors);
  if (has_rig(scene)) run.profiles = checked_profiles(scene, options.scene, run.errors);
  std::optional<Motion> motion = load_motion(options, scene, run);
  if (!motion || !run.errors.empty()) return run;

  constexpr double until_stopped = 1e6;  // s
  const bool moved_by_hand = options.view_input || options.spacemouse || moved_by_program;
  const double of_scene =
      moved_by_hand && !options.fast ? until_stopped : motion->end().value_or(scene.duration);
  const double duration = options.duration.value_or(of_scene);
  run.plan = {.num_cycles = static_cast<std::uint64_t>(std::max(1LL, std::llround(duration / scene.step))),
              .rearm = options.rearm,
              .quiet = options.quiet,
              .seal = options.seal,
              .thread = {.core = options.core,
                         .runtime_ns = to_ns(1e-6 * options.deadline_us),
                         .period_ns = to_ns(scene.step)}};
  check_passivity(options, scene, *motion, run);
  const bool follows_motion = !moved_by_hand && run.buses.choice != BusChoice::real;
  const std::string& speed_of = options.motion.empty() ? options.scene : options.motion;
  if (follows_motion && !motion_targets(scene).empty())
    check_speed(scene, *motion, duration, speed_of, run.warnings);
  const bool only_with_step = options.step && has_rig(scene) && !is_rig_valid(scene) && of_file.is_valid;
  Session::Made made = make_session(options, *std::move(loaded.scene), *std::move(motion), run);
  for (const std::string& error : made.errors) run.errors.push_back(blamed(options, only_with_step) + error);
  if (made.session) {
    add_hand(options, *made.session, run);
    const StartCheck start = check_start(*made.session);
    for (const std::string& warning : start.warnings) run.warnings.push_back(options.scene + ": " + warning);
    for (const std::string& error : start.errors) run.errors.push_back(options.scene + ": " + error);
    if (made.session->rig()) check_bus_loads(options, made.session->scene(), of_file, run);
  }
  if (run.errors.empty()) run.session = std::move(made.session);
  return run;
}

bool has_hardware(const RunOptions& options, const PreparedRun& run) {
  return run.session->bus() == BusChoice::real || !options.trackers.empty() || run.spacemouse ||
         run.socket_device || run.has_own_device;
}

std::string why_no_reset(const RunOptions& options, const PreparedRun& run) {
  const auto refused = [](const std::string& why) { return why + ": stop the run, and start it again"; };
  if (has_hardware(options, run)) return refused("this run has hardware, which cannot go back");
  if (run.world) return refused("the simulation of --world cannot go back");
  const RunFileNames& files = options.files;
  for (const std::string* file :
       {&files.trace, &files.contacts, &files.nets, &files.record, &files.inputs, &files.on_fault})
    if (!file->empty()) return refused("this run writes " + *file + ", whose steps follow one another");
  return "";
}

PreparedRun prepare_again(const RunOptions& options, const PreparedRun& run) {
  PreparedRun next;
  next.buses = run.buses;
  next.profiles = run.profiles;
  Session::Made made = make_session(options, run.session->scene(), run.session->motion(), next);
  next.errors = made.errors;
  if (!made.session) return next;
  next.session = std::move(made.session);
  add_hand(options, *next.session, next);
  return next;
}

}  // namespace godobject
