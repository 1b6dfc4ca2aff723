// The table of states: one row per state and event, no torque without a request. docs/faults.md has a copy.
#include "hal/rig/supervisor.h"

#include <gmock/gmock.h>

#include <deque>
#include <fstream>
#include <set>
#include <sstream>
#include <tuple>
#include <vector>

namespace godobject::test_supervisor {
namespace {

using testing::HasSubstr;

std::vector<RigEvent> all_events() {
  std::vector<RigEvent> events;
  for (std::size_t i = 0; i < num_rig_events; ++i) events.push_back(static_cast<RigEvent>(i));
  return events;
}

auto key(const Supervision& s) { return std::tuple(s.state, s.torque, s.reached); }

/// A state of the supervisor. requested: torque was requested since it was last off or stopped.
struct Node {
  Supervision now;
  bool requested = false;
};

/// Visits every reachable state with every event, breadth first. Returns the states.
template <class Visit>
std::vector<Supervision> explore(Visit&& visit) {
  std::deque<Node> open{{}};
  std::set<decltype(std::tuple_cat(key({}), std::tuple(false)))> seen;
  std::set<decltype(key({}))> states;
  std::vector<Supervision> found;
  while (!open.empty()) {
    const Node node = open.front();
    open.pop_front();
    if (!seen.insert(std::tuple_cat(key(node.now), std::tuple(node.requested))).second) continue;
    if (states.insert(key(node.now)).second) found.push_back(node.now);
    for (const RigEvent event : all_events()) {
      const std::optional<Supervision> after = next(node.now, event);
      const bool requested =
          event == RigEvent::arm ||
          (node.requested && after && after->reached > RigState::ready && after->state != RigState::stopping);
      visit(node, event, after);
      if (after) open.push_back({.now = *after, .requested = requested});
    }
  }
  return found;
}

TEST(Supervisor, StateAndEventHaveOneRow) {
  std::set<std::pair<std::size_t, RigEvent>> seen;
  for (const RigTransition& row : rig_transitions()) {
    EXPECT_FALSE(row.cause.empty());
    for (std::size_t state = 0; state < num_rig_states; ++state) {
      if (!row.leaves(static_cast<RigState>(state))) continue;
      EXPECT_TRUE(seen.insert({state, row.event}).second)
          << name_of(static_cast<RigState>(state)) << " " << name_of(row.event);
    }
  }
}

TEST(Supervisor, EveryStateAndEventIsReached) {
  std::set<RigState> states;
  std::set<RigEvent> events;
  for (const Supervision& s : explore([&](const Node&, RigEvent event, const auto&after) {
         if (after) events.insert(event);
       }))
    states.insert(s.state);
  EXPECT_EQ(states.size(), num_rig_states);
  EXPECT_EQ(events.size(), num_rig_events);
}

TEST(Supervisor, TorqueIsRequested) {
  explore([](const Node& before, RigEvent event, const std::optional<Supervision>& after) {
    if (!after) return;
    const bool has_torque = after->torque == TorqueOutput::normal || after->torque == TorqueOutput::fade;
    if (!has_torque) return;
    EXPECT_TRUE(event == RigEvent::arm || before.requested) << name_of(before.now.state) << name_of(event);
    EXPECT_TRUE(after->state == RigState::armed || after->state == RigState::hold);
  });
}

TEST(Supervisor, FaultAndStopRemoveTheTorqueFromEveryState) {
  explore([](const Node& before, RigEvent event, const std::optional<Supervision>& after) {
    const bool is_on = before.now.state >= RigState::booting && before.now.state <= RigState::fault;
    if (!is_on) return;
    if (event == RigEvent::fault || event == RigEvent::stop) {
      ASSERT_TRUE(after);
      EXPECT_TRUE(after->torque == TorqueOutput::run_down || after->torque == TorqueOutput::at_once);
    }
    if (event == RigEvent::quick_stop) {
      ASSERT_TRUE(after);
      EXPECT_EQ(after->torque, TorqueOutput::at_once);
      EXPECT_EQ(after->state, RigState::fault);
    }
  });
}

TEST(Supervisor, FaultIsLeftOnRequestOnly) {
  for (const RigEvent event : all_events()) {
    const std::optional<Supervision> after =
        next({.state = RigState::fault, .torque = TorqueOutput::run_down, .reached = RigState::armed}, event);
    if (!after || after->state == RigState::fault) continue;
    EXPECT_TRUE(event == RigEvent::clear || event == RigEvent::stop || event == RigEvent::switch_off)
        << name_of(event);
  }
}

TEST(Supervisor, TorqueRemovedAtOnceStaysSo) {
  Supervisor s;
  for (const RigEvent event :
       {RigEvent::start, RigEvent::nodes_up, RigEvent::homed, RigEvent::drives_up, RigEvent::arm})
    ASSERT_TRUE(s.on(event));
  EXPECT_EQ(s.torque(), TorqueOutput::normal);
  ASSERT_TRUE(s.on(RigEvent::quick_stop));
  ASSERT_TRUE(s.on(RigEvent::fault));
  EXPECT_EQ(s.torque(), TorqueOutput::at_once);
  EXPECT_EQ(s.reached(), RigState::armed);
  EXPECT_FALSE(s.on(RigEvent::arm));
  ASSERT_TRUE(s.on(RigEvent::clear));
  EXPECT_EQ(s.torque(), TorqueOutput::run_down);
  EXPECT_EQ(s.reached(), RigState::booting);
  EXPECT_FALSE(s.on(RigEvent::arm)) << "boots first";
}

TEST(Supervisor, DocumentHasTheTable) {
  std::ifstream file(GODOBJECT_SOURCE_DIR "/docs/faults.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("<!-- states: begin -->\n\n" + rig_transitions_markdown() +
                                    "\n<!-- states: end -->"));
}

}  // namespace
}  // namespace godobject::test_supervisor
