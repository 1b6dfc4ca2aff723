// If any thread of a run crashes, the last frames are written. The threads are those of the table in
// docs/threads.md.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <set>
#include <sstream>
#include <thread>

#include "platform/linux/device_threads.h"
#include "platform/rt/signals.h"
#include "platform/rt/stop_key.h"
#include "platform/scene/toml.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/free_port.h"
#include "tests/support/run_over_ptys.h"

namespace godobject::test::test_dying_threads {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAreArray;
using testing::KilledBySignal;

/// Threads of the run that CrashedThread starts; the main one has the name of the program.
const std::set<std::string> threads_of_a_run{"godobject", "loop", "file", "console", "view", "openigtlink"};
/// Threads of other devices.
const std::set<std::string> threads_of_devices{"tracker", "spacemouse"};
/// Thread of a run on a terminal.
const std::set<std::string> threads_of_terminals{"keys"};

/// Returns the first column of the table in docs/threads.md.
std::set<std::string> documented_threads() {
  const std::string page = read_file(GODOBJECT_SOURCE_DIR "/docs/threads.md");
  const std::size_t begin = page.find("<!-- threads: begin -->"), end = page.find("<!-- threads: end -->");
  if (begin == std::string::npos || end == std::string::npos) return {};
  std::istringstream lines(page.substr(begin, end - begin));
  std::set<std::string> names;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("| `")) names.insert(line.substr(3, line.find('`', 3) - 3));
  return names;
}

/// Returns the first thread of this name in a process; 0 if there is none.
pid_t thread_named(pid_t process, const std::string& name) {
  std::error_code ignored;
  for (const auto& task :
       std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", ignored))
    if (read_file(task.path() / "comm") == name + "\n") return std::stoi(task.path().filename().string());
  return 0;
}

pid_t wait_for_thread(pid_t process, const std::string& name) {
  for (int i = 0; i < 500; ++i) {
    if (const pid_t thread = thread_named(process, name)) return thread;
    std::this_thread::sleep_for(10ms);
  }
  return 0;
}

TEST(Threads, TheDocumentedOnesAreThoseThatAreTested) {
  std::set<std::string> tested = threads_of_a_run;
  tested.insert(threads_of_devices.begin(), threads_of_devices.end());
  tested.insert(threads_of_terminals.begin(), threads_of_terminals.end());
  EXPECT_THAT(documented_threads(), ElementsAreArray(tested));
}

class CrashedThread : public RunOverPtys, public testing::WithParamInterface<std::string> {
 protected:
  bool start() {
    return RunOverPtys::start(write("scene.toml", patient_toml()),
                              {"--view", "--openigtlink", std::to_string(free_port()), "--trace",
                               path("t.csv"), "--record", path("r.log")});
  }
  void hear(const CanFrame& frame) override { frames_.push_back(frame); }

  std::vector<CanFrame> frames_;
};

TEST_P(CrashedThread, WritesTheLastFrames) {
  constexpr int tries = 3;
  for (int i = 0; i < tries; ++i) {
    if (!start()) continue;
    const pid_t thread = thread_named(host_->pid(), GetParam());
    ASSERT_NE(thread, 0) << "no thread is called " << GetParam();
    const rlimit no_core{.rlim_cur = 0, .rlim_max = 0};
    prlimit(host_->pid(), RLIMIT_CORE, &no_core, nullptr);
    listen(1ms);
    frames_.clear();
    ASSERT_EQ(syscall(SYS_tgkill, host_->pid(), thread, SIGSEGV), 0);
    const int status = host_->wait_status();
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV) << status;
    listen(300ms);
    const auto is_off = [](const CanFrame& f) {  // NMT enter pre-operational
      return f.id == 0 && f.data[0] == 0x80;
    };
    EXPECT_TRUE(std::ranges::any_of(frames_, is_off)) << "the drives' watchdogs had to end it";
    return;
  }
  FAIL() << "the host did not come up in " << tries << " tries";
}

