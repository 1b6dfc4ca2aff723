// A program on a local socket as the device: its poses within limits, its silence, packets that are none, and
// the wrench that it receives.
#include "platform/linux/socket_device.h"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <vector>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_socket_device {
namespace {

constexpr Nanoseconds ms = 1'000'000;
Nanoseconds now_ns = 0;

int connect_to(const std::string& path) {
  const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  close(fd);
  return -1;
}

/// The user's program: one end of the socket.
class Program {
 public:
  explicit Program(const std::string& path) : fd_(connect_to(path)) {}
  ~Program() { disconnect(); }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void disconnect() {
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
  }
  bool is_connected() const { return fd_ >= 0; }
  PosePacket packet(const Vec3& p_W) {
    return {.number = ++number_,
            .t_s = 1e-9 * static_cast<double>(now_ns),
            .p_WD_m = {p_W.x(), p_W.y(), p_W.z()}};
  }
  template <class Packet>
  void send(const Packet& packet, std::size_t size = sizeof(Packet)) {
    EXPECT_EQ(::send(fd_, &packet, size, MSG_NOSIGNAL), static_cast<ssize_t>(size));
  }
  /// Returns the wrenches that have arrived, oldest first.
  std::vector<WrenchPacket> receive() {
    std::vector<WrenchPacket> all;
    for (WrenchPacket packet; recv(fd_, &packet, sizeof packet, 0) == sizeof packet;) all.push_back(packet);
    return all;
  }

 private:
  int fd_;
  std::uint32_t number_ = 0;
};

SceneConfig wall() {
  SceneConfig scene = *load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/wall.toml").scene;
  scene.motion.reset();
  return scene;
}

/// A session with a program as its device, and a clock of the test's own.
class SocketDeviceTest : public testing::Test {
 protected:
  void SetUp() override {
    now_ns = 1'000 * ms;
    path_ = testing::TempDir() + "device" + std::to_string(getpid()) + ".sock";
    device_.emplace(scene_, []() noexcept { return now_ns; });
    ASSERT_EQ(device_->open(path_), "");
    made_ = make_session(scene_, Motion(scene_), BusChoice::direct);
    ASSERT_TRUE(made_.session) << made_.errors.front();
    made_.session->add(*device_);
    made_.session->start(1);
    record_ = made_.session->at_start();
    program_.emplace(path_);
    ASSERT_TRUE(program_->is_connected());
  }
  void TearDown() override {
    made_.session.reset();
    device_.reset();
    EXPECT_FALSE(std::filesystem::exists(path_));
  }

  void step() {
    now_ns += ms;
    ASSERT_TRUE(made_.session->advance(record_));
    if (has(record_.limited, Limited::held)) ++periods_held_;
  }
  /// Runs periods in which the program sends the pose p_W(t), t: time of this call, s.
  template <class Path>
  void follow(int periods, Path&& p_W) {
    for (int i = 0; i < periods; ++i) {
      program_->send(program_->packet(p_W(1e-3 * i)));
      step();
      for (const WrenchPacket& packet : program_->receive()) newest_ = packet;
    }
  }
  void rest(int periods, const Vec3& p_W) {
    follow(periods, [&](double) { return p_W; });
  }
  /// Presses the peg 30 mm into the wall.
  void press() {
    rest(50, start());
    follow(1000, [&](double t) { return Vec3(start() + Vec3(0.095 * std::min(2 * t, 1.0), 0, 0)); });
  }
  Vec3 target() const { return record_.bodies[0].target.X_WD.p; }
  Vec3 start() const { return scene_.bodies[0].X_WB.p; }

