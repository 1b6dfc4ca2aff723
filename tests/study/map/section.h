// Section of docs/report.md about the stability map, its figure, and the extreme cases one by one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/study/map/sample.h"

namespace godobject::study {

/// The section stands between these lines of the report.
inline constexpr const char* map_begin = "<!-- begin of the stability map -->\n";
inline constexpr const char* map_end = "<!-- end of the stability map -->\n";

/// Samples of one family with one integrator.
struct MapSummary {
  std::string family, integrator;
  std::size_t drawn = 0, silent = 0, reported = 0, faults = 0, diverging = 0;
  double median = 0, worst = 0;  // gain of those without a fault
  std::uint64_t worst_sample = 0;
};

/// Summarises by family and integrator.
std::vector<MapSummary> summarise(const std::vector<MapSample>& samples);

/// Writes the section into the report, the figure stability-map.png beside it into figures/, and runs the
/// extreme cases. results: a file of all shards. steps_at_rest: see study_cases(). Throws std::runtime_error.
void write_map_section(const std::filesystem::path& results, const std::filesystem::path& report,
                       long steps_at_rest = 10'000'000);

}  // namespace godobject::study
