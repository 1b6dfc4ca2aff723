#include "tests/study/report/results.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

const std::array<std::string, 2> integrators{ImplicitEuler::name, TrBdf2::name};

const ErrorRow* find_row(const std::vector<ErrorRow>& rows, const std::string& scene,
                         const std::string& integrator, double h) {
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

/// Returns the step sizes of the results, slowest first.
std::vector<double> steps_of(const std::vector<ErrorRow>& rows) {
  std::vector<double> steps;
  for (const ErrorRow& r : rows)
    if (std::find(steps.begin(), steps.end(), r.h) == steps.end()) steps.push_back(r.h);
  return steps;
}

/// True if a is at least as accurate as b. A free body's position is exact with every integrator, so only its
/// attitude counts.
bool at_least_as_accurate(const ErrorRow& a, const ErrorRow& b) {
  return a.errors.rotation <= b.errors.rotation &&
         (a.errors.energy || a.errors.position <= b.errors.position);
}

std::string error_text(const ErrorRow& r) {
  const std::string rotation = number(r.errors.rotation, 2) + " rad";
  return r.errors.energy ? rotation : number(r.errors.position, 2) + " m, " + rotation;
}

/// Writes the longest step at which the second-order integrator matches the first-order one at its shortest.
void write_exchange(std::ostream& out, const std::vector<ErrorRow>& rows, const std::string& scene) {
  const ErrorRow* const fine = find_row(rows, scene, ImplicitEuler::name, steps_of(rows).back());
  for (const double h : steps_of(rows)) {
    const ErrorRow* const row = find_row(rows, scene, TrBdf2::name, h);
    if (row == nullptr || fine == nullptr || !at_least_as_accurate(*row, *fine)) continue;
    out << "| " << scene << " | " << number(h * 1e3) << " | " << error_text(*row) << " | "
        << error_text(*fine) << " | " << whole(100 * row->ns_per_second() / fine->ns_per_second()) << " |\n";
    return;
  }
  out << "| " << scene << " | none | | | |\n";
}

/// Returns the order at the last halving of the step.
std::string last_order(const std::vector<ErrorRow>& rows, const ErrorRow& r,
                       std::optional<double> ErrorRow::*order) {
  const ErrorRow* const last = find_row(rows, r.scene, r.integrator, steps_of(rows).back());
  return last != nullptr && last->*order ? number(*(last->*order)) : "-";
}

}  // namespace

void write_error(std::ostream& out, const std::vector<ErrorRow>& rows) {
  constexpr double h = 1e-3;
  out << "### 1. Error against run time\n\n";
  if (rows.empty()) return;
  out << "The longest step at which " << TrBdf2::name << " is at least as accurate as " << ImplicitEuler::name
      << " at " << number(1e3 * steps_of(rows).back()) << " ms, and its share of the compute time:\n\n"
      << "| scene | step, ms | error | " << ImplicitEuler::name << " | time, % |\n|---|---|---|---|---|\n";
  for (const std::string& scene : scenes_of(rows)) write_exchange(out, rows, scene);
  out << R"(
![error against run time](figures/error.png)

Where the line of tr-bdf2 breaks, longer steps are taken as two implicit Euler stages.

At 1 ms; worst errors of position (m) and rotation (rad); order of the last halving; drift of the joints; all steps:
`error.csv`:

| scene | integrator | m | order | rad | order | drift, m | drift, rad | ns/step | instr./step |
|---|---|---|---|---|---|---|---|---|---|
)";
  for (const std::string& scene : scenes_of(rows))
    for (const std::string& integrator : integrators) {
      const ErrorRow* const r = find_row(rows, scene, integrator, h);
      if (r == nullptr) continue;
      out << "| " << scene << " | " << integrator << " | " << number(r->errors.position) << " | "
          << last_order(rows, *r, &ErrorRow::order_position) << " | " << number(r->errors.rotation) << " | "
          << last_order(rows, *r, &ErrorRow::order_rotation) << " | "
          << (r->errors.drift ? number(r->errors.drift->m, 2) + " | " + number(r->errors.drift->rad, 2)
                              : "- | -")
          << " | " << number(r->ns_per_step) << " | " << whole(r->instructions_per_step) << " |\n";
    }
  out << '\n';
}

void write_random(std::ostream& out, const std::vector<RandomRow>& rows) {
  if (rows.empty()) return;
  out << "Drawn at random (`error-random.csv`): error of " << TrBdf2::name << " at 1 ms over that of "
      << ImplicitEuler::name << R"( at 0.125 ms.

| scenes | drawn | less accurate | position: median | 90 % | worst | rotation: median | 90 % | worst |
|---|---|---|---|---|---|---|---|---|
)";
  for (const std::string& kind : random_kinds()) {
    std::vector<double> position, rotation;
    long less_accurate = 0;
    for (const RandomRow& r : rows) {
      if (r.scene != kind) continue;
      position.push_back(r.position);
      rotation.push_back(r.rotation);
      less_accurate += std::max(r.position, r.rotation) > 1;
    }
    out << "| " << kind << " | " << position.size() << " | " << less_accurate;
    for (std::vector<double>* ratios : {&position, &rotation}) {
      std::ranges::sort(*ratios);
      out << " | " << number((*ratios)[ratios->size() / 2], 2) << " | "
          << number((*ratios)[ratios->size() * 9 / 10], 2) << " | " << number(ratios->back(), 2);
    }
    out << " |\n";
  }
  out << '\n';
}

