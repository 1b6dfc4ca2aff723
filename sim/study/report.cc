#include "sim/study/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "core/godobject.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

const std::array<std::string, 2> integrators{ImplicitEuler::name, TrBdf2::name};

std::string number(double value, int digits = 3) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}
std::string number(const std::optional<double>& value, int digits = 3) {
  return value ? number(*value, digits) : "not available";
}
std::string whole(const std::optional<double>& value) {
  return value ? std::to_string(std::lround(*value)) : "not available";
}

const ErrorRow* find_row(const std::vector<ErrorRow>& rows, const std::string& scene, const std::string& integrator, double h) {
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const ErrorRow& r) {
    return r.scene == scene && r.integrator == integrator && std::abs(r.h / h - 1) < 1e-6;
  });
  return row == rows.end() ? nullptr : &*row;
}

std::vector<std::string> scenes_of(const std::vector<ErrorRow>& rows) {
  std::vector<std::string> scenes;
  for (const ErrorRow& r : rows)
    if (std::find(scenes.begin(), scenes.end(), r.scene) == scenes.end()) scenes.push_back(r.scene);
  return scenes;
}

/// The step sizes of the results, slowest first.
std::vector<double> steps_of(const std::vector<ErrorRow>& rows) {
  std::vector<double> steps;
  for (const ErrorRow& r : rows)
    if (std::find(steps.begin(), steps.end(), r.h) == steps.end()) steps.push_back(r.h);
  return steps;
}

void write_question(std::ostream& out, const StudyOptions& options) {
  out << "# Report: error, stability and size of the step\n\n"
      << "Written by `" << options.command << "` on " << options.machine << "; built by " << build_description() << ".\n"
      << (options.quick ? "**A quick run: small grids, short scenes.** " : "")
      << "Every number below comes from that run.\n\n"
      << "## What was asked\n\n"
      << "1. Error against run time of each integrator.\n"
      << "2. What each does in stiff and extreme cases.\n"
      << "3. What a scene saves by leaving parts out.\n\n";
}

/// The slowest-is-cheapest way of `better` to be at least as accurate as the best `worse` row.
void write_exchange(std::ostream& out, const std::vector<ErrorRow>& rows, const std::string& scene) {
  const ErrorRow* const fine = find_row(rows, scene, ImplicitEuler::name, steps_of(rows).back());
  if (fine == nullptr) return;
  for (const double h : steps_of(rows)) {
    const ErrorRow* const row = find_row(rows, scene, TrBdf2::name, h);
    if (row == nullptr || row->errors.position > fine->errors.position || row->errors.rotation > fine->errors.rotation)
      continue;
    out << "On " << scene << ", " << TrBdf2::name << " at " << number(h * 1e3) << " ms is at least as accurate as "
        << ImplicitEuler::name << " at " << number(fine->h * 1e3) << " ms (" << number(row->errors.position, 2) << " against "
        << number(fine->errors.position, 2) << " m, " << number(row->errors.rotation, 2) << " against "
        << number(fine->errors.rotation, 2) << " rad) for " << number(100 * row->ns_per_second() / fine->ns_per_second(), 2)
        << " % of the compute time.\n";
    return;
  }
}

/// Mean order from the slowest step to h, or "-" where the error is rounding.
std::string mean_order(const std::vector<ErrorRow>& rows, const ErrorRow& last, std::optional<double> ErrorRow::*order) {
  double sum = 0;
  int count = 0;
  for (const ErrorRow& r : rows) {
    if (r.scene != last.scene || r.integrator != last.integrator || !(r.*order)) continue;
    sum += *(r.*order);
    ++count;
  }
  return count > 0 ? number(sum / count, 2) : "-";
}

void write_error(std::ostream& out, const std::vector<ErrorRow>& rows) {
  constexpr double h = 1e-3;
  out << "### 1. Error against run time\n\n";
  for (const std::string& scene : scenes_of(rows)) write_exchange(out, rows, scene);
  out << "\n![error against run time](figures/error.png)\n\n"
      << "At a step of 1 ms; \"order\" is the mean over all halvings of the step:\n\n"
      << "| scene | integrator | position error, m | order | rotation error, rad | order | energy error | ns per step | "
         "instructions per step | instructions per simulated s |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const std::string& scene : scenes_of(rows))
    for (const std::string& integrator : integrators) {
      const ErrorRow* const r = find_row(rows, scene, integrator, h);
      if (r == nullptr) continue;
      out << "| " << scene << " | " << integrator << " | " << number(r->errors.position) << " | "
          << mean_order(rows, *r, &ErrorRow::order_position) << " | " << number(r->errors.rotation) << " | "
          << mean_order(rows, *r, &ErrorRow::order_rotation) << " | "
          << (r->errors.energy ? number(*r->errors.energy) : "-") << " | " << number(r->ns_per_step) << " | "
          << whole(r->instructions_per_step) << " | " << number(r->instructions_per_second()) << " |\n";
    }
  out << "\nAll steps: `error.csv`.\n\n";
}