  SceneConfig scene_ = wall();
  std::string path_;
  std::optional<SocketDevice> device_;
  Session::Made made_;
  CycleRecord record_;
  std::optional<Program> program_;
  WrenchPacket newest_;
  int periods_held_ = 0;
};

TEST_F(SocketDeviceTest, TheTargetFollowsTheProgramAFewMillisecondsLater) {
  const auto path = [&](double t) { return Vec3(start() + Vec3(0, 0.02 * std::sin(6 * t), 0)); };
  rest(100, start());
  for (int i = 0; i < 1000; ++i) {
    follow(1, [&](double) { return path(1e-3 * i); });
    if (i > 20) {
      EXPECT_LT((target() - path(1e-3 * i)).norm(), 0.12 * 5e-3) << i;  // speed times 5 ms
    }
  }
  EXPECT_EQ(device_->counters().samples, 1100u);
  EXPECT_EQ(device_->counters().malformed + device_->counters().late, 0u);
  EXPECT_EQ(newest_.number, 1100u);
}

TEST_F(SocketDeviceTest, TheWrenchIsThatOfTheStep) {
  press();
  const Wrench& F = made_.session->engine().feedback(0);
  EXPECT_LT(F.f.x(), -1);  // the wall pushes back
  EXPECT_EQ(Vec3(newest_.f_W_N[0], newest_.f_W_N[1], newest_.f_W_N[2]), F.f);
  EXPECT_EQ(Vec3(newest_.tau_W_Nm[0], newest_.tau_W_Nm[1], newest_.tau_W_Nm[2]), F.tau);
  EXPECT_EQ(newest_.flags, WrenchPacket::live);
}

TEST_F(SocketDeviceTest, NothingIsEngagedBeforeTheFirstPoses) {
  for (int i = 0; i < 100; ++i) step();
  EXPECT_FALSE(record_.engaged);
  EXPECT_LT((record_.bodies[0].X_WB.p - start()).norm(), 0.05);
  rest(100, start());
  EXPECT_TRUE(record_.engaged);
}

TEST_F(SocketDeviceTest, ASilentProgramIsHeldAndItsForceFades) {
  press();
  periods_held_ = 0;
  for (int i = 0; i < 45; ++i) step();
  EXPECT_EQ(periods_held_, 0);
  for (int i = 0; i < 1000; ++i) step();
  EXPECT_GT(periods_held_, 990);
  const auto wrenches = program_->receive();
  ASSERT_FALSE(wrenches.empty());
  EXPECT_LT((Vec3(made_.session->engine().feedback(0).f)).norm(), 1e-9);
}

TEST_F(SocketDeviceTest, WhatIsNoPoseIsRefusedAndCounted) {
  rest(100, start());
  const Vec3 before = target();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   inf = std::numeric_limits<double>::infinity();
  std::vector<PosePacket> wrong;
  const auto add = [&](auto&& change) {
    PosePacket packet = program_->packet(start() + Vec3(1, 1, 1));
    change(packet);
    wrong.push_back(packet);
  };
  for (const double x : {nan, inf, -inf, 101.0, 1e300}) add([&](PosePacket& p) { p.p_WD_m[1] = x; });
  for (const double x : {nan, inf, 0.0, 1.01}) add([&](PosePacket& p) { p.q_WD_wxyz = {x, 0, 0, 0}; });
  for (const double x : {nan, inf, 1e9}) add([&](PosePacket& p) { p.t_s = x; });
  add([](PosePacket& p) { p.magic = 0; });
  add([](PosePacket& p) { p.number = 1; });  // not newer
  add([](PosePacket& p) { p.number = 0; });
  for (const PosePacket& packet : wrong) program_->send(packet);
  program_->send(wrong.front(), 79);
  program_->send(std::array<char, 200>{});
  step();
  EXPECT_EQ(device_->counters().malformed, wrong.size() + 2);
  EXPECT_EQ(device_->counters().samples, 100u);
  EXPECT_LT((target() - before).norm(), 1e-12);

  PosePacket old = program_->packet(start());
  old.t_s -= 0.06;
  program_->send(old);
  step();
  EXPECT_EQ(device_->counters().late, 1u);
  rest(20, start());  // and goes on
  EXPECT_EQ(device_->counters().samples, 120u);
}

TEST_F(SocketDeviceTest, RandomBytesMoveNothing) {
  std::mt19937 random(7);
  rest(100, start());
  for (int i = 0; i < 2000; ++i) {
    std::array<std::uint32_t, 30> bytes{};
    for (std::uint32_t& word : bytes) word = static_cast<std::uint32_t>(random());
    if (i % 2 == 0) bytes[0] = PosePacket::magic_of_poses;
    program_->send(bytes, i % 2 == 0 ? sizeof(PosePacket) : random() % sizeof bytes + 1);
    if (i % 8 == 0) rest(1, start());
  }
  step();
  EXPECT_LT((target() - start()).norm(), 1e-3);
  EXPECT_EQ(device_->counters().samples + device_->counters().malformed + device_->counters().late,
            100u + 2250);
}

TEST_F(SocketDeviceTest, AJumpIsWalkedAtTheLimitOfSpeed) {
  rest(100, start());
  const Vec3 far = start() + Vec3(0, 1, 0);
  Vec3 last = target();
  for (int i = 0; i < 600; ++i) {
    rest(1, far);
    EXPECT_LE((target() - last).norm(), SocketDevice::max_speed * 1e-3 * (1 + 1e-9)) << i;
    last = target();
  }
  EXPECT_LT((target() - far).norm(), 1e-9);
}

TEST_F(SocketDeviceTest, OneProgramAtATime) {
  rest(50, start());
  Program second(path_);
  step();
  EXPECT_EQ(device_->counters().refused, 1u);
  rest(50, start());
  EXPECT_TRUE(record_.engaged);
  program_->disconnect();
  step();
  step();
  EXPECT_FALSE(device_->counters().connected);
  EXPECT_TRUE(has(record_.limited, Limited::held));
  program_.emplace(path_);
  rest(200, start());
  EXPECT_EQ(device_->counters().connections, 2u);
  EXPECT_FALSE(has(record_.limited, Limited::held));
}

TEST_F(SocketDeviceTest, AProgramThatDoesNotReadGetsNoOldWrenches) {
  rest(50, start());
  for (int i = 0; i < 500; ++i) {
    program_->send(program_->packet(start()));
    step();
  }
  EXPECT_GT(device_->counters().not_sent, 400u);
  EXPECT_EQ(device_->counters().samples, 550u);
  EXPECT_LT(program_->receive().size(), 32u);
  rest(10, start());
  EXPECT_EQ(newest_.number, 560u);
}

TEST_F(SocketDeviceTest, AfterTroubleNoForceIsDisplayed) {
  press();
  device_->tell(RunTrouble::energy_gained);
  rest(10, start() + Vec3(0.095, 0, 0));
  EXPECT_EQ(newest_.flags, 0u);
  EXPECT_EQ(newest_.f_W_N, (std::array<double, 3>{}));
  device_->restart();
  rest(10, start() + Vec3(0.095, 0, 0));
  EXPECT_EQ(newest_.flags, WrenchPacket::live);
  EXPECT_LT(newest_.f_W_N[0], -1);
}

TEST_F(SocketDeviceTest, TheLastWrenchIsZero) {
  press();
  EXPECT_LT(newest_.f_W_N[0], -1);
  made_.session.reset();
  device_.reset();
  const auto last = program_->receive();
  ASSERT_EQ(last.size(), 1u);
  EXPECT_EQ(last.front().flags, 0u);
  EXPECT_EQ(last.front().f_W_N, (std::array<double, 3>{}));
}

TEST_F(SocketDeviceTest, TheForceRunsDownAtTheEnd) {
  press();
  made_.session->stop();
  std::vector<double> force{newest_.f_W_N[0]};
  int periods = 0;
  for (; made_.session->phase() != RunPhase::ended; ++periods) {
    ASSERT_LT(periods, 100);
    now_ns += ms;
    EXPECT_FALSE(made_.session->advance(record_));
    for (const WrenchPacket& packet : program_->receive()) {
      force.push_back(packet.f_W_N[0]);
      newest_ = packet;
    }
  }
  EXPECT_LT(force.front(), -1);
  EXPECT_EQ(force.size(), 51u);
  for (std::size_t i = 1; i < force.size(); ++i)
    EXPECT_NEAR(force[i] - force[i - 1], -force.front() / 50, 1e-9) << i;
  EXPECT_EQ(newest_.f_W_N, (std::array<double, 3>{}));
  EXPECT_EQ(newest_.flags, 0u);
}

TEST_F(SocketDeviceTest, AQuickStopCutsTheForceAtOnce) {
  press();
  made_.session->quick_stop();
  now_ns += ms;
  EXPECT_FALSE(made_.session->advance(record_));
  const auto wrenches = program_->receive();
  ASSERT_EQ(wrenches.size(), 1u);
  EXPECT_EQ(wrenches.front().f_W_N, (std::array<double, 3>{}));
  EXPECT_EQ(wrenches.front().flags, 0u);
}

TEST_F(SocketDeviceTest, TheLoopDoesNotAllocate) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has the heap";
  rest(50, start());
  std::string calls;
  for (int i = 0; i < 50; ++i) {
    program_->send(program_->packet(start()));
    AllocationGuard guard;
    now_ns += ms;
    static_cast<void>(made_.session->advance(record_));
    calls += guard.report();
  }
  EXPECT_THAT(calls, testing::Not(testing::ContainsRegex("alloc|free|mutex|sleep"))) << calls;
}

