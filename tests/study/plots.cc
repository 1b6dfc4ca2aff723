#include "tests/study/plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace godobject::study {
namespace {

bool is_free(const std::vector<ErrorRow>& rows, const std::string& scene) {
  return std::any_of(rows.begin(), rows.end(),
                     [&](const ErrorRow& r) { return r.scene == scene && r.errors.energy.has_value(); });
}

/// Writes one panel: column `error` against compute time, one line per integrator.
void error_panel(std::ofstream& out, const std::string& scene, const std::string& error,
                 const std::string& label) {
  out << "set title '" << scene << "'\nset ylabel '" << label << "'\nplot";
  const char* separator = " ";
  for (const auto& [integrator, colour] :
       {std::pair{ImplicitEuler::name, "purple"}, {TrBdf2::name, "forest-green"}}) {
    out << separator << "'error.csv' using (strcol('scene') eq '" << scene << "' && strcol('integrator') eq '"
        << integrator << "' ? column('ns_per_simulated_s')*1e-3 : NaN):(column('" << error
        << "')) with linespoints pt 7 ps 0.6 lc rgb '" << colour << "'";
    separator = ", ";
  }
  out << '\n';
}

}  // namespace

void write_error_script(const std::filesystem::path& directory, const std::vector<ErrorRow>& rows) {
  std::vector<std::string> scenes;
  for (const ErrorRow& r : rows)
    if (scenes.empty() || scenes.back() != r.scene) scenes.push_back(r.scene);
  std::ofstream out = script(directory, "error", 270 * static_cast<int>(scenes.size()), 560);
  out << "set logscale xy\nset format y '10^{%T}'\nset grid\nunset key\n"
      << "set xlabel 'compute per simulated second, us'\n"
      << "set multiplot layout 2," << scenes.size() << " columnsfirst title 'purple: " << ImplicitEuler::name
      << ", green: " << TrBdf2::name << "'\n";
  for (const std::string& scene : scenes) {
    if (is_free(rows, scene)) error_panel(out, scene, "energy_error", "worst energy error, share");
    else error_panel(out, scene, "position_error_m", "worst position error, m");
    error_panel(out, scene, "rotation_error_rad", "worst rotation error, rad");
  }
  out << "unset multiplot\n";
}

void write_stability_script(const std::filesystem::path& directory, std::size_t scheme_index,
                            const StabilityGrid& grid) {
  const std::string scheme = stability_schemes[scheme_index];
  const std::string figure = "stability-" + scheme;
  std::ofstream out = script(directory, figure, 240 * static_cast<int>(grid.dampings.size()),
                             210 * static_cast<int>(grid.inertia_ratios.size()) + 20);
  out << "set palette maxcolors 4 defined (0 '#4c9f70', 1 '#f2d16b', 2 '#e07b39', 3 '#8c1c13')\n"
      << "set cbrange [-0.5:3.5]\nunset colorbox\nunset key\n"
      << "set xlabel 'log_{10} step, s' offset 0,0.5\nset ylabel 'log_{10} stiffness, N/m' offset 1,0\n"
      << "set xtics 1\nset ytics 3\n"
      << "set xrange [" << std::log10(grid.steps.front()) << ':' << std::log10(grid.steps.back()) << "]\n"
      << "set yrange [" << std::log10(grid.stiffnesses.front()) << ':' << std::log10(grid.stiffnesses.back())
      << "]\n"
      << "set multiplot layout " << grid.inertia_ratios.size() << ',' << grid.dampings.size() << " title '"
      << scheme
      << ":  green stable, yellow dissipative, orange energy-gaining, red failed;  line: limit of an "
         "explicitly integrated coupling'\n";
  // number of consecutive rows of the file per panel
  const std::size_t cells = grid.stiffnesses.size() * grid.steps.size();
  const std::size_t panels = grid.dampings.size() * grid.inertia_ratios.size();
  for (std::size_t j = 0; j < grid.inertia_ratios.size(); ++j)
    for (std::size_t i = 0; i < grid.dampings.size(); ++i) {
      const std::size_t first_row = 1 + cells * (scheme_index * panels + i * grid.inertia_ratios.size() + j);
      // The line is h sqrt(k/m) = limit, m = 0.1 kg:  log k = log m + 2 (log limit - log h).
      out << "set title 'damping " << grid.dampings[i] << ", inertia " << grid.inertia_ratios[j]
          << "' offset 0,-0.7\n"
          << "plot 'stability.csv' skip " << first_row << " every ::0::" << cells - 1
          << " using (log10($3)):(log10($2)):8 with image, -1 + 2*(log10("
          << explicit_limit(grid.dampings[i], grid.inertia_ratios[j])
          << ") - x) with lines lc 'black' lw 1.5\n";
    }
  out << "unset multiplot\n";
}