namespace {

std::size_t count(const std::vector<StabilityResult>& results, const std::string& scheme,
                  Stability stability) {
  return static_cast<std::size_t>(std::count_if(
      results.begin(), results.end(),
      [&](const StabilityResult& r) { return r.scheme == scheme && r.stability == stability; }));
}

/// Writes the largest gain of energy of a scheme, if any.
void write_gains(std::ostream& out, const std::vector<StabilityResult>& results, const std::string& scheme) {
  double rise = 0, max_damping = 0;
  for (const StabilityResult& r : results) {
    if (r.scheme != scheme || r.stability != Stability::energy_gaining) continue;
    rise = std::max(rise, r.rise);
    max_damping = std::max(max_damping, r.cell.damping);
  }
  if (rise > 0)
    out << "- " << scheme << " gains at most " << number(rise, 2)
        << " of the first energy, with a damping ratio of " << number(max_damping)
        << (max_damping > 0 ? " or less" : "") << ".\n";
}

}  // namespace

void write_stability(std::ostream& out, const StudyResults& results) {
  out << "### 2. Stability\n\n"
         "Cells that are stable, dissipative, energy-gaining, failed, over coupling stiffness, step, "
         "damping\nratio and inertia ratio:\n\n";
  for (const std::string scheme : stability_schemes) {
    out << "- " << scheme;
    const char* separator = ": ";
    for (const Stability s :
         {Stability::stable, Stability::dissipative, Stability::energy_gaining, Stability::failed}) {
      out << separator << count(results.stability, scheme, s);
      separator = ", ";
    }
    out << '\n';
  }
  out << "\nBlack line: the theoretical limit of the explicit scheme.\n\n";
  for (const std::string scheme : stability_schemes) write_gains(out, results.stability, scheme);
  out << '\n';
  for (const std::string scheme : stability_schemes)
    out << "![stability of " << scheme << "](figures/stability-" << scheme << ".png)\n\n";
  out << R"(The explicit scheme's limit of h sqrt(k/m) in translation, by theory (z half the damping ratio) 2 (sqrt(z^2 + 1) - z),
and by bisection:

)";
  for (const ExplicitLimit& l : results.explicit_limits)
    out << "- ratio " << number(l.damping) << ": " << number(explicit_limit(l.damping), 4) << ", "
        << number(l.measured, 4) << '\n';
  out << '\n';
}

namespace {

std::string change(std::optional<double> with, std::optional<double> without) {
  if (!with || !without) return "not available";
  std::ostringstream text;
  text << std::showpos << std::lround(*with - *without);
  return text.str();
}

double data_bytes(const FootprintRow& r) {
  return static_cast<double>(r.params_bytes + r.state_bytes + r.scratch_bytes);
}

/// Writes the cost of each component: differences of pairs of compositions.
void write_parts(std::ostream& out, const std::vector<FootprintRow>& rows) {
  struct Part {
    const char *name, *without, *with;
  };
  constexpr std::array parts{Part{"device", "free-1 implicit-euler", "device-1 implicit-euler"},
                             Part{"coupling", "device-1 implicit-euler", "pose-1 implicit-euler"},
                             Part{"feedback", "pose-1 implicit-euler", "haptic-1 implicit-euler"},
                             Part{"second order", "haptic-1 implicit-euler", "haptic-1 tr-bdf2"},
                             Part{"capacity 8, one body in it", "haptic-1 tr-bdf2", "haptic-8 tr-bdf2"}};
  out << R"(What a part adds:

| part | from | to | data, bytes | code, bytes | constants, bytes | instructions of a step |
|---|---|---|---|---|---|---|
)";
  for (const Part& p : parts) {
    const FootprintRow *const a = find(rows, p.without), *const b = find(rows, p.with);
    if (a == nullptr || b == nullptr) continue;
    out << "| " << p.name << " | " << p.without << " | " << p.with << " | "
        << change(data_bytes(*b), data_bytes(*a)) << " | " << change(b->code_bytes, a->code_bytes) << " | "
        << change(b->constant_bytes, a->constant_bytes) << " | " << change(b->instructions, a->instructions)
        << " |\n";
  }
  out << '\n';
}

}  // namespace

void write_footprint(std::ostream& out, const std::vector<FootprintRow>& rows) {
  out << "### 3. Footprint\n\n";
  if (rows.empty()) {
    out << "Not available.\n\n";
    return;
  }
  write_parts(out, rows);
  if (const FootprintRow* const smallest = find(rows, "free-1 implicit-euler"))
    out << "The smallest, " << smallest->composition << ", has " << whole(data_bytes(*smallest))
        << " bytes of data, " << whole(smallest->code_bytes) << " of code and "
        << whole(smallest->constant_bytes) << " of constants, and " << whole(smallest->instructions)
        << " instructions a step. All compositions: `footprint.csv`; the number after the dash is how many "
           "bodies fit.\n\n";
  out << "![footprint](figures/footprint.png)\n\n";
}

}  // namespace godobject::study