TEST(SocketOfADevice, IsReplacedOnlyIfNobodyListens) {
  const std::string path = testing::TempDir() + "left" + std::to_string(getpid()) + ".sock";
  const auto clock = []() noexcept { return now_ns; };
  const SceneConfig scene = wall();
  {
    SocketDevice first(scene, clock), second(scene, clock);
    ASSERT_EQ(first.open(path), "");
    EXPECT_THAT(second.open(path), testing::HasSubstr("in use"));
  }
  const int killed = socket(AF_UNIX, SOCK_SEQPACKET, 0);  // its path stays behind
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  ASSERT_EQ(bind(killed, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  close(killed);
  {
    SocketDevice after(scene, clock);
    EXPECT_EQ(after.open(path), "");
  }
  EXPECT_FALSE(std::filesystem::exists(path));

  std::ofstream(path) << "of the user\n";
  SocketDevice none(scene, clock);
  EXPECT_THAT(none.open(path), testing::HasSubstr("in use"));
  EXPECT_TRUE(std::filesystem::exists(path));
  std::filesystem::remove(path);
  EXPECT_THAT(none.open(""), testing::HasSubstr("no path"));
  EXPECT_THAT(none.open(std::string(200, 'x')), testing::HasSubstr("no path"));
  EXPECT_THAT(none.open("/nowhere/here.sock"), testing::HasSubstr("No such file"));
}

}  // namespace
}  // namespace godobject::test_socket_device
