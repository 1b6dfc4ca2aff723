// The cycle of the real-time thread, including buses and the inputs and states of an input log, uses neither
// heap nor locks nor system calls.
#include <gtest/gtest.h>

#include <memory>

#include "platform/cli/report/files.h"
#include "platform/cli/run/loop.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_realtime_cycle {
namespace {

class RealtimeCycleOf : public testing::TestWithParam<std::pair<const char*, BusChoice>> {};

TEST_P(RealtimeCycleOf, AllocatesLocksAndCallsNothing) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "the sanitizer owns the allocator";
  const LoadResult loaded = load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + GetParam().first);
  ASSERT_TRUE(loaded.scene.has_value());
  Motion motion(*loaded.scene);
  if (const std::vector<std::size_t> driven = driven_bodies(*loaded.scene); !driven.empty()) {
    const std::string body = loaded.scene->bodies[driven.front()].name;
    const MotionResult switched =
        Motion::parse("t," + body + ".engaged," + body + ".clutch\n0,1,1\n0.5,0,1\n0.6,1,0\n0.8,1,1\n",
                      "switches.csv", *loaded.scene);
    ASSERT_TRUE(switched.motion.has_value()) << switched.errors.front();
    motion = *switched.motion;
  }
  Session::Made made = make_session(*loaded.scene, motion, GetParam().second);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  RunFileNames names;
  names.inputs = "run.godo";
  list_recorded(names, *made.session);
  made.session->start(5);

  constexpr std::uint64_t num_cycles = 1000;
  Ring<CycleEntry> cycles(num_cycles, entry_of(*made.session));
  Ring<BusFrame> frames(16);  // overflows: counting must not allocate either
  made.session->set_bus_observer({.on_frame =
                                      [](void* context, std::size_t bus, const ReceivedFrame& frame) {
                                        static_cast<void>(static_cast<Ring<BusFrame>*>(context)->try_push(
                                            {.bus = bus, .received = frame}));
                                      },
                                  .context = &frames});
  const std::atomic<bool> stop{false};
  EngineState state = state_of(*made.session);
  Ring<EngineState> states(1, state);
  const auto cycle = std::make_unique<RealtimeCycle>(*made.session, RunPlan{.num_cycles = num_cycles}, stop,
                                                     cycles, &states);

  AllocationGuard guard;
  while ((*cycle)(Wake{})) continue;
  EXPECT_EQ(guard.calls(), 0) << guard.report();

  EXPECT_EQ(cycle->statistics().cycles, num_cycles);
  EXPECT_EQ(cycles.lost(), 0u);
  ASSERT_TRUE(states.try_pop(state));
  EXPECT_EQ(state.cycle, num_cycles);
  EXPECT_EQ(state.hash, made.session->engine().state_hash());
  EXPECT_EQ(made.session->rig() != nullptr, frames.lost() > 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, RealtimeCycleOf,
                         testing::Values(std::pair{"rigid.toml", BusChoice::sim},
                                         std::pair{"desk.toml", BusChoice::sim},
                                         std::pair{"relative.toml", BusChoice::sim},
                                         std::pair{"grasper.toml", BusChoice::sim},
                                         std::pair{"scissors-imposed.toml", BusChoice::direct},
                                         std::pair{"chain.toml", BusChoice::direct},
                                         std::pair{"admittance.toml", BusChoice::direct}));

}  // namespace
}  // namespace godobject::test_realtime_cycle
