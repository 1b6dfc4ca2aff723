// The program godobject. Its main() sets the simulation: none in platform/cli/main.cc, the devices of scenes
// in platform/cli/simulate/main.cc.
#pragma once

#include "platform/cli/verbs.h"
#include "platform/session/simulated_devices.h"

namespace godobject {

/// Functions of a program that links simulated devices. Default: none.
struct LinkedSimulation {
  SimulatedDevices devices{};
  void (*add_verb)(CLI::App& app, ExitCode& code) = nullptr;  // adds `simulate`
};

/// Adds all verbs, in the order of help.
void add_verbs(CLI::App& app, const LinkedSimulation& simulation, ExitCode& code);

/// Runs the program and returns the exit code of main().
int run_program(int argc, char** argv, const LinkedSimulation& simulation);

}  // namespace godobject
