// `godobject run --spacemouse` and a daemon on a socket in the test's own folder, with the messages of
// spacenavd.
#include <gmock/gmock.h>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <functional>
#include <thread>

#include <nlohmann/json.hpp>

#include "platform/linux/device_threads.h"
#include "platform/scene/toml.h"
#include "tests/support/program.h"

namespace godobject::test::test_cli_spacemouse {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Words = std::array<std::int32_t, 8>;

/// Serves one client at a time.
class Daemon {
 public:
  explicit Daemon(std::string path) : path_(std::move(path)) { open(); }
  ~Daemon() { shut(); }

  void open() {
    listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof(address.sun_path) - 1);
    unlink(path_.c_str());
    if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
        listen(listener_, 4) != 0)
      throw std::runtime_error("no socket at " + path_);
  }
  /// Waits for a client, at most 10 s: a program that ends before it connects does not block the test.
  bool accept_one() {
    pollfd waiting{.fd = listener_, .events = POLLIN, .revents = 0};
    if (poll(&waiting, 1, 10'000) == 1) client_ = accept(listener_, nullptr, nullptr);
    return client_ >= 0;
  }
  bool send_bytes(const void* data, std::size_t size) const {
    return send(client_, data, size, MSG_NOSIGNAL) == static_cast<ssize_t>(size);
  }
  bool send_words(const Words& words) const { return send_bytes(words.data(), sizeof(words)); }
  void shut() {
    for (int* const descriptor : {&client_, &listener_})
      if (*descriptor >= 0) close(std::exchange(*descriptor, -1));
  }

 private:
  std::string path_;
  int listener_ = -1, client_ = -1;
};

class CliSpaceMouse : public ProgramTest {
 protected:
  /// Runs the program; `meanwhile` controls the daemon once it has a client. A busy machine stops a program
  /// for 50 ms at times: five periods of 10 ms. A run that is held for it is repeated.
  nlohmann::json run(const std::string& arguments, const std::function<void(Daemon&)>& meanwhile) {
    nlohmann::json report;
    for (int attempt = 0; attempt < 4; ++attempt) {
      Daemon daemon(path("spnav.sock"));
      std::thread far([&] {
        if (daemon.accept_one()) meanwhile(daemon);
      });
      result_ =
          run_program("run sim/scenes/spacemouse.toml --step 0.01 --spacemouse " + path("spnav.sock") + " " +
                      arguments + " --trace " + path("trace.csv") + " --report " + path("report.json"));
      far.join();
      report = nlohmann::json::parse(read_file(path("report.json")), nullptr, false);
      if (!report.is_object()) throw std::runtime_error("no report: " + result_.output);
      if (report["timing"]["holds"] == 0) break;
    }
    return report;
  }
  /// Returns the last x of the ball.
  double last_x() const {
    const std::string text = read_file(path("trace.csv"));
    const std::string row = text.substr(text.rfind('\n', text.size() - 2) + 1);
    return std::stod(row.substr(row.find(',') + 1));
  }

  ProgramResult result_;
};

TEST_F(CliSpaceMouse, LeadsTheToolToTheWallAndNoFurther) {
  const nlohmann::json report = run("--duration 3", [](Daemon& daemon) {
    for (int i = 0; i < 60; ++i) {  // 0.1 m/s to the right: 65 mm to the wall
      std::this_thread::sleep_for(16ms);
      if (!daemon.send_words({0, 350, 0, 0, 0, 0, 0, 16})) return;
    }
    static_cast<void>(daemon.send_words({0}));
    std::this_thread::sleep_for(1500ms);
  });
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_EQ(report["mode"], "realtime");
  EXPECT_GT(report["spacemouse"]["events"], 50);
  EXPECT_EQ(report["spacemouse"]["malformed"], 0);
  EXPECT_NEAR(last_x(), 0.065, 0.003) << "the wall is at 80 mm, the ball's radius is 15 mm";
  EXPECT_THAT(result_.output, HasSubstr("spacemouse"));
}

TEST_F(CliSpaceMouse, ADaemonThatEndsIsReportedAndMayReturn) {
  const nlohmann::json report = run("--duration 5", [](Daemon& daemon) {
    static_cast<void>(daemon.send_words({0, 100}));
    std::this_thread::sleep_for(300ms);
    daemon.shut();
    std::this_thread::sleep_for(500ms);
    daemon.open();
    if (!daemon.accept_one()) return;
    std::this_thread::sleep_for(200ms);
    const Words motion{0, 0, 200};
    static_cast<void>(daemon.send_bytes(motion.data(), 20));  // in two pieces
    std::this_thread::sleep_for(50ms);
    static_cast<void>(daemon.send_bytes(motion.data() + 5, 12));
    std::this_thread::sleep_for(300ms);
  });
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_THAT(result_.output, HasSubstr("the daemon has closed the connection: the target rests"));
  EXPECT_THAT(result_.output, HasSubstr("the daemon is back"));
  EXPECT_EQ(report["spacemouse"]["connections"], 2);
  EXPECT_EQ(report["spacemouse"]["events"], 2);
}

TEST_F(CliSpaceMouse, WhatIsNoEventEndsTheConnection) {
  const nlohmann::json report = run("--duration 1", [](Daemon& daemon) {
    static_cast<void>(daemon.send_words({0, 0x7fffffff}));
    std::this_thread::sleep_for(1500ms);
  });
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_THAT(result_.output, HasSubstr("the received bytes are no event of spacenavd"));
  EXPECT_EQ(report["spacemouse"]["malformed"], 1);
}

TEST_F(CliSpaceMouse, SaysWhatToInstallWhereThereIsNoDaemon) {
  const ProgramResult result =
      run_program("run sim/scenes/spacemouse.toml --spacemouse " + path("none.sock"));
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.output, HasSubstr("apt-get install spacenavd"));
  EXPECT_THAT(result.output, HasSubstr(path("none.sock")));
  const ProgramResult of_environment =
      run_program("run sim/scenes/spacemouse.toml --spacemouse", "SPNAV_SOCKET=" + path("other.sock") + " ");
  EXPECT_EQ(of_environment.exit_code, 3);
  EXPECT_THAT(of_environment.output, HasSubstr(path("other.sock")));
}

