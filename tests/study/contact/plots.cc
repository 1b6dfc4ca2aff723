#include "tests/study/contact/plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "platform/scene/scene.h"
#include "tests/study/plots.h"

namespace godobject::study {
namespace {

using Lines = std::array<std::pair<const char*, const char*>, 2>;  // name of a line, and its colour

/// Plots y against x, one line per name: the rows whose column `key` is that name.
void plot_lines(std::ofstream& out, const std::string& file, const std::string& key, const std::string& where,
                const std::string& x, const std::string& y, const Lines& lines, const char* style) {
  out << "plot";
  const char* separator = " ";
  for (const auto& [name, colour] : lines) {
    out << separator << '\'' << file << "' using (strcol('" << key << "') eq '" << name << "'" << where
        << " ? " << x << " : NaN):(" << y << ") with " << style << " lc rgb '" << colour << "' title '"
        << name << '\'';
    separator = ", ";
  }
  out << '\n';
}

constexpr Lines integrator_lines{{{ImplicitEuler::name, "purple"}, {TrBdf2::name, "forest-green"}}};

}  // namespace

void write_contact_error_script(const std::filesystem::path& directory,
                                const std::vector<ContactErrorRow>& rows) {
  std::vector<std::string> scenes;
  for (const ContactErrorRow& r : rows)
    if (std::ranges::find(scenes, r.scene) == scenes.end()) scenes.push_back(r.scene);
  std::ofstream out = script(directory, "contact-error", 960, 280 * static_cast<int>(scenes.size()));
  out << "set logscale xy\nset format xy '10^{%T}'\nset grid\nset key top right font 'sans,7'\n"
      << "set xlabel 'compute per simulated second, us'\nset multiplot layout " << scenes.size() << ",3\n";
  for (const std::string& scene : scenes)
    for (const auto& [y, label] : {std::pair{"column('position_error_m')", "worst position error, m"},
                                   {"column('penetration_error_m')", "worst error of penetration, m"},
                                   {"column('energy_error_J')", "worst error of energy, J"}}) {
      out << "set title '" << scene << "'\nset ylabel '" << label << "'\n";
      plot_lines(out, "contact-error.csv", "integrator", " && strcol('scene') eq '" + scene + "'",
                 "column('ns_per_simulated_s')*1e-3", y, integrator_lines, "linespoints pt 7 ps 0.6");
    }
  out << "unset multiplot\n";
}

void write_contact_stability_script(const std::filesystem::path& directory, const ContactGrid& grid) {
  const std::size_t panels = grid.dampings.size();
  std::ofstream out = script(directory, "contact-stability", 220 * static_cast<int>(panels) + 60, 520);
  out << "set palette defined (0 '#4c9f70', 0.5 '#f2d16b', 1 '#e07b39')\nset cbrange [-12:0]\nunset key\n"
      << "set xlabel 'log_{10} step, s'\nset ylabel 'log_{10} stiffness, N/m'\nset xtics 0.5\nset ytics 2\n"
      << "set xrange [" << std::log10(grid.steps.front()) << ':' << std::log10(grid.steps.back()) << "]\n"
      << "set yrange [" << std::log10(grid.stiffnesses.front()) << ':' << std::log10(grid.stiffnesses.back())
      << "]\nset object rectangle from graph 0,0 to graph 1,1 behind fillcolor '#8c1c13' fillstyle solid\n"
      << "set multiplot layout 2," << panels
      << " title 'contacts: log_{10} of the largest energy gain, J; green: 10^{-12} J or less, dark red: "
         "failed'\n";
  // number of consecutive rows per panel
  const std::size_t cells = grid.stiffnesses.size() * grid.steps.size();
  std::size_t first_row = 1;
  for (const char* integrator : {ImplicitEuler::name, TrBdf2::name})
    for (const double damping : grid.dampings) {
      out << (damping == grid.dampings.back() ? "set" : "unset") << " colorbox\n"
          << "set title '" << integrator << ", damping " << damping << " of critical' font 'sans,8'\n"
          << "plot 'contact-stability.csv' skip " << first_row << " every ::0::" << cells - 1
          << " using (log10($4)):(log10($2)):($5 > 0 ? NaN : log10($6 > 1e-12 ? $6 : 1e-12)) with image\n";
      first_row += cells;
    }
  out << "unset multiplot\n";
}

void write_contact_imposed_script(const std::filesystem::path& directory) {
  const Lines lines{{{coupling_names[0], "forest-green"}, {coupling_names[1], "#8c1c13"}}};
  std::ofstream out = script(directory, "contact-imposed", 960, 560);
  out << "set grid\nset key top left font 'sans,8' opaque\nset xlabel 't, s'\n"
      << "set multiplot layout 2,2 title 'lego: the held brick as a god-object, and placed where the device "
         "is; "
         "peaks of every 10 ms'\n"
      << "set logscale y\nset format y '10^{%T}'\nset yrange [1e-7:1e-3]\nset ylabel 'deepest contact, m'\n";
  const auto plot = [&](const char* y) {
    plot_lines(out, "contact-imposed.csv", "coupling", "", "column('t_s')", y, lines, "lines");
    out << "unset key\n";
  };
  plot("column('overlap_m')");
  out << "set yrange [1e-3:1e2]\nset ylabel 'force on the held brick, N'\n";
  plot("column('force_N')");
  out << "unset logscale y\nset format y '%g'\nset yrange [*:*]\nset ylabel 'energy given to the others, "
         "mJ'\n";
  plot("column('energy_J')*1e3");
  out << "set yrange [0:1<*]\nset ylabel 'bricks ejected'\n";
  plot("column('ejected')");
  out << "unset multiplot\n";
}

}  // namespace godobject::study