INSTANTIATE_TEST_SUITE_P(OfARun, CrashedThread, testing::ValuesIn(threads_of_a_run),
                         [](const auto& test) { return test.param; });

/// Dies of SIGSEGV in the thread of this name, which `make` starts, with last frames into a pipe.
template <class Make>
void die_in_thread(const std::string& name, int descriptor, const Make& make) {
  const rlimit no_core{.rlim_cur = 0, .rlim_max = 0};
  setrlimit(RLIMIT_CORE, &no_core);
  guard_process();
  const LastResort last({{.descriptor = descriptor, .writes = {"last"}}});
  const auto kept = make();
  const pid_t thread = wait_for_thread(getpid(), name);
  if (thread == 0) _exit(3);
  syscall(SYS_tgkill, getpid(), thread, SIGSEGV);
  std::this_thread::sleep_for(5s);
  _exit(4);
}

class DeviceThread : public ProgramTest {
 protected:
  DeviceThread() { EXPECT_EQ(pipe2(ends_.data(), O_NONBLOCK), 0); }
  ~DeviceThread() override {
    for (const int end : ends_) close(end);
  }
  std::string written() const {
    std::array<char, 100> buffer{};
    const ssize_t size = read(ends_[0], buffer.data(), buffer.size());
    return size > 0 ? std::string(buffer.data(), static_cast<std::size_t>(size)) : std::string();
  }
  std::array<int, 2> ends_{};
};

TEST_F(DeviceThread, OfATrackerWritesTheLastFrames) {
  const LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/tracked.toml");
  ASSERT_TRUE(loaded.scene);
  TrackerParams params = loaded.scene->device->trackers.front();
  params.port = "/dev/no-such-port";
  const auto make = [&] { return std::make_unique<TrackerThread>(make_tracker(params, {}).tracker); };
  EXPECT_EXIT(die_in_thread("tracker", ends_[1], make), KilledBySignal(SIGSEGV), "the drives were commanded");
  EXPECT_EQ(written(), "last");
}

TEST_F(DeviceThread, OfASpaceMouseWritesTheLastFrames) {
  const LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/spacemouse.toml");
  ASSERT_TRUE(loaded.scene);
  const std::string where = path("socket");
  const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(where.begin(), where.end(), address.sun_path);
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(listen(listener, 1), 0);
  SpaceMouse mouse(*loaded.scene, []() noexcept { return MonotonicClock{}.now(); });
  const auto make = [&] {
    std::string why_not;
    return SpaceMouseThread::start(
        where, mouse, [](const std::string&) {}, why_not);
  };
  EXPECT_EXIT(die_in_thread("spacemouse", ends_[1], make), KilledBySignal(SIGSEGV),
              "the drives were commanded");
  EXPECT_EQ(written(), "last");
  close(listener);
}

TEST_F(DeviceThread, OfTheKeysWritesTheLastFramesAndRestoresTheTerminal) {
  int master = -1, terminal = -1;
  ASSERT_EQ(openpty(&master, &terminal, nullptr, nullptr, nullptr), 0);
  termios before{}, after{};
  ASSERT_EQ(tcgetattr(terminal, &before), 0);
  const auto make = [&] {
    dup2(terminal, STDIN_FILENO);
    static const StopSignals signals(Suspension::stops);
    auto key = std::make_unique<StopKey>(signals);
    termios during{};
    if (tcgetattr(terminal, &during) != 0 || (during.c_lflag & (ICANON | ECHO)) != 0) _exit(5);
    return key;
  };
  EXPECT_EXIT(die_in_thread("keys", ends_[1], make), KilledBySignal(SIGSEGV), "the drives were commanded");
  EXPECT_EQ(written(), "last");
  ASSERT_EQ(tcgetattr(terminal, &after), 0);
  EXPECT_EQ(after.c_lflag, before.c_lflag);
  close(terminal);
  close(master);
}

}  // namespace
}  // namespace godobject::test::test_dying_threads
