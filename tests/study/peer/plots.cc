#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

#include "tests/study/figure.h"
#include "tests/study/peer/study.h"

namespace godobject::study {
namespace {

/// Variants of one engine have shades of one colour.
struct Shades {
  std::string engine;  // begin of the names
  std::vector<std::string> colours;
};

/// Returns the shades of an engine; those of an engine with a longer name come first.
const Shades& shades_of(const std::string& engine) {
  static const std::vector<Shades> all{{"implicit-euler", {"purple", "orchid"}},
                                       {"tr-bdf2", {"forest-green"}},
                                       {"MuJoCo 2.2", {"#00838f", "#26c6da", "#80deea"}},
                                       {"MuJoCo", {"#08519c", "#3182bd", "#000000", "#6baed6", "#9ecae1"}},
                                       {"Bullet", {"#444444", "#777777", "#aaaaaa"}},
                                       {"ODE", {"#8a6508", "#daa520", "#e6d690"}},
                                       {"Simbody", {"#ad1457", "#f48fb1"}},
                                       {"Jolt", {"#a63603", "#e6550d", "#fd8d3c"}},
                                       {"Rapier", {"#8c1c13", "#c51b8a"}},
                                       {"", {"gray"}}};
  return *std::ranges::find_if(all, [&](const Shades& s) { return engine.starts_with(s.engine); });
}

/// Returns the different values of a column, in their order.
std::vector<std::string> values_of(const std::vector<PeerError>& rows, std::string PeerError::*column) {
  std::vector<std::string> values;
  for (const PeerError& r : rows)
    if (std::ranges::find(values, r.*column) == values.end()) values.push_back(r.*column);
  return values;
}

/// A row of the figure: an error over the step or over the compute time.
struct Panel {
  const char *x_column, *factor, *x_label, *x_range, *column, *label;
};

constexpr Panel panels[] = {
    {"step_s", "*1e3", "step, ms", "[0.1:5]", "position_error_m", "worst position error, m"},
    {"step_s", "*1e3", "step, ms", "[0.1:5]", "rotation_error_rad", "worst rotation error, rad"},
    {"native_ms_per_simulated_s", "", "native time of a simulated second, ms", "[*:*]", "position_error_m",
     "worst position error, m"},
    {"native_ms_per_simulated_s", "", "native time of a simulated second, ms", "[*:*]", "rotation_error_rad",
     "worst rotation error, rad"}};

}  // namespace

void write_peer_script(const std::filesystem::path& out, const PeerResults& results) {
  // gnuplot refuses a panel without a point
  const bool has_times =
      std::ranges::any_of(results.errors, [](const PeerError& r) { return !!r.native_us; });
  const std::size_t rows = has_times ? std::size(panels) : 2;
  std::ofstream gp = script(out, "peers", 1080, 300 * static_cast<int>(rows));
  gp << "set logscale xy\nset format y '10^{%T}'\nset grid\nunset key\nset multiplot layout " << rows
     << ",4 columnsfirst\n";
  const std::vector<std::string> engines = values_of(results.errors, &PeerError::engine);
  // panel: null for the key
  const auto plot_lines = [&](const std::string& scene, const Panel* panel) {
    std::vector<std::string> names;
    const char* separator = "plot ";
    for (const std::string& engine : engines) {
      const Shades& shades = shades_of(engine);
      const auto number = static_cast<std::size_t>(std::ranges::count(names, shades.engine));
      names.push_back(shades.engine);
      const std::string style = " with linespoints pt 7 ps 0.5 lw " +
                                std::string(is_ours(engine) ? "2" : "1") + " lc rgb '" +
                                shades.colours[std::min(number, shades.colours.size() - 1)] + "'";
      if (panel == nullptr) gp << separator << "NaN" << style << " title '" << engine << "'";
      else
        gp << separator << "'peers-error.csv' using (strcol('scene') eq '" << scene
           << "' && strcol('engine') eq '" << engine << "' ? column('" << panel->x_column << "')"
           << panel->factor << " : NaN):(column('" << panel->column << "'))" << style;
      separator = ", ";
    }
    gp << '\n';
  };
  for (const std::string& scene : values_of(results.errors, &PeerError::scene))
    for (const Panel& panel : std::span(panels).first(rows)) {
      gp << "set title '" << scene << "'\nset ylabel '" << panel.label << "'\nset xlabel '" << panel.x_label
         << "'\nset xrange " << panel.x_range << '\n';
      plot_lines(scene, &panel);
    }
  gp << "set lmargin at screen 0.8\nset rmargin at screen 0.99\nset tmargin at screen 0.99\nset bmargin at "
        "screen 0.01\nset key at screen 0.99,0.97 top right font 'sans,8' noenhanced\nunset "
        "title\nunset border\nunset "
        "tics\n"
     << "unset xlabel\nunset ylabel\nunset grid\nset xrange [1:2]\nset yrange [1:2]\n";
  plot_lines("", nullptr);
  gp << "unset multiplot\n";
}

}  // namespace godobject::study
