// A rig on the log of a run: it boots, follows and ends as in the run, with every protocol of drives.
#include "platform/rig/log_link.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <fstream>

#include "hal/can/candump.h"
#include "hal/rig/rig.h"
#include "sim/rig/link.h"
#include "tests/support/may_allocate.h"
#include "tests/support/program.h"
#include "tests/support/simulated_rig.h"

namespace godobject::test::test_log_link {
namespace {

using testing::HasSubstr;

constexpr Nanoseconds period = 1'000'000;
constexpr double period_s = 1e-3;

/// Turns every joint to and fro.
struct TurningHand final : Hand {
  explicit TurningHand(std::size_t joints) : num_joints(joints) {}
  bool moves_joints() const noexcept override { return true; }
  JointTarget joints(double t) const noexcept override {
    const auto n = static_cast<Eigen::Index>(num_joints);
    JointTarget target{.q = JointVector::Zero(n), .q_dot = JointVector::Zero(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      target.q(i) = 0.1 * std::sin(3 * t + static_cast<double>(i));
      target.q_dot(i) = 0.3 * std::cos(3 * t + static_cast<double>(i));
    }
    return target;
  }
  Target target(std::size_t, double) const noexcept override { return {}; }
  bool presses_clutch(std::size_t, double) const noexcept override { return false; }
  bool presses_hold(double) const noexcept override { return false; }
  std::size_t num_joints;
};

RigParams params_with(DriveProtocol protocol) {
  RigParams params = arm_rig_params();
  for (DriveParams& drive : params.drives) {
    drive.protocol = protocol;
    if (protocol != DriveProtocol::cia402) drive.node_id = static_cast<std::uint8_t>(15 + drive.node_id);
    if (protocol == DriveProtocol::odrive) drive.profile.clear();
  }
  if (protocol == DriveProtocol::moteus) params.buses[1].data_bit_rate = 5e6;
  return params;
}

struct Logged {
  std::vector<std::vector<double>> q;  // of each cycle in which the rig was armed
  RigFault faults = RigFault::none;
  std::uint64_t foreign = 0, incomplete = 0;
};

/// Runs the cycles of RigDevice, from start to stop. goes_on: called before each.
template <class GoesOn>
Logged run(const RigParams& params, RigLink& link, int num_cycles, const GoesOn& goes_on) {
  Logged logged;
  Rig rig(params, period_s, link.buses());
  const std::vector<Wrench> F_hand_W(params.tree.handles.size(), Wrench{Vec3(0.1, 0, 0), Vec3(0, 0, 0.2)});
  bool started = false;
  for (int i = 0; i < 8000 && static_cast<int>(logged.q.size()) < num_cycles && goes_on(); ++i) {
    const Nanoseconds began = link.begin_cycle(1e-3 * static_cast<double>(logged.q.size()));
    if (!started) rig.start(began);
    started = true;
    rig.sync(began);
    Nanoseconds now = began;
    while (now < began + 700'000) {
      now = link.wait(began + 700'000);
      rig.receive(now);
    }
    const DeviceSample sample = rig.read(now);
    if (rig.state() == RigState::ready) static_cast<void>(rig.arm());
    if (rig.state() == RigState::armed) logged.q.emplace_back(sample.q.begin(), sample.q.end());
    static_cast<void>(rig.command(F_hand_W, now));
    link.end_cycle();
  }
  logged.faults = rig.faults();
  logged.foreign = rig.counters().foreign;
  logged.incomplete = rig.counters().incomplete_syncs;
  rig.stop();
  return logged;
}

class LogOfARig : public ProgramTest {
 protected:
  /// Runs a simulated rig and writes its log, which begins at `epoch`.
  Logged record(const RigParams& params, int num_cycles, const std::string& before = "") {
    std::ofstream file(path("run.log"));
    file << before;
    struct Writer {
      std::ofstream& out;
      const RigParams& params;
    } writer{file, params};
    SimLink link({.rig = params, .plant = {}, .wire = {}, .faults = {}}, period_s,
                 std::make_shared<TurningHand>(params.tree.joints.size()), period / 16);
    link.set_observer({.on_frame =
                           [](void* context, std::size_t bus, const ReceivedFrame& received) {
                             [[maybe_unused]] const MayAllocate scope;
                             const auto& to = *static_cast<Writer*>(context);
                             std::array<char, max_candump_line> line{};
                             std::size_t size = 0;
                             ReceivedFrame at = received;
                             at.t_ns += epoch;
                             ASSERT_EQ(format_candump(at, to.params.buses[bus].name, line, size),
                                       CandumpResult::ok);
                             to.out.write(line.data(), static_cast<std::streamsize>(size)) << '\n';
                           },
                       .context = &writer});
    return run(params, link, num_cycles, [] { return true; });
  }
  std::vector<LogSource> sources(std::size_t num_buses) const {
    return std::vector<LogSource>(num_buses, {.path = path("run.log"), .interface = ""});
  }
  static constexpr Nanoseconds epoch = 1'700'000'000'000'000'000;
};

TEST_F(LogOfARig, IsARigToRunOn) {
  for (const DriveProtocol protocol : {DriveProtocol::cia402, DriveProtocol::odrive, DriveProtocol::moteus}) {
    const RigParams params = params_with(protocol);
    const Logged first = record(params, 500);
    ASSERT_EQ(first.q.size(), 500u) << static_cast<int>(protocol);
    LogLink link(params, period);
    ASSERT_EQ(link.read(sources(2)), "");
    const Logged second = run(params, link, 500, [&] { return !link.ended(); });
    EXPECT_EQ(second.faults, RigFault::none) << static_cast<int>(protocol);
    ASSERT_GE(second.q.size(), 495u) << static_cast<int>(protocol);
    EXPECT_EQ(second.foreign, first.foreign) << "no frame of the host";
    EXPECT_LE(second.incomplete, first.incomplete + 2) << static_cast<int>(protocol);
    double most = 0;
    for (std::size_t i = 0; i < second.q.size(); ++i)
      for (std::size_t k = 0; k < second.q[i].size(); ++k)
        most = std::max(most, std::abs(second.q[i][k] - first.q[i][k]));
    EXPECT_LT(most, 1e-3) << static_cast<int>(protocol);
  }
}

/// Without an encoder, and without SYNC: cycles begin at requests.
TEST_F(LogOfARig, OfDrivesWithoutCanopenIsARigToRunOn) {
  for (const DriveProtocol protocol : {DriveProtocol::odrive, DriveProtocol::moteus}) {
    RigParams params = params_with(protocol);
    params.encoders.clear();
    params.buses.erase(params.buses.begin());
    params.tree.joints.resize(num_arm_drives);
    for (DriveParams& drive : params.drives) drive.bus = 0;
    for (HandleParams& handle : params.tree.handles) handle.joint = params.tree.joints.back().name;
    ASSERT_THAT(validate(params, period_s), testing::IsEmpty());
    const Logged first = record(params, 300);
    ASSERT_EQ(first.q.size(), 300u) << static_cast<int>(protocol);
    LogLink link(params, period);
    ASSERT_EQ(link.read(sources(1)), "");
    const Logged second = run(params, link, 300, [&] { return !link.ended(); });
    EXPECT_EQ(second.faults, RigFault::none) << static_cast<int>(protocol);
    EXPECT_GE(second.q.size(), 295u) << static_cast<int>(protocol);
    EXPECT_LE(second.incomplete, first.incomplete + 10)
        << "a request behind a heartbeat was sent before it began";
  }
}

/// Nodes that were configured first, with long waits: SDO requests and answers, and boot-ups, precede the
/// first SYNC.
TEST_F(LogOfARig, SettingUpIsLeftOut) {
  const RigParams params = arm_rig_params();
  const Logged first =
      record(params, 300,
             "(1699999900.000000) can0 701#00\n(1699999900.100000) can0 601#4018100100000000\n"
             "(1699999900.200000) can0 581#4318100100000000\n(1699999920.000000) can1 701#00\n");
  LogLink link(params, period);
  ASSERT_EQ(link.read(sources(2)), "");
  const Logged second = run(params, link, 300, [&] { return !link.ended(); });
  EXPECT_EQ(second.faults, RigFault::none);
  EXPECT_GE(second.q.size(), 295u);
}

TEST_F(LogOfARig, AGapOfTheLogIsOneOfTheCycles) {
  const RigParams params = arm_rig_params();
  static_cast<void>(record(params, 50));
  LogLink link(params, period);
  ASSERT_EQ(link.read(sources(2)), "");
  Nanoseconds last = link.begin_cycle(0);
  for (int i = 0; i < 40; ++i) {
    const Nanoseconds began = link.begin_cycle(0);
    EXPECT_NEAR(static_cast<double>(began - last), 1e6, 2e3) << "the SYNCs of the log, to the microsecond";
    last = began;
  }
}

TEST_F(LogOfARig, ComplaintsNameTheFileAndTheLine) {
  const RigParams params = arm_rig_params();
  LogLink link(params, period);
  write("run.log", "(1.000000) can0 080#\n(1.0) can0 080#\n(1.000000) can0 080#\n");
  EXPECT_THAT(link.read(sources(2)), HasSubstr("run.log:2: no line of a log"));
  write("run.log", "(1.000000) vcan9 080#\n");
  EXPECT_THAT(link.read(sources(2)), HasSubstr("holds no frame"));
  write("run.log", "(1.000000) can0 080#\n(1.000100) can0 701#05\n");
  EXPECT_THAT(LogLink(params, period).read(sources(2)), HasSubstr("run.log: holds no frame of can1"));
  EXPECT_THAT(link.read(std::vector<LogSource>(2, {.path = path("none.log"), .interface = ""})),
              HasSubstr("cannot"));
  EXPECT_THAT(link.read(std::vector<LogSource>(2, {.path = path("run.log"), .interface = "can5"})),
              HasSubstr("holds no frame of can5"));
}

}  // namespace
}  // namespace godobject::test::test_log_link
