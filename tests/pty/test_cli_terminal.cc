// Output of a run on a terminal, and the terminals it makes.
#include <gmock/gmock.h>
#include <pty.h>

#include "tests/support/background_program.h"
#include "tests/support/program.h"

namespace godobject::test_cli_terminal {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

/// Returns all output of the command on a terminal of its own.
std::string on_terminal(const std::string& arguments) {
  int terminal = -1;
  const pid_t pid = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (pid == 0) {
    const std::string command = "cd '" GODOBJECT_SOURCE_DIR "' && exec '" GODOBJECT_PROGRAM "' " + arguments;
    execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  std::string shown;
  std::array<char, 4096> buffer{};
  for (ssize_t n; (n = read(terminal, buffer.data(), buffer.size())) > 0;)
    shown.append(buffer.data(), static_cast<std::size_t>(n));
  close(terminal);
  waitpid(pid, nullptr, 0);
  return shown;
}

TEST(CliTerminal, ALongFastRunShowsHowFarItIs) {
  const std::string scene = "sim/scenes/lego.toml --bus direct --fast --motion sim/scenes/lego-motion.csv";
  const std::string shown = on_terminal("run " + scene);
  EXPECT_THAT(shown, ContainsRegex("t [0-9.]+ of [0-9.]+ s \\([0-9]+ %\\), about [0-9]+ s left"));
  EXPECT_THAT(on_terminal("run " + scene + " --quiet"), Not(HasSubstr("left")));
  EXPECT_THAT(on_terminal("run sim/scenes/s1.toml --bus direct --fast --duration 0.1"),
              Not(HasSubstr("left")));
}

TEST(CliTerminal, PtyAloneStandsForEveryBusAsOfSimulate) {
  const test::ProgramResult result =
      test::run_program("run sim/scenes/rigid.toml --bus pty --duration 0.1", "timeout 1 ");
  EXPECT_THAT(result.output, ContainsRegex("bus can0: waiting for the other end of /dev/pts/"));
  EXPECT_THAT(result.output, ContainsRegex("bus can1: waiting for the other end of /dev/pts/"));
}

}  // namespace
}  // namespace godobject::test_cli_terminal
