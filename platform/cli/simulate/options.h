// What `godobject simulate` was asked for, and what becomes of it: a simulation on open buses, or every complaint
// with its place.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "platform/cli/simulate/simulation.h"

namespace godobject {

struct SimulateOptions {
  std::string scene;                   // path
  std::vector<std::string> buses;      // "ADDRESS" or "NAME=ADDRESS"
  std::vector<std::string> taps;       // likewise
  std::string motion, faults, report;  // paths; empty: the scene's own, none, none
  std::optional<double> duration;      // s; none: until it is stopped
  bool control = false;                // commands on standard input
  bool realtime = false;
  bool start_now = false;  // the motion does not wait for the first SYNC
};

struct PreparedSimulation {
  std::unique_ptr<Simulation> simulation;  // null where there are errors
  std::vector<std::string> errors, notes;
  bool not_available = false;  // the errors are of this machine's buses and terminals
};

PreparedSimulation prepare(const SimulateOptions& options);

}  // namespace godobject
