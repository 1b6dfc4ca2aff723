// The program's verbs. A new one is a file cmd_<verb>.cc and a line in each of the two lists below.
//
// The room: main.cc takes the command line apart; cmd_*.cc is one verb each; bus/ is what verbs do on one bus, run/ the
// verb `run`, simulate/ the verb `simulate`. check_text.h, fault_texts.h, limit_texts.h and time_to_zero.h say things in
// words; option_*.h and named_address.h read what options give; command_documents.h makes the manual page and the
// completion.
#pragma once

#include <array>

#include <CLI/CLI.hpp>

namespace godobject {

/// What the program exits with.
enum class ExitCode : int {
  ok = 0,
  fault = 1,          // during the run, or a file that could not be written
  usage = 2,          // wrong options or a wrong file: nothing was done
  not_available = 3,  // this machine does not have what was asked for
};

/// Adds the verb to `app`; when it has run, its exit code is in `code`, which outlives `app`.
using AddVerb = void (*)(CLI::App& app, ExitCode& code);

struct RunOptions;
/// The options of `run`, which `check` has too.
void add_run_options(CLI::App& verb, RunOptions& options);

void add_run(CLI::App& app, ExitCode& code);
void add_check(CLI::App& app, ExitCode& code);
void add_simulate(CLI::App& app, ExitCode& code);
void add_bus_load(CLI::App& app, ExitCode& code);
void add_monitor(CLI::App& app, ExitCode& code);
void add_faults(CLI::App& app, ExitCode& code);
void add_sdo(CLI::App& app, ExitCode& code);
void add_lss(CLI::App& app, ExitCode& code);
void add_drive(CLI::App& app, ExitCode& code);
void add_encoder(CLI::App& app, ExitCode& code);
void add_view(CLI::App& app, ExitCode& code);
void add_documents(CLI::App& app, ExitCode& code);

inline constexpr std::array<AddVerb, 12> verbs{add_run,      add_check,   add_simulate, add_view,
                                               add_bus_load, add_monitor, add_faults,   add_sdo,
                                               add_lss,      add_drive,   add_encoder,  add_documents};

}  // namespace godobject