void write_drift_script(const std::filesystem::path& directory) {
  std::ofstream out = script(directory, "joint-drift", 960, 380);
  out << "set logscale xy\nset format y '10^{%T}'\nset grid\nset linetype 4 lc rgb '#8c1c13'\n"
      << "set linetype 5 lc rgb 'forest-green'\nset linetype 2 lc rgb 'orange'\nunset key\n"
      << "set xlabel 'step, ms'\nset multiplot layout 1,3 title 'S3: worst of 2 s'\n";
  const std::array<std::pair<const char*, const char*>, 3> panels{
      {{"drift_m", "joint drift, m"},
       {"drift_rad", "joint drift, rad"},
       {"position_error_m", "position error, m"}}};
  for (const auto& panel : panels) {
    const auto& [column, label] = panel;
    if (&panel == &panels.back()) out << "set key bottom right font 'sans,7'\nset yrange [1e-12:*]\n";
    out << "set title '" << label << "'\nplot";
    const char* separator = " ";
    for (const std::string& scheme : joint_schemes()) {
      out << separator << "'joint-drift.csv' using (strcol('scheme') eq '" << scheme
          << "' ? column('step_s')*1e3 : NaN):(column('" << column
          << "')) with linespoints pt 7 ps 0.6 title '" << scheme << "'";
      separator = ", ";
    }
    out << '\n';
  }
  out << "unset multiplot\n";
}

void write_joint_stability_script(const std::filesystem::path& directory, const JointGrid& grid) {
  const std::vector<std::string> schemes = joint_schemes();
  std::ofstream out = script(directory, "joint-stability", 240 * static_cast<int>(schemes.size()) + 60, 300);
  out << "set palette defined (0 '#4c9f70', 0.5 '#f2d16b', 1 '#e07b39')\nset cbrange [-13:-2]\nunset key\n"
      << "set xlabel 'log_{10} step, s'\nset ylabel 'log_{10} stiffness, N/m'\nset xtics 1\nset ytics 2\n"
      << "set xrange [" << std::log10(grid.steps.front()) << ':' << std::log10(grid.steps.back()) << "]\n"
      << "set yrange [" << std::log10(grid.stiffnesses.front()) << ':' << std::log10(grid.stiffnesses.back())
      << "]\nset object rectangle from graph 0,0 to graph 1,1 behind fillcolor '#8c1c13' fillstyle solid\n"
      << "set multiplot layout 1," << schemes.size()
      << " title 'S3: log_{10} of the worst joint drift in 1000 steps, m;  dark red: failed'\n";
  // number of consecutive rows per scheme
  const std::size_t cells = grid.stiffnesses.size() * grid.steps.size();
  for (std::size_t i = 0; i < schemes.size(); ++i)
    out << "set title '" << schemes[i] << "' font 'sans,8'\n"
        << "plot 'joint-stability.csv' skip " << 1 + i * cells << " every ::0::" << cells - 1
        << " using (log10($3)):(log10($2)):($4 > 0 ? NaN : log10($6)) with image\n";
  out << "unset multiplot\n";
}

void write_footprint_script(const std::filesystem::path& directory, const std::vector<FootprintRow>& rows) {
  // Compositions for one body; in a full run every second row is for eight.
  const bool has_large =
      std::any_of(rows.begin(), rows.end(), [](const FootprintRow& r) { return r.max_bodies > 1; });
  const std::string from = std::string("'footprint.csv' skip 1 every ") + (has_large ? "2" : "1");
  std::ofstream out = script(directory, "footprint", 960, 420);
  out << "set style data histogram\nset style histogram rowstacked\nset style fill solid 0.8 border\n"
      << "set boxwidth 0.8\nset grid y\nset key top left\nset yrange [0:*]\nset offsets 0,0,graph 0.2,0\n"
      << "set xtics rotate by 60 right noenhanced font 'sans,7'\nset bmargin 10\n"
      << "set multiplot layout 1,3\n"
      << "set title 'data, bytes'\n"
      << "plot " << from << " using 3:xtic(1) title 'params', " << from << " using 4 title 'state', " << from
      << " using 5 title 'scratch'\n"
      << "set title 'code of the step, bytes'\n"
      << "plot " << from << " using 6:xtic(1) title 'machine code', " << from
      << " using 7 title 'constants'\n"
      << "set title 'instructions of a step'\n"
      << "plot " << from << " using 8:xtic(1) notitle\n"
      << "unset multiplot\n";
}

}  // namespace godobject::study
