// godobject: the command line.
#include <cstdio>
#include <exception>
#include <new>

#include "platform/cli/verbs.h"

int main(int argc, char** argv) {
  using godobject::ExitCode;
  ExitCode code = ExitCode::ok;
  CLI::App app("A tool in a simulated scene, pulled to a tracked device by a damped spring.", "godobject");
  app.set_version_flag("--version", GODOBJECT_VERSION);
  app.require_subcommand(0, 1);
  app.footer(
      "Exit codes: 0 ok, 1 fault during the run, 2 usage or configuration, 3 not available on this machine.");
  for (const godobject::AddVerb add : godobject::verbs) add(app, code);
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) {
      std::fputs(app.help().c_str(), stderr);
      code = ExitCode::usage;
    }
  } catch (const CLI::ParseError& error) {
    code = app.exit(error) == 0 ? ExitCode::ok : ExitCode::usage;
  } catch (const std::bad_alloc&) {
    std::fputs("out of memory: a smaller scene, a shorter motion, or more of it (ulimit -v)\n", stderr);
    code = ExitCode::not_available;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "a defect of the program: %s\n", error.what());
    code = ExitCode::not_available;
  }
  return static_cast<int>(code);
}
