// What `godobject run` was asked for, and what becomes of it: a session that is ready to boot, or every
// complaint with its place. Nothing is written here.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/session.h"

namespace godobject {

struct RunOptions {
  std::string scene;  // path
  bool realtime = false;
  BusChoice bus = BusChoice::sim;
  std::optional<double> duration;  // s
  std::optional<double> step;      // s
  std::string integrator;          // empty: the scene's; the same goes for the paths below
  std::string motion;
  std::string trace, record, report;
};

struct PreparedRun {
  std::unique_ptr<Session> session;  // null where there are errors
  std::uint64_t num_cycles = 0;
  std::vector<std::string> errors;  // "file:line:column: what" or "--option: what"
  std::vector<std::string> notes;
};

PreparedRun prepare(const RunOptions& options);

}  // namespace godobject
