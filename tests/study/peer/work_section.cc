// Work-precision in the report and in a result file.
#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "tests/study/csv_writer.h"
#include "tests/study/peer/work_precision.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

using Kind = Reading::Kind;

struct Column {
  const char *name, *about;
  std::optional<BestPeer> WorkComparison::*best;
};

constexpr std::array<Column, 4> columns{
    {{"error_in_our_time", "its error in our time", &WorkComparison::error_in_our_time},
     {"error_in_its_time", "its error, ours in its time", &WorkComparison::error_in_its_time},
     {"time_to_our_error", "its time to our error", &WorkComparison::time_to_our_error},
     {"time_to_its_error", "its time, ours to its error", &WorkComparison::time_to_its_error}}};

/// Returns the ratio; "open" for a lower bound that leaves open which is better.
std::string ratio_text(const Reading& ratio) {
  if (ratio.kind == Kind::at_least && ratio.value < 1) return "open";
  const char* const bound = ratio.kind == Kind::at_most ? "< " : ratio.kind == Kind::at_least ? "> " : "";
  return bound + number(ratio.value, 2);
}

/// Returns the comparisons by position; those by rotation are in the result file.
std::vector<WorkComparison> reported(const PeerResults& results) {
  std::vector<WorkComparison> all = compare_work(results);
  std::erase_if(all, [](const WorkComparison& c) { return std::string_view(c.quantity) != "position"; });
  return all;
}

}  // namespace

std::string peers_better_in_equal_time(const PeerResults& results) {
  std::string text;
  for (const WorkComparison& c : reported(results))
    for (const Column& column : columns) {
      const std::optional<BestPeer>& best = c.*column.best;
      if (!best || best->ratio.kind == Kind::at_least || !(best->ratio.value < noticeable)) continue;
      text += (text.empty() ? "" : "; ") + c.scene + " than " + c.integrator + " (" + best->engine + ", " +
              column.about + ": " + ratio_text(best->ratio) + " times ours)";
    }
  return text;
}

void write_work(std::ostream& out, const PeerResults& results) {
  const std::vector<WorkComparison> all = reported(results);
  if (all.empty()) return;
  out << "\nWork and precision of the position: the best native peer over ours, above 1 where ours is "
         "better. Columns: "
         "errors in equal "
         "time, at the time of our step of 1 ms and of its; times to an equal error, that of our step of 1 "
         "ms and of "
         "its. A curve that ends before is a bound:\n\n| scene | ours |";
  for (const Column& column : columns) out << ' ' << column.about << " |";
  out << "\n|---|---|---|---|---|---|\n";
  for (const WorkComparison& c : all) {
    out << "| " << c.scene << " | " << c.integrator << " |";
    for (const Column& column : columns) {
      const std::optional<BestPeer>& best = c.*column.best;
      out << ' ' << (best ? ratio_text(best->ratio) + " (" + best->engine + ")" : "none so fast") << " |";
    }
    out << '\n';
  }
}

void write_work_csv(const std::filesystem::path& file, const PeerResults& results) {
  CsvWriter csv(file, "scene,quantity,integrator,measure,best_native_peer,bound,peer_over_ours");
  for (const WorkComparison& c : compare_work(results))
    for (const Column& column : columns) {
      const std::optional<BestPeer>& best = c.*column.best;
      if (!best) continue;
      const Kind kind = best->ratio.kind;
      csv.row(c.scene, c.quantity, c.integrator, column.name, best->engine,
              kind == Kind::at_most    ? "at most"
              : kind == Kind::at_least ? "at least"
                                       : "exact",
              best->ratio.value);
    }
}

}  // namespace godobject::study
