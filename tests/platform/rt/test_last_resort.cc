// Last frames of a dying program. tests/hil/test_ways_out.py tests the same from the wire, for signals from
// outside.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "platform/rig/buses.h"
#include "platform/rt/signals.h"
#include "platform/scene/toml.h"

namespace godobject::test_last_resort {
namespace {

using testing::HasSubstr;
using testing::KilledBySignal;

/// A pipe as a bus. Death tests run in a child process; its frames remain in the pipe.
class Wire {
 public:
  Wire() { EXPECT_EQ(pipe2(ends_.data(), O_NONBLOCK), 0); }
  ~Wire() {
    for (const int end : ends_) close(end);
  }
  LastWords words() const { return {.descriptor = ends_[1], .writes = {"first ", "second"}}; }
  std::string text() const {
    std::array<char, 100> buffer{};
    const ssize_t size = read(ends_[0], buffer.data(), buffer.size());
    return size > 0 ? std::string(buffer.data(), static_cast<std::size_t>(size)) : std::string();
  }

 private:
  std::array<int, 2> ends_{};
};

/// Dies of `defect` with registered frames; the child must not leave a core file.
template <class Defect>
void die(const Wire& wire, const Defect& defect) {
  const rlimit no_core{.rlim_cur = 0, .rlim_max = 0};
  setrlimit(RLIMIT_CORE, &no_core);
  guard_process();
  const LastResort last({wire.words()});
  defect();
}

TEST(LastResort, TerminateWritesTheLastFrames) {
  const Wire wire;
  EXPECT_EXIT(die(wire, [] { std::terminate(); }), KilledBySignal(SIGABRT), "the drives were commanded");
  EXPECT_EQ(wire.text(), "first second");
}

/// A frame in the middle of a line would be lost with it.
TEST(LastResort, TheRestOfACutLineComesFirst) {
  const Wire wire;
  LineRest rest;
  rest.store("4400000000\r");
  EXPECT_EXIT(
      {
        guard_process();
        LastWords words = wire.words();
        words.rest = &rest;
        const LastResort last({words});
        std::terminate();
      },
      KilledBySignal(SIGABRT), "the drives were commanded");
  EXPECT_EQ(wire.text(), "4400000000\rfirst second");
}

TEST(LastResort, AnExceptionThatEscapesWritesTheLastFrames) {
  const Wire wire;
  const auto escape = [] { std::thread([] { throw std::runtime_error("torn"); }).join(); };
  EXPECT_EXIT(die(wire, escape), KilledBySignal(SIGABRT), "torn; the drives were commanded");
  EXPECT_EQ(wire.text(), "first second");
}

/// Each call needs stack space of its own, which the next one reads.
std::size_t recurse(const volatile char* before, std::size_t depth) {
  volatile char room[4096];
  room[0] = before[0];
  return depth == 0 ? 0 : recurse(room, depth - 1) + static_cast<std::size_t>(room[0]);
}

TEST(LastResort, AStackOverflowWritesTheLastFrames) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer takes the signal";
#endif
  const Wire wire;
  EXPECT_EXIT(die(wire,
                  [] {
                    const rlimit small{.rlim_cur = 1 << 20, .rlim_max = RLIM_INFINITY};
                    setrlimit(RLIMIT_STACK, &small);
                    const char begin = 1;
                    static_cast<void>(recurse(&begin, 1u << 20));
                  }),
              KilledBySignal(SIGSEGV), "ended by SIGSEGV; the drives were commanded");
  EXPECT_EQ(wire.text(), "first second");
}

TEST(LastResort, ABusThatTakesNothingDoesNotKeepTheOthers) {
  const Wire full, wire;
  std::array<char, 4096> junk{};
  while (write(full.words().descriptor, junk.data(), junk.size()) > 0) continue;
  EXPECT_EXIT(
      {
        guard_process();
        const LastResort last({full.words(), {.descriptor = -1, .writes = {"lost"}}, wire.words()});
        std::terminate();
      },
      KilledBySignal(SIGABRT), "the drives were commanded");
  EXPECT_EQ(wire.text(), "first second");
}

TEST(LastResort, NothingElseIsWrittenAfterwards) {
  EXPECT_EXIT(
      {
        static_cast<void>(BusWrite::end());
        _exit(BusWrite().allowed() ? 1 : 0);
      },
      testing::ExitedWithCode(0), "");
}

/// Every signal that ends or suspends a process by default has a fate, except two that cannot be caught.
TEST(StopSignals, EverySignalHasAFate) {
  constexpr std::array harmless{SIGCHLD, SIGCONT, SIGURG, SIGWINCH};
  for (int signal = 1; signal < 32; ++signal) {
    const bool has_fate = std::ranges::count(signal_rows(), signal, &SignalRow::signal) == 1;
    const bool is_free =
        signal == SIGKILL || signal == SIGSTOP || std::ranges::find(harmless, signal) != harmless.end();
    EXPECT_NE(has_fate, is_free) << signal << " " << strsignal(signal);
  }
}

TEST(StopSignals, TheSecondOneInsists) {
  const StopSignals signals(Suspension::stops);
  raise(SIGHUP);
  EXPECT_TRUE(signals.requested());
  EXPECT_FALSE(signals.insisted());
  EXPECT_EQ(signals.name(), "SIGHUP");
  raise(SIGTSTP);
  EXPECT_TRUE(signals.insisted());
  EXPECT_EQ(signals.name(), "SIGHUP") << "the one that came first";
}

/// nohup: the terminal may disappear.
TEST(StopSignals, AHangUpThatWasIgnoredStaysSo) {
  std::signal(SIGHUP, SIG_IGN);
  {
    const StopSignals signals(Suspension::stops);
    raise(SIGHUP);
    EXPECT_FALSE(signals.requested());
  }
  std::signal(SIGHUP, SIG_DFL);
}

/// The last frames are those of Rig::stop(), in the bytes of each kind of bus.
TEST(LastFrames, AreThoseOfStoppingARig) {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/tests/hil/rig.toml");
  ASSERT_TRUE(loaded.scene.has_value());
  std::string error;
  std::vector<std::unique_ptr<LinuxBus>> buses;
  buses.push_back(make_bus(*parse_bus_address("pty", error), {}));
  LinuxLink link(std::move(buses), 1'000'000);
  ASSERT_TRUE(link.bus(0).open());
  const std::vector<LastWords> words = last_words(*loaded.scene->device->rig, 1e-3, link);
  ASSERT_EQ(words.size(), 1u);
  EXPECT_EQ(words[0].descriptor, link.bus(0).descriptor());
  EXPECT_THAT(words[0].writes,
              testing::ElementsAre("\rt20B400000000\r", "\rt20C400000000\r", "\rt00028001\r", "\rt00028002\r",
                                   "\rt0002800B\r", "\rt0002800C\r", "\rt00028015\r"));
  const auto can = make_bus(*parse_bus_address("socketcan:can0", error), {});
  const std::string bytes = can->as_written({.id = 0x20B, .size = 4});
  EXPECT_EQ(bytes.size(), 16u);
  EXPECT_EQ(bytes.substr(0, 5), std::string("\x0B\x02\0\0\x04", 5));
}

}  // namespace
}  // namespace godobject::test_last_resort
