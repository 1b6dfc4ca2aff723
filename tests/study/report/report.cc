#include "tests/study/report/report.h"

#include <fstream>
#include <stdexcept>

#include "core/gain_watch.h"
#include "tests/study/report/results.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

void write_question(std::ostream& out, const StudyOptions& options) {
  out << "# Report: error, stability and size of the step\n\n"
      << "Written by `" << options.command << "` on " << options.machine << "; built by "
      << build_description() << ".\n"
      << (options.quick ? "**A quick run: small grids, short scenes.** " : "")
      << "Every number below comes from that run.\n\n"
      << "## What was asked\n\n"
      << "1. Error against run time of each integrator.\n"
      << "2. What each does in stiff and extreme cases.\n"
      << "3. What a scene saves by leaving parts out.\n"
      << "4. Articulated tools: error, what holds their joints, what joints cost.\n"
      << "5. Contacts: error, stability, what a god-object avoids, what contacts and friction cost.\n"
      << "6. Nets: error against run time, what a node costs; their stability is in 2.\n\n";
}

constexpr const char* error_method = R"(## How

**Error.** The reference is `tests/oracle`: extrapolation of order 12 in extended precision, which shares no
code with the core. Errors are the largest over all multiples of 4 ms: distance of the centres of mass, angle
between the attitudes, both of the worst body, and for the free body the change of kinetic energy. On S1 and S3
they count from 0.5 s on. The device's sample is the exact target at the end of each step. Time is the median
over stretches of up to 1000 steps of the smallest composition, inputs computed before. Instructions per simulated
second are those of a step on S1 (articulated tools: S3, or S5 with eight links) at 1 ms, over the step.

Drawn at random, each with a seed of its own, 0.252 s, against tr-bdf2 at 1/64 ms: released, a rod of 10 to 40 cm and
20 g to 1 kg let go towards a target up to 10 cm and 2.5 rad away; led, the same on a target that swings and turns at up to
2 Hz; chain, S5 of 2 to 5 links in any attitude, the last one up to 100 times heavier; top, a body that spins at 10 to
200 rad/s on a ball joint.

)";

constexpr const char* stability_method = R"( A rod of 0.1 kg (moments I, I, I / inertia ratio,
I = 1e-3 kg m^2) on a spring with k_r = k (0.1 m)^2 and damping g = ratio sqrt(m k), g_r = ratio sqrt(I k_r)
starts at rest 0.1 m and 1 rad from its target, which rests too. It runs for one period of the undamped
spring, at least 1000 steps. The first of these that is true:

- *failed*: a fault, or more than 1e6 times the first energy;
- *energy-gaining*: the energy of tool and spring rises from some step to some later one by more than 1e-9 of
  the first energy; the exact energy never rises;
- *dissipative*: in translation, at some time within the first period (at least one step), more than 10 % of
  the first energy is gone that the exact solution, known in closed form, still has;
- *stable*: none of these.

The explicit scheme, semi-implicit Euler with the spring's force taken at the start of the step, exists in the
study only.

)";

static_assert(max_energy_loss == 0.1 && max_energy_rise == 1e-9 && max_energy_ratio == 1e6, "quoted above");

constexpr const char* footprint_method = R"(**Footprint.** Params, state and scratch are `sizeof`.
Code and constants are the .text and .rodata sections of an archive that holds the step of one composition and
nothing else. Instructions are counted by callgrind inside the step: 1000 steps less 500 steps of S1 at 1 ms,
over 500.

)";

constexpr const char* joints_method = R"(**Joints.** Drift is the worst e_v (m) and e_w (rad) of
any joint (core/joint/joint.h) after any step. The map starts S3 on its moving device; all its stiffnesses rise
together, the number given is that of trocar and tube, and damping ratios stay. A run has failed when the step
reports a fault, a joint is apart by more than 0.1 m or 1 rad, or the tool has more than 100 times the largest
kinetic energy of its device. Schemes that need the start of the stage exist for implicit Euler only. Slow motion:
a fifth of the amplitude (S5: of gravity) at 0.3 times the rate. In a pair the device of the second body also pulls
across the joint.

)";
static_assert(max_apart == 0.1 && max_apart_angle == 1 && max_energy_ratio_of_device == 100, "quoted above");

