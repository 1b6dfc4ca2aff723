// The loop's thread makes no system call but those of docs/threads.md, no call of the heap, and no page
// fault. This holds in simulated time, and in real time on each kind of device with every output beside it.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "platform/cli/report/files.h"
#include "platform/cli/run/loop.h"
#include "platform/linux/socket_device.h"
#include "platform/rt/seal.h"
#include "platform/rt/signals.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/run_over_ptys.h"
#include "tests/support/sealed_run.h"

namespace godobject::test::test_sealed_loop {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

Session::Made session_of(const char* file, BusChoice bus) {
  const LoadResult loaded = load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + file);
  return make_session(*loaded.scene, Motion(*loaded.scene), bus);
}

TEST(Seal, ItsTableIsThatOfThePage) {
  std::string expected = "| made for | calls |\n|---|---|";
  std::string_view purpose;
  for (const LoopCall& call : loop_calls()) {
    if (call.purpose != purpose)
      expected += (purpose.empty() ? "\n| " : " |\n| ") + std::string(call.purpose) + " |";
    purpose = call.purpose;
    expected += " `" + std::string(call.name) + "`";
  }
  expected += " |\n";
  EXPECT_THAT(read_file(GODOBJECT_SOURCE_DIR "/docs/threads.md"), HasSubstr(expected));
}

// ---- simulated time ------------------------------------------------------------------------------

struct SealedRun {
  const char* scene;
  BusChoice bus;
  std::uint64_t num_cycles;
};

class SealedCycles : public testing::TestWithParam<SealedRun> {};

