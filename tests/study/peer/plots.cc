#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "tests/study/figure.h"
#include "tests/study/peer/study.h"

namespace godobject::study {
namespace {

/// Returns the colour of an engine's line; variants of one engine have shades of one colour.
std::string colour_of(const std::string& engine, std::size_t variant) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> colours{
      {"implicit-euler", {"purple", "orchid"}},
      {"tr-bdf2", {"forest-green"}},
      {"MuJoCo", {"#08519c", "#3182bd", "#000000", "#6baed6", "#9ecae1"}},
      {"Jolt", {"#a63603", "#e6550d", "#fd8d3c"}},
      {"Rapier", {"#8c1c13", "#c51b8a"}}};
  for (const auto& [name, shades] : colours)
    if (engine.starts_with(name)) return shades[std::min(variant, shades.size() - 1)];
  return "gray";
}

/// Returns the different values of a column, in their order.
std::vector<std::string> values_of(const std::vector<PeerError>& rows, std::string PeerError::*column) {
  std::vector<std::string> values;
  for (const PeerError& r : rows)
    if (std::ranges::find(values, r.*column) == values.end()) values.push_back(r.*column);
  return values;
}

std::string first_word(const std::string& text) { return text.substr(0, text.find_first_of(" ,")); }

}  // namespace

void write_peer_script(const std::filesystem::path& out, const PeerResults& results) {
  std::ofstream gp = script(out, "peers", 1080, 640);
  gp << "set logscale xy\nset format y '10^{%T}'\nset grid\nset xlabel 'step, ms'\nset xrange [0.1:5]\n"
     << "unset key\nset multiplot layout 2,4 columnsfirst\n";
  const std::array<std::pair<const char*, const char*>, 2> panels{
      {{"position_error_m", "worst position error, m"}, {"rotation_error_rad", "worst rotation error, rad"}}};
  const std::vector<std::string> engines = values_of(results.errors, &PeerError::engine);
  const auto plot_lines = [&](const std::string& scene, const char* column, bool in_key) {
    std::vector<std::string> names;
    const char* separator = "plot ";
    for (const std::string& engine : engines) {
      const std::string name = first_word(engine);
      const auto number = static_cast<std::size_t>(std::count(names.begin(), names.end(), name));
      names.push_back(name);
      const std::string style = " with linespoints pt 7 ps 0.5 lw " +
                                std::string(is_ours(engine) ? "2" : "1") + " lc rgb '" +
                                colour_of(engine, number) + "'";
      if (in_key) gp << separator << "NaN" << style << " title '" << engine << "'";
      else
        gp << separator << "'peers-error.csv' using (strcol('scene') eq '" << scene
           << "' && strcol('engine') eq '" << engine << "' ? column('step_s')*1e3 : NaN):(column('" << column
           << "'))" << style;
      separator = ", ";
    }
    gp << '\n';
  };
  for (const std::string& scene : values_of(results.errors, &PeerError::scene))
    for (const auto& [column, label] : panels) {
      gp << "set title '" << scene << "'\nset ylabel '" << label << "'\n";
      plot_lines(scene, column, false);
    }
  gp << "set key at screen 0.99,0.9 top right font 'sans,8' noenhanced\nunset title\nunset border\nunset "
        "tics\n"
     << "unset xlabel\nunset ylabel\nunset grid\nset yrange [1:2]\n";
  plot_lines("", "", true);
  gp << "unset multiplot\n";
}

}  // namespace godobject::study
