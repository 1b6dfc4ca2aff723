#include "platform/cli/run/options.h"
#include "platform/linux/device_threads.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include "hal/base/crc16.h"
#include "sim/tracker/ndi.h"
#include "tests/support/loopback_server.h"
#include "tests/support/tracker_thread.h"

namespace godobject::test_tracker_thread {
namespace {

using test::LoopbackServer;
using test::read_until;

/// The far end of a pseudo-terminal with a scripted tracker: a wired tool that is always visible.
class FarEnd {
 public:
  FarEnd() {
    EXPECT_EQ(openpty(&master_, &slave_, nullptr, nullptr, nullptr), 0);
    std::array<char, 128> name{};
    EXPECT_EQ(ttyname_r(slave_, name.data(), name.size()), 0);
    path_ = name.data();
    EXPECT_EQ(fcntl(master_, F_SETFL, O_NONBLOCK), 0);
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  ~FarEnd() { hang_up(); }

  void hang_up() {
    thread_ = {};
    if (master_ >= 0) close(master_);
    if (slave_ >= 0) close(slave_);
    master_ = slave_ = -1;
  }
  const std::string& path() const { return path_; }

 private:
  void answer(const std::string& command) {
    std::string reply = "OKAY";
    if (command.starts_with("PHSR:01")) reply = "00";
    if (command.starts_with("PHSR:02")) reply = initialised_ ? "00" : "010A001";
    if (command.starts_with("PINIT")) initialised_ = true;
    if (command.starts_with("PHSR:03")) reply = "010A011";
    if (command.starts_with("PHINF")) reply = "01000001Traxtal Tech0013211140231";
    if (command.starts_with("BX")) reply = "ERROR01";
    if (command.starts_with("TX")) {
      std::array<char, 80> text{};
      std::snprintf(text.data(), text.size(),
                    "010A+07138+05131+04024+02550+011455+002063-073118+0156500000031%08X\n0000", ++frame_);
      reply = text.data();
    }
    send(reply);
  }

  void send(std::string reply) {
    const std::vector<std::uint8_t> bytes(reply.begin(), reply.end());
    std::array<char, 6> crc{};
    std::snprintf(crc.data(), crc.size(), "%04X\r", unsigned{crc16<crc16_arc>(bytes)});
    reply += crc.data();
    EXPECT_EQ(write(master_, reply.data(), reply.size()), static_cast<ssize_t>(reply.size()));
  }

  /// A pseudo-terminal carries no break, so it is assumed until there is a command.
  void run(const std::stop_token& stop) {
    std::string command;
    int idle = 0;
    while (!stop.stop_requested()) {
      char c = 0;
      if (read(master_, &c, 1) != 1) {
        usleep(500);
        if (++idle % 200 == 0 && !spoken_to_) send("RESET");
      } else if (c == '\r') {
        spoken_to_ = true;
        answer(command);
        command.clear();
      } else {
        command += c;
      }
    }
  }

  int master_ = -1, slave_ = -1;
  std::string path_;
  bool initialised_ = false, spoken_to_ = false;
  unsigned frame_ = 0;
  std::jthread thread_;
};

std::unique_ptr<TrackerThread> start(const std::string& path) {
  TrackerParams params;
  params.name = "polaris";
  params.port = path;
  params.tools.push_back({.body = "tool", .tool = "0A", .X_TH = {}});
  return std::make_unique<TrackerThread>(make_tracker(params, {}).tracker);
}

TEST(TrackerThread, PosesComeOverAPseudoTerminal) {
  FarEnd far;
  const auto thread = start(far.path());
  TrackerReport report;
  ASSERT_TRUE(read_until(*thread, report, [&] { return report.tools[0].number > 20; })) << report.text.data();
  EXPECT_EQ(report.state, TrackerState::tracking);
  EXPECT_EQ(report.tools[0].state, ToolState::valid);
  EXPECT_NEAR(report.tools[0].X_TH.p.x(), 0.11455, 1e-9);
  EXPECT_EQ(report.counters.bad_crc, 0u);
  const Nanoseconds now = MonotonicClock().now();
  EXPECT_LE(report.tools[0].t_ns, now);
  EXPECT_GT(report.tools[0].t_ns, now - 10'000'000'000);
}

TEST(TrackerThread, UnpluggedIsAStateAndThePortIsOpenedAgain) {
  auto far = std::make_unique<FarEnd>();
  // A name that stays while its target disappears and returns, as /dev/serial/by-id does.
  const std::string link = testing::TempDir() + "tracker_thread_port_" + std::to_string(getpid());
  unlink(link.c_str());
  ASSERT_EQ(symlink(far->path().c_str(), link.c_str()), 0);
  const auto thread = start(link);
  TrackerReport report;
  ASSERT_TRUE(read_until(*thread, report, [&] { return report.state == TrackerState::tracking; }));
  far->hang_up();
  ASSERT_TRUE(read_until(*thread, report, [&] { return report.state == TrackerState::opening; }));
  EXPECT_EQ(report.tools[0].state, ToolState::stale);
  EXPECT_GT(std::string(report.text.data()).size(), 10u);
  far = std::make_unique<FarEnd>();
  unlink(link.c_str());
  ASSERT_EQ(symlink(far->path().c_str(), link.c_str()), 0);
  EXPECT_TRUE(read_until(*thread, report, [&] { return report.tools[0].state == ToolState::valid; }))
      << report.text.data();
  unlink(link.c_str());
}

TEST(TrackerThread, AVegaIsReadOverTcp) {
  TrackerParams params;
  params.name = "vega";
  params.tools.push_back({.body = "tool", .tool = "0A", .X_TH = {}});
  const Pose pose{.p = Vec3(0.1, -0.2, -1.5), .q = Quat(0.5, 0.5, -0.5, 0.5)};
  std::atomic<bool> ends = false;
  const LoopbackServer server([&](int client) {
    const MonotonicClock clock;
    SimNdi vega(params, 250, 1);
    vega.set_bx2(true);
    vega.set_pose(0, pose);
    std::array<std::uint8_t, 512> bytes{};
    pollfd waiting{.fd = client, .events = POLLIN, .revents = 0};
    while (!ends) {
      const bool readable = poll(&waiting, 1, 1) > 0;
      const Nanoseconds now = clock.now();
      vega.advance(now);
      if (readable) {
        const ssize_t size = recv(client, bytes.data(), bytes.size(), 0);
        if (size <= 0) return;
        vega.receive(std::span(bytes).first(static_cast<std::size_t>(size)), now);
      }
      while (const std::size_t size = vega.transmit(bytes, now))
        static_cast<void>(send(client, bytes.data(), size, MSG_NOSIGNAL));
    }
  });
  params.port = server.address();
  auto thread = std::make_unique<TrackerThread>(make_tracker(params, {{}}).tracker);
  TrackerReport report;
  EXPECT_TRUE(read_until(*thread, report, [&] { return report.tools[0].number > 50; })) << report.text.data();
  EXPECT_EQ(report.tools[0].state, ToolState::valid);
  EXPECT_LT((report.tools[0].X_TH.p - pose.p).norm(), 1e-6);
  EXPECT_EQ(report.counters.malformed + report.counters.bad_crc, 0u);
  const Nanoseconds now = MonotonicClock().now();
  EXPECT_LE(report.tools[0].t_ns, now);
  EXPECT_GT(report.tools[0].t_ns, now - 10'000'000'000);  // by this clock, not by the tracker's
  ends = true;                                            // the connection is lost, and made again
  EXPECT_TRUE(read_until(*thread, report, [&] { return report.state == TrackerState::opening; }));
  ends = false;
  EXPECT_TRUE(read_until(*thread, report, [&] { return report.tools[0].state == ToolState::valid; }))
      << report.text.data();
  thread.reset();
  ends = true;
}

TEST(TrackerThread, APortThatIsNotThereSaysSo) {
  const auto thread = start("/dev/no-such-tracker");
  TrackerReport report;
  ASSERT_TRUE(read_until(*thread, report, [&] { return report.text[0] != '\0'; }));
  EXPECT_EQ(report.state, TrackerState::opening);
  EXPECT_NE(std::string(report.text.data()).find("/dev/no-such-tracker"), std::string::npos);
}

TEST(ToolDefinitions, FilesAreNamedWhenTheyAreNotThatOrNotThere) {
  TrackerParams params;
  params.name = "polaris";
  for (const char* const tool : {"0A", "none.rom", "hal/tracker/params.h"})
    params.tools.push_back({.body = "tool", .tool = tool, .X_TH = {}});
  std::vector<std::string> errors;
  static_cast<void>(read_tool_definitions(params, GODOBJECT_SOURCE_DIR, errors));
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_NE(errors[0].find("none.rom"), std::string::npos);
  EXPECT_NE(errors[1].find("tracker/params.h"), std::string::npos);
}

}  // namespace
}  // namespace godobject::test_tracker_thread
