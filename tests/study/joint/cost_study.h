// What joints cost: bytes of a composition, bytes of each part of a body, instructions of a step by kind of joint.
#pragma once

#include "tests/study/footprint_study.h"

namespace godobject::study {

/// A composition on a motion of the probe. Equal counts on both: the data do not matter.
struct JointCostRow {
  std::string composition;
  std::string motion;  // "s3", "s5", "pair-hinge"
  std::size_t num_bodies = 0;
  std::size_t params_bytes = 0, state_bytes = 0, scratch_bytes = 0;
  std::optional<double> code_bytes, constant_bytes;  // of the step
  std::optional<double> instructions;                // of a step
  std::optional<double> instructions_slow;           // on the slow motion
};

/// Bytes of a part in every body.
struct PartBytes {
  std::string part;
  std::size_t params = 0, state = 0, scratch = 0;
};

struct JointCosts {
  std::vector<JointCostRow> compositions;
  std::vector<JointCostRow> kinds;  // two bodies, by kind of joint; "pair-free" has none
  std::vector<PartBytes> parts;
};

/// Rows are empty, with the reason in `why_not`, where the probe program is not built. `quick`: without instructions.
JointCosts study_joint_costs(const std::filesystem::path& probe_directory, bool quick,
                             InstructionCounter& counter, const Progress& progress, std::string& why_not);

void write_csv(const std::filesystem::path& file, const JointCosts& costs);

}  // namespace godobject::study
