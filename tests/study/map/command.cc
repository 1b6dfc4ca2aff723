#include "tests/study/map/command.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "tests/study/map/section.h"
#include "tests/study/map/shard.h"
#include "tests/study/verb.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

struct MapArguments {
  std::uint64_t seed = 1, samples = 16000, sample = 0;
  std::string shard = "1/1";
  bool replaces = false;
  std::vector<std::string> merge;
  std::string out, report;
};

/// Prints rows done and time to go to standard error, at most once in two seconds.
class ProgressLine {
 public:
  explicit ProgressLine(const std::string& shard) : shard_(shard) {}

  void operator()(std::uint64_t done, std::uint64_t rows) {
    const auto now = std::chrono::steady_clock::now();
    if (!started_) first_ = done, begin_ = now;
    const bool is_due = !started_ || done == rows || now - last_ > std::chrono::seconds(2);
    started_ = true;
    if (!is_due) return;
    last_ = now;
    const double seconds = std::chrono::duration<double>(now - begin_).count();
    const double rate = seconds > 0 ? static_cast<double>(done - first_) / seconds : 0;
    std::fprintf(stderr, "stability-map: shard %s: %llu of %llu samples", shard_.c_str(),
                 static_cast<unsigned long long>(done), static_cast<unsigned long long>(rows));
    if (rate > 0 && done < rows)
      std::fprintf(stderr, ", %.0f a second, %.0f s to go", rate, static_cast<double>(rows - done) / rate);
    std::fprintf(stderr, "\n");
  }

 private:
  std::string shard_;
  bool started_ = false;
  std::uint64_t first_ = 0;
  std::chrono::steady_clock::time_point begin_, last_;
};

void run_or_merge(const MapArguments& a) {
  if (a.merge.empty()) {
    const MapHead head{.seed = a.seed,
                       .samples = a.samples,
                       .shard = parse_shard(a.shard),
                       .fingerprint = map_fingerprint()};
    if (a.replaces && !begins_with(head, a.out)) fs::remove(a.out);
    run_shard(head, a.out, ProgressLine(a.shard));
  } else {
    merge_shards({a.merge.begin(), a.merge.end()}, a.out);
  }
  std::printf("results in %s\n", a.out.c_str());
}

int run(int argc, char** argv) {
  MapArguments a;
  CLI::App app("Draw scenes of eight families and record their energy gains with both integrators.",
               "stability-map");
  CLI::Option* const seed = app.add_option("--seed", a.seed, "seed of all scenes (1)");
  CLI::Option* const samples =
      app.add_option("--samples", a.samples, "number of samples of the whole run (16000)")
          ->check(CLI::Range(std::uint64_t(1), std::uint64_t(1) << 31));
  CLI::Option* const shard =
      app.add_option("--shard", a.shard, "part of the run, k/n (1/1); an interrupted file is continued");
  CLI::Option* const out = app.add_option("--out", a.out, "CSV file to write");
  app.add_flag("--replace", a.replaces, "replace a file of another run or program, which is refused without")
      ->needs(out);
  app.add_option("--merge", a.merge, "write the union of these shards instead of running")
      ->needs(out)
      ->excludes(seed)
      ->excludes(samples)
      ->excludes(shard);
  app.add_option("--report", a.report,
                 "report (Markdown) whose section of the map to write; needs all shards")
      ->needs(out);
  CLI::Option* const sample = app.add_option("--sample", a.sample, "print this sample alone")
                                  ->excludes(out)
                                  ->excludes(samples)
                                  ->excludes(shard);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (*sample) {
    std::printf("%s\n%s\n", map_columns().c_str(), row_of(map_sample(a.seed, a.sample)).c_str());
    return 0;
  }
  if (a.out.empty()) {
    std::fprintf(stderr, "stability-map: name the file to write with --out, or a sample with --sample\n");
    return 2;
  }
  if (!a.report.empty() && a.merge.empty() && a.shard != "1/1") {
    std::fprintf(stderr, "stability-map: --report needs all shards: give it with --merge\n");
    return 2;
  }
  run_or_merge(a);
  if (!a.report.empty()) write_map_section(a.out, a.report);
  return 0;
}

}  // namespace

int run_map_command(int argc, char** argv) { return run_verb("stability-map", argc, argv, run); }

}  // namespace godobject::study