TEST_F(CliSpaceMouse, ConflictingOptionsAreReported) {
  for (const auto& [arguments, word] :
       {std::pair{"sim/scenes/wall.toml --spacemouse", "add [device.spacemouse]"},
        std::pair{"sim/scenes/spacemouse.toml --spacemouse --fast", "remove --fast"},
        std::pair{"sim/scenes/spacemouse.toml --spacemouse --view --view-input",
                  "excludes --view-input, since both move the tool: remove either"}}) {
    const ProgramResult result = run_program(std::string("run ") + arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.output, HasSubstr(word));
  }
}

/// Random bytes in random pieces: the loop is not affected, and accepted events are counted.
TEST_F(CliSpaceMouse, SurvivesADaemonThatTalksNonsense) {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/spacemouse.toml");
  lead_by_spacemouse(*loaded.scene);
  SpaceMouse mouse(*loaded.scene, []() noexcept { return MonotonicClock{}.now(); });
  Daemon daemon(path("spnav.sock"));
  std::string why_not;
  std::atomic<int> num_lines{0};
  const auto thread = SpaceMouseThread::start(
      path("spnav.sock"), mouse, [&](const std::string&) { ++num_lines; }, why_not);
  ASSERT_TRUE(thread) << why_not;
  ASSERT_TRUE(daemon.accept_one());
  std::srand(1);
  for (int i = 0; i < 200; ++i) {
    std::array<std::uint8_t, 100> bytes{};
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(std::rand() % 3);
    if (!daemon.send_bytes(bytes.data(), static_cast<std::size_t>(std::rand() % 100))) break;
    std::this_thread::sleep_for(1ms);
  }
  std::this_thread::sleep_for(100ms);
  EXPECT_FALSE(thread->counters().connected);
  EXPECT_EQ(thread->counters().malformed, 1u);
  EXPECT_EQ(num_lines, 1);
}

}  // namespace
}  // namespace godobject::test::test_cli_spacemouse
