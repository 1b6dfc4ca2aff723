// godobject-study: error against run time, stability maps, footprint, and their report.
#include <cstdio>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>

#include "platform/rt/setup.h"
#include "tests/study/feel/command.h"
#include "tests/study/map/command.h"
#include "tests/study/study.h"
#include "tests/study/wall/command.h"

namespace godobject {
namespace {

struct StudyArguments {
  std::string part = "all";
  bool quick = false;
  std::string out, report;
};

/// Returns the command line with these arguments.
std::string command_of(const StudyArguments& a) {
  std::string command = "godobject-study " + a.part;
  if (a.quick) command += " --quick";
  command += " --out " + a.out;
  if (!a.report.empty()) command += " --report " + a.report;
  return command;
}

std::string machine_text() {
  const Machine machine = this_machine();
  return machine.cpu + " (" + std::to_string(machine.num_cpus) + " CPUs), Linux " + machine.kernel;
}

study::StudyOptions study_options(const StudyArguments& a) {
  study::StudyOptions options;
  options.error = a.part == "all" || a.part == "error";
  options.stability = a.part == "all" || a.part == "stability";
  options.footprint = a.part == "all" || a.part == "footprint";
  options.joints = a.part == "all" || a.part == "joints";
  options.contacts = a.part == "all" || a.part == "contacts";
  options.nets = a.part == "all" || a.part == "nets";
  options.quick = a.quick;
  options.out = a.out;
  options.report = a.report;
  options.machine = machine_text();
  options.command = command_of(a);
  return options;
}

int run_parts(const StudyArguments& a) {
  if (!a.report.empty() && a.part != "all") {
    std::fprintf(stderr, "--report needs the results of all parts: godobject-study all --report ...\n");
    return 2;
  }
  const study::StudyResults results = run_study(
      study_options(a), [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
  for (const std::string& note : results.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  std::printf("results in %s\n", a.out.c_str());
  if (!a.report.empty()) std::printf("report in %s\n", a.report.c_str());
  return 0;
}

int run(int argc, char** argv) {
  StudyArguments arguments;
  CLI::App app("Measure error against run time, stability, footprint, joints, contacts and nets.",
               "godobject-study");
  app.footer(
      "Drawn scenes over all parameters: godobject-study stability-map --help\n"
      "Impedance that a hand feels: godobject-study feel --help\n"
      "Stiffest passive walls: godobject-study z-width --help");
  app.add_option("PART", arguments.part,
                 "error, stability, footprint, joints, contacts, nets or all (default)")
      ->check(CLI::IsMember({"error", "stability", "footprint", "joints", "contacts", "nets", "all"}));
  app.add_flag("--quick", arguments.quick, "small grids, well under a minute");
  app.add_option("--out", arguments.out, "folder for CSV files and figures")->required();
  app.add_option("--report", arguments.report, "report (Markdown) to write; figures go beside it");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return run_parts(arguments);
}

}  // namespace
}  // namespace godobject

int main(int argc, char** argv) {
  try {
    if (argc > 1 && std::string(argv[1]) == "feel") return godobject::study::run_feel_command(argc, argv);
    if (argc > 1 && std::string(argv[1]) == "z-width") return godobject::study::run_wall_command(argc, argv);
    if (argc > 1 && std::string(argv[1]) == "stability-map")
      return godobject::study::run_map_command(argc, argv);
    return godobject::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "study: %s\n", error.what());
    return 1;
  }
}
