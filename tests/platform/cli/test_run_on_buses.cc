// A run on real buses in wall time: another thread simulates a rig at the far ends of cables.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <sstream>
#include <stdexcept>

#include "hal/can/candump.h"
#include "platform/cli/run/loop.h"
#include "platform/scene/toml.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/program.h"
#include "tests/support/rig_player.h"

namespace godobject::test::test_run_on_buses {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Test machines are slow at times, so limits are wide.
SceneConfig patient_scene() {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml");
  SceneConfig scene = *std::move(loaded.scene);
  scene.step = 4e-3;
  RigParams& rig = *scene.device->rig;
  rig.stale_after_s = 2;
  rig.heartbeat_timeout_s = 5;
  rig.boot_timeout_s = 9;
  for (EncoderParams& encoder : rig.encoders) {
    encoder.max_speed = 100;
    encoder.calibration.modulus_counts = 1u << 30;
  }
  for (DriveParams& drive : rig.drives) {
    drive.max_speed = 100;
    drive.torque_max_Nm = 0.005;  // too small to shake the hand, however late it comes
  }
  return scene;
}

/// Commands received by the drives, in order.
struct Command {
  std::uint32_t node = 0;
  std::uint16_t controlword = 0;
  std::int16_t torque_per_mille = 0;
};

std::vector<Command> commands(const std::vector<CanFrame>& frames) {
  std::vector<Command> out;
  for (const CanFrame& frame : frames) {
    const std::uint32_t node = frame.id & 0x7F;
    if ((frame.id & ~0x7Fu) != 0x200 || frame.size != 4) continue;
    const auto word = [&](std::size_t i) {
      return static_cast<std::uint16_t>(frame.data[i] | frame.data[i + 1] << 8);
    };
    out.push_back({node, word(0), static_cast<std::int16_t>(word(2))});
  }
  return out;
}

bool commands_torque(const std::vector<CanFrame>& frames) {
  const auto turns = [](const Command& c) { return c.torque_per_mille != 0; };
  return std::ranges::any_of(commands(frames), turns);
}

void expect_motors_off(const std::vector<CanFrame>& frames) {
  std::map<std::uint32_t, Command> last;
  for (const Command& command : commands(frames)) last[command.node] = command;
  EXPECT_EQ(last.size(), 3u);
  for (const auto& [node, command] : last) {
    EXPECT_EQ(command.torque_per_mille, 0) << node;
    EXPECT_EQ(command.controlword, 0) << node << ": disable voltage";
  }
}

class RunOnBuses : public ProgramTest {
 protected:
  /// Makes the far end and an opened session on its cables.
  void connect(std::function<void(RigPlayer&, std::uint64_t)> on_sync = {}) {
    player_ = std::make_unique<RigPlayer>(scene_, motion_, std::move(on_sync));
    std::vector<std::unique_ptr<LinuxBus>> buses;
    for (Cable& cable : player_->cables) buses.push_back(std::make_unique<CableBus>(cable));
    auto link = std::make_unique<LinuxLink>(std::move(buses), std::llround(1e9 * scene_.step));
    link_ = link.get();
    Session::Made made = Session::make(scene_, motion_, std::move(link));
    if (!made.session) throw std::runtime_error(made.errors.front());
    session_ = std::move(made.session);
    if (!open_buses(*link_, where_, rig()).empty()) throw std::runtime_error("a cable does not open");
  }
  RunResult run(const RunPlan& plan, const std::string& record = "") {
    RunFileNames names;
    names.record = record;
    RunFiles files(names, scene_, 0);
    const RigOnBuses real{*link_, where_, rig(), scene_.step, profiles_};
    const std::optional<RunResult> result = run_realtime(*session_, plan, files, &real);
    player_->stop();
    EXPECT_THAT(files.close(), IsEmpty());
    return result.value_or(RunResult{});
  }
  const RigParams& rig() const { return *scene_.device->rig; }

