// godobject check: validates a scene and prints its properties, without moving anything.
// godobject bus-load: checks that the buses of a scene can carry its messages.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "hal/rig/validate.h"
#include "platform/cli/program.h"
#include "platform/cli/run/options.h"
#include "platform/rig/buses.h"
#include "platform/scene/checks.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/toml.h"

namespace godobject {
namespace {

/// Prints every message of the bus, by priority.
void print_bus_load(std::FILE* out, const BusLoad& load) {
  std::fprintf(out, "\n# bus %s: %.1f %% nominal, %.1f %% worst case\n", load.bus.c_str(),
               load.nominal_percent, load.worst_percent);
  std::fprintf(out, "#   %-32s %6s %10s %8s %6s\n", "message", "id", "period ms", "bits", "worst");
  for (const BusMessage& m : load.messages)
    std::fprintf(out, "#   %-32s  0x%03X %10g %8d %6d\n", m.name.c_str(), static_cast<unsigned>(m.cob_id),
                 1e3 * m.period_s, m.nominal_bits, m.worst_bits);
}

nlohmann::ordered_json to_json(const BusLoad& load) {
  nlohmann::ordered_json messages = nlohmann::ordered_json::array();
  for (const BusMessage& m : load.messages)
    messages.push_back({{"name", m.name},
                        {"cob_id", m.cob_id},
                        {"period_s", m.period_s},
                        {"nominal_bits", m.nominal_bits},
                        {"worst_bits", m.worst_bits}});
  return {{"bus", load.bus},
          {"nominal_percent", load.nominal_percent},
          {"worst_percent", load.worst_percent},
          {"messages", messages}};
}

void print_composition(const Composition& c) {
  std::printf("\n# composition '%s': the smallest compiled one that covers the scene\n", c.name.c_str());
  std::printf("#   %-24s %8s %8s %8s   bytes, for %zu bodies\n", "part", "params", "state", "scratch",
              c.max_bodies);
  for (const PartBytes& part : c.parts)
    std::printf("#   %-24s %8zu %8zu %8zu\n", part.name.c_str(), part.params_bytes, part.state_bytes,
                part.scratch_bytes);
  std::printf("#   all: params %zu, state %zu, scratch %zu, total %zu bytes\n", c.params_bytes, c.state_bytes,
              c.scratch_bytes, c.bytes());
  std::printf("# compiled in:\n");
  for (const Composition& other : compositions())
    std::printf("#   %-32s %8zu bytes\n", other.name.c_str(), other.bytes());
}

void print_capacities(const SceneConfig& scene, const Engine& engine) {
  const Composition& c = engine.composition();
  const auto print = [](const char* what, std::size_t used, std::size_t available) {
    std::printf("#   %-24s %8zu of %zu\n", what, used, available);
  };
  std::printf("# capacities used\n");
  print("bodies", scene.bodies.size(), c.max_bodies);
  if (c.has_nets()) {
    print("nodes", engine.nets().nodes.size(), c.max_nodes);
    print("springs", engine.nets().springs.size(), c.max_springs);
    print("attachments", engine.nets().attachments.size(), c.max_attachments);
    print("triangles of nets", engine.nets().faces().size(), c.max_faces);
    std::printf("#   %-24s at most %zu at once; more raise the fault contacts_full\n", "contacts of nodes",
                c.max_node_contacts);
  }
  if (c.contacts == ContactScope::none) return;
  const ContactCounts counts = contact_counts(scene);
  print("spheres", counts.spheres, c.max_spheres);
  print("surfaces", counts.surfaces, c.max_surfaces);
  std::printf("#   %-24s at most %zu at once; more raise the fault contacts_full\n", "contacts",
              c.max_contacts);
}

void print_top_speed(const SceneConfig& scene) {
  const std::optional<SpeedBound> bound = top_speed(scene);
  if (!bound || std::isinf(bound->top())) {
    if (const std::string text = top_speed_text(scene); !text.empty())
      std::printf("\n# top speed: %s\n", text.c_str());
    return;
  }
  std::printf("\n# top speed up to which %s passes through a solid: %.3g m/s, %s\n",
              what_does_not_pass(scene), bound->top(), bound->what.c_str());
  std::printf(
      "#   bound by the travel in a step: %.3g m/s; by the energy of the tool: %.3g m/s; hand at most %.3g m "
      "beyond the surface\n",
      bound->travel, bound->energy, bound->hand);
}

void warn_of_top_speed(const std::string& path, const SceneConfig& scene) {
  const std::optional<SpeedBound> bound = top_speed(scene);
  if (bound && bound->top() < advised_top_speed)
    std::fprintf(stderr,
                 "warning: %s: above %.3g m/s %s may pass through each other, and a hand reaches %g m/s: "
                 "make the solid thicker, the contact stiffer or the step shorter\n",
                 path.c_str(), bound->top(), bound->what.c_str(), advised_top_speed);
}

void warn_of_contacts_at_start(const std::string& path, const SceneConfig& scene) {
  for (const SpheresAlone& one : spheres_alone(scene)) {
    const std::string more =
        one.num_others > 1 ? " (and " + std::to_string(one.num_others - 1) + " more)" : "";
    std::fprintf(
        stderr,
        "warning: %s: the shape of body '%s' touches %s%s only with its corners, ends and spheres and "
        "may pass through between them at any speed; space spheres of the body more closely than the "
        "edges of the mesh\n",
        path.c_str(), one.body.c_str(), one.other.c_str(), more.c_str());
  }
  const BuriedSolids buried = buried_solids(scene);
  if (buried.num == 0) return;
  std::fprintf(stderr,
               "warning: %s: %zu %s with the centre inside a solid, the deepest %.3g mm, %s: contacts push "
               "it out slowly through the nearest face; move the body or the solid\n",
               path.c_str(), buried.num,
               buried.num == 1 ? "sphere or shape begins" : "spheres or shapes begin", 1e3 * buried.depth,
               buried.deepest.c_str());
}

/// Prints the objects of each PDO of nodes with a profile, as index, sub-index and bits.
void print_process_data(const RigParams& rig, const RigProfiles& profiles) {
  const auto print = [&](const std::optional<NodeProfile>& profile, std::size_t bus, unsigned node) {
    if (!profile) return;
    for (const PdoProfile& pdo : profile->pdos) {
      std::printf("#   %s node %u %cpdo%d", rig.buses[bus].name.c_str(), node,
                  pdo.direction == PdoDirection::receive ? 'r' : 't', pdo.number);
      for (const MappedObject& object : pdo.map)
        std::printf("  %04Xh:%02X:%d", static_cast<unsigned>(object.address.index),
                    static_cast<unsigned>(object.address.sub), static_cast<int>(object.bits));
      std::puts("");
    }
  };
  std::puts("\n# process data of profiles");
  for (std::size_t i = 0; i < std::min(profiles.encoders.size(), rig.encoders.size()); ++i)
    print(profiles.encoders[i], rig.encoders[i].bus, rig.encoders[i].node_id);
  for (std::size_t i = 0; i < std::min(profiles.drives.size(), rig.drives.size()); ++i)
    print(profiles.drives[i], rig.drives[i].bus, rig.drives[i].node_id);
}

void print_passivity(const Passivity& passivity) {
  const std::vector<std::string> table = passivity_table(passivity);
  if (!table.empty()) std::puts("");
  for (const std::string& row : table) std::puts(row.c_str());
}

/// Prints the rows without the explanation of the columns.
void print_margins(const Passivity& passivity) {
  constexpr std::size_t num_head_lines = 2;
  const std::vector<std::string> table = passivity_table(passivity);
  for (std::size_t i = 0; i < std::min(table.size(), num_head_lines + passivity.joints.size()); ++i)
    std::puts(table[i].c_str());
}

void print_all(const PreparedRun& prepared) {
  const SceneConfig& scene = prepared.session->scene();
  std::printf("# effective configuration\n%s", effective_config_toml(scene).c_str());
  print_composition(prepared.session->engine().composition());
  print_capacities(scene, prepared.session->engine());
  print_top_speed(scene);
  if (scene.device && scene.device->rig) {
    std::puts("");
    for (const std::string& line : time_to_zero_lines(*scene.device->rig, scene.step, prepared.profiles))
      std::puts(line.c_str());
    print_process_data(*scene.device->rig, prepared.profiles);
  }
  print_passivity(prepared.passivity);
  for (const BusLoad& load : prepared.bus_loads) print_bus_load(stdout, load);
}

ExitCode check(RunOptions options, bool full) {
  options.only_check = true;
  const std::string& path = options.scene;
  const PreparedRun prepared = prepare(options);
  if (!options.quiet)
    for (const std::string& note : prepared.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  for (const std::string& warning : prepared.warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  for (const std::string& error : prepared.errors) std::fprintf(stderr, "%s\n", error.c_str());
  if (!prepared.session) {
    if (options.quiet) return ExitCode::usage;
    print_passivity(prepared.passivity);
    for (const BusLoad& load : prepared.bus_loads) print_bus_load(stdout, load);
    return ExitCode::usage;
  }
  if (const std::string why_not = why_not_real_time(options, prepared); !why_not.empty()) {
    std::fputs(why_not.c_str(), stderr);
    return ExitCode::not_available;
  }
  if (full) {
    print_all(prepared);
  } else if (!options.quiet) {
    for (const std::string& line : check_lines(options, prepared)) std::printf("%s\n", line.c_str());
    print_margins(prepared.passivity);
    std::printf("for all details: godobject check --full\n");
  }
  warn_of_top_speed(path, prepared.session->scene());
  warn_of_contacts_at_start(path, prepared.session->scene());
  for (const BusLoad& load : prepared.bus_loads)
    if (const std::string advice = load_advice(load); !advice.empty())
      std::fprintf(stderr, "%s: %s\n", path.c_str(), advice.c_str());
  return ExitCode::ok;
}

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

void add_check(CLI::App& app, const ProgramParts& parts, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("check", "Validate a scene and options without running it.");
  const auto options = std::make_shared<RunOptions>();
  options->parts = parts;
  add_run_options(*verb, *options);
  const auto full = std::make_shared<bool>(false);
  verb->add_flag("--full", *full,
                 "print everything: the values in effect as a scene file, the composition with its memory, "
                 "the objects of PDOs, and every message of every bus");
  verb->callback([options, full, &code] { code = check(*options, *full); });
}

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
