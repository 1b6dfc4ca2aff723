// Checks of a prepared run: options against each other and the scene, and the motion, which must be no faster
// than a hand.
#include "platform/cli/run/options.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "platform/rt/setup.h"
#include "platform/scene/checks.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_interface_name = 15;  // limit of candump's format

struct NamedPath {
  std::string option;
  std::string path;
};

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  if (a == b || fs::equivalent(a, b, ignored)) return true;
  const fs::path full = fs::weakly_canonical(a, ignored);  // empty on an error
  return !full.empty() && full == fs::weakly_canonical(b, ignored);
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Returns why `path` cannot be written; empty if it can.
std::string why_not_writable(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return "is a directory";
  fs::path folder = folder_of(path);
  // make_folders() creates missing folders, but none in the root folder, where a missing one is a
  // misspelling.
  fs::path missing;
  for (; !fs::exists(folder, ignored) && folder != folder_of(folder); folder = folder_of(folder))
    missing = folder;
  if (!missing.empty() && folder == folder.root_path())
    return "cannot be written: create the missing folder '" + missing.string() + "'";
  if (!fs::is_directory(folder, ignored))
    return "cannot be written: '" + folder.string() + "' is not a folder";
  const bool exists = fs::exists(path, ignored);
  if (access(exists ? path.c_str() : folder.c_str(), exists ? W_OK : W_OK | X_OK) == 0) return "";
  return "cannot be written: " + std::generic_category().message(errno);
}

void check_record(const RunOptions& options, BusChoice choice, const SceneConfig& scene,
                  std::vector<std::string>& errors) {
  if (options.files.record.empty()) return;
  if (options.view_input) {
    errors.push_back("--record: with --view-input there is no bus to record: remove either");
  } else if (!has_rig(scene)) {
    errors.push_back(
        "--record: scene '" + scene.name +
        "' describes no buses to record: name the file .godo for its inputs, remove --record, or "
        "add [[bus]] tables");
  } else if (choice == BusChoice::direct) {
    errors.push_back(
        "--record: with --bus direct there is no bus to record: name the file .godo for its "
        "inputs, or remove either");
  } else {
    for (const BusParams& bus : scene.device->rig->buses)
      if (bus.name.size() > max_interface_name)
        errors.push_back("--record: bus name '" + bus.name +
                         "' is too long for a candump log: shorten it to at most " +
                         std::to_string(max_interface_name) + " characters");
  }
}

void check_contacts(const RunOptions& options, const SceneConfig& scene, std::vector<std::string>& errors) {
  if (!options.files.contacts.empty() && contact_scope(scene) == ContactScope::none)
    errors.push_back("--contacts: nothing in scene '" + scene.name +
                     "' can touch: give its bodies spheres, and obstacles or shapes to touch");
}

void check_nets(const RunOptions& options, const SceneConfig& scene, std::vector<std::string>& errors) {
  if (!options.files.nets.empty() && scene.nets.empty())
    errors.push_back("--nets: scene '" + scene.name + "' has no nets: remove --nets, or add a [[net]] table");
}

/// Returns the number of frames that the host sends at once: SYNC, a heartbeat, and a command to each drive.
std::size_t frames_at_once(const RigParams& rig, std::size_t bus) {
  constexpr std::size_t without_drives = 2;
  return without_drives + static_cast<std::size_t>(std::ranges::count(rig.drives, bus, &DriveParams::bus));
}

}  // namespace

void check_outputs(const RunOptions& options, std::vector<std::string>& errors) {
  if (!options.files.on_fault.empty() && !is_input_log(options.files.on_fault))
    errors.push_back("--on-fault: '" + options.files.on_fault + "' must end in " +
                     std::string(input_log_ending) + ", as input logs do: give another name");
  std::vector<NamedPath> taken{{"the scene file", options.scene}, {"--motion", options.motion}};
  for (const NamedPath& out :
       {NamedPath{"--trace", options.files.trace}, NamedPath{"--contacts", options.files.contacts},
        NamedPath{"--nets", options.files.nets}, NamedPath{"--record", options.files.record},
        NamedPath{"--record", options.files.inputs}, NamedPath{"--on-fault", options.files.on_fault},
        NamedPath{"--report", options.report}}) {
    if (out.path.empty()) continue;
    const std::string why_not = why_not_writable(out.path);
    if (!why_not.empty()) errors.push_back(out.option + ": '" + out.path + "' " + why_not);
    for (const NamedPath& other : taken)
      if (!other.path.empty() && same_file(out.path, other.path))
        errors.push_back(out.option + ": '" + out.path + "' is also " + other.option + ": give another name");
    taken.push_back(out);
  }
}

void name_fault_log(RunOptions& options, const PreparedRun& run) {
  const bool is_real = run.session->bus() == BusChoice::real && run.log == nullptr;
  if (!options.keeps_faults || !options.files.on_fault.empty() || !is_real || run.world) return;
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 40> time{};
  std::strftime(time.data(), time.size(), "-fault-%Y%m%dT%H%M%S", &local);
  const std::string name =
      fs::path(options.scene).stem().string() + time.data() + std::string(input_log_ending);
  fs::path folder;
  for (const std::string& output :
       {options.report, options.files.trace, options.files.inputs, options.files.record})
    if (folder.empty()) folder = fs::path(output).parent_path();
  const std::string path = (folder / name).string();
  if (const std::string why_not = why_not_writable(path); why_not.empty()) options.files.on_fault = path;
  else
    std::fprintf(stderr,
                 "note: the seconds before a fault are not kept, because '%s' %s; give --on-fault FILE, or "
                 "--on-fault none\n",
                 path.c_str(), why_not.c_str());
}

