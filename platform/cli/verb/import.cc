// godobject import: writes a robot description in URDF as a scene file.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>

#include "platform/cli/program.h"
#include "platform/scene/toml.h"
#include "platform/scene/urdf/urdf.h"

namespace godobject {
namespace {

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

}  // namespace

void add_import(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("import", "Write a robot description (URDF) as a scene file.");
  const auto options = std::make_shared<ImportOptions>();
  verb->add_option("FILE", options->file, "read this robot description (URDF), see docs/scenes.md")
      ->required();
  verb->add_option("--out", options->out, "write this new scene file; default: standard output");
  verb->callback([options, &code] { code = import_urdf(*options); });
}

}  // namespace godobject