constexpr const char* contacts_method =
    R"(**Contacts.** press and bounce are set against the reference solutions of their cases, at the times of these
that are multiples of 2 ms: distance of the centres of mass, difference of the deepest sphere's depth, difference of
energy, contact springs included. Where in a step an impact falls changes an error by a factor: orders of single halvings
scatter, those over all steps tell. A bounce is within the larger share of its height and its time.

The map: a rod of 0.1 kg on five spheres, friction 0.5, thrown at a plane, and pressed into it by a coupling and dragged;
0.6 s, at most 2000 steps; damping is over critical, 2 sqrt(m k). What is in the contact springs is left out of the gain,
so that it cannot hide what comes back from them.

lego: peaks of every step. Overlap is the depth of the deepest sphere or edge in what it touches; `./dev bench` says how
deep the boxes are in each other. Energy, kinetic and potential, is that of the bricks that are never held, and a brick is
ejected that leaves the board or is faster than 1 m/s. The residual is by how much the worst force misses its law or its
balance when the solver stops.

Instructions: S2 (k = 1e4 N/m) from 2.5 to 3 s, S4 from 1.5 to 2 s. A scene pays for what it has: one
without contacts has no code and no byte of theirs, one over obstacles no code of touching bodies (tests
`SceneWithoutContacts.HasNotAByteForThem` and `contacts.no_scene_pays_for_contacts_it_has_not`).

)";
static_assert(ejected_speed == 1, "quoted above");

constexpr const char* extremes_method =
    R"(**Extremes.** A cell is the worst of its cases, each drawn with a seed of its own (tests/study/extreme_*.cc), which the
CSV files name. Energy is that of bodies, springs and gravity; of nets, also of contacts, less the work done from outside
(core/energy_balance.h), and counts as gained where the run-time check of scenes says so, beyond 1 % of what is at work. A
fault, or a joint 1 mm apart, counts as infinite.

)";
static_assert(gain_allowed == 0.01, "quoted above");

constexpr const char* nets_method =
    R"(**Nets.** The small net: a sheet of 5 x 5 nodes on a body that a hand sways for 0.128 s, free, or a corner of it pressed on a
plane (tests/core/net/small_net.h). The oracle has its nodes as balls and its anchors as springs. Error: the farthest of nodes and
body at the end; default iterations: 12 at most, and none after one that changes no velocity by more than 0.1 mm/s in an
implicit Euler step of 1 ms. Cost: S6, a tube of rings on a coupled body, pressed on a bar and drawn off for 0.9 s; each step
is timed.

)";

void write_method(std::ostream& out, const StudyResults& results) {
  out << error_method
      << "S3 is stiff (its tube rolls at 4e4 1/s): the oracle, which is explicit, would take minutes. Its "
         "reference is "
      << "tr-bdf2 at 1/64 ms, over the first 0.05 s within " << number(results.s3_reference_error, 2)
      << " m of the oracle.\n\n"
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

}  // namespace

void write_report(const StudyOptions& options, const StudyResults& results) {
  if (options.report.has_parent_path()) fs::create_directories(options.report.parent_path());
  std::ofstream out(options.report);
  write_question(out, options);
  out << "## Result\n\n";
  write_error(out, results.errors);
  write_random(out, results.random);
  write_stability(out, results);
  write_extremes(out, results.extremes);
  write_footprint(out, results.footprint);
  write_joints(out, results);
  write_contacts(out, results);
  write_nets(out, results.nets);
  write_method(out, results);
  if (!out.flush()) throw std::runtime_error(options.report.string() + ": cannot be written");
  copy_figures(options, results);
}

}  // namespace godobject::study
