#include "sim/tracker/ndi.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/support/simulated_tracker.h"

namespace godobject::test_sim_ndi {
namespace {

using test::SimulatedTracker;

const Pose here{.p = Vec3(0.1, -0.2, -1.5), .q = Quat(0.5, 0.5, -0.5, 0.5)};

/// A wired tool and a passive one with a definition of 700 bytes.
struct Polaris : SimulatedTracker {
  explicit Polaris(const std::vector<std::string>& tools = {"0A", "probe.rom"},
                   const TrackerParams& params = {})
      : SimulatedTracker(make_host(tools, params), nullptr) {
    far = std::make_unique<SimNdi>(tracker->params(), 60, 1);
    for (std::size_t i = 0; i < tools.size(); ++i) far->set_pose(i, here);
  }
  static std::unique_ptr<Tracker> make_host(const std::vector<std::string>& tools, TrackerParams params) {
    const TrackerParams named = test::tracker_params(TrackerProtocol::ndi, tools);
    if (params.port.empty()) params.port = named.port;
    params.tools = named.tools;
    ToolDefinitions definitions(tools.size());
    for (std::size_t i = 0; i < tools.size(); ++i)
      if (tools[i].size() > 2) definitions[i].assign(700, 0x5A);
    MadeTracker made = make_tracker(params, definitions);
    EXPECT_TRUE(made.errors.empty());
    return std::move(made.tracker);
  }
  SimNdi& sim() { return static_cast<SimNdi&>(*far); }
};

TEST(SimNdi, FromResetToPosesOfTwoTools) {
  Polaris rig;
  ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
  EXPECT_EQ(rig.breaks, 1);
  EXPECT_EQ(rig.baud, 115'200u);
  EXPECT_EQ(rig.sim().definition_size(1), 704u) << "700 bytes in blocks of 64";
  rig.run(1);
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(rig.tool(i).state, ToolState::valid);
    EXPECT_LT((rig.tool(i).X_TH.p - here.p).norm(), 1e-6);
    EXPECT_LT(rig.tool(i).X_TH.q.angularDistance(here.q), 1e-6);
    EXPECT_NEAR(rig.tool(i).number, 60, 3);
  }
  EXPECT_GT(rig.tracker->report().counters.repeated, 500u) << "polled every 2 ms, measured every 16";
  EXPECT_EQ(rig.tracker->report().counters.bad_crc, 0u);
  EXPECT_EQ(rig.tracker->report().counters.lost_frames, 0u);
}

TEST(SimNdi, TextAndBinaryRepliesAgree) {
  ndi::PoseReply reply;
  reply.num_handles = 3;
  reply.handles[0] = {.handle = 1, .status = ndi::HandleStatus::valid, .X_TH = here, .error_m = 3e-4};
  reply.handles[0].frame = 0xFFFFFFFF;
  reply.handles[1] = {.handle = 2, .status = ndi::HandleStatus::missing, .X_TH = {}};
  reply.handles[2] = {.handle = 3, .status = ndi::HandleStatus::disabled, .X_TH = {}};
  std::array<std::uint8_t, 512> bytes{};
  ndi::ReplyReceiver receiver;
  ndi::ReplyReceiver::Event event{};
  ndi::PoseReply tx, bx;
  for (const std::uint8_t byte : make_tx_reply(reply, bytes)) event = receiver.push(byte);
  ASSERT_EQ(event, ndi::ReplyReceiver::Event::text);
  ASSERT_EQ(ndi::parse_tx(receiver.content(), ndi::option::transforms, tx), ParseResult::ok);
  for (const std::uint8_t byte : make_bx_reply(reply, bytes)) event = receiver.push(byte);
  ASSERT_EQ(event, ndi::ReplyReceiver::Event::binary);
  ASSERT_EQ(ndi::parse_bx(receiver.content(), ndi::option::transforms, bx), ParseResult::ok);
  ASSERT_EQ(tx.num_handles, 3u);
  ASSERT_EQ(bx.num_handles, 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(tx.handles[i].handle, bx.handles[i].handle);
    EXPECT_EQ(tx.handles[i].status, bx.handles[i].status);
    EXPECT_EQ(tx.handles[i].frame, bx.handles[i].frame);
    EXPECT_LT((tx.handles[i].X_TH.p - bx.handles[i].X_TH.p).norm(), 1e-5);
    EXPECT_LT(tx.handles[i].X_TH.q.angularDistance(bx.handles[i].X_TH.q), 2e-4);
    EXPECT_NEAR(tx.handles[i].error_m, bx.handles[i].error_m, 1e-7);
  }
}

TEST(SimNdi, OldFirmwareIsPolledWithText) {
  Polaris rig;
  rig.sim().set_text_only(true);
  ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
  EXPECT_EQ(rig.tool(0).state, ToolState::valid);
  EXPECT_LT((rig.tool(0).X_TH.p - here.p).norm(), 1e-5);
}

TEST(SimNdi, ALineWithoutBreaks) {
  Polaris rig;
  rig.understands_breaks = false;
  ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
}

TrackerParams on_network() {
  TrackerParams params;
  params.port = "tcp:vega";
  return params;
}

TEST(SimNdi, ANetworkHasNeitherBreaksNorBitRates) {
  Polaris rig({"0A", "probe.rom"}, on_network());
  rig.sim().set_bx2(true);
  ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
  EXPECT_EQ(rig.breaks, 0);
  EXPECT_EQ(rig.baud, 0u) << "a rate was set";
  rig.run(1);
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(rig.tool(i).state, ToolState::valid);
    EXPECT_LT((rig.tool(i).X_TH.p - here.p).norm(), 1e-6);
    EXPECT_NEAR(rig.tool(i).number, 60, 3);
  }
  EXPECT_EQ(rig.tracker->report().counters.malformed, 0u);
}

// The time of a pose is that of its measurement by the tracker's clock, mapped by the least delayed reply.
TEST(SimNdi, PosesOfBx2HaveTheTrackersTime) {
  Polaris rig({"0A"}, on_network());
  rig.sim().set_bx2(true);
  ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
  rig.run(0.5);
  for (const Nanoseconds delay : {Nanoseconds{0}, Nanoseconds{9'000'000}, Nanoseconds{2'000'000}}) {
    rig.sim().faults.delay = delay;
    std::uint32_t number = rig.tool(0).number;
    Nanoseconds before = 0;
    for (int k = 0; k < 400; ++k) {
      rig.run(1e-3);
      if (rig.tool(0).number == number) continue;
      number = rig.tool(0).number;
      const Nanoseconds t = rig.tool(0).t_ns;
      if (before != 0) {
        EXPECT_NEAR(static_cast<double>(t - before), 1e9 / 60, 2e4) << delay;  // however late
      }
      before = t;
    }
  }
}

TEST(SimNdi, ANetworkedTrackerWithoutBx2IsPolledWithBx) {
  Polaris rig({"0A"}, on_network());
  ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
  EXPECT_EQ(rig.tool(0).state, ToolState::valid);
}

TEST(SimNdi, HiddenAndFarToolsInBx2) {
  Polaris rig({"0A", "0B"}, on_network());
  rig.sim().set_bx2(true);
  ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
  rig.far->faults.missing[0] = true;
  rig.far->faults.out_of_volume[1] = true;
  rig.run(0.3);
  EXPECT_EQ(rig.tool(0).state, ToolState::missing);
  EXPECT_EQ(rig.tool(1).state, ToolState::out_of_volume);
  rig.far->faults = {};
  rig.far->faults.disabled[1] = true;
  rig.run(0.3);
  EXPECT_EQ(rig.tool(0).state, ToolState::valid);
  EXPECT_EQ(rig.tool(1).state, ToolState::disabled);
}

TEST(SimNdi, BrokenBytesOfBx2AreRefused) {
  ndi::PoseReply reply;
  reply.num_handles = 2;
  reply.t_ns = sim_ndi_clock_ns;
  reply.handles[0] = {
      .handle = 1, .status = ndi::HandleStatus::valid, .X_TH = here, .error_m = 3e-4, .frame = 7};
  reply.handles[1] = {.handle = 2, .status = ndi::HandleStatus::missing, .X_TH = {}, .frame = 7};
  std::array<std::uint8_t, 512> wire{};
  const auto made = make_bx2_reply(reply, wire);
  ndi::ReplyReceiver receiver;
  auto event = ndi::ReplyReceiver::Event::more;
  for (const std::uint8_t byte : made) event = receiver.push(byte);
  ASSERT_EQ(event, ndi::ReplyReceiver::Event::binary);
  const std::vector<std::uint8_t> body(receiver.content().begin(), receiver.content().end());
  ndi::PoseReply parsed;
  ASSERT_EQ(ndi::parse_bx2(body, parsed), ParseResult::ok);
  EXPECT_EQ(parsed.t_ns, reply.t_ns);
  ASSERT_EQ(parsed.num_handles, 2u);
  EXPECT_EQ(parsed.handles[0].frame, 7u);
  EXPECT_LT((parsed.handles[0].X_TH.p - here.p).norm(), 1e-6);
  EXPECT_EQ(parsed.handles[1].status, ndi::HandleStatus::missing);
  for (std::size_t size = 0; size < body.size(); ++size)
    EXPECT_NE(ndi::parse_bx2(std::span(body).first(size), parsed), ParseResult::ok) << size;
  std::mt19937 random(1);
  for (int trial = 0; trial < 20000; ++trial) {
    std::vector<std::uint8_t> broken = body;
    for (int k = 0; k < 3; ++k)
      broken[random() % broken.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    if (ndi::parse_bx2(broken, parsed) != ParseResult::ok) continue;
    for (const ndi::HandlePose& pose : parsed.all())
      if (pose.status == ndi::HandleStatus::valid) {
        ASSERT_NEAR(pose.X_TH.q.norm(), 1, 1e-6);
      }
  }
}

TEST(SimNdi, AToolIsMissingAndTheOtherIsNot) {
  Polaris rig;
  ASSERT_TRUE(rig.track());
  rig.far->faults.missing[0] = true;
  rig.run(0.5);
  EXPECT_EQ(rig.tracker->report().state, TrackerState::tracking);
  EXPECT_EQ(rig.tool(0).state, ToolState::missing);
  EXPECT_EQ(rig.tool(1).state, ToolState::valid);
  rig.far->faults.missing[0] = false;
  rig.far->faults.out_of_volume[1] = true;
  rig.run(0.1);
  EXPECT_EQ(rig.tool(0).state, ToolState::valid);
  EXPECT_EQ(rig.tool(1).state, ToolState::out_of_volume);
}

TEST(SimNdi, AToolThatIsNotPluggedInIsDisabled) {
  Polaris rig;
  rig.far->faults.disabled[0] = true;
  ASSERT_TRUE(rig.track());
  rig.run(0.1);
  EXPECT_EQ(rig.tool(0).state, ToolState::disabled);
  EXPECT_EQ(rig.tool(1).state, ToolState::valid);
  EXPECT_NE(std::string(rig.tracker->report().text.data()).find("1 of 2"), std::string::npos);
}

TEST(SimNdi, UnpluggedWhileTracking) {
  Polaris rig;
  ASSERT_TRUE(rig.track());
  rig.far->faults.disabled[0] = true;
  rig.run(0.1);
  EXPECT_EQ(rig.tool(0).state, ToolState::disabled);
  EXPECT_EQ(rig.tool(1).state, ToolState::valid);
}

TEST(SimNdi, NoiseOnTheLineCostsRepliesAndNeverGivesAPose) {
  Polaris rig;
  rig.far->faults.corrupt_probability = 0.05;
  ASSERT_TRUE(rig.track(60)) << rig.tracker->report().text.data();
  rig.run_until(
      [&] {
        for (const std::size_t i : {0u, 1u}) {
          EXPECT_TRUE(rig.tool(i).number == 0 || (rig.tool(i).X_TH.p - here.p).norm() < 1e-6);
        }
        return false;
      },
      20);
  EXPECT_EQ(rig.tracker->report().state, TrackerState::tracking);
  EXPECT_GT(rig.tracker->report().counters.bad_crc, 20u);
  EXPECT_GT(rig.tool(0).number, 900u);
}

enum class Damage : std::uint8_t { drop, truncate, corrupt, twice };

/// At 115200 bit/s a reply of two tools takes 9 ms; the request is repeated before the second measurement has
/// passed.
TEST(SimNdi, ADamagedReplyCostsTwoFramesAtTheMost) {
  constexpr double frame_s = 1.0 / 60;
  for (const bool text : {false, true})
    for (const Damage kind : {Damage::drop, Damage::truncate, Damage::corrupt, Damage::twice})
      for (int in_a_row = 1; in_a_row <= 3; ++in_a_row) {
        Polaris rig;
        rig.sim().set_text_only(text);
        ASSERT_TRUE(rig.track());
        rig.far->faults.delay = 9'000'000;
        rig.run(1);
        std::mt19937 random(7);
        const auto below = [&](std::size_t n) { return random() % n; };
        int left = 0;
        Nanoseconds good_again = 0;
        rig.damage = [&](std::vector<std::uint8_t>& bytes) {
          if (left == 0) return;
          if (--left == 0) good_again = rig.now;
          switch (kind) {
            case Damage::drop: return bytes.clear();
            case Damage::truncate: return bytes.resize(below(bytes.size()));
            case Damage::corrupt:
              bytes[below(bytes.size())] ^= static_cast<std::uint8_t>(1u << below(8));
              return;
            case Damage::twice: {
              const std::vector<std::uint8_t> copy = bytes;
              bytes.insert(bytes.end(), copy.begin(), copy.end());
            }
          }
        };
        double worst_s = 0;
        for (int n = 0; n < 60; ++n) {
          rig.run(0.05 + 1e-3 * static_cast<double>(below(40)));
          left = in_a_row;
          ASSERT_TRUE(rig.run_until([&] { return left == 0; }, 3));
          const std::uint32_t number = rig.tool(0).number;
          ASSERT_TRUE(rig.run_until([&] { return rig.tool(0).number != number; }, 2));
          worst_s = std::max(worst_s, 1e-9 * static_cast<double>(rig.now - good_again));
          EXPECT_LT((rig.tool(0).X_TH.p - here.p).norm(), 1e-5);
        }
        EXPECT_LE(worst_s, 2 * frame_s + 1e-3) << static_cast<int>(kind) << ", " << in_a_row << " in a row";
        EXPECT_EQ(rig.tracker->report().counters.restarts, 0u);
      }
}

/// The request is not repeated while a tracker waits for its next measurement, or an adapter is slow.
TEST(SimNdi, WhatIsSlowIsNotTakenForLost) {
  for (const Nanoseconds delay : {1'000'000, 16'000'000, 60'000'000}) {
    Polaris rig;
    ASSERT_TRUE(rig.track());
    rig.far->faults.delay = delay;
    rig.run(2);
    const std::uint64_t timeouts = rig.tracker->report().counters.timeouts;
    rig.run(5);
    EXPECT_EQ(rig.tracker->report().counters.timeouts, timeouts) << delay;
    EXPECT_EQ(rig.tool(0).state, ToolState::valid);
  }
}

TEST(SimNdi, SilenceMakesStaleAndIsRecoveredFrom) {
  Polaris rig;
  ASSERT_TRUE(rig.track());
  rig.far->faults.silent = true;
  rig.run(0.15);
  EXPECT_EQ(rig.tool(0).state, ToolState::stale) << "after stale_after, 0.1 s";
  EXPECT_TRUE(rig.run_until([&] { return rig.tracker->report().state == TrackerState::initialising; }, 3));
  EXPECT_EQ(rig.tracker->report().counters.restarts, 1u);
  rig.far->faults.silent = false;
  ASSERT_TRUE(rig.track(20)) << rig.tracker->report().text.data();
  rig.run(0.1);
  EXPECT_EQ(rig.tool(0).state, ToolState::valid);
  EXPECT_EQ(rig.tool(1).state, ToolState::valid);
}

TEST(SimNdi, NobodyThereIsAFailureWithARemedyAndIsTriedAgain) {
  Polaris rig;
  rig.far->faults.silent = true;
  EXPECT_TRUE(rig.run_until([&] { return rig.tracker->report().state == TrackerState::failed; }, 30));
  EXPECT_GT(rig.now, 10'000'000'000) << "not before boot_timeout";
  EXPECT_NE(std::string(rig.tracker->report().text.data()).find("switched on"), std::string::npos);
  rig.far->faults.silent = false;
  EXPECT_TRUE(rig.track(30));
}

TEST(SimNdi, APowerCycleIsSeenAtOnce) {
  Polaris rig;
  ASSERT_TRUE(rig.track());
  rig.far->serial_break(rig.now);  // resets all state and sends RESET
  rig.run(0.05);
  EXPECT_EQ(rig.tracker->report().counters.restarts, 1u);
  EXPECT_TRUE(rig.track());
}

TEST(SimNdi, LateRepliesAreTakenAsLate) {
  Polaris rig;
  ASSERT_TRUE(rig.track());
  rig.far->faults.delay = 40'000'000;
  rig.run(2);
  EXPECT_EQ(rig.tracker->report().state, TrackerState::tracking);
  EXPECT_GT(rig.tracker->report().counters.lost_frames, 20u) << "polled at 25 Hz, measured at 60";
  EXPECT_LT(rig.now - rig.tool(0).t_ns, 45'000'000);
}

/// Foreign tools that are plugged in, loaded or worn out have no effect, for any number and any poses.
TEST(SimNdi, ForeignToolsCostNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const bool text_only : {false, true}) {
    for (const std::size_t count : {1u, 15u, 16u, 17u, 40u, 180u}) {
      for (const Quat& q : {Quat(nan, nan, nan, nan), Quat(0, 0, 0, 0), Quat(1, 0, 0, 0)}) {
        Polaris rig;
        rig.sim().set_text_only(text_only);
        rig.sim().set_foreign_tools(0x40, count, {.p = Vec3(1, 2, 3), .q = q});
        ASSERT_TRUE(rig.track()) << count << " " << rig.tracker->report().text.data();
        rig.run(0.5);
        for (const std::size_t i : {0u, 1u}) {
          EXPECT_EQ(rig.tool(i).state, ToolState::valid) << count;
          EXPECT_LT((rig.tool(i).X_TH.p - here.p).norm(), 1e-5);
          EXPECT_GE(rig.tool(i).number, 28u);
        }
        EXPECT_EQ(rig.tracker->report().counters.bad_crc, 0u);
        EXPECT_EQ(rig.tracker->report().counters.malformed, 0u);
      }
    }
  }
}

/// A tool of the scene without a pose does not affect the other.
TEST(SimNdi, AToolWithoutAPoseCostsNoOther) {
  Polaris rig({"0A", "0B"});
  ASSERT_TRUE(rig.track());
  rig.run(0.1);
  rig.far->set_pose(1, {.p = here.p, .q = Quat(0, 0, 0, 0)});
  rig.run(0.5);
  EXPECT_EQ(rig.tool(0).state, ToolState::valid);
  EXPECT_EQ(rig.tool(1).state, ToolState::stale);
  EXPECT_GT(rig.tracker->report().counters.malformed, 10u);
}

TEST(SimNdi, RepliesThatAreNoneOfItsProtocolAreNamed) {
  struct Case {
    std::string bytes, word;
  };
  for (const Case& c : {Case{"login: \r\n", "login:"}, Case{"+0.12 +3.4 +5.6\r\n", "text, without NDI's CRC"},
                        Case{"\xF0\x80\x01\xFE\r", "F0 80 01 FE"}}) {
    Polaris rig;
    rig.far->faults.silent = true;
    const Nanoseconds end = rig.now + 60'000'000'000;
    while (rig.tracker->report().state != TrackerState::failed && rig.now < end) {
      rig.step();
      if (rig.now / 1'000'000 % 50 == 0)
        rig.tracker->receive({reinterpret_cast<const std::uint8_t*>(c.bytes.data()), c.bytes.size()},
                             rig.now);
    }
    ASSERT_EQ(rig.tracker->report().state, TrackerState::failed);
    EXPECT_NE(std::string(rig.tracker->report().text.data()).find(c.word), std::string::npos)
        << rig.tracker->report().text.data();
  }
}

TEST(SimNdi, SetUpIsRefusedWithReasons) {
  TrackerParams params = test::tracker_params(TrackerProtocol::ndi, {"0A", "probe.rom"});
  EXPECT_EQ(make_tracker(params, {}).errors.size(), 1u) << "no definition";
  params.baud = 12345;
  EXPECT_EQ(make_tracker(params, {}).errors.size(), 2u);
  params.tools.clear();
  EXPECT_EQ(make_tracker(params, {}).errors.size(), 1u);
  params = test::tracker_params(TrackerProtocol::polhemus, {"0A"});
  EXPECT_EQ(make_tracker(params, {}).errors.size(), 1u);
}

}  // namespace
}  // namespace godobject::test_sim_ndi
