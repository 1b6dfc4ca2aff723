// Report sections of the extreme maps and the nets.
#include <algorithm>
#include <cmath>

#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "tests/study/report/results.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

/// Red cells and the worst value of one integrator.
struct Worst {
  std::size_t red = 0;
  double value = 0;
};

Worst worst_of(const ExtremeMap& map, const std::string& integrator) {
  Worst worst;
  for (const ExtremeCell& c : map.cells) {
    if (c.integrator != integrator) continue;
    worst.red += map.is_red(c);
    worst.value = std::max(worst.value, c.worst);
  }
  return worst;
}

std::string text_of(const Worst& worst) {
  return std::isfinite(worst.value) ? number(worst.value, 2) : "failed";
}

}  // namespace

void write_extremes(std::ostream& out, const std::vector<ExtremeMap>& maps) {
  if (maps.empty()) return;
  out << "Stiff and extreme cases that might gain energy, or move for ever, in silence. A cell is red whose "
         "worst case is beyond the limit. Pairs: implicit-euler, tr-bdf2.\n\n"
         "| map of | cells | draws | red | worst | limit | measured |\n|---|---|---|---|---|---|---|\n";
  for (const ExtremeMap& map : maps) {
    const Worst euler = worst_of(map, ImplicitEuler::name), second = worst_of(map, TrBdf2::name);
    out << "| " << map.about << " | " << map.cells.size() / 2 << " | " << map.draws << " | " << euler.red
        << ", " << second.red << " | " << text_of(euler) << ", " << text_of(second) << " | "
        << number(map.limit, 2) << " | " << map.measure << " |\n";
  }
  out << '\n';
  for (const ExtremeMap& map : maps) out << "![" << map.name << "](figures/" << figure_of(map) << ".png)\n\n";
}

void write_nets(std::ostream& out, const NetResults& nets) {
  out << "### 6. Nets\n\n";
  if (nets.errors.empty()) {
    out << "Not available.\n\n";
    return;
  }
  out << "The small net, 25 nodes, deformed by " << number(1e3 * nets.deformation_free, 2)
      << " mm in the mean free and " << number(1e3 * nets.deformation_pressed, 2)
      << " mm pressed; at 1 ms, other steps are in `net-error.csv`:\n\n![error of nets against run "
         "time](figures/net-error.png)\n\n"
      << "| net | integrator | error, m | us/step |\n"
         "|---|---|---|---|\n";
  for (const NetErrorRow& r : nets.errors) {
    if (!is_one_ms(r.h)) continue;
    out << "| " << r.scene << " | " << r.integrator << " | " << number(r.position) << " | "
        << number(1e-3 * r.ns_per_step) << " |\n";
  }
  out << "\nWhat a node costs, S6: a tube pressed on a bar, more nodes of the "
         "same stuff:\n\n"
         "| nodes | integrator | us/step | us, 99 % | iterations | contacts | instr./step |\n"
         "|---|---|---|---|---|---|---|\n";
  for (const NetCostRow& r : nets.costs)
    out << "| " << r.nodes << " | " << r.integrator << " | " << number(1e-3 * r.ns_per_step) << " | "
        << number(1e-3 * r.ns_p99) << " | " << number(r.iterations, 2) << " | " << number(r.contacts) << " | "
        << (r.instructions ? whole(r.instructions) : "-") << " |\n";
  out << "\nThe composition holds 1024 nodes; its bytes are in `net-cost.csv`.\n\n"
         "A sheet falls on another one, which lies on a ball (`tests/study/scenes/sheets.toml`), after 0.5 "
         "s:\n\n"
         "![two sheets](figures/sheets.png)\n\n";
}

}  // namespace godobject::study
