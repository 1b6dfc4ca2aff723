#include "tests/study/feel/command.h"

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "tests/study/csv_writer.h"
#include "tests/study/feel/feel.h"
#include "tests/study/figure.h"
#include "tests/study/verb.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> integrators{"implicit-euler", "tr-bdf2"};
const std::vector<double> damping_ratios{1, 1.4, 2};

/// Prints the row of a case: apparent mass of free motion, and the displayed spring while pressed.
void print_case(FeelCase c) {
  const Felt slow = measure_feel(c, 1), quick = measure_feel(c, 10);
  const double drag_N = drag_of(c);
  c.is_pressed = true;
  const Felt pressed = measure_feel(c, 1);
  std::printf("%-18s %-15s %13.1f %10.1f %10.1f %10.1f %12.1f %12.2f\n", c.plan.name.c_str(),
              c.integrator.c_str(), c.damping_ratio, 1e3 * slow.mass(), 1e3 * quick.mass(), 1e3 * drag_N,
              pressed.stiffness(), pressed.damping());
}

void write_rows(const fs::path& directory, int per_decade) {
  CsvWriter csv(directory / "feel.csv",
                "plan,integrator,damping_ratio,pressed,f_hz,mass_kg,damping_ns_per_m,stiffness_n_per_m,"
                "law_mass_kg,law_damping_ns_per_m,law_stiffness_n_per_m");
  for (const FeelPlan& plan : feel_plans())
    for (const std::string& integrator : integrators)
      for (const double damping_ratio : damping_ratios)
        for (const bool is_pressed : {false, true}) {
          const FeelCase c{.plan = plan,
                           .integrator = integrator,
                           .damping_ratio = damping_ratio,
                           .is_pressed = is_pressed};
          for (const double f_Hz : feel_frequencies(per_decade)) {
            const Felt felt = measure_feel(c, f_Hz), law = feel_by_law(c, f_Hz);
            csv.row(plan.name, integrator, damping_ratio, int{is_pressed}, f_Hz, felt.mass(), felt.damping(),
                    felt.stiffness(), law.mass(), law.damping(), law.stiffness());
          }
        }
}

void write_script(const fs::path& directory) {
  std::ofstream out = script(directory, "feel", 960, 380);
  const auto panel = [&](const char* title, const char* column, const char* factor, int pressed) {
    out << "set title '" << title << "'\nplot";
    const char* separator = " ";
    for (const FeelPlan& plan : feel_plans()) {
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
      << "set multiplot layout 1,3\n";
  panel("free: apparent mass, g", "mass_kg", "1e3", 0);
  panel("pressed: stiffness, N/m", "stiffness_n_per_m", "1", 1);
  panel("pressed: damping, N s/m", "damping_ns_per_m", "1", 1);
  out << "unset multiplot\n";
}

int run(int argc, char** argv) {
  std::string out;
  int per_decade = 4;
  CLI::App app(
      "Measure the impedance that a hand feels, free and pressed, through simulated encoder, bus and drive.",
      "godobject-study feel");
  app.add_option("--out", out, "folder for feel.csv and its figure");
  app.add_option("--per-decade", per_decade, "frequencies in each decade from 0.1 to 100 Hz (4)")
      ->check(CLI::Range(1, 20));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::printf("from motion to force:\n");
  for (const FeelPlan& plan : feel_plans())
    std::printf("  %-18s %6.2f ms\n", plan.name.c_str(), 1e3 * delay_of(plan));
  std::printf("%-18s %-15s %13s %10s %10s %10s %12s %12s\n", "plan", "integrator", "damping ratio",
              "g at 1 Hz", "g at 10 Hz", "drag, mN", "pressed, N/m", "and N s/m");
  for (const FeelPlan& plan : feel_plans())
    for (const std::string& integrator : integrators)
      for (const double damping_ratio : damping_ratios)
        print_case({.plan = plan, .integrator = integrator, .damping_ratio = damping_ratio});
  if (out.empty()) return 0;
  fs::create_directories(out);
  write_rows(out, per_decade);
  write_script(out);
  const std::string error = draw(out, "feel");
  if (!error.empty()) std::fprintf(stderr, "feel: %s\n", error.c_str());
  std::printf("results in %s\n", out.c_str());
  return 0;
}

}  // namespace

int run_feel_command(int argc, char** argv) { return run_verb("feel", argc, argv, run); }

}  // namespace godobject::study
