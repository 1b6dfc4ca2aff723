// What contacts and friction cost: bytes of a composition, instructions of a step.
#pragma once

#include "tests/study/footprint_study.h"

namespace godobject::study {

/// A composition on a motion of the probe.
struct ContactCostRow {
  FootprintRow size;
  std::string motion;                  // "s2", "s2-smooth" (without friction), "s4"
  std::optional<double> instructions;  // of a step, mean of 500
};

/// S2 and S4, each also with a composition that has no contacts. Empty, with the reason in `why_not`, where the probe
/// program is not built. `quick`: without instructions.
std::vector<ContactCostRow> study_contact_costs(const std::filesystem::path& probe_directory, bool quick,
                                                InstructionCounter& counter, const Progress& progress,
                                                std::string& why_not);

void write_csv(const std::filesystem::path& file, const std::vector<ContactCostRow>& rows);

}  // namespace godobject::study
