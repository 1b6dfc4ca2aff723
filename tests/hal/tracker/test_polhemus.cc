#include "hal/tracker/polhemus.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

#include "hal/tracker/polhemus_tracker.h"
#include "tests/support/polhemus_recording.h"
#include "tests/support/shared_data.h"

namespace godobject::polhemus::test_polhemus {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Event = RecordReceiver::Event;
constexpr Nanoseconds ms = 1'000'000;

Bytes wire_of(const Record& record) {
  std::array<std::uint8_t, max_record_size> buffer{};
  const std::span<const std::uint8_t> bytes = make_record(record, buffer);
  return {bytes.begin(), bytes.end()};
}

Record record_at(int i, Model model = Model::fastrak) {
  const double angle = 0.01 * i;
  return {.model = model,
          .station = 1,
          .X_TH = {.p = Vec3(0.3, -0.1 + 1e-4 * i, 0.2), .q = Quat(std::cos(angle), 0, std::sin(angle), 0)},
          .t_ms = static_cast<std::uint32_t>(4 * i)};
}

TEST(Polhemus, BytesOnTheWire) {
  Record record{.station = 2, .error = ' ', .X_TH = {.p = Vec3(0.0254, -0.0508, 0), .q = Quat::Identity()}};
  Bytes expected{'0', '2', ' ', 0, 0, 0x80, 0x3F, 0, 0, 0x00, 0xC0};
  expected.resize(15);                                  // z = 0
  expected.insert(expected.end(), {0, 0, 0x80, 0x3F});  // w = 1
  expected.resize(31);
  expected.push_back(' ');
  EXPECT_EQ(wire_of(record), expected);
  record.model = Model::liberty;
  record.t_ms = 0x01020304;
  const Bytes liberty = wire_of(record);
  ASSERT_EQ(liberty.size(), 41u);
  EXPECT_EQ(Bytes(liberty.begin(), liberty.begin() + 8), (Bytes{'L', 'Y', 2, 'C', ' ', 0, 33, 0}));
  EXPECT_EQ(Bytes(liberty.end() - 5, liberty.end()), (Bytes{4, 3, 2, 1, ' '}));
}

TEST(Polhemus, InitCommands) {
  std::string fastrak, liberty;
  for (std::size_t i = 0; const auto command = init_command(Model::fastrak, i, 2); ++i)
    fastrak.append(command->data.data(), command->size);
  for (std::size_t i = 0; const auto command = init_command(Model::liberty, i, 2); ++i)
    liberty.append(command->data.data(), command->size);
  EXPECT_EQ(fastrak, "cUO1,2,11,0\rO2,2,11,0\rfC");
  EXPECT_EQ(liberty, "PU0\rO1,2,7,8,0\rO2,2,7,8,0\rF1\rC\r");
}

TEST(Polhemus, FrameCommands) {
  const auto all = [](Model model, std::size_t stations) {
    std::string text;
    for (std::size_t i = 0; const auto command = frame_command(model, i, stations, Vec3(0.6, 0, -0.8)); ++i)
      text.append(command->data.data(), command->size);
    return text;
  };
  EXPECT_EQ(all(Model::fastrak, 2),
            "R1\rb1\rN1,0,0,0\rr1,0,0,0\rH1,0.600,0.000,-0.800\rR2\rb2\rN2,0,0,0\rr2,0,0,0\rH2,0.600,0.000,-"
            "0.800\r");
  EXPECT_EQ(all(Model::liberty, 16), "\x12*\r\x02*\rN*,0,0,0\rG0,0,0\rH*,0.600,0.000,-0.800\r");
}

/// A station that is not in the scene, without a pose, repeatedly: the others lose no record.
TEST(Polhemus, ARecordWithoutAPoseCostsNoOther) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Model model : {Model::fastrak, Model::liberty}) {
    for (const Quat& q : {Quat(nan, nan, nan, nan), Quat(0, 0, 0, 0), Quat(1, 0, nan, 0)}) {
      RecordReceiver receiver;
      int records = 0, malformed = 0;
      for (int i = 0; i < 20; ++i) {
        Record foreign = record_at(i, model);
        foreign.station = 3;
        foreign.X_TH.q = q;
        for (const Record& record : {record_at(i, model), foreign})
          for (const std::uint8_t byte : wire_of(record)) {
            const Event event = receiver.push(byte);
            records += event == Event::record ? 1 : 0;
            malformed += event == Event::malformed ? 1 : 0;
          }
      }
      EXPECT_EQ(records, 20);
      EXPECT_EQ(malformed, 20);
    }
  }
}

