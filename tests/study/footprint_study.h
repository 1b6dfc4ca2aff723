// What a composition costs: bytes of data, bytes of code, instructions of a step.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/study/error_study.h"

namespace godobject::study {

struct FootprintRow {
  std::string composition;  // "haptic-1 tr-bdf2"
  std::size_t max_bodies = 0;
  std::size_t params_bytes = 0, state_bytes = 0, scratch_bytes = 0;
  std::optional<double> code_bytes;         // of the step: machine code
  std::optional<double> constant_bytes;     // of the step: read-only data
  std::optional<double> instructions;       // of a step with one body
  std::optional<double> instructions_full;  // of a step with max_bodies bodies
};

/// What a composition of the probe program is there to show: by its name.
enum class Family : std::uint8_t {
  rigid,
  articulated,  // "...-joints..."
  touching,     // "pressed...", "bricks...", with contacts and without
  net,          // "net-..."
};

/// Every composition of a family that the probe program has (the quick one has few), with its bytes. Empty, with the reason in `why_not`, where
/// it is not built.
std::vector<FootprintRow> list_compositions(const std::filesystem::path& probe_directory, bool quick,
                                            Family family, std::string& why_not);

/// Every rigid composition the probe program has. Empty, with the reason in `why_not`, where it is not built;
/// numbers whose tool is missing are absent. `quick`: only compositions with one body.
std::vector<FootprintRow> study_footprint(const std::filesystem::path& probe_directory, bool quick,
                                          InstructionCounter& counter, const Progress& progress,
                                          std::string& why_not);

const FootprintRow* find(const std::vector<FootprintRow>& rows, const std::string& composition);

void write_csv(const std::filesystem::path& file, const std::vector<FootprintRow>& rows);

}  // namespace godobject::study
