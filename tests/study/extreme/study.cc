#include "tests/study/extreme/study.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "tests/study/csv_writer.h"
#include "tests/study/plots.h"

namespace godobject::study {
namespace {

/// Returns the axis range, extended by half a cell on each side.
std::string range_with_rims(const Axis& axis) {
  const double first = std::log10(axis.values.front()), last = std::log10(axis.values.back()),
               half = (last - first) / (2 * (static_cast<double>(axis.values.size()) - 1));
  std::ostringstream text;
  text << '[' << first - half << ':' << last + half << ']';
  return text.str();
}

std::string text_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace

void fill(ExtremeMap& map, const std::string& integrator, const ExtremeCase& measure,
          const Progress& progress) {
  progress("stability: " + map.name + ", " + integrator);
  for (const double panel : map.panels.values)
    for (const double row : map.rows.values)
      for (const double column : map.columns.values) {
        ExtremeCell cell{.integrator = integrator, .panel = panel, .row = row, .column = column};
        for (unsigned draw = 0; draw < map.draws; ++draw) {
          const double value = measure(panel, row, column, draw);
          if (value <= cell.worst) continue;
          cell.worst = std::isfinite(value) ? value : std::numeric_limits<double>::infinity();
          cell.worst_draw = draw;
        }
        map.cells.push_back(cell);
      }
}

std::vector<ExtremeMap> study_extremes(bool quick, const Progress& progress) {
  std::vector<ExtremeMap> maps;
  for (const auto map : {map_spin, map_heavy_end, map_contradiction, map_pressed, map_nets})
    maps.push_back(map(quick, progress));
  return maps;
}

std::string figure_of(const ExtremeMap& map) { return "extreme-" + map.name; }

void write_csv(const std::filesystem::path& file, const ExtremeMap& map) {
  CsvWriter csv(file, "integrator,panel,row,column,worst,worst_draw,red");
  for (const ExtremeCell& c : map.cells)
    csv.row(c.integrator, c.panel, c.row, c.column, c.worst, c.worst_draw, map.is_red(c) ? 1 : 0);
}

void write_extreme_script(const std::filesystem::path& directory, const ExtremeMap& map) {
  const std::size_t panels = map.panels.values.size();
  const std::vector<std::string> integrators{ImplicitEuler::name, TrBdf2::name};
  std::ofstream out =
      script(directory, figure_of(map), 300 * static_cast<int>(std::max(panels, std::size_t(2))), 560);
  const double limit = std::log10(map.limit);
  out << "set palette defined (0 '#4c9f70', 1 '#f2d16b', 1.001 '#e07b39', 2 '#8c1c13')\n"
      << "set cbrange [" << limit - 6 << ':' << limit + 6 << "]\nunset key\n"
      << "set xlabel 'log_{10} " << map.columns.label << "'\nset ylabel 'log_{10} " << map.rows.label << "'\n"
      << "set xrange " << range_with_rims(map.columns) << "\nset yrange " << range_with_rims(map.rows) << '\n'
      << "set multiplot layout 2," << panels << " title 'log_{10} of " << map.measure << ";  red beyond "
      << text_of(map.limit) << "'\n";
  const std::size_t cells =
      map.rows.values.size() * map.columns.values.size();  // number of consecutive rows per panel
  std::size_t first_row = 1;
  for (const std::string& integrator : integrators)
    for (const double panel : map.panels.values) {
      out << "set title '" << integrator;
      if (panels > 1) out << ", " << map.panels.label << ' ' << panel;
      out << "' font 'sans,8'\n"
          << "plot '" << figure_of(map) << ".csv' skip " << first_row << " every ::0::" << cells - 1
          << " using (log10($4)):(log10($3)):(strlen(strcol(5)) ? ($5 > " << 1e-6 * map.limit
          << " ? log10($5) : " << limit - 6 << ") : " << limit + 6 << ") with image\n";
      first_row += cells;
    }
  out << "unset multiplot\n";
}

}  // namespace godobject::study
