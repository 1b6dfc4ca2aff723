// Cost of contacts and friction: bytes of a composition, instructions of a step.
#pragma once

#include "tests/study/footprint_study.h"

namespace godobject::study {

/// A composition on a motion of the probe.
struct ContactCostRow {
  FootprintRow size;
  std::string motion;                  // "s2", "s2-smooth" (without friction), "s4"
  std::optional<double> instructions;  // per step, mean of 500
};

/// Measures S2 and S4, each also with a composition without contacts. Returns no rows, with the reason in
/// `why_not`, if the probe program is not built. quick: without instruction counts.
std::vector<ContactCostRow> study_contact_costs(const std::filesystem::path& probe_directory, bool quick,
                                                InstructionCounter& counter, const Progress& progress,
                                                std::string& why_not);

void write_csv(const std::filesystem::path& file, const std::vector<ContactCostRow>& rows);

}  // namespace godobject::study