TEST(Polhemus, RecordingsComeBackThroughTheWire) {
  const auto files = test::files_with(test::shared_file("data/polhemus_fastrak_hand"), ".traj");
  if (files.empty()) GTEST_SKIP() << "no recorded Polhemus poses";
  EXPECT_EQ(files.size(), 12u);
  for (const Model model : {Model::fastrak, Model::liberty}) {
    for (const auto& file : files) {
      RecordReceiver receiver;
      const std::vector<Pose> poses = test::read_matrices(file);
      EXPECT_GE(poses.size(), 363u);
      std::size_t count = 0;
      for (const Pose& pose : poses) {
        for (const std::uint8_t byte : wire_of({.model = model, .X_TH = pose})) {
          const Event event = receiver.push(byte);
          EXPECT_NE(event, Event::malformed);
          if (event != Event::record) continue;
          ++count;
          EXPECT_LT((receiver.record().X_TH.p - pose.p).norm(), 1e-6);
          EXPECT_LT(receiver.record().X_TH.q.angularDistance(pose.q), 1e-6);
        }
      }
      EXPECT_EQ(count, poses.size()) << file;
    }
  }
}

TEST(Polhemus, NoPoseOfANumberThatIsNone) {
  for (const Model model : {Model::fastrak, Model::liberty}) {
    for (Eigen::Index i = 0; i < 7; ++i) {
      Record record = record_at(0, model);
      (i < 3 ? record.X_TH.p[i] : record.X_TH.q.coeffs()[i - 3]) = std::numeric_limits<double>::quiet_NaN();
      RecordReceiver receiver;
      for (const std::uint8_t byte : wire_of(record)) EXPECT_NE(receiver.push(byte), Event::record) << i;
    }
  }
}

TEST(Polhemus, InStepAgainAfterALostByte) {
  for (const Model model : {Model::fastrak, Model::liberty}) {
    const std::size_t size = wire_of(record_at(0, model)).size();
    for (std::size_t lost = 0; lost < size; ++lost) {
      RecordReceiver receiver;
      int records = 0, malformed = 0;
      for (int i = 0; i < 8; ++i) {
        Bytes wire = wire_of(record_at(i, model));
        if (i == 2) wire.erase(wire.begin() + static_cast<std::ptrdiff_t>(lost));
        for (const std::uint8_t byte : wire) {
          const Event event = receiver.push(byte);
          if (event == Event::malformed) ++malformed;
          if (event != Event::record) continue;
          ++records;
          EXPECT_NEAR(receiver.record().X_TH.p.x(), 0.3, 1e-6) << lost;
        }
      }
      EXPECT_GE(records, 6) << lost;
      EXPECT_EQ(malformed, 1) << lost;
    }
  }
}

/// Up to three records in a row are truncated, changed in a bit, left out or sent twice.
/// At the latest the second record after them is read.
TEST(Polhemus, InStepWithinTwoRecordsOfADamagedOne) {
  std::mt19937 random(5);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  for (const Model model : {Model::fastrak, Model::liberty})
    for (int kind = 0; kind < 4; ++kind)
      for (int n = 0; n < 600; ++n) {
        const int in_a_row = 1 + n % 3;
        RecordReceiver receiver;
        int first_read = -1;
        for (int i = 0; i < 10 && first_read < 0; ++i) {
          Bytes wire = wire_of(record_at(i, model));
          const bool damaged = i >= 3 && i < 3 + in_a_row;
          if (damaged && kind == 0) wire.resize(below(wire.size()));
          if (damaged && kind == 1) wire[below(wire.size())] ^= static_cast<std::uint8_t>(1u << below(8));
          if (damaged && kind == 2) wire.clear();
          if (damaged && kind == 3)
            wire.insert(wire.end(), wire.begin(), wire.begin() + static_cast<long>(wire.size() / 2));
          for (const std::uint8_t byte : wire)
            if (receiver.push(byte) == Event::record && i >= 3 + in_a_row) first_read = i;
        }
        ASSERT_GE(first_read, 0);
        ASSERT_LE(first_read, 3 + in_a_row + 1) << "kind " << kind;
      }
}

