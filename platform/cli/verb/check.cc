// godobject check: validates a scene and prints its properties, without moving anything.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "platform/cli/bus/load_text.h"
#include "platform/cli/check_text.h"
#include "platform/cli/run/options.h"
#include "platform/cli/time_to_zero.h"
#include "platform/cli/verbs.h"
#include "platform/rig/load_advice.h"
#include "platform/scene/checks.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/toml.h"

namespace godobject {
namespace {

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
    std::fprintf(stderr,
                 "warning: %s: the shape of body '%s' touches %s%s only with its spheres and may pass "
                 "through between them at any speed; set a sphere at each corner, and space spheres more "
                 "closely than the edges of the other solid\n",
                 path.c_str(), one.body.c_str(), one.other.c_str(), more.c_str());
  }
  const BuriedSpheres buried = buried_spheres(scene);
  if (buried.num == 0) return;
  std::fprintf(stderr,
               "warning: %s: %zu %s with the centre inside a solid, the deepest %.3g mm, %s: contacts push "
               "it out slowly through the nearest face; move the body or the solid\n",
               path.c_str(), buried.num, buried.num == 1 ? "sphere begins" : "spheres begin",
               1e3 * buried.depth, buried.deepest.c_str());
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

}  // namespace

void add_check(CLI::App& app, const SimulatedDevices& simulated, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("check", "Validate a scene and options without running it.");
  const auto options = std::make_shared<RunOptions>();
  options->simulated = simulated;
  add_run_options(*verb, *options);
  const auto full = std::make_shared<bool>(false);
  verb->add_flag("--full", *full,
                 "print everything: the values in effect as a scene file, the composition with its memory, "
                 "and every message of every bus");
  verb->callback([options, full, &code] { code = check(*options, *full); });
}

}  // namespace godobject
