#include "platform/cli/run/spacemouse.h"

#include <unistd.h>

#include "platform/rt/background_file.h"

namespace godobject {

void check_spacemouse(const RunOptions& options, const SceneConfig& scene, PreparedRun& run) {
  const bool has_one = scene.device && scene.device->spacemouse;
  if (!options.spacemouse) {
    if (has_one && !options.view_input)
      run.notes.push_back("scene '" + scene.name +
                          "' has a SpaceMouse, which --spacemouse uses: this run uses the scene's motion");
    return;
  }
  if (!has_one)
    run.errors.push_back("--spacemouse: scene '" + scene.name +
                         "' has no SpaceMouse: add [device.spacemouse] (docs/scenes.md)");
  if (options.fast) run.errors.push_back("--spacemouse: requires wall time: remove --fast");
  if (!options.motion.empty()) run.errors.push_back("--spacemouse: replaces --motion: remove either");
  if (options.view_input)
    run.errors.push_back("--spacemouse: excludes --view-input, since both move the tool: remove either");
}

std::string connect_spacemouse(const RunOptions& options, PreparedRun& run) {
  if (!run.spacemouse) return "";
  constexpr std::size_t console_bytes = 1 << 12;
  const auto console = std::make_shared<BackgroundFile>(STDERR_FILENO, console_bytes);
  const auto log = [console](const std::string& line) { static_cast<void>(console->write(line + "\n")); };
  const std::string socket = options.spacemouse->empty() ? spacenav_socket() : *options.spacemouse;
  std::string why_not;
  run.spacemouse_thread = SpaceMouseThread::start(socket, *run.spacemouse, log, why_not);
  return why_not;
}

}  // namespace godobject
