// What `godobject run` was asked for, and what becomes of it: a session that is ready to boot, or every
// complaint with its place. Nothing is written here.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/bus_load.h"
#include "sim/session.h"

namespace godobject {

struct RunOptions {
  std::string scene;  // path
  bool realtime = false;
  std::optional<BusChoice> bus;    // by default sim where the scene describes buses
  std::optional<double> duration;  // s
  std::optional<double> step;      // s
  std::string integrator;          // empty: the scene's; the same goes for the paths below
  std::string motion;
  std::string trace, record, report;
};

struct PreparedRun {
  std::unique_ptr<Session> session;  // null where there are errors
  std::uint64_t num_cycles = 0;
  std::vector<BusLoad> bus_loads;   // what the scene's buses carry at worst; empty with --bus direct
  std::vector<std::string> errors;  // "file:line:column: what", "file: what" or "--option: what"
  std::vector<std::string> notes;
};

PreparedRun prepare(const RunOptions& options);

}  // namespace godobject
