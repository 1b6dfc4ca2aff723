#include "tests/study/footprint_study.h"

#include <algorithm>
#include <sstream>

#include "tests/study/csv_writer.h"
#include "tests/study/tool.h"

namespace godobject::study {
namespace {

/// Parses "haptic-1 tr-bdf2,512,400,900" as printed by the probe.
bool parse(const std::string& line, FootprintRow& row) {
  std::istringstream fields(line);
  char comma = 0;
  if (!std::getline(fields, row.composition, ',')) return false;
  if (!(fields >> row.params_bytes >> comma >> row.state_bytes >> comma >> row.scratch_bytes)) return false;
  const std::size_t dash = row.composition.rfind('-', row.composition.find(' '));
  return static_cast<bool>(std::istringstream(row.composition.substr(dash + 1)) >> row.max_bodies);
}

Family family_of(const std::string& composition) {
  if (composition.starts_with("pressed") || composition.starts_with("bricks")) return Family::touching;
  if (composition.starts_with("net-")) return Family::net;
  return composition.find("joints") == std::string::npos ? Family::rigid : Family::articulated;
}

/// Adds up the sections of the composition's archive, which `size -A` prints as "name size address".
void measure_code(const std::filesystem::path& probe_directory, FootprintRow& row) {
  std::string name = row.composition;
  std::replace(name.begin(), name.end(), ' ', '-');
  const ToolResult size = run_tool({"size", "-A", (probe_directory / ("libprobe-" + name + ".a")).string()});
  if (!size.ok()) return;
  row.code_bytes = row.constant_bytes = 0;
  std::istringstream lines(size.output);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string section;
    double bytes = 0;
    if (!(words >> section >> bytes)) continue;
    if (section.starts_with(".text")) *row.code_bytes += bytes;
    if (section.starts_with(".rodata")) *row.constant_bytes += bytes;
  }
}

}  // namespace

std::vector<FootprintRow> list_compositions(const std::filesystem::path& probe_directory, bool quick,
                                            Family family, std::string& why_not) {
  std::vector<FootprintRow> rows;
  const std::filesystem::path program = probe_program(probe_directory, quick);
  const ToolResult list = run_tool({program.string()});
  if (!list.ok()) why_not = "the probe program is not built (target " + program.filename().string() + ")";
  std::istringstream lines(list.ok() ? list.output : "");
  for (std::string line; std::getline(lines, line);) {
    FootprintRow row;
    if (!parse(line, row) || family_of(row.composition) != family) continue;
    measure_code(probe_directory, row);
    rows.push_back(row);
  }
  return rows;
}

std::vector<FootprintRow> study_footprint(const std::filesystem::path& probe_directory, bool quick,
                                          InstructionCounter& counter, const Progress& progress,
                                          std::string& why_not) {
  std::vector<FootprintRow> rows = list_compositions(probe_directory, quick, Family::rigid, why_not);
  if (quick) std::erase_if(rows, [](const FootprintRow& r) { return r.max_bodies > 1; });
  for (FootprintRow& row : rows) {
    progress("footprint: " + row.composition);
    row.instructions = counter.per_step(row.composition);
    row.instructions_full = counter.per_step(row.composition, "s1-full");
  }
  return rows;
}

const FootprintRow* find(const std::vector<FootprintRow>& rows, const std::string& composition) {
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const FootprintRow& r) { return r.composition == composition; });
  return row == rows.end() ? nullptr : &*row;
}

void write_csv(const std::filesystem::path& file, const std::vector<FootprintRow>& rows) {
  CsvWriter csv(file,
                "composition,max_bodies,params_bytes,state_bytes,scratch_bytes,code_bytes,constant_bytes,"
                "instructions_one_body,instructions_all_bodies");
  for (const FootprintRow& r : rows)
    csv.row(r.composition, r.max_bodies, r.params_bytes, r.state_bytes, r.scratch_bytes, r.code_bytes,
            r.constant_bytes, r.instructions, r.instructions_full);
}

}  // namespace godobject::study