TEST_P(SealedCycles, CallNothingAndFaultNoPage) {
  if (const std::string reason = why_not_sealed(); !reason.empty()) GTEST_SKIP() << reason;
  const RtProcess process;
  const bool is_locked = process.steps()[1].result == RtResult::ok;
  Session::Made made = session_of(GetParam().scene, GetParam().bus);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  made.session->start(5);
  Ring<CycleEntry> cycles(4096, entry_of(*made.session));
  const std::atomic<bool> stop{false};
  const auto cycle = std::make_unique<RealtimeCycle>(
      *made.session, RunPlan{.num_cycles = GetParam().num_cycles, .seal = true}, stop, cycles);
  Seal seal;
  std::atomic<bool> ended{false};
  std::string called;
  std::thread loop([&] {
    const ThreadSetup setup("loop");
    EXPECT_EQ(seal.close().result, RtResult::ok);
    {
      AllocationGuard guard;
      while ((*cycle)(Wake{})) continue;
      guard.disarm();
      cycle->thread_ends();
      seal.loop_ended();
      if (guard.calls() > 0) called = guard.report();
    }
    ended = true;
  });
  CycleEntry taken = entry_of(*made.session);
  while (!ended) {
    while (cycles.try_pop(taken)) continue;
    std::this_thread::sleep_for(1ms);
  }
  loop.join();
  EXPECT_EQ(seal.text(), "");
  EXPECT_EQ(seal.num_refused(), 0u);
  EXPECT_EQ(called, "");
  EXPECT_EQ(cycle->statistics().cycles, GetParam().num_cycles);
  ASSERT_TRUE(cycle->page_faults().has_value());
  if (is_locked) {
    EXPECT_EQ(cycle->page_faults()->minor, 0);
    EXPECT_EQ(cycle->page_faults()->major, 0);
    EXPECT_EQ(cycle->first_page_fault().value_or(0), 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, SealedCycles,
                         testing::Values(SealedRun{"rigid.toml", BusChoice::direct, 1'000'000},
                                         SealedRun{"grasper.toml", BusChoice::sim, 100'000},
                                         SealedRun{"tracked.toml", BusChoice::sim, 20'000},
                                         SealedRun{"endobag.toml", BusChoice::direct, 2'000}));

// ---- a planted call --------------------------------------------------------------------------------

/// A user's device that makes a forbidden call in its 200th period.
class Planted final : public HandDevice {
 public:
  explicit Planted(void (*call)()) : call_(call) {}
  void read(Period&, std::span<BodySample>) noexcept override {
    if (++periods_ == 200) call_();
  }

 private:
  void (*call_)();
  int periods_ = 0;
};

struct Plant {
  const char* name;
  void (*call)();
};

class SealedRunWith : public testing::TestWithParam<Plant> {};

TEST_P(SealedRunWith, AForbiddenCallIsNamedAndStopsTheMotors) {
  if (const std::string reason = why_not_sealed(); !reason.empty()) GTEST_SKIP() << reason;
  Session::Made made = session_of("grasper.toml", BusChoice::sim);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  Planted planted(GetParam().call);
  made.session->add(planted);
  const std::string log = testing::TempDir() + "seal-" + GetParam().name + ".godo";
  RunFileNames names;
  names.on_fault = log;
  RunFiles files(names, made.session->scene(), 0);
  const std::optional<RunResult> result =
      run_realtime(*made.session, {.num_cycles = 5000, .quiet = true, .seal = true}, files, nullptr);
  ASSERT_TRUE(result.has_value());
  EXPECT_THAT(result->seal_broken, HasSubstr("the loop called " + std::string(GetParam().name) + " ("));
  EXPECT_THAT(result->seal_broken, HasSubstr("), which the seal refuses"));
  EXPECT_GE(result->refused_calls, 1u);
  EXPECT_LT(result->statistics.cycles, 300u);
  EXPECT_TRUE(files.close().empty());
  ASSERT_EQ(files.fault_files().size(), 1u);
  const ProgramResult again = run_program("replay " + log);
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_THAT(again.output, HasSubstr("identical"));
  std::filesystem::remove(log);
  EXPECT_EQ(made.session->phase(), RunPhase::ended);
  const auto event = std::ranges::find(result->events, "seal_broken", &RunEvent::name);
  ASSERT_NE(event, result->events.end());
  EXPECT_TRUE(is_fault(event->kind));
  EXPECT_THAT(event->cause, HasSubstr(GetParam().name));
  EXPECT_NE(std::ranges::find(result->events, RunEventKind::quick_stop, &RunEvent::kind),
            result->events.end());
}

INSTANTIATE_TEST_SUITE_P(
    Calls, SealedRunWith,
    testing::Values(Plant{"openat", [] { static_cast<void>(!open("/dev/null", O_RDONLY | O_CLOEXEC)); }},
                    Plant{"nanosleep",
                          [] {
                            const timespec shortly{.tv_sec = 0, .tv_nsec = 1};
                            static_cast<void>(syscall(SYS_nanosleep, &shortly, nullptr));
                          }},
                    Plant{"futex",  // the wait for a lock that another thread holds
                          [] {
                            static int taken = 1;
                            static_cast<void>(
                                syscall(SYS_futex, &taken, FUTEX_WAIT_PRIVATE, 1, nullptr, nullptr, 0));
                          }}),
    [](const auto& plant) { return plant.param.name; });

TEST(SealedRun, NamesTheFirstCycleWithAPageFault) {
  if (const std::string reason = why_not_sealed(); !reason.empty()) GTEST_SKIP() << reason;
  Session::Made made = session_of("rigid.toml", BusChoice::sim);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  static volatile char* page = nullptr;
  page = static_cast<volatile char*>(
      mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  Planted planted([] {
    constexpr int dont_need_locked = 24;  // MADV_DONTNEED_LOCKED, Linux 5.18
    if (madvise(const_cast<char*>(page), 4096, dont_need_locked) == 0) *page = 1;
  });
  made.session->add(planted);
  RunFiles files({}, made.session->scene(), 0);
  const std::optional<RunResult> result =
      run_realtime(*made.session, {.num_cycles = 400, .quiet = true, .seal = true}, files, nullptr);
  ASSERT_TRUE(result.has_value());
  ASSERT_TRUE(result->first_page_fault.has_value()) << "MADV_DONTNEED_LOCKED needs Linux 5.18";
  const auto lock = std::ranges::find(result->setup, "lock memory", &RtStep::name);
  if (lock->result == RtResult::ok) {
    EXPECT_EQ(*result->first_page_fault, 200u);
  }
}

// ---- real time -------------------------------------------------------------------------------------

class SealedProgram : public ProgramTest {
 protected:
  void SetUp() override {
    if (const std::string reason = why_not_sealed(); !reason.empty()) GTEST_SKIP() << reason;
  }
  /// Runs with every output. record: name of the record, whose ending gives its kind.
  void run_sealed(const std::string& scene_and_device, const char* record) {
    const int seconds = sealed_seconds(3);
    const ProgramResult result = run_program(
        "run " + scene_and_device + " --seal --view --duration " + std::to_string(seconds) + " --trace " +
        path("trace.csv") + " --record " + path(record) + " --report " + path("report.json"));
    expect_sealed(path("report.json"), seconds, 1e-3, guard_, result.output);
  }

  const LoopGuard guard_{path("calls.txt")};
};

TEST_F(SealedProgram, OnASimulatedDeviceWithEveryOutput) { run_sealed("sim/scenes/grasper.toml", "bus.log"); }

TEST_F(SealedProgram, OnATrackerOfAPseudoTerminalWithEveryOutput) {
  BackgroundProgram far({"simulate", "sim/scenes/tracked.toml", "--control", "-"});
  const std::string first = far.line();
  ASSERT_EQ(far.line(), "ready");
  run_sealed("sim/scenes/tracked.toml --tracker polaris=" + first.substr(first.find('/')), "inputs.godo");
}

TEST_F(SealedProgram, OnAProgramThatConnectsAgain) {
  const std::string socket_path = path("device.sock");
  BackgroundProgram host({"run", "sim/scenes/wall.toml", "--device", socket_path, "--duration", "3", "--seal",
                          "--report", path("report.json")});
  std::uint32_t number = 0;
  const auto end = std::chrono::steady_clock::now() + 2500ms;
  for (int connection = -1, sent = 0; std::chrono::steady_clock::now() < end;) {
    std::this_thread::sleep_for(1ms);
    if (connection < 0) {
      connection = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
      sockaddr_un address{};
      address.sun_family = AF_UNIX;
      std::memcpy(address.sun_path, socket_path.c_str(), socket_path.size());
      number = 0;
      if (connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) continue;
    } else {
      PosePacket pose{.number = ++number};
      pose.t_s = 1e-9 * static_cast<double>(MonotonicClock{}.now());
      static_cast<void>(send(connection, &pose, sizeof pose, MSG_NOSIGNAL));
      if (++sent % 500 != 0) continue;
    }
    close(connection);
    connection = -1;
  }
  static_cast<void>(host.wait_status());
  expect_sealed(path("report.json"), 3, 1e-3, guard_);
  const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")), nullptr, false);
  EXPECT_GE(report["device_program"]["connections"], 2);
}

class SealedOnSlcan : public RunOverPtys {
 protected:
  void hear(const CanFrame&) override {}
};

TEST_F(SealedOnSlcan, WithTraceRecordAndView) {
  if (const std::string reason = why_not_sealed(); !reason.empty()) GTEST_SKIP() << reason;
  const LoopGuard guard(path("calls.txt"));
  const double step = 5e-3;  // of the scene
  const int seconds = sealed_seconds(5, step);
  ASSERT_TRUE(start(write("scene.toml", patient_toml()),
                    {"--seal", "--view", "--trace", path("trace.csv"), "--record", path("bus.log"),
                     "--report", path("report.json")},
                    seconds));
  listen(std::chrono::seconds(seconds));
  static_cast<void>(host_->wait_status());
  expect_sealed(path("report.json"), seconds, step, guard);
}

}  // namespace
}  // namespace godobject::test::test_sealed_loop