/// Returns the host's tracker, configured for continuous records from `now` on.
std::unique_ptr<Tracker> tracking_tracker(Nanoseconds& now) {
  TrackerParams params;
  params.protocol = TrackerProtocol::polhemus;
  params.tools.push_back({.body = "tool", .tool = "1", .X_TH = {}});
  std::unique_ptr<Tracker> tracker = make_tracker(params, {}).tracker;
  tracker->opened(now);
  for (; tracker->report().state != TrackerState::tracking && now < 5000 * ms; now += 10 * ms) {
    static_cast<void>(tracker->next(now));
    tracker->receive(wire_of(record_at(0)), now);
  }
  return tracker;
}

TEST(PolhemusTracker, ACorruptedRecordIsRefusedOrNear) {
  // Without a CRC a wrong low bit of a position passes; its error is bounded.
  double worst = 0;
  for (std::size_t at = 0; at < fastrak_size; ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      Nanoseconds now = 0;
      const auto tracker = tracking_tracker(now);
      ASSERT_EQ(tracker->report().state, TrackerState::tracking);
      Bytes wire = wire_of(record_at(1));
      wire[at] = static_cast<std::uint8_t>(wire[at] ^ (1u << bit));
      tracker->receive(wire, now + 10 * ms);
      tracker->receive(wire_of(record_at(2)), now + 20 * ms);
      const ToolSample& sample = tracker->report().tools[0];
      worst = std::max(worst, (sample.X_TH.p - record_at(2).X_TH.p).norm());
    }
  }
  EXPECT_LT(worst, 0.25);
}

TEST(PolhemusTracker, ARealJumpIsAcceptedAfterAWhile) {
  Nanoseconds now = 0;
  const auto tracker = tracking_tracker(now);
  Record far = record_at(1);
  far.X_TH.p += Vec3(1, 0, 0);
  const std::uint64_t before = tracker->report().counters.malformed;
  for (int i = 0; i < 4; ++i) tracker->receive(wire_of(far), now += 10 * ms);
  EXPECT_NEAR(tracker->report().tools[0].X_TH.p.x(), 1.3, 1e-6);
  EXPECT_EQ(tracker->report().counters.malformed - before, 2u);
}

TEST(PolhemusTracker, AMirrorImageIsLossHoweverLongItLasts) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int n = 0; n < 50; ++n) {
    Nanoseconds now = 0;
    const auto tracker = tracking_tracker(now);
    Record record = record_at(0);
    const Vec3 noise(uniform(random), uniform(random), uniform(random));
    record.X_TH.p = -record.X_TH.p + 0.005 * noise;
    const auto& tool = tracker->report().tools[0];
    const int period_ms = 4 + n % 3 * 20;
    for (int i = 0; i < 40; ++i) {
      record.X_TH.p += 0.001 * noise;
      tracker->receive(wire_of(record), now += period_ms * ms);
      ASSERT_NE(tool.state, ToolState::valid) << n << " " << i;
    }
    EXPECT_LT((tool.X_TH.p - record_at(0).X_TH.p).norm(), 1e-6) << "the last one that was seen";
    record.X_TH.p = -record.X_TH.p;
    tracker->receive(wire_of(record), now += period_ms * ms);
    EXPECT_EQ(tool.state, ToolState::valid);
  }
}

TEST(Polhemus, AnyBytesAreSurvived) {
  std::mt19937 random(5);
  const std::string_view alphabet = "0123 LYPAUC!%\x01\x02";
  RecordReceiver receiver;
  for (int i = 0; i < 500'000; ++i) {
    const auto byte = static_cast<std::uint8_t>(
        i / 1000 % 2 == 0 ? random() : static_cast<unsigned>(alphabet[random() % alphabet.size()]));
    static_cast<void>(receiver.push(byte));
  }
}

}  // namespace
}  // namespace godobject::polhemus::test_polhemus
