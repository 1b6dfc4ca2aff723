// godobject-peers: the core beside other engines, native and in WASM, and that section of the report.
#include <cstdio>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>

#include "tests/study/figure.h"
#include "tests/study/peer/section.h"
#include "tests/study/peer/study.h"
#include "tests/study/tool.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

struct PeerArguments {
  bool quick = false;
  fs::path out, report;
};

/// is_complete: true if the figure belongs into the report.
void draw_peers(const PeerArguments& a, const PeerResults& results, bool is_complete) {
  write_peer_script(a.out, results);
  if (!tool_exists("gnuplot")) {
    std::fprintf(stderr, "note: no figure: gnuplot is not installed\n");
    return;
  }
  const std::string problem = draw(a.out, "peers");
  if (!problem.empty()) throw std::runtime_error(problem);
  if (!a.report.empty() && is_complete)
    fs::copy_file(a.out / "peers.png", a.report.parent_path() / "figures" / "peers.png",
                  fs::copy_options::overwrite_existing);
}

int run(const PeerArguments& a) {
  const PeerResults results =
      study_peers({.out = a.out, .packages = {}}, a.quick,
                  [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
  write_csv(a.out, results);
  std::printf("results in %s\n", a.out.c_str());
  if (!results.missing.empty())
    std::fprintf(stderr, "note: native engines are left out: %s\n", results.missing.c_str());
  const bool is_complete = results.why_not.empty();
  if (!is_complete)
    std::fprintf(stderr, "note: engines in WASM are left out, and the report's section stays: %s\n",
                 results.why_not.c_str());
  draw_peers(a, results, is_complete);
  if (a.report.empty() || !is_complete) return 0;
  replace_peers(a.report, results);
  std::printf("section in %s\n", a.report.c_str());
  return 0;
}

int main_of(int argc, char** argv) {
  PeerArguments arguments;
  CLI::App app("Compare the core with the engines of the build and those that npm has fetched.",
               "godobject-peers");
  app.add_flag("--quick", arguments.quick, "S1 alone, some seconds");
  app.add_option("--out", arguments.out, "folder for CSV files and the figure")->required();
  app.add_option("--report", arguments.report,
                 "report (Markdown) whose section between markers is rewritten");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return run(arguments);
}

}  // namespace
}  // namespace godobject::study

int main(int argc, char** argv) {
  try {
    return godobject::study::main_of(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "peers: %s\n", error.what());
    return 1;
  }
}
