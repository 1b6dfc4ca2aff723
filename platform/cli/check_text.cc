#include "platform/cli/run/options.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <limits>

#include "core/setup.h"
#include "hal/rig/watchdog.h"
#include "platform/scene/checks.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/joint/joints.h"
#include "platform/scene/net/params.h"

namespace godobject {
namespace {

/// Returns "label                text".
[[gnu::format(printf, 2, 3)]] std::string line(const char* label, const char* what, ...) {
  std::array<char, 512> text{};
  std::va_list arguments;
  va_start(arguments, what);
  std::vsnprintf(text.data(), text.size(), what, arguments);
  va_end(arguments);
  std::string out = label;
  out.resize(std::max<std::size_t>(out.size() + 1, 16), ' ');
  return out + text.data();
}

/// Returns a number between two texts.
std::string with_number(const char* before, double x, const char* after) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", x);
  return std::string(before) + text.data() + after;
}

/// Returns "6 encoders", "1 drive".
std::string number_of(std::size_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

std::string where_it_runs(const RunOptions& options, const PreparedRun& prepared) {
  switch (prepared.session->bus()) {
    case BusChoice::sim: return "simulated";
    case BusChoice::direct:
      if (prepared.spacemouse) return "a SpaceMouse, by spacenavd";
      if (prepared.has_own_device) return "that of this program";
      return "none: the motion drives the core";
    case BusChoice::real: break;
  }
  std::string text = "real";
  for (const std::string& given : options.buses) text += ", " + given;
  for (const std::string& given : options.trackers) text += ", tracker " + given;
  return text;
}

void add_device(const DeviceConfig& device, std::vector<std::string>& lines) {
  std::string text = "'" + device.name + "', " + device_kind_names[static_cast<std::size_t>(device.kind)];
  if (device.rig) {
    text += ", " + number_of(device.rig->tree.joints.size(), "joint") + ", " +
            number_of(device.rig->encoders.size(), "encoder") + ", " +
            number_of(device.rig->drives.size(), "drive");
    if (!device.rig->buttons.empty()) text += ", " + number_of(device.rig->buttons.size(), "button");
  }
  if (!device.trackers.empty()) text += ", " + number_of(device.trackers.size(), "tracker");
  if (device.spacemouse) text += ", a SpaceMouse";
  lines.push_back(line("device", "%s", text.c_str()));
  lines.push_back(line("wrench limits", "%g N, %g N m; %g N/s, %g N m/s; ramp %g s", device.limits.force,
                       device.limits.torque, device.limits.force_rate, device.limits.torque_rate,
                       device.limits.ramp));
}

/// Adds the rows of the table of time_to_zero_lines() without its head.
void add_times_to_zero(const PreparedRun& prepared, std::vector<std::string>& lines) {
  const SceneConfig& scene = prepared.session->scene();
  if (!scene.device || !scene.device->rig) return;
  const std::vector<std::string> table =
      time_to_zero_lines(*scene.device->rig, scene.step, prepared.profiles);
  for (std::size_t i = 1; i < table.size(); ++i)
    lines.push_back(
        line(i == 1 ? "time to zero" : "", "%s", table[i].substr(table[i].find_first_not_of("# ")).c_str()));
}

/// Adds the angular velocity below which TR-BDF2 is of second order: the smallest bound of all bodies.
void add_order(const SceneConfig& scene, std::vector<std::string>& lines) {
  if (scene.integrator != "tr-bdf2") return;
  const BodyConfig* fastest = nullptr;
  double bound = std::numeric_limits<double>::infinity();
  for (const BodyConfig& body : scene.bodies) {
    const double w = max_extrapolated_turn_of(rigid_body(body.mass, body.inertia),
                                              body.coupling.value_or(SpringParams{}), !scene.nets.empty()) /
                     scene.step;
    if (w >= bound) continue;
    bound = w;
    fastest = &body;
  }
  if (fastest == nullptr) return;
  lines.push_back(
      line("integrator order",
           "2; falls back to 1 (limit first_order) if '%s' exceeds %.3g rad/s or a contact or stop changes",
           fastest->name.c_str(), bound));
}

void add_contacts(const SceneConfig& scene, const Composition& c, std::vector<std::string>& lines) {
  if (c.contacts != ContactScope::none) {
    const ContactCounts counts = contact_counts(scene);
    lines.push_back(line("contacts", "%zu of %zu spheres, %zu of %zu surfaces, at most %zu at once",
                         counts.spheres, c.max_spheres, counts.surfaces, c.max_surfaces, c.max_contacts));
  }
  if (const std::string text = top_speed_text(scene); !text.empty())
    lines.push_back(line("top speed", "%s", text.c_str()));
}

void add_terms(const SceneConfig& scene, std::vector<std::string>& lines) {
  const auto add = [](std::string& text, std::size_t n, const char* one) {
    if (n > 0) text += (text.empty() ? "" : ", ") + number_of(n, one);
  };
  std::string text;
  const TermCounts counts = term_counts(scene);
  add(text, scene.springs.size(), "spring");
  add(text, counts.coordinate_springs - scene.gears.size(), "joint spring");
  add(text, scene.gears.size(), "gear");
  add(text, scene.loops.size(), "closing joint");
  add(text, scene.forces.size(), "force");
  if (!text.empty()) lines.push_back(line("forces", "%s", text.c_str()));
  const Mobility mobility = mobility_at_start(scene);
  if (mobility.num_constraints == 0) return;
  text = number_of(mobility.num_freedoms, "degree") + " of freedom; " +
         number_of(mobility.num_constraints, "constraint") + " by closing joints and rigid gears";
  if (mobility.num_redundant > 0)
    text += ", " + std::to_string(mobility.num_redundant) +
            " of them redundant: how the joints share these forces is arbitrary";
  lines.push_back(line("", "%s", text.c_str()));
}

void add_nets(const Session& session, std::vector<std::string>& lines) {
  const SceneNets& nets = session.engine().nets();
  if (nets.nodes.empty()) return;
  const Composition& c = session.engine().composition();
  const NetTimes times = time_constants(nets);
  double mass = 0;
  for (const NetNode& node : nets.nodes) mass += node.m;
  std::size_t bytes = 0;
  for (const PartBytes& part : c.parts)
    if (part.name == "nets") bytes = part.params_bytes + part.state_bytes + part.scratch_bytes;
  lines.push_back(
      line("nets", "%s: %zu of %zu nodes, %zu of %zu springs, %.3g kg; at most %zu contacts of nodes at once",
           number_of(nets.nets.size(), "net").c_str(), nets.nodes.size(), c.max_nodes, nets.springs.size(),
           c.max_springs, mass, c.max_node_contacts));
  const int stages = session.scene().integrator == integrator_names[0] ? 1 : 2;
  const double most = stages * nets.max_iterations;
  lines.push_back(
      line("", "%zu bytes; a step: %s, each at most %d iterations over %zu springs: %.2g springs, %.2g Mflop",
           bytes, number_of(static_cast<std::size_t>(stages), "stage").c_str(), nets.max_iterations,
           nets.springs.size(), most * static_cast<double>(nets.springs.size()),
           1e-6 * most * flops_of_an_iteration(nets)));
  if (!nets.attachments.empty())
    lines.push_back(line("", "%zu of %zu attachments to other bodies, assumed held in the time constants",
                         nets.attachments.size(), c.max_attachments));
  if (const std::size_t faces = nets.faces().size(); faces > 0) {
    std::string own;
    for (const NetRange& net : nets.nets)
      if (net.touches_itself) own += (own.empty() ? "" : ", ") + ("'" + net.name + "'");
    lines.push_back(line("", "nets touch each other%s%s; %zu of %zu triangles",
                         own.empty() ? "" : "; and themselves: ", own.c_str(), faces, c.max_faces));
  }
  const std::string slowest = times.slowest ? with_number("slowest <= ", *times.slowest, " s, carriers held")
                                            : "slowest not bounded, because nodes have no anchors";
  lines.push_back(line("", "time constants: fastest %.3g s, %.2g steps; %s", times.fastest,
                       times.fastest / session.scene().step, slowest.c_str()));
}

std::string row(const std::string& drive, const std::string& time, const std::string& mechanism) {
  std::array<char, 48> columns{};
  std::snprintf(columns.data(), columns.size(), "#   %-24.24s %8s   ", drive.c_str(), time.c_str());
  return columns.data() + mechanism;
}

std::string milliseconds(const std::optional<double>& s) {
  if (!s) return "never";
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "%.3g ms", 1e3 * *s);
  return text.data();
}

}  // namespace

