#include "tests/study/wall/command.h"

#include <array>
#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include "tests/study/page.h"
#include "tests/study/verb.h"
#include "tests/support/z_width.h"

namespace godobject::study {
namespace {

/// Returns kN/m, to two digits.
std::string kilo(double N_per_m) {
  std::array<char, 32> digits{};
  const char* const format = N_per_m < 1e5 ? "%.2g" : "%.0f";
  std::snprintf(digits.data(), digits.size(), format, 1e-3 * N_per_m);
  return digits.data();
}

/// Returns the stiffest wall found, "0" if none is passive, and "any" at the end of the grid.
std::string found(double N_per_m) { return N_per_m < z_width_end_N_per_m ? kilo(N_per_m) : "any"; }

std::string row_text(const ZWidthPlace& place) {
  std::array<char, 96> head{};
  std::snprintf(head.data(), head.size(), "|%g|%d|%g|%g|", place.damping, place.delay, 1e6 * place.count,
                1e-3 / place.period_s);
  const ZWidthRow row = z_width_row(place);
  std::string text = std::string(head.data()) + kilo(place.colgate()) + "|" + found(row.controlled) + "|";
  for (const double stiffness : row.laws) text += found(stiffness) + "|";
  return text + "\n";
}

/// Returns the map as a table of Markdown.
std::string table() {
  std::string head = "| b, N s/m | d | count, um | rate, kHz | b / (T/2 + t_d) | spring, controlled |";
  std::string rule = "|---|---|---|---|---|---|";
  for (const auto& [name, law] : wall_laws()) {
    head += " " + name + " |";
    rule += "---|";
  }
  std::string text = head + "\n" + rule + "\n";
  for (const ZWidthPlace& place : z_width_places()) text += row_text(place);
  return text;
}

int run(int argc, char** argv) {
  std::string page;
  CLI::App app("Print the stiffest wall, kN/m, that stays passive, over damping, delay, counts and rate.",
               "godobject-study z-width");
  app.add_option("--page", page, "page (Markdown) in which the table between its z-width marks is replaced");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const std::string text = table();
  std::fputs(text.c_str(), stdout);
  if (!page.empty()) replace_marked(page, "z-width", text);
  return 0;
}

}  // namespace

int run_wall_command(int argc, char** argv) { return run_verb("z-width", argc, argv, run); }

}  // namespace godobject::study
