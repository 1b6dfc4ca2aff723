#include "platform/cli/report/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

namespace godobject {
namespace {

struct Closer {
  void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};
/// A file without a name, which ends with this object.
using Scratch = std::unique_ptr<std::FILE, Closer>;

std::string error_text(int number) { return std::generic_category().message(number); }

std::string text_of(std::FILE* file) {
  std::string text;
  std::rewind(file);
  std::array<char, 4096> buffer{};
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), file)) > 0;)
    text.append(buffer.data(), n);
  return text;
}

/// Runs gnuplot with its settings as shipped. Returns the error number of the start, or 0 and the wait
/// status.
int run_gnuplot(std::FILE* script, int picture, std::FILE* messages, int& status) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(script), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, picture, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(messages), STDERR_FILENO);
  std::string name = "gnuplot", defaults = "--default-settings", from_input = "-";
  std::array<char*, 4> arguments{name.data(), defaults.data(), from_input.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, name.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return error;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  return 0;
}

}  // namespace

bool is_plot(std::string_view path) noexcept { return path.ends_with(".svg") || path.ends_with(".png"); }

std::string gnuplot_text(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c == '\n' ? ' ' : c);
  return quoted + "'";
}

std::string draw_plot(const std::string& path, int width, int height, const std::string& script) {
  const std::string size = std::to_string(width) + "," + std::to_string(height);
  const std::string terminal = path.ends_with(".svg") ? "svg noenhanced background 'white' font 'sans,11'"
                                                      : "pngcairo noenhanced font 'sans,9'";
  const Scratch input(std::tmpfile()), messages(std::tmpfile());
  if (!input || !messages) return "a temporary file cannot be made: " + error_text(errno);
  const std::string text = "set terminal " + terminal + " size " + size + "\n" + script;
  if (std::fwrite(text.data(), 1, text.size(), input.get()) != text.size() || std::fflush(input.get()) != 0)
    return "a temporary file cannot be written: " + error_text(errno);
  std::rewind(input.get());
  const int picture = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (picture < 0) return "'" + path + "' could not be written: " + error_text(errno);
  int status = 0;
  const int error = run_gnuplot(input.get(), picture, messages.get(), status);
  ::close(picture);
  if (error == 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  ::unlink(path.c_str());
  if (error == ENOENT)
    return "gnuplot draws it and is not installed: install it, on Debian `sudo apt-get install gnuplot-nox`";
  if (error != 0) return "gnuplot cannot be started: " + error_text(error);
  return "gnuplot failed: " + text_of(messages.get());
}

}  // namespace godobject
