#include "platform/cli/run_options.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "sim/scene_toml.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_interface_name = 15;  // of candump's format
constexpr double min_stale_steps = 3;

struct NamedPath {
  std::string option;
  std::string path;
};

void add(std::vector<std::string>& to, const std::vector<std::string>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored) ||
         fs::weakly_canonical(a, ignored) == fs::weakly_canonical(b, ignored);
}

/// Empty, or why `path` could not be written.
std::string why_not_writable(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return "is a directory";
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  const bool exists = fs::exists(path, ignored);
  if (access(exists ? path.c_str() : folder.c_str(), exists ? W_OK : W_OK | X_OK) == 0) return "";
  return "cannot be written: " + std::generic_category().message(errno);
}

/// Every output can be written, and none of them over an input or another output.
void check_outputs(const RunOptions& options, std::vector<std::string>& errors) {
  std::vector<NamedPath> taken{{"the scene file", options.scene}, {"--motion", options.motion}};
  for (const NamedPath& out : {NamedPath{"--trace", options.trace}, NamedPath{"--record", options.record},
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

void check_record(const RunOptions& options, const SceneConfig& scene, std::vector<std::string>& errors) {
  if (options.record.empty()) return;
  if (options.bus == BusChoice::direct) {
    errors.push_back("--record: with --bus direct there is no bus to record");
  } else if (scene.device && scene.device->rig) {
    for (const BusParams& bus : scene.device->rig->buses)
      if (bus.name.size() > max_interface_name)
        errors.push_back("--record: bus name '" + bus.name + "' is too long for a candump log, at most " +
                         std::to_string(max_interface_name) + " characters");
  }
}

void apply_overrides(const RunOptions& options, SceneConfig& scene) {
  if (!options.integrator.empty()) scene.integrator = options.integrator;
  if (!options.step) return;
  scene.step = *options.step;
  if (!scene.device || !scene.device->rig) return;
  RigParams& rig = *scene.device->rig;
  rig.cycle_s = scene.step;
  // Samples come once a step: what was late at the scene's own step may be in time at a longer one.
  rig.stale_after_s = std::max(rig.stale_after_s, min_stale_steps * scene.step);
}

std::optional<Motion> load_motion(const RunOptions& options, const SceneConfig& scene, PreparedRun& run) {
  if (options.motion.empty()) return Motion(scene);
  MotionResult result = Motion::read(options.motion, scene);
  add(run.errors, result.errors);
  add(run.notes, result.notes);
  return std::move(result.motion);
}

}  // namespace

PreparedRun prepare(const RunOptions& options) {
  PreparedRun run;
  LoadResult loaded = load_scene(options.scene);
  add(run.errors, loaded.errors);
  add(run.notes, loaded.warnings);
  check_outputs(options, run.errors);
  if (!loaded.scene) return run;

  SceneConfig& scene = *loaded.scene;
  check_record(options, scene, run.errors);
  apply_overrides(options, scene);
  std::optional<Motion> motion = load_motion(options, scene, run);
  if (!motion || !run.errors.empty()) return run;

  const double duration = options.duration.value_or(motion->end().value_or(scene.duration));
  run.num_cycles = static_cast<std::uint64_t>(std::max(1LL, std::llround(duration / scene.step)));
  Session::Made made = Session::make(scene, *std::move(motion), options.bus);
  for (const std::string& error : made.errors) run.errors.push_back(options.scene + ":1:1: " + error);
  run.session = std::move(made.session);
  return run;
}

}  // namespace godobject
