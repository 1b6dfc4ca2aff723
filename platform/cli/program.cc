#include "platform/cli/program.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <memory>
#include <new>

#include "platform/cli/command_line.h"
#include "platform/rt/setup.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

/// True if all printed text was written. A full disk behind `> FILE` is detected only by this last flush.
bool standard_output_is_complete() {
  errno = 0;
  std::cout.flush();
  const bool complete = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
  if (!complete) {
    const char* const why =
        errno == 0 ? "the disk may be full, or the reader may have closed it" : std::strerror(errno);
    std::fprintf(stderr, "standard output could not be written: %s\n", why);
  }
  return complete;
}

/// Returns the last verb that was parsed, or its own verb in turn.
const CLI::App& innermost(const CLI::App& app) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  return given.empty() ? app : innermost(*given.front());
}

/// Returns the verbs or options for which a word may be a misspelling.
std::vector<std::string> known_words(const CLI::App& verb, bool option) {
  std::vector<std::string> known;
  if (!option)
    for (const CLI::App* other : verb.get_subcommands([](const CLI::App*) { return true; }))
      known.push_back(other->get_name());
  else
    for (const CLI::Option* other : verb.get_options())
      for (const std::string& name : other->get_lnames()) known.push_back("--" + name);
  return known;
}

/// Returns "did you mean 'check'?" for the first unknown word; empty if nothing is near it.
std::string hint_for(const CLI::App& app, int argc, char** argv) {
  const CLI::App& verb = innermost(app);
  const std::vector<std::string> unknown =
      verb.remaining(true).empty() ? app.remaining(true) : verb.remaining(true);
  for (int i = 1; i < argc; ++i) {
    if (std::ranges::find(unknown, argv[i]) == unknown.end()) continue;
    const std::string word = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    const std::vector<std::string> known = known_words(verb, word.starts_with("-"));
    const std::vector<std::string_view> names(known.begin(), known.end());
    const std::optional<std::string_view> nearest = nearest_name(word, names);
    return nearest ? "did you mean '" + std::string(*nearest) + "' in place of '" + word + "'?\n" : "";
  }
  return "";
}

/// Runs the program. Throws if memory runs out or on a defect.
ExitCode run(int argc, char** argv, const ProgramParts& parts) {
  ExitCode code = ExitCode::ok;
  CLI::App app("Couple a tool in a simulated scene to a tracked device by a damped spring.", "godobject");
  app.set_version_flag("--version", GODOBJECT_VERSION);
  app.require_subcommand(0, 1);
  app.formatter(std::make_shared<HelpFormat>());
  app.footer(
      "Exit codes: 0 ok, 1 fault during the run, 2 usage or configuration, 3 not available on this machine.");
  add_verbs(app, parts, code);
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) {
      std::fputs(app.help().c_str(), stderr);
      code = ExitCode::usage;
    }
  } catch (const CLI::ExtrasError& error) {
    app.exit(error);
    std::fputs(hint_for(app, argc, argv).c_str(), stderr);
    code = ExitCode::usage;
  } catch (const CLI::ParseError& error) {
    code = app.exit(error) == 0 ? ExitCode::ok : ExitCode::usage;
  }
  return standard_output_is_complete() ? code : std::max(code, ExitCode::fault);
}

}  // namespace

void add_verbs(CLI::App& app, const ProgramParts& parts, ExitCode& code) {
  const FaultChecks& checks = parts.simulated.faults;
  add_run(app, parts, code);
  add_check(app, parts, code);
  add_doctor(app, checks, code);
  if (parts.add_verb != nullptr) parts.add_verb(app, code);
  add_view(app, checks, code);
  add_accuracy(app, checks, code);
  add_replay(app, checks, code);
  add_metrics(app, checks, code);
  add_export(app, checks, code);
  add_bus_load(app, checks, code);
  add_monitor(app, checks, code);
  add_import(app, code);
  add_faults(app, code);
  add_sdo(app, code);
  add_lss(app, code);
  add_drive(app, code);
  add_encoder(app, code);
  add_identify(app, code);
  add_documents(app, code);
}

int run_program(int argc, char** argv, const ProgramParts& parts) {
  ExitCode code = ExitCode::not_available;
  // Otherwise a warning would stand within a line of a table, where both streams go to one pipe.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (parts.engine != nullptr) wrap_engines(parts.engine);
  if (!keep_standard_descriptors()) {
    std::fputs(
        "/dev/null cannot be opened, and a standard stream is closed: mount /dev, or open the stream\n",
        stderr);
    return static_cast<int>(code);
  }
  const auto guarded = [&] {
    try {
      code = run(argc, argv, parts);
    } catch (const std::bad_alloc&) {
      std::fputs(
          "out of memory: use a smaller scene or a shorter motion, or raise the limit of memory (ulimit "
          "-v)\n",
          stderr);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "internal error, a defect of this program: %s\n", error.what());
    }
  };
  if (!call_on_large_stack(guarded))
    std::fputs("out of memory: a stack of 8 MB cannot be allocated: raise ulimit -v\n", stderr);
  return static_cast<int>(code);
}

}  // namespace godobject
