#include "tests/study/feel/command.h"

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "tests/study/csv_writer.h"
#include "tests/study/feel/feel.h"
#include "tests/study/feel/table.h"
#include "tests/study/figure.h"
#include "tests/study/page.h"
#include "tests/study/verb.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

void write_rows(const fs::path& directory, const std::vector<FeelSweep>& sweeps) {
  CsvWriter csv(directory / "feel.csv",
                "plan,integrator,damping_ratio,pressed,f_hz,mass_kg,damping_ns_per_m,stiffness_n_per_m,"
                "law_mass_kg,law_damping_ns_per_m,law_stiffness_n_per_m,hand_mass_kg,hand_damping_ns_per_m,"
                "hand_stiffness_n_per_m,sine_n,ripple_n");
  for (const auto& [c, all] : sweeps)
    for (const Felt& felt : all) {
      const Impedance &shown = felt.displayed, &hand = felt.hand, law = feel_by_law(c, shown.f_Hz);
      csv.row(c.plan.name, c.integrator, c.damping_ratio, int{c.is_pressed}, shown.f_Hz, shown.mass(),
              shown.damping(), shown.stiffness(), law.mass(), law.damping(), law.stiffness(), hand.mass(),
              hand.damping(), hand.stiffness(), felt.sine_N, felt.ripple_N);
    }
}

void write_script(const fs::path& directory) {
  std::ofstream out = script(directory, "feel", 960, 720);
  const auto panel = [&](const std::string& title, const std::string& column, const char* factor,
                         int pressed) {
    out << "set title '" << title << "'\nplot";
    const char* separator = " ";
    for (const FeelPlan& plan : feel_plans()) {
      if (!plan.has_buses && column.starts_with("hand")) continue;  // without a device
      out << separator << "'feel.csv' using (strcol('plan') eq '" << plan.name
          << "' && strcol('integrator') eq 'tr-bdf2' && column('damping_ratio') == 1.4 && column('pressed') "
             "== "
          << pressed << " ? column('f_hz') : NaN):(" << factor << "*column('" << column
          << "')) with linespoints pt 7 ps 0.4 title '" << plan.name << "'";
      separator = ", ";
    }
    out << '\n';
  };
  out << "set logscale x\nset grid\nset xlabel 'frequency, Hz'\nset key bottom left\n"
      << "set multiplot layout 2,2\n";
  panel("free: displayed mass, g", "mass_kg", "1e3", 0);
  panel("free: mass at the hand, g", "hand_mass_kg", "1e3", 0);
  panel("pressed: stiffness, N/m", "stiffness_n_per_m", "1", 1);
  panel("pressed: damping, N s/m", "damping_ns_per_m", "1", 1);
  out << "unset multiplot\n";
}

int run(int argc, char** argv) {
  std::string out, page;
  int per_decade = 4;
  CLI::App app(
      "Measure the impedance that a hand feels, free and pressed, through simulated encoder, bus and drive.",
      "godobject-study feel");
  app.add_option("--out", out, "folder for feel.csv and its figure");
  app.add_option("--per-decade", per_decade, "frequencies in each decade from 0.1 to 100 Hz (4)")
      ->check(CLI::Range(1, 20));
  app.add_option("--page", page, "page (Markdown) in which the tables between its feel marks are replaced");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const std::vector<FeelSweep> sweeps = sweep_feel(per_decade);
  const std::string text = feel_tables(sweeps);
  std::fputs(text.c_str(), stdout);
  if (!page.empty()) replace_marked(page, "feel", text);
  if (out.empty()) return 0;
  fs::create_directories(out);
  write_rows(out, sweeps);
  write_script(out);
  const std::string error = draw(out, "feel");
  if (!error.empty()) std::fprintf(stderr, "feel: %s\n", error.c_str());
  std::printf("results in %s\n", out.c_str());
  return 0;
}

}  // namespace

int run_feel_command(int argc, char** argv) { return run_verb("feel", argc, argv, run); }

}  // namespace godobject::study
