// godobject faults: prints meaning and remedy of every fault.
#include <cstdio>
#include <memory>
#include <vector>

#include "platform/cli/fault_texts.h"
#include "platform/cli/verbs.h"
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

}  // namespace

void add_faults(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("faults", "Explain each fault and its remedy.");
  const auto name = std::make_shared<std::string>();
  verb->add_option("NAME", *name, "explain this fault; default: all");
  verb->callback([name, &code] { code = show_faults(*name); });
}

}  // namespace godobject
