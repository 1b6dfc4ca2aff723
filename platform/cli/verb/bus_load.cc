// godobject bus-load: checks that the buses of a scene can carry its messages.
#include <cstdio>
#include <memory>

#include "hal/rig/validate.h"
#include "platform/cli/bus/load_text.h"
#include "platform/cli/verbs.h"
#include "platform/rig/load_advice.h"
#include "platform/scene/toml.h"

namespace godobject {
namespace {

struct BusLoadOptions {
  std::string scene;
  bool json = false;
  bool allow_overload = false;
  FaultChecks faults{};  // simulation of the program
};

/// Loads a scene with a valid rig; none after printing the errors.
std::optional<SceneConfig> load_rig(const std::string& path, const FaultChecks& checks) {
  LoadResult loaded = load_scene(path, checks);
  for (const std::string& warning : loaded.warnings) std::fprintf(stderr, "%s\n", warning.c_str());
  for (const std::string& error : loaded.errors) std::fprintf(stderr, "%s\n", error.c_str());
  if (!loaded.scene) return std::nullopt;
  if (!loaded.scene->device || !loaded.scene->device->rig) {
    std::fprintf(stderr, "%s: the scene describes no buses; add [[bus]] tables, encoders and joints\n",
                 path.c_str());
    return std::nullopt;
  }
  const std::vector<std::string> errors = validate(*loaded.scene->device->rig, loaded.scene->step);
  for (const std::string& error : errors) std::fprintf(stderr, "%s: %s\n", path.c_str(), error.c_str());
  return errors.empty() ? std::move(loaded.scene) : std::nullopt;
}

ExitCode show_bus_load(const BusLoadOptions& options) {
  const std::optional<SceneConfig> scene = load_rig(options.scene, options.faults);
  if (!scene) return ExitCode::usage;
  const RigParams& rig = *scene->device->rig;
  const std::vector<BusLoad> loads = bus_load(rig, scene->step, usual_load(rig));
  if (options.json) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const BusLoad& load : loads) json.push_back(to_json(load));
    std::printf("%s\n", json.dump(2).c_str());
  } else {
    for (const BusLoad& load : loads) print_bus_load(stdout, load);
  }
  ExitCode code = ExitCode::ok;
  for (const BusLoad& load : loads) {
    const bool refused = load.worst_percent > planned_load_percent && !options.allow_overload;
    const std::string advice = load_advice(load);
    if (refused) code = ExitCode::fault;
    if (!advice.empty())
      std::fprintf(stderr, "%s: %s%s\n", options.scene.c_str(), advice.c_str(),
                   refused ? " (--allow-overload accepts it)" : "");
  }
  return code;
}

}  // namespace

void add_bus_load(CLI::App& app, const FaultChecks& checks, ExitCode& code) {
  CLI::App* verb = app.add_subcommand(
      "bus-load",
      "Print the load of a scene's buses, nominal and worst case, message by message; fail above 70 %.");
  const auto options = std::make_shared<BusLoadOptions>();
  options->faults = checks;
  verb->add_option("SCENE", options->scene, "read this scene file (TOML), see docs/scenes.md")->required();
  verb->add_flag("--json", options->json, "print JSON");
  verb->add_flag("--allow-overload", options->allow_overload,
                 "return exit code 0 even above 70 % in the worst case");
  verb->callback([options, &code] { code = show_bus_load(*options); });
}

}  // namespace godobject
