// Report sections of the extreme maps and the nets.
#include <algorithm>
#include <cmath>

#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "tests/study/report/results.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

std::string at(const ExtremeMap& map, const ExtremeCell& c) {
  std::string text = map.rows.label + " " + number(c.row) + ", " + map.columns.label + " " + number(c.column);
  if (map.panels.values.size() > 1) text += ", " + map.panels.label + " " + number(c.panel);
  return text;
}

void write_summary(std::ostream& out, const ExtremeMap& map, const std::string& integrator) {
  std::size_t cells = 0, red = 0;
  const ExtremeCell* worst = nullptr;
  for (const ExtremeCell& c : map.cells) {
    if (c.integrator != integrator) continue;
    ++cells;
    red += map.is_red(c);
    if (worst == nullptr || c.worst > worst->worst) worst = &c;
  }
  if (worst == nullptr) return;
  out << "| " << map.name << " | " << integrator << " | " << cells << " x " << map.draws << " | "
      << map.measure << " | " << number(map.limit, 2) << " | " << red << " | "
      << (std::isfinite(worst->worst) ? number(worst->worst, 2) : "failed") << " | "
      << (worst->worst > 0 ? at(map, *worst) : "-") << " |\n";
}

}  // namespace

void write_extremes(std::ostream& out, const std::vector<ExtremeMap>& maps) {
  if (maps.empty()) return;
  out << "Stiff and extreme cases that might gain energy, or move for ever, in silence; a cell is red whose "
         "worst case is "
         "beyond the limit:\n\n"
         "| map | integrator | cells x cases | measured | limit | red | worst | where "
         "|\n|---|---|---|---|---|---|---|---|\n";
  for (const ExtremeMap& map : maps)
    for (const char* integrator : {ImplicitEuler::name, TrBdf2::name}) write_summary(out, map, integrator);
  out << '\n';
  for (const ExtremeMap& map : maps) out << "- " << map.name << ": " << map.about << ".\n";
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
      << " mm pressed:\n\n![error of nets against run time](figures/net-error.png)\n\n"
      << "| net | integrator | step, ms | error, m | of the deformation | order | us/step | compute per "
         "simulated s, us |\n"
         "|---|---|---|---|---|---|---|---|\n";
  for (const NetErrorRow& r : nets.errors)
    out << "| " << r.scene << " | " << r.integrator << " | " << number(1e3 * r.h) << " | "
        << number(r.position) << " | " << number(100 * r.share, 2) << " % | "
        << (r.order ? number(*r.order, 2) : "-") << " | " << number(1e-3 * r.ns_per_step) << " | "
        << number(1e-3 * r.ns_per_step / r.h) << " |\n";
  out << "\nWhat a node costs, S6: a tube pressed on a bar, more nodes of the same stuff:\n\n"
         "| nodes | integrator | us/step | 99 % | ns/node | iterations | contacts | instr./step | params | "
         "state | scratch |\n"
         "|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const NetCostRow& r : nets.costs)
    out << "| " << r.nodes << " | " << r.integrator << " | " << number(1e-3 * r.ns_per_step) << " | "
        << number(1e-3 * r.ns_p99) << " | " << number(r.ns_per_step / static_cast<double>(r.nodes)) << " | "
        << number(r.iterations, 2) << " | " << number(r.contacts) << " | "
        << (r.instructions ? whole(r.instructions) : "-") << " | " << r.params_bytes << " | " << r.state_bytes
        << " | " << r.scratch_bytes << " |\n";
  out << "\nBytes, of the composition that holds 1024 nodes.\n\n";
}

}  // namespace godobject::study
