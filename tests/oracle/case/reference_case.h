// Loader of the reference solutions: a folder with case.json, reference.csv and, where bodies are
// coupled, motion.csv. The format is described in the README beside those folders.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tests/oracle/case/case.h"
#include "tests/oracle/solve.h"
#include "tests/oracle/target.h"

namespace godobject::oracle {

struct ReferenceCase {
  std::string about;
  double duration = 0;  // s
  Case problem;
  Solution expected;  // reference.csv, bodies in the order of problem.bodies
};

/// Throws std::runtime_error for a missing or malformed file, and for a case with parts that the oracle
/// cannot solve (contact). A reference must not be compared with another problem.
ReferenceCase load_reference_case(const std::filesystem::path& folder);

/// Reads the states of these bodies from a file like reference.csv.
Solution load_solution(const std::filesystem::path& file, const std::vector<Body>& bodies);

/// The motion of one body from the columns t, <body>.x y z qw qx qy qz of a motion file.
std::shared_ptr<const Target> load_motion(const std::filesystem::path& file, const std::string& body);

}  // namespace godobject::oracle