std::vector<std::string> check_lines(const RunOptions& options, const PreparedRun& prepared) {
  const Session& session = *prepared.session;
  const SceneConfig& scene = session.scene();
  const Composition& composition = session.engine().composition();
  std::vector<std::string> lines;
  lines.push_back(
      line("scene", "%s: '%s', %s, %s", options.scene.c_str(), scene.name.c_str(),
           scene.bodies.size() == 1 ? "1 body" : (std::to_string(scene.bodies.size()) + " bodies").c_str(),
           number_of(scene.joints.size() + scene.loops.size(), "joint").c_str()));
  lines.push_back(line("composition", "'%s', %zu bytes", composition.name.c_str(), composition.bytes()));
  lines.push_back(line("time", "%g s in steps of %g s, %s",
                       static_cast<double>(prepared.plan.num_cycles) * scene.step, scene.step,
                       scene.integrator.c_str()));
  add_order(scene, lines);
  const char* const own_motion = scene.motion ? "of the scene" : "none: the hand rests";
  lines.push_back(line("motion", "%s", options.motion.empty() ? own_motion : options.motion.c_str()));
  if (scene.device) add_device(*scene.device, lines);
  lines.push_back(line("buses", "%s", where_it_runs(options, prepared).c_str()));
  for (const BusLoad& load : prepared.bus_loads)
    lines.push_back(line("", "%s: load %.1f %% at worst, %.1f %% nominal", load.bus.c_str(),
                         load.worst_percent, load.nominal_percent));
  add_times_to_zero(prepared, lines);
  add_contacts(scene, composition, lines);
  add_terms(scene, lines);
  add_nets(session, lines);
  return lines;
}

std::vector<std::string> time_to_zero_lines(const RigParams& rig, double cycle_s,
                                            const RigProfiles& profiles) {
  if (rig.drives.empty()) return {};
  std::vector<std::string> lines{"# time to zero torque after the death of this program"};
  for (std::size_t i = 0; i < rig.drives.size(); ++i) {
    const DriveParams& drive = rig.drives[i];
    const TimeToZero time = time_to_zero(rig, cycle_s, i, profiles);
    lines.push_back(
        row(drive.joint + " (" + rig.buses[drive.bus].name + " node " + std::to_string(drive.node_id) + ")",
            milliseconds(time.s), time.mechanism));
  }
  return lines;
}

}  // namespace godobject
