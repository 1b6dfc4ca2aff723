// godobject faults: prints meaning and remedy of every fault.
// godobject man, godobject completion bash: documents for packagers, hidden in help.
#include <cstdio>
#include <memory>
#include <vector>

#include "platform/cli/command_line.h"
#include "platform/cli/fault_texts.h"
#include "platform/cli/program.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

struct FaultGroup {
  const char* title;
  std::vector<FaultText> faults;
};

std::vector<FaultGroup> fault_groups() {
  FaultGroup core{.title = "core: a step was not taken, or was taken with less than the scene describes",
                  .faults = {}};
  for (const CoreFaultText& fault : core_fault_texts) core.faults.push_back(fault.text);
  FaultGroup rig{
      .title =
          "rig: the torque runs down to zero, until the faults are cleared and the device is armed again",
      .faults = {}};
  for (const RigFaultText& fault : rig_fault_texts())
    rig.faults.push_back({.name = fault.name, .meaning = fault.meaning, .remedy = fault.remedy});
  const FaultGroup run{.title = "run: faults of godobject run itself",
                       .faults = {run_fault_texts.begin(), run_fault_texts.end()}};
  return {core, rig, run};
}

void print_fault(const FaultText& fault) {
  std::printf("  %.*s\n    meaning: %.*s\n    remedy:  %.*s\n", static_cast<int>(fault.name.size()),
              fault.name.data(), static_cast<int>(fault.meaning.size()), fault.meaning.data(),
              static_cast<int>(fault.remedy.size()), fault.remedy.data());
}

/// Prints the fault `name`, or all if it is empty. Returns usage if no fault has this name.
ExitCode show_faults(const std::string& name) {
  std::vector<std::string_view> names;
  bool any_shown = false;
  for (const FaultGroup& group : fault_groups()) {
    bool title_shown = false;
    for (const FaultText& fault : group.faults) {
      names.push_back(fault.name);
      if (!name.empty() && name != fault.name) continue;
      if (!title_shown) std::printf("%s%s\n", any_shown ? "\n" : "", group.title);
      title_shown = any_shown = true;
      print_fault(fault);
    }
  }
  if (any_shown) return ExitCode::ok;
  const auto nearest = nearest_name(name, names);
  std::fprintf(stderr, "unknown fault '%s'%s; godobject faults lists all\n", name.c_str(),
               nearest ? ("; did you mean '" + std::string(*nearest) + "'?").c_str() : "");
  return ExitCode::usage;
}

ExitCode print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  return ExitCode::ok;
}

}  // namespace

void add_faults(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("faults", "Explain each fault and its remedy.");
  const auto name = std::make_shared<std::string>();
  verb->add_option("NAME", *name, "explain this fault; default: all");
  verb->callback([name, &code] { code = show_faults(*name); });
}

void add_documents(CLI::App& app, ExitCode& code) {
  CLI::App* man = app.add_subcommand("man", "Print the manual page, in roff.")->group("");
  man->callback([&app, &code] { code = print(man_page(app, GODOBJECT_VERSION)); });

  CLI::App* completion = app.add_subcommand("completion", "Print the completion of a shell.")->group("");
  const auto shell = std::make_shared<std::string>();
  completion->add_option("SHELL", *shell, "print the completion of this shell")
      ->required()
      ->check(CLI::IsMember({"bash"}));
  completion->callback([&app, &code, shell] { code = print(bash_completion(app)); });
}

}  // namespace godobject