  SceneConfig scene_ = patient_scene();
  Motion motion_{scene_};
  static constexpr BusBackend cable_kind{.name = "cable", .where = "NUMBER"};
  RigAddresses where_{
      .addresses = {{.backend = &cable_kind, .where = "0"}, {.backend = &cable_kind, .where = "1"}},
      .texts = {"cable:0", "cable:1"}};
  RigProfiles profiles_{.encoders = std::vector<std::optional<NodeProfile>>(rig().encoders.size()),
                        .drives = std::vector<std::optional<NodeProfile>>(rig().drives.size())};
  std::unique_ptr<RigPlayer> player_;
  std::unique_ptr<Session> session_;
  LinuxLink* link_ = nullptr;
  MonotonicClock clock_;
};

TEST_F(RunOnBuses, BootsFollowsPushesAndShutsDown) {
  connect();
  const RunResult result = run({.num_cycles = 500});
  EXPECT_TRUE(result.ready);
  EXPECT_EQ(result.statistics.cycles, 500u);
  EXPECT_EQ(result.statistics.rig_faults, RigFault::none) << session_->rig()->fault_text();
  EXPECT_THAT(result.recoveries, IsEmpty());
  EXPECT_EQ(session_->phase(), RunPhase::ended);
  EXPECT_EQ(session_->bus(), BusChoice::real);
  EXPECT_GT(result.statistics.following.count(), 0u);
  EXPECT_EQ(result.statistics.sensing.max().m, 0) << "nobody knows where the handle really is";
  EXPECT_TRUE(commands_torque(player_->got[1]));
  expect_motors_off(player_->got[1]);
  EXPECT_GT(link_->timing().added_latency_ns.count(), 0u);
  EXPECT_GT(link_->timing().sync_jitter_ns.count(), 0u);
  EXPECT_EQ(session_->host_buses()[1]->counters().sent, player_->got[1].size());
}

/// Checks both directions of both buses.
TEST_F(RunOnBuses, RecordHasEveryFrame) {
  connect();
  EXPECT_TRUE(run({.num_cycles = 100}, path("run.log")).ready);
  std::map<std::string, std::vector<CanFrame>, std::less<>> logged;
  std::istringstream log(read_file(path("run.log")));
  for (std::string line; std::getline(log, line);) {
    ReceivedFrame received;
    std::string_view bus;
    ASSERT_EQ(parse_candump(line, received, bus), CandumpResult::ok) << line;
    logged[std::string(bus)].push_back(received.frame);
  }
  const auto count = [](const std::vector<CanFrame>& frames, const CanFrame& like) {
    return std::ranges::count_if(frames, [&](const CanFrame& f) {
      return f.id == like.id && f.size == like.size && f.data == like.data;
    });
  };
  for (std::size_t i = 0; i < player_->cables.size(); ++i) {
    const std::vector<CanFrame>& of_bus = logged[rig().buses[i].name];
    // The record does not contain frames that the nodes sent after the last cycle.
    EXPECT_GE(of_bus.size(), player_->got[i].size() + session_->host_buses()[i]->counters().received);
    EXPECT_LE(of_bus.size(), player_->got[i].size() + player_->sent[i].size());
    for (const CanFrame& frame : player_->got[i])
      EXPECT_EQ(count(of_bus, frame), count(player_->got[i], frame)) << std::hex << frame.id;
  }
}

TEST_F(RunOnBuses, UnpluggedIsAFaultAndStaysOne) {
  connect([](RigPlayer& player, std::uint64_t syncs) {
    if (syncs == 300) player.cables[0].unplug();
    if (syncs == 320) player.cables[0].plug();
  });
  const RunResult result = run({.num_cycles = 600});
  EXPECT_EQ(result.statistics.cycles, 600u) << "the scene goes on";
  EXPECT_TRUE(any(session_->rig()->faults() & RigFault::bus_down));
  ASSERT_EQ(result.recoveries.size(), 1u);
  EXPECT_THAT(result.recoveries[0].named, HasSubstr("bus_down (can0)"));
  EXPECT_THAT(result.recoveries[0].troubles,
              testing::ElementsAre(HasSubstr("bus can0 (cable:0): the cable")));
  EXPECT_EQ(result.recoveries[0].recovered_after_s, std::nullopt);
  expect_motors_off(player_->got[1]);
}

TEST_F(RunOnBuses, RearmsWhenItsBusesAreBack) {
  connect([](RigPlayer& player, std::uint64_t syncs) {
    if (syncs == 300) player.cables[0].unplug();
  });
  // Plugs it in again after the host has failed to open it.
  std::atomic<bool> over{false};
  std::thread hand([&] {
    while (!over && player_->cables[0].refused_opens() < 2)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    player_->cables[0].plug();
  });
  const RunResult result = run({.num_cycles = 600, .rearm = Rearm::automatic});
  over = true;
  hand.join();
  EXPECT_EQ(result.statistics.cycles, 600u);
  EXPECT_EQ(session_->rig()->faults(), RigFault::none) << session_->rig()->fault_text();
  ASSERT_EQ(result.recoveries.size(), 1u);
  EXPECT_THAT(result.recoveries[0].named, HasSubstr("bus_down (can0)"));
  EXPECT_GE(result.recoveries[0].boots, 1);
  EXPECT_TRUE(result.recoveries[0].recovered_after_s.has_value());
  expect_motors_off(player_->got[1]);
}

TEST_F(RunOnBuses, ASignalEndsItCleanly) {
  connect([](RigPlayer&, std::uint64_t syncs) {
    if (syncs == 400) raise(SIGTERM);
  });
  const RunResult result = run({.num_cycles = 1'000'000});
  EXPECT_EQ(result.stopped_by, "SIGTERM");
  EXPECT_EQ(session_->phase(), RunPhase::ended);
  expect_motors_off(player_->got[1]);
}

TEST_F(RunOnBuses, TheCycleDoesNotTouchTheHeap) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "the sanitizer owns the allocator";
  connect();
  Ring<CycleEntry> cycles(64, entry_of(*session_));
  const std::atomic<bool> stop{false};
  RealtimeCycle cycle(*session_, {.num_cycles = 100}, stop, cycles);
  Cyclic<MonotonicClock> loop(clock_, std::llround(1e9 * scene_.step));
  session_->start(10);
  AllocationGuard guard;
  loop.run([&](const Wake& wake) { return cycle(wake); });
  guard.disarm();
  EXPECT_EQ(guard.heap_calls(), 0) << guard.report();
  EXPECT_EQ(cycle.statistics().cycles, 100u);
  EXPECT_EQ(session_->phase(), RunPhase::ended);
}

}  // namespace
}  // namespace godobject::test::test_run_on_buses
