// godobject: the program. Its main() says what it simulates: platform/cli/main.cc nothing, platform/cli/simulate/main.cc the
// devices of scenes.
#pragma once

#include "platform/cli/verbs.h"
#include "platform/session/simulated_devices.h"

namespace godobject {

/// What a program can do that links simulated devices. As it is here: nothing.
struct Simulation {
  SimulatedDevices devices{};
  void (*add_verb)(CLI::App& app, ExitCode& code) = nullptr;  // `simulate`
};

/// All verbs, in the order in which help lists them.
void add_verbs(CLI::App& app, const Simulation& simulation, ExitCode& code);

/// What main() returns.
int run_program(int argc, char** argv, const Simulation& simulation);

}  // namespace godobject