std::size_t count(const std::vector<StabilityResult>& results, const std::string& scheme, Stability stability) {
  return static_cast<std::size_t>(std::count_if(results.begin(), results.end(), [&](const StabilityResult& r) {
    return r.scheme == scheme && r.stability == stability;
  }));
}

/// In which cells a scheme gains energy, and how much.
void write_gains(std::ostream& out, const std::vector<StabilityResult>& results, const std::string& scheme) {
  const std::size_t gaining = count(results, scheme, Stability::energy_gaining);
  double rise = 0, max_damping = 0;
  for (const StabilityResult& r : results) {
    if (r.scheme != scheme || r.stability != Stability::energy_gaining) continue;
    rise = std::max(rise, r.rise);
    max_damping = std::max(max_damping, r.cell.damping);
  }
  if (gaining == 0)
    out << "- " << scheme << " gains energy in no cell.\n";
  else
    out << "- " << scheme << " gains energy in " << gaining << " cells, all with a damping ratio of " << number(max_damping)
        << (max_damping > 0 ? " or less" : "") << ": at most " << number(rise, 2) << " of the first energy.\n";
}

void write_stability(std::ostream& out, const StudyResults& results) {
  out << "### 2. Stability\n\n| scheme | stable | dissipative | energy-gaining | failed |\n|---|---|---|---|---|\n";
  for (const std::string scheme : stability_schemes) {
    out << "| " << scheme << " |";
    for (const Stability s : {Stability::stable, Stability::dissipative, Stability::energy_gaining, Stability::failed})
      out << ' ' << count(results.stability, scheme, s) << " |";
    out << '\n';
  }
  out << "\nCells of the map by class. The map runs over coupling stiffness, step, damping ratio and inertia ratio; the "
         "black line is the limit of the explicit coupling by theory, in the faster of translation and rotation.\n\n";
  for (const std::string scheme : stability_schemes) write_gains(out, results.stability, scheme);
  out << '\n';
  for (const std::string scheme : stability_schemes)
    out << "![stability of " << scheme << "](figures/stability-" << scheme << ".png)\n\n";
  out << "The explicit coupling's limit of h sqrt(k/m) in translation, by theory 2 (sqrt(z^2 + 1) - z) with z half the "
         "damping ratio g / sqrt(m k), and found by bisection:\n\n| damping ratio | theory | measured |\n|---|---|---|\n";
  for (const ExplicitLimit& l : results.explicit_limits)
    out << "| " << number(l.damping) << " | " << number(explicit_limit(l.damping), 4) << " | " << number(l.measured, 4)
        << " |\n";
  out << '\n';
}

std::string change(std::optional<double> with, std::optional<double> without) {
  if (!with || !without) return "not available";
  std::ostringstream text;
  text << std::showpos << std::lround(*with - *without);
  return text.str();
}

double data_bytes(const FootprintRow& r) { return static_cast<double>(r.params_bytes + r.state_bytes + r.scratch_bytes); }

/// What each part adds: pairs of compositions that differ by it.
void write_parts(std::ostream& out, const std::vector<FootprintRow>& rows) {
  struct Part { const char *name, *without, *with; };
  constexpr std::array parts{Part{"device", "free-1 implicit-euler", "device-1 implicit-euler"},
                             Part{"coupling", "device-1 implicit-euler", "pose-1 implicit-euler"},
                             Part{"feedback", "pose-1 implicit-euler", "haptic-1 implicit-euler"},
                             Part{"second order", "haptic-1 implicit-euler", "haptic-1 tr-bdf2"},
                             Part{"capacity 8, one body in it", "haptic-1 tr-bdf2", "haptic-8 tr-bdf2"}};
  out << "What a part adds:\n\n| part | from | to | data, bytes | code, bytes | constants, bytes | instructions of a step |\n"
         "|---|---|---|---|---|---|---|\n";
  for (const Part& p : parts) {
    const FootprintRow *const a = find(rows, p.without), *const b = find(rows, p.with);
    if (a == nullptr || b == nullptr) continue;
    out << "| " << p.name << " | " << p.without << " | " << p.with << " | " << change(data_bytes(*b), data_bytes(*a))
        << " | " << change(b->code_bytes, a->code_bytes) << " | " << change(b->constant_bytes, a->constant_bytes)
        << " | " << change(b->instructions, a->instructions) << " |\n";
  }
  out << '\n';
}

