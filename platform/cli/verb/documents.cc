// godobject faults: prints meaning and remedy of every fault.
// godobject import: writes a robot description in URDF as a scene file.
// godobject man [VERB], godobject completion bash: documents for packagers, hidden in help.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

#include "platform/cli/command_line.h"
#include "platform/cli/fault_texts.h"
#include "platform/cli/program.h"
#include "platform/scene/text/diagnostics.h"
#include "platform/scene/toml.h"
#include "platform/scene/urdf/urdf.h"

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

struct ImportOptions {
  std::string file, out;
};

#ifdef GODOBJECT_TINYXML2

/// Writes a new file. An existing one is kept, because it may have been edited.
ExitCode write_new(const std::string& path, const std::string& text) {
  std::FILE* const file = std::fopen(path.c_str(), "wx");
  if (file == nullptr) {
    const std::string why = errno == EEXIST ? "exists and is kept: remove it, or give another name to --out"
                                            : std::string("cannot be written: ") + std::strerror(errno);
    std::fprintf(stderr, "%s: %s\n", printable(path).c_str(), why.c_str());
    return ExitCode::usage;
  }
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (std::fclose(file) == 0 && written) return ExitCode::ok;
  std::fprintf(stderr, "%s: cannot be written to its end: the disk may be full\n", printable(path).c_str());
  std::remove(path.c_str());
  return ExitCode::fault;
}

ExitCode import_urdf(const ImportOptions& options) {
  const FileText file = read_file(options.file, max_toml_bytes);
  if (!file.text) {
    std::fprintf(stderr, "%s: %s\n", printable(options.file).c_str(), file.why_not.c_str());
    return ExitCode::usage;
  }
  Diagnostics log(options.file);
  const std::string& beside = options.out.empty() ? options.file : options.out;
  const std::string folder = std::filesystem::absolute(beside).parent_path().string();
  std::string scene;
  if (const std::optional<UrdfRobot> robot = read_urdf(*file.text, log)) {
    const std::vector<UrdfGroup> groups = groups_of(*robot, log);
    if (log.ok()) scene = scene_of_urdf(*robot, groups, folder, log);
  }
  std::vector<std::string> errors = log.errors();
  if (errors.empty() && !(errors = parse_scene(scene, folder + "/scene.toml").errors).empty())
    errors.push_back(printable(options.file) +
                     ": its scene would have these errors: correct the description");
  for (const std::string& warning : log.warnings()) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  for (const std::string& error : errors) std::fprintf(stderr, "%s\n", error.c_str());
  if (!errors.empty()) return ExitCode::usage;
  if (!options.out.empty()) return write_new(options.out, scene);
  std::fputs(scene.c_str(), stdout);
  return ExitCode::ok;
}

#else

ExitCode import_urdf(const ImportOptions& /*options*/) {
  std::fputs(
      "import: this program was built without tinyxml2, which reads XML: ./dev setup base (or apt-get "
      "install "
      "libtinyxml2-dev), then build again\n",
      stderr);
  return ExitCode::not_available;
}

#endif

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

void add_import(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("import", "Write a robot description (URDF) as a scene file.");
  const auto options = std::make_shared<ImportOptions>();
  verb->add_option("FILE", options->file, "read this robot description (URDF), see docs/scenes.md")
      ->required();
  verb->add_option("--out", options->out, "write this new scene file; default: standard output");
  verb->callback([options, &code] { code = import_urdf(*options); });
}

void add_documents(CLI::App& app, ExitCode& code) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : verbs_of(app)) verbs.push_back(verb->get_name());
  CLI::App* man = app.add_subcommand("man", "Print the manual page, in roff.")->group("");
  const auto of_verb = std::make_shared<std::string>();
  man->add_option("VERB", *of_verb, "print the page of this verb; default: of the program")
      ->check(CLI::IsMember(verbs));
  man->callback([&app, &code, of_verb] {
    code = print(of_verb->empty() ? man_page(app, GODOBJECT_VERSION)
                                  : man_page_of_verb(app, *app.get_subcommand(*of_verb), GODOBJECT_VERSION));
  });

  CLI::App* completion = app.add_subcommand("completion", "Print the completion of a shell.")->group("");
  const auto shell = std::make_shared<std::string>();
  completion->add_option("SHELL", *shell, "print the completion of this shell")
      ->required()
      ->check(CLI::IsMember({"bash"}));
  completion->callback([&app, &code, shell] { code = print(bash_completion(app)); });
}

}  // namespace godobject
