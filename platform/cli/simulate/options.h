// Options of `godobject simulate` and the simulation prepared from them, on open buses, or all errors with
// their places.
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
  std::vector<std::string> taps;       // as buses
  std::string motion, faults, report;  // paths; empty: the scene's own, none, none
  std::optional<double> duration;      // s; none: until stopped
  bool control = false;                // true: commands on standard input
  bool realtime = false;
  bool start_now = false;  // true: the motion does not wait for the first SYNC
};

struct PreparedSimulation {
  std::unique_ptr<Simulation> simulation;  // null if there are errors
  std::vector<std::string> errors, notes;
  bool not_available = false;  // true if the errors are of this machine's buses and terminals
};

PreparedSimulation prepare(const SimulateOptions& options);

}  // namespace godobject
