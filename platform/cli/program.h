// The program godobject and its verbs. A new verb is a function in verb/, a line in the list below and one in
// program.cc. Its main() in platform/cli/simulate/main.cc sets the simulation: the devices of scenes, or none
// with GODOBJECT_SIM=OFF.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/math/pose.h"
#include "platform/device/hand_device.h"
#include "platform/engine/wrapped.h"
#include "platform/session/session.h"

namespace CLI {
class App;
}

namespace godobject {

/// Exit code of the program.
enum class ExitCode : int {
  ok = 0,
  fault = 1,          // during the run, or a file that could not be written
  usage = 2,          // wrong options or a wrong file; nothing was done
  not_available = 3,  // this machine does not have a requested resource
};

struct FaultChecks;
struct RunOptions;

/// Makes the device of a run, whose functions are called on the real-time thread. Returns null with the
/// reason and the remedy in why_not.
using DeviceMaker = std::unique_ptr<HandDevice> (*)(const SceneConfig& scene, std::string& why_not);

/// Parts of a program. Default: none but those of all programs.
struct ProgramParts {
  SimulatedDevices simulated{};  // devices of scenes, if simulated ones are linked
  void (*add_verb)(CLI::App& app, ExitCode& code) = nullptr;  // adds `simulate`
  EngineWrapper engine = nullptr;                             // step of the program, in runs and replays
  // Device of each run that has a coupled body, without --bus and other options that give a device.
  DeviceMaker device = nullptr;
};

/// Adds the options of `run`, which `check` shares.
void add_run_options(CLI::App& verb, RunOptions& options);

// Each function adds its verb to `app`. When the verb has run, its exit code is in `code`, which outlives
// `app`. Verbs that read scenes receive the parts of the program.
void add_run(CLI::App& app, const ProgramParts& parts, ExitCode& code);
void add_check(CLI::App& app, const ProgramParts& parts, ExitCode& code);
// only in programs that simulate, see ProgramParts
void add_simulate(CLI::App& app, ExitCode& code);
void add_doctor(CLI::App& app, const FaultChecks& checks, ExitCode& code);
void add_view(CLI::App& app, const FaultChecks& checks, ExitCode& code);
void add_bus_load(CLI::App& app, const FaultChecks& checks, ExitCode& code);
void add_monitor(CLI::App& app, const FaultChecks& checks, ExitCode& code);
void add_accuracy(CLI::App& app, const FaultChecks& checks, ExitCode& code);
void add_metrics(CLI::App& app, const FaultChecks& checks, ExitCode& code);
void add_replay(CLI::App& app, const FaultChecks& checks, ExitCode& code);
void add_export(CLI::App& app, const FaultChecks& checks, ExitCode& code);
void add_import(CLI::App& app, ExitCode& code);
void add_faults(CLI::App& app, ExitCode& code);
void add_sdo(CLI::App& app, ExitCode& code);
void add_lss(CLI::App& app, ExitCode& code);
void add_drive(CLI::App& app, ExitCode& code);
void add_encoder(CLI::App& app, ExitCode& code);
void add_identify(CLI::App& app, ExitCode& code);
void add_documents(CLI::App& app, ExitCode& code);

/// Replays an input log and prints as `replay` does. rows: receives the lines of its trace, the header first.
ExitCode replay_input_log(const std::string& file, const FaultChecks& checks,
                          std::function<bool(std::string_view)> rows);

/// Adds all verbs, in the order of help.
void add_verbs(CLI::App& app, const ProgramParts& parts, ExitCode& code);

/// Runs the program and returns the exit code of main().
int run_program(int argc, char** argv, const ProgramParts& parts);

}  // namespace godobject
