// The space bar of a run's terminal: an emergency stop. The terminal's modes are restored.
#include "platform/rt/stop_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <thread>

namespace godobject::test_stop_key {
namespace {

using namespace std::chrono_literals;

/// A terminal in the place of the standard input.
class StopKeyTest : public testing::Test {
 protected:
  StopKeyTest() {
    EXPECT_EQ(openpty(&master_, &terminal_, nullptr, nullptr, nullptr), 0);
    dup2(terminal_, STDIN_FILENO);
  }
  ~StopKeyTest() override {
    dup2(former_, STDIN_FILENO);
    for (const int descriptor : {master_, terminal_, former_}) close(descriptor);
  }
  tcflag_t modes() const {
    termios now{};
    EXPECT_EQ(tcgetattr(terminal_, &now), 0);
    return now.c_lflag;
  }
  void press(char key) const { EXPECT_EQ(write(master_, &key, 1), 1); }

  int former_ = dup(STDIN_FILENO), master_ = -1, terminal_ = -1;
};

bool is_set_soon(const std::atomic<bool>& flag) {
  for (int i = 0; i < 500 && !flag; ++i) std::this_thread::sleep_for(10ms);
  return flag;
}

TEST_F(StopKeyTest, SpaceBarStopsAtOnce) {
  const StopSignals signals(Suspension::stops);
  const StopKey key(signals);
  ASSERT_TRUE(key.works());
  for (const char other : {'x', '\n', '\x1b'}) press(other);
  std::this_thread::sleep_for(50ms);
  EXPECT_FALSE(signals.requested());
  press(' ');
  EXPECT_TRUE(is_set_soon(signals.requested()));
  EXPECT_TRUE(signals.insisted());
  EXPECT_EQ(signals.name(), "space bar");
}

TEST_F(StopKeyTest, RestoresTheModes) {
  const tcflag_t before = modes();
  {
    const StopSignals signals(Suspension::stops);
    const StopKey key(signals);
    EXPECT_EQ(modes() & (ICANON | ECHO), 0u);
    EXPECT_EQ(modes() & ISIG, before & ISIG) << "Ctrl-C stays a signal";
  }
  EXPECT_EQ(modes(), before);
}

TEST_F(StopKeyTest, LeavesATerminalToTheProgramThatReadsItsKeys) {
  const StopSignals signals(Suspension::stops);
  const StopKey first(signals);
  {
    const StopKey second(signals);
    EXPECT_FALSE(second.works());
  }
  EXPECT_EQ(modes() & ICANON, 0u);
}

TEST_F(StopKeyTest, OfAPipeDoesNothing) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  dup2(ends[0], STDIN_FILENO);
  const StopSignals signals(Suspension::stops);
  EXPECT_FALSE(StopKey(signals).works());
  for (const int end : ends) close(end);
}

/// Otherwise the shell of the foreground would lose its keys.
TEST_F(StopKeyTest, OfABackgroundJobDoesNothing) {
  int master = -1;
  const pid_t shell = forkpty(&master, nullptr, nullptr, nullptr);
  if (shell == 0) {
    const pid_t job = fork();
    if (job == 0) {
      setpgid(0, 0);
      std::signal(SIGTTOU, SIG_IGN);  // as guard_process() does
      const StopSignals signals(Suspension::stops);
      _exit(StopKey(signals).works() ? 1 : 0);
    }
    int status = 1;
    waitpid(job, &status, 0);
    const StopSignals signals(Suspension::stops);
    _exit(status == 0 && StopKey(signals).works() ? 0 : 1);
  }
  int status = 1;
  waitpid(shell, &status, 0);
  EXPECT_EQ(status, 0);
  close(master);
}

}  // namespace
}  // namespace godobject::test_stop_key
