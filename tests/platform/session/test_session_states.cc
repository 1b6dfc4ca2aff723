// States of a run, by the table of hal/rig/supervisor.h: hold, fault, and the way back.
#include <gtest/gtest.h>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject::test_session_states {
namespace {

/// A session on a simulated rig, stopped by hand.
struct RunOfASession {
  RunOfASession() {
    const LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml");
    Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::sim);
    session = std::move(made.session);
    record = session->at_start();
  }
  RigState state_after(int periods) {
    for (int i = 0; i < periods; ++i) static_cast<void>(session->advance(record));
    return session->state();
  }

  std::unique_ptr<Session> session;
  CycleRecord record;
};

class SessionStates : public testing::Test, public RunOfASession {};

TEST_F(SessionStates, HoldEndsWithThePose) {
  EXPECT_EQ(session->state(), RigState::off);
  ASSERT_TRUE(session->boot(5));
  EXPECT_EQ(state_after(10), RigState::armed);
  session->hold(true);
  EXPECT_EQ(state_after(10), RigState::hold);
  EXPECT_EQ(session->phase(), RunPhase::running);
  session->hold(false);
  EXPECT_EQ(state_after(1), RigState::armed);
}

TEST_F(SessionStates, FaultIsLeftByTheEndOnly) {
  ASSERT_TRUE(session->boot(5));
  ASSERT_EQ(state_after(10), RigState::armed);
  session->deadlines_missed();
  EXPECT_EQ(state_after(1), RigState::fault);
  session->hold(true);
  EXPECT_EQ(state_after(10), RigState::fault);
  session->hold(false);
  EXPECT_EQ(state_after(100), RigState::fault);
  EXPECT_EQ(session->phase(), RunPhase::running) << "the scene goes on without torque";
  session->stop();
  EXPECT_EQ(session->state(), RigState::stopping);
  session->shut_down();
  EXPECT_EQ(session->state(), RigState::ended);
  session->start(5);
  EXPECT_EQ(state_after(10), RigState::ended) << "restart() first";
  session->restart();
  EXPECT_EQ(state_after(10), RigState::off) << "start() first";
  ASSERT_TRUE(session->boot(5));
  EXPECT_EQ(state_after(10), RigState::armed);
}

TEST_F(SessionStates, StopInEveryState) {
  for (const int periods : {0, 1, 50}) {
    RunOfASession other;
    if (periods > 0) other.session->start(5);
    static_cast<void>(other.state_after(periods));
    other.session->quick_stop();
    other.session->shut_down();
    EXPECT_EQ(other.session->state(), RigState::ended) << periods;
  }
}

}  // namespace
}  // namespace godobject::test_session_states