std::string make_folders(const RunOptions& options) {
  for (const std::string& path :
       {options.files.trace, options.files.contacts, options.files.nets, options.files.record,
        options.files.inputs, options.files.on_fault, options.report}) {
    std::error_code error;
    if (path.empty() || fs::exists(folder_of(path), error)) continue;
    if (!fs::create_directories(folder_of(path), error) && error)
      return "'" + folder_of(path).string() + "' cannot be created: " + error.message();
  }
  return "";
}

void check_view(const RunOptions& options, const SceneConfig& scene, std::vector<std::string>& errors) {
  if (!options.view) {
    if (options.view_input) errors.push_back("--view-input: requires --view: add it");
    return;
  }
  if (!options.view_input) return;
  const bool is_coupled =
      std::ranges::any_of(scene.bodies, [](const auto& body) { return bool(body.coupling); });
  if (!is_coupled && !page_moves_joints(scene))
    errors.push_back("--view-input: scene '" + scene.name + "' has no coupled body: add a [body.coupling]");
  if (options.fast) errors.push_back("--view-input: requires wall time: remove --fast");
  if (!options.motion.empty())
    errors.push_back("--view-input: the page's pointer replaces --motion: remove either");
  if (!options.trackers.empty() ||
      std::ranges::any_of(options.buses, [](const std::string& bus) { return bus != "direct"; }))
    errors.push_back(
        "--view-input: the page's pointer replaces the device and its motors: remove --bus and --tracker");
}

void check_recorded(const RunOptions& options, BusChoice choice, const SceneConfig& scene,
                    std::vector<std::string>& errors) {
  check_record(options, choice, scene, errors);
  check_contacts(options, scene, errors);
  check_nets(options, scene, errors);
}

void check_real_buses(const RunOptions& options, PreparedRun& run) {
  if (run.buses.choice != BusChoice::real) {
    if (options.rearm != Rearm::never && run.buses.choice == BusChoice::direct)
      run.errors.push_back("--rearm: with --bus direct there is no device to arm: remove --rearm");
    return;
  }
  if (run.buses.real.are_logs()) {
    if (!options.trackers.empty())
      run.errors.push_back(
          "--tracker: a log runs in its own time, a real tracker in wall time: remove --tracker, or use a "
          "bus other than replay:");
    return;
  }
  if (options.fast)
    run.errors.push_back(
        "--fast: real buses and trackers run in wall time, not on a simulated clock: remove --fast");
  if (!options.motion.empty())
    run.notes.push_back(
        "--motion: real buses and trackers measure the handles; this run reads only the switches of the "
        "file");
}

void check_scheduling(const RunOptions& options, double step_s, std::vector<std::string>& errors) {
  if (options.core)
    if (const std::string why_not = why_no_core(*options.core); !why_not.empty())
      errors.push_back("--core: " + why_not + ": give one of them");
  if (1e-6 * options.deadline_us < step_s) return;
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "--deadline: %g us are not shorter than the step of %g us: give less, or a longer step",
                options.deadline_us, 1e6 * step_s);
  errors.push_back(text.data());
}

std::vector<RtStep> check_buses(const SceneConfig& scene, const RigAddresses& where) {
  const RigParams& rig = *scene.device->rig;
  std::vector<RtStep> steps;
  for (std::size_t i = 0; i < where.addresses.size(); ++i) {
    const BusAddress& address = where.addresses[i];
    const BusParams& bus = rig.buses[i];
    if (address.backend->check == nullptr) continue;
    std::ranges::move(
        address.backend->check({.name = bus.name,
                                .where = address.where,
                                .settings = {.bit_rate = bus.bit_rate, .data_bit_rate = bus.data_bit_rate},
                                .frames = frames_at_once(rig, i)}),
        std::back_inserter(steps));
  }
  return steps;
}

std::string why_not_real_time(const RunOptions& options, const PreparedRun& run) {
  const RtThreadPlan& plan = run.plan.thread;
  std::vector<RtStep> unmet;
  if (options.require_rt) {
    unmet = real_time_checks({}, plan);
    if (run.buses.choice == BusChoice::real && has_rig(run.session->scene()) && !run.buses.real.are_logs())
      std::ranges::move(check_buses(run.session->scene(), run.buses.real), std::back_inserter(unmet));
    std::erase_if(unmet, [](const RtStep& step) { return step.result == RtResult::ok; });
  } else if (plan.core || plan.runtime_ns > 0) {
    unmet = try_rt_thread({}, plan);
    std::erase_if(unmet, [](const RtStep& step) {
      return step.result != RtResult::failed || (step.name != core_step && step.name != deadline_step);
    });
  }
  if (unmet.empty()) return "";
  std::string names;
  for (const RtStep& step : unmet)
    names += (names.empty() ? "" : ", ") + step.name + " (" + std::string(name_of(step.result)) + ")";
  const std::string option = options.require_rt ? "--require-rt" : plan.core ? "--core" : "--deadline";
  return option + ": this machine does not meet the real-time requirements: " + names +
         "; apply the remedies below, or remove " + option + "\n" + rt_table(unmet);
}

void check_speed(const SceneConfig& scene, const Motion& motion, double duration, const std::string& file,
                 std::vector<std::string>& warnings) {
  const MotionSpeed most = fastest(motion, duration, scene.step);
  if (most.speed <= max_hand_speed) return;
  std::array<char, 240> text{};
  std::snprintf(
      text.data(), text.size(),
      ": the motion moves the target of '%s' at %.3g m/s at %.3g s; expected are at most %g m/s, the "
      "speed of a hand: give lengths in m and times in s, or slow the motion down",
      motion_targets(scene)[most.body].c_str(), most.speed, most.t, max_hand_speed);
  warnings.push_back(file + text.data());
}

}  // namespace godobject
