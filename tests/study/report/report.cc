#include "tests/study/report/report.h"

#include <array>
#include <fstream>
#include <stdexcept>

#include "core/gain_watch.h"
#include "tests/study/report/results.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

/// Sections that other commands write: head.py, `godobject-study stability-map`, godobject-peers,
/// float_core.py, steps.py, `./dev sanitize` and the like.
constexpr const char* head = "head";
constexpr std::array sections{"stability map", "peers", "float core", "steps", "long checks"};

void write_question(std::ostream& out, const StudyOptions& options, const std::string& head_section) {
  out << "# Report: error, stability and size of the step\n\n"
      << "Written by `" << options.command << "` on " << options.machine << "; built by "
      << build_description() << ".\n"
      << (options.quick ? "**A quick run: small grids, short scenes.** " : "")
      << "Every number below comes from that run, but those of sections that name another command.\n\n"
      << head_section << "\n## What was asked\n\n"
      << "Error against run time of each integrator; stability in stiff and extreme cases; what a part "
         "costs.\n\n";
}

constexpr const char* error_method = R"(## How

**Error.** Against the [oracle](oracle.md), the largest over all multiples of 4 ms, of the worst body; on S1 and S3 from
0.5 s on. The device's sample is the exact target at the end of each step. Time is the median over up to 1000 steps of
the smallest composition. Instructions are those of S1 (articulated tools: S3, or S5 with eight links).

Drawn, 0.252 s each, against tr-bdf2 at 1/64 ms: released, a rod of 10 to 40 cm and 20 g to 1 kg, up to 10 cm and 2.5 rad
from its target; led, the target swings at up to 2 Hz; chain, S5 of 2 to 5 links, the last up to 100 times heavier; top,
10 to 200 rad/s on a ball joint.

)";

constexpr const char* stability_method =
    R"( A rod of 0.1 kg (moments I, I, I / inertia ratio, I = 1e-3 kg m^2) on a spring
with k_r = k (0.1 m)^2, g = ratio sqrt(m k), g_r = ratio sqrt(I k_r) starts at rest 0.1 m and 1 rad from its resting
target. It runs for one period of the undamped spring, at least 1000 steps. The first that is true:

- *failed*: a fault, or more than 1e6 times the first energy
- *energy-gaining*: the energy rises between any two steps by more than 1e-9 of the first
- *dissipative*: in translation within the first period, over 10 % of the first energy are gone that the exact solution has
- *stable*: none of these

The explicit scheme is semi-implicit Euler with the spring's force at the start of the step.

)";

static_assert(max_energy_loss == 0.1 && max_energy_rise == 1e-9 && max_energy_ratio == 1e6, "quoted above");

constexpr const char* footprint_method =
    R"(**Footprint.** `sizeof`; .text and .rodata of an archive of one step; callgrind: 1000 steps less 500 of S1 at 1 ms.

)";

constexpr const char* joints_method =
    R"(**Joints.** Drift: worst e_v (m) and e_w (rad) of a joint (core/joint/joint.h). In the map all stiffnesses of S3 rise
together. Failed: a fault, a joint apart by 0.1 m or 1 rad, or 100 times the device's largest kinetic energy.

)";
static_assert(max_apart == 0.1 && max_apart_angle == 1 && max_energy_ratio_of_device == 100, "quoted above");

constexpr const char* contacts_method =
    R"(**Contacts.** press and bounce: against the solutions of their cases at multiples of 2 ms. A bounce's error: the larger
share of height and time. The map: a rod of 0.1 kg on five spheres, friction 0.5, thrown at a plane, pressed and dragged;
0.6 s, at most 2000 steps; damping over 2 sqrt(m k); gain without the energy in contact springs. lego: energy is of
bricks never held; one that leaves the board or is faster than 1 m/s is ejected. The residual is the worst force's
deviation from its law or balance. Instructions: S2 (k = 1e4 N/m) from 2.5 to 3 s, S4 from 1.5 to 2 s.

)";
static_assert(ejected_speed == 1, "quoted above");

constexpr const char* extremes_method =
    R"(**Extremes.** A cell is the worst of its drawn cases (tests/study/extreme; seeds in the CSV files). Energy: of bodies,
springs, gravity, with nets of contacts, less outer work (core/energy_balance.h), beyond 1 % of what is at work. A fault,
or a joint 1 mm apart, is infinite.

)";
static_assert(gain_allowed == 0.01, "quoted above");

constexpr const char* nets_method =
    R"(**Nets.** Small: 5 x 5 nodes on a body swayed for 0.128 s, free, or a corner pressed on a plane
(tests/core/net/small_net.h). Error: farthest node or body at the end. Cost: S6, for 0.9 s.

)";

void write_method(std::ostream& out, const StudyResults& results) {
  out << error_method
      << "S3 is too stiff for the explicit oracle. Its reference is tr-bdf2 at 1/64 ms, over the first 0.05 "
         "s "
         "within "
      << number(results.s3_reference_error, 2) << " m of the oracle.\n\n"
      << "**Stability.** " << results.stability.size() / stability_schemes.size() << " cells for each scheme."
      << stability_method << footprint_method << joints_method << contacts_method << extremes_method
      << nets_method;
  if (results.notes.empty()) return;
  out << "Left out:\n\n";
  for (const std::string& note : results.notes) out << "- " << note << '\n';
}

void copy_figures(const StudyOptions& options, const StudyResults& results) {
  const fs::path figures = options.report.parent_path() / "figures";
  fs::create_directories(figures);
  std::vector<std::string> names{"error",         "footprint",         "joint-drift",     "joint-stability",
                                 "contact-error", "contact-stability", "contact-imposed", "net-error"};
  for (const char* scheme : stability_schemes) names.push_back(std::string("stability-") + scheme);
  for (const ExtremeMap& map : results.extremes) names.push_back(figure_of(map));
  for (const std::string& name : names) {
    const fs::path from = options.out / (name + ".png");
    if (fs::exists(from))
      fs::copy_file(from, figures / from.filename(), fs::copy_options::overwrite_existing);
  }
}

/// Returns a section that another command writes, from the report before; else an empty one.
std::string section_of(const fs::path& report, const std::string& name) {
  const std::string begin = "<!-- begin of the " + name + " -->\n",
                    end = "<!-- end of the " + name + " -->\n";
  std::ifstream in(report);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t from = text.find(begin), to = text.find(end);
  if (from == std::string::npos || to == std::string::npos || to < from) return begin + end;
  return text.substr(from, to + end.size() - from);
}

}  // namespace

void write_report(const StudyOptions& options, const StudyResults& results) {
  if (options.report.has_parent_path()) fs::create_directories(options.report.parent_path());
  const std::string head_section = section_of(options.report, head);
  std::string kept;
  for (const char* name : sections) kept += section_of(options.report, name) + '\n';
  std::ofstream out(options.report);
  write_question(out, options, head_section);
  out << "## Result\n\n";
  write_error(out, results.errors);
  write_random(out, results.random);
  write_stability(out, results);
  write_extremes(out, results.extremes);
  write_footprint(out, results.footprint);
  write_joints(out, results);
  write_contacts(out, results);
  write_nets(out, results.nets);
  out << kept;
  write_method(out, results);
  if (!out.flush()) throw std::runtime_error(options.report.string() + ": cannot be written");
  copy_figures(options, results);
}

}  // namespace godobject::study
