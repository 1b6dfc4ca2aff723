// Cost of joints: bytes of a composition, bytes of each component of a body, instructions of a step by kind
// of joint.
#pragma once

#include "tests/study/footprint_study.h"

namespace godobject::study {

/// A composition on a motion of the probe. Equal counts on both motions show that they are independent of the
/// data.
struct JointCostRow {
  std::string composition;
  std::string motion;  // "s3", "s5", "pair-hinge"
  std::size_t num_bodies = 0;
  std::size_t params_bytes = 0, state_bytes = 0, scratch_bytes = 0;
  std::optional<double> code_bytes, constant_bytes;  // per step
  std::optional<double> instructions;                // per step
  std::optional<double> instructions_slow;           // per step, on the slow motion
};

/// Bytes of a component in every body.
struct PartBytes {
  std::string part;
  std::size_t params = 0, state = 0, scratch = 0;
};

struct JointCosts {
  std::vector<JointCostRow> compositions;
  std::vector<JointCostRow> kinds;  // two bodies, by kind of joint; "pair-free" has no joint
  std::vector<PartBytes> parts;
};

/// Returns no rows, with the reason in `why_not`, if the probe program is not built. quick: without
/// instruction counts.
JointCosts study_joint_costs(const std::filesystem::path& probe_directory, bool quick,
                             InstructionCounter& counter, const Progress& progress, std::string& why_not);

void write_csv(const std::filesystem::path& file, const JointCosts& costs);

}  // namespace godobject::study