void write_footprint(std::ostream& out, const std::vector<FootprintRow>& rows) {
  out << "### 3. Footprint\n\n";
  if (rows.empty()) {
    out << "Not available.\n\n";
    return;
  }
  write_parts(out, rows);
  out << "![footprint](figures/footprint.png)\n\n"
      << "| composition | params | state | scratch | code | constants | instructions, one body | instructions, all "
         "bodies |\n|---|---|---|---|---|---|---|---|\n";
  for (const FootprintRow& r : rows)
    out << "| " << r.composition << " | " << r.params_bytes << " | " << r.state_bytes << " | " << r.scratch_bytes << " | "
        << whole(r.code_bytes) << " | " << whole(r.constant_bytes) << " | " << whole(r.instructions) << " | "
        << whole(r.instructions_full) << " |\n";
  out << "\nBytes; the number after the dash is how many bodies fit.\n\n";
}

void write_method(std::ostream& out, const StudyResults& results) {
  const std::size_t num_cells = results.stability.size() / 3;
  out << "## How\n\n"
         "**Error.** The reference is `tests/oracle`: extrapolation of order 12 in extended precision, which shares no code "
         "with the core. Errors are the largest over all multiples of 4 ms: distance of the centres of mass, angle between "
         "the attitudes, and for the free body the change of kinetic energy. On S1 they count from 0.5 s on. The device's "
         "sample is the exact target at the end of each step. Time is the median of repeated runs of a loop over the step of "
         "the smallest composition, its inputs computed before; the timer runs round the whole loop. Instructions per "
         "simulated second are those of a step on S1, over the step.\n\n"
         "**Stability.** " << num_cells << " cells for each scheme. A rod of 0.1 kg (moments I, I, I / inertia ratio, I = 1e-3 kg "
         "m^2) on a spring with k_r = k (0.1 m)^2 and damping g = ratio sqrt(m k), g_r = ratio sqrt(I k_r) starts at rest "
         "0.1 m and 1 rad from its target, which rests too. It runs for one period of the undamped spring, at least 1000 "
         "steps. *Failed*: a fault, or more than 1e6 times the first energy. *Energy-gaining*: the energy of tool and spring "
         "rises from some step to some later one by more than 1e-9 of the first energy; the exact energy never rises. "
         "*Dissipative*: in translation, at some time within the first period (at least one step), more than "
      << number(100 * max_energy_loss)
      << " % of the first energy is gone that the exact solution, known in closed form, still has. *Stable*: none of these. "
         "The explicit scheme, semi-implicit Euler with the spring's force taken at the start of the step, exists in the "
         "study only.\n\n"
         "**Footprint.** Params, state and scratch are `sizeof`. Code and constants are the .text and .rodata sections of an "
         "archive that holds the step of one composition and nothing else. Instructions are counted by callgrind inside the "
         "step: 1000 steps less 500 steps of S1 at 1 ms, over 500.\n\n";
  if (results.notes.empty()) return;
  out << "Left out:\n\n";
  for (const std::string& note : results.notes) out << "- " << note << '\n';
  out << '\n';
}

void copy_figures(const StudyOptions& options) {
  const fs::path figures = options.report.parent_path() / "figures";
  fs::create_directories(figures);
  std::vector<std::string> names{"error", "footprint"};
  for (const char* scheme : stability_schemes) names.push_back(std::string("stability-") + scheme);
  for (const std::string& name : names) {
    const fs::path from = options.out / (name + ".png");
    if (fs::exists(from)) fs::copy_file(from, figures / from.filename(), fs::copy_options::overwrite_existing);
  }
}

}  // namespace

void write_report(const StudyOptions& options, const StudyResults& results) {
  if (options.report.has_parent_path()) fs::create_directories(options.report.parent_path());
  std::ofstream out(options.report);
  write_question(out, options);
  out << "## Result\n\n";
  write_error(out, results.errors);
  write_stability(out, results);
  write_footprint(out, results.footprint);
  write_method(out, results);
  if (!out.flush()) throw std::runtime_error(options.report.string() + ": cannot be written");
  copy_figures(options);
}

}  // namespace godobject::study
