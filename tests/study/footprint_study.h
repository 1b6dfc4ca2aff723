// Cost of a composition: bytes of data, bytes of code, instructions of a step.
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
  std::optional<double> code_bytes;         // machine code of the step
  std::optional<double> constant_bytes;     // read-only data of the step
  std::optional<double> instructions;       // per step with one body
  std::optional<double> instructions_full;  // per step with max_bodies bodies
};

/// Family of a composition of the probe program, by its name.
enum class Family : std::uint8_t {
  rigid,
  articulated,  // "...-joints..."
  touching,     // "pressed...", "bricks...", with and without contacts
  net,          // "net-..."
};

/// Returns every composition of a family in the probe program (the quick one has few), with its bytes.
/// Returns no rows, with the reason in `why_not`, if the program is not built.
std::vector<FootprintRow> list_compositions(const std::filesystem::path& probe_directory, bool quick,
                                            Family family, std::string& why_not);

/// Measures every rigid composition of the probe program. Returns no rows, with the reason in `why_not`, if
/// the program is not built. Numbers whose tool is missing are absent. quick: only compositions with one
/// body.
std::vector<FootprintRow> study_footprint(const std::filesystem::path& probe_directory, bool quick,
                                          InstructionCounter& counter, const Progress& progress,
                                          std::string& why_not);

const FootprintRow* find(const std::vector<FootprintRow>& rows, const std::string& composition);

void write_csv(const std::filesystem::path& file, const std::vector<FootprintRow>& rows);

}  // namespace godobject::study
