// Frames and pointer messages agree with docs/view.md, and invalid pointer messages are refused.
#include "platform/session/record.h"
#include "platform/view/frame.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace godobject::test_frame {
namespace {

/// Returns a sample with random numbers.
ViewSample random_sample(std::mt19937& random, std::size_t num_bodies, std::size_t num_contacts) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  const auto pose = [&] {
    return Pose{.p = vector(),
                .q = Quat(number(random), number(random), number(random), number(random)).normalized()};
  };
  ViewSample sample{.record = {}, .phase = RunPhase::running, .counters = {}, .touching = {}};
  CycleRecord& record = sample.record;
  record.cycle = random();
  record.t = number(random);
  record.engaged = true;
  record.fault = Fault::contacts_full;
  record.limited = Limited::torque | Limited::ramp;
  record.rig_faults = RigFault::second_host;
  record.drives.rate_limited = 4;
  record.held = num_bodies - 1;
  record.hand_W = {.tau = vector(), .f = vector()};
  for (std::size_t i = 0; i < num_bodies; ++i) {
    BodyView body;
    body.X_WB = pose();
    body.target.X_WD = pose();
    body.coupling_B = {.tau = vector(), .f = vector()};
    body.feedback_D = {.tau = vector(), .f = vector()};
    record.bodies.push_back(body);
  }
  for (std::size_t i = 0; i < num_contacts; ++i)
    sample.touching.push_back({.a = i % num_bodies,
                               .b = i % 2 == 0 ? world : 0,
                               .p_W = vector(),
                               .n_W = vector(),
                               .F_W = vector()});
  sample.num_touching = num_contacts;
  sample.paused = true;
  record.joint_q = {0.5, -0.25};
  record.device_q = {2};
  record.drive_torque = {3};
  record.bodies.back().joint_C = {.tau = Vec3(5, 12, 0), .f = Vec3(3, 0, 4)};
  record.term_forces = {{.tau = Vec3::Zero(), .f = Vec3(0, 10, 0)}};
  return sample;
}

template <class T>
T at(const std::vector<std::uint8_t>& bytes, std::size_t place) {
  T value;
  std::memcpy(&value, bytes.data() + place, sizeof value);  // assumes a little-endian machine
  return value;
}

void expect_vector(const std::vector<std::uint8_t>& bytes, std::size_t place, const Vec3& expected) {
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(at<float>(bytes, place + 4 * static_cast<std::size_t>(i)), static_cast<float>(expected[i]))
        << place;
}

std::uint32_t bit_of(std::string_view limit) {
  const auto* const found = std::ranges::find(run_limits, limit, &RunLimit::name);
  EXPECT_NE(found, run_limits.end()) << limit;
  return 1u << (found - run_limits.begin());
}

TEST(Frame, HasTheDocumentedLayout) {
  static_assert(std::endian::native == std::endian::little);
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    const std::size_t num_bodies = 1 + random() % 9, num_contacts = random() % 20;
    const ViewSample sample = random_sample(random, num_bodies, num_contacts);
    const std::vector<std::size_t> driven{num_bodies / 2};
    const std::vector<Vec3> vertices(3, Vec3(1, 2, 3));
    const std::vector<std::size_t> children{num_bodies - 1};
    std::vector<std::uint8_t> bytes;
    encode(sample, driven, vertices, bytes, children);
    const std::size_t values = 132 + 28 * num_bodies + 76 + 44 * num_contacts + 12 * vertices.size();
    ASSERT_EQ(bytes.size(), values + 4 * 8);
    EXPECT_EQ(at<std::uint32_t>(bytes, 120), 8u);
    const std::array<float, 8> expected{0.5F, -0.25F, 2, 3, 5, 13, 10, 0};
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_EQ(at<float>(bytes, values + 4 * i), expected[i]) << i;
    EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "GOVF");
    EXPECT_EQ(at<std::uint16_t>(bytes, 4), 1);
    EXPECT_EQ(at<std::uint16_t>(bytes, 6), 132);
    EXPECT_EQ(at<std::uint64_t>(bytes, 8), sample.record.cycle);
    EXPECT_EQ(at<double>(bytes, 16), sample.record.t);
    EXPECT_EQ(bytes[24], 2);
    EXPECT_EQ(bytes[25], frame_engaged | frame_paused);
    EXPECT_EQ(at<std::uint16_t>(bytes, 26), 1);
    EXPECT_EQ(at<std::uint32_t>(bytes, 28), 1u << 3);
    EXPECT_EQ(at<std::uint32_t>(bytes, 32), bit_of("torque") | bit_of("ramp") | bit_of("drive_torque_rate"));
    EXPECT_EQ(at<std::uint32_t>(bytes, 36), 1u << 14);
    EXPECT_EQ(at<std::int32_t>(bytes, 40), static_cast<std::int32_t>(num_bodies - 1));
    EXPECT_EQ(at<std::uint32_t>(bytes, 44), num_bodies);
    EXPECT_EQ(at<std::uint32_t>(bytes, 48), num_contacts);
    EXPECT_EQ(at<std::uint32_t>(bytes, 52), 3u);
    expect_vector(bytes, 80, sample.record.hand_W.f);
    expect_vector(bytes, 132 + 28 * (num_bodies - 1), sample.record.bodies.back().X_WB.p);
    const BodyView& tool = sample.record.bodies[driven.front()];
    const std::size_t after_bodies = 132 + 28 * num_bodies;
    expect_vector(bytes, after_bodies, tool.target.X_WD.p);
    expect_vector(bytes, after_bodies + 12, Vec3(tool.target.X_WD.q.vec()));
    EXPECT_EQ(at<float>(bytes, after_bodies + 24), static_cast<float>(tool.target.X_WD.q.w()));
    expect_vector(bytes, after_bodies + 28, tool.coupling_B.f);
    expect_vector(bytes, after_bodies + 52, tool.feedback_D.f);
    if (num_contacts > 0) {
      const std::size_t contact = after_bodies + 76;
      EXPECT_EQ(at<std::uint32_t>(bytes, contact + 4), UINT32_MAX) << "the world";
      expect_vector(bytes, contact + 32, sample.touching.front().F_W);
    }
    expect_vector(bytes, values - 12, Vec3(1, 2, 3));
  }
}

TEST(Frame, LeavesOutContactsBeyondItsRoom) {
  std::mt19937 random(2);
  const ViewSample sample = random_sample(random, 2, max_frame_contacts + 100);
  std::vector<std::uint8_t> bytes;
  encode(sample, {}, {}, bytes);
  EXPECT_EQ(at<std::uint32_t>(bytes, 48), max_frame_contacts);
}

TEST(Pointer, IsReadBackAsItWasWritten) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-0.5, 0.5);
  for (int round = 0; round < 1000; ++round) {
    const PointerMessage sent{.number = static_cast<std::uint32_t>(random()),
                              .holds = random() % 2 == 0,
                              .moves = random() % 2 == 0,
                              .target = static_cast<std::uint32_t>(random()),
                              .dp_W = Vec3(number(random), number(random), number(random)),
                              .dphi_W = Vec3(number(random), number(random), number(random))};
    PointerMessage read;
    ASSERT_EQ(decode(encode(sent), read), ParseResult::ok);
    EXPECT_EQ(read.number, sent.number);
    EXPECT_EQ(read.holds, sent.holds);
    EXPECT_EQ(read.moves, sent.moves);
    EXPECT_EQ(read.target, sent.target);
    EXPECT_EQ(read.dp_W, sent.dp_W.cast<float>().cast<double>());
    EXPECT_EQ(read.dphi_W, sent.dphi_W.cast<float>().cast<double>());
  }
}

TEST(Pointer, IsRefusedWhereItIsNone) {
  const auto with = [](std::size_t place, std::uint8_t byte) {
    auto bytes = encode(PointerMessage{});
    bytes[place] = byte;
    return bytes;
  };
  PointerMessage out{.number = 7};
  EXPECT_EQ(decode(with(0, 'X'), out), ParseResult::other_message);
  EXPECT_EQ(decode(with(4, 2), out), ParseResult::bad_value) << "another version";
  EXPECT_EQ(decode(with(6, 4), out), ParseResult::bad_value) << "a button that there is not";
  const auto bytes = encode(PointerMessage{});
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_EQ(decode(std::span(bytes).first(size), out), ParseResult::too_short);
  std::vector<std::uint8_t> longer(bytes.begin(), bytes.end());
  longer.push_back(0);
  EXPECT_EQ(decode(longer, out), ParseResult::too_long);
  for (const double x :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1.5, -4.0}) {
    EXPECT_EQ(decode(encode(PointerMessage{.dp_W = Vec3(0, x, 0)}), out), ParseResult::bad_value) << x;
    EXPECT_EQ(decode(encode(PointerMessage{.dphi_W = Vec3(x * 3, 0, 0)}), out), ParseResult::bad_value) << x;
  }
  EXPECT_EQ(out.number, 7u) << "untouched";
}

/// Returns the bytes of docs/view.md.
std::vector<std::uint8_t> pace_message(std::uint16_t steps, float speed, std::uint16_t version = 1) {
  std::vector<std::uint8_t> bytes(12);
  std::memcpy(bytes.data(), "GOVC", 4);
  std::memcpy(&bytes[4], &version, 2);
  std::memcpy(&bytes[6], &steps, 2);
  std::memcpy(&bytes[8], &speed, 4);
  return bytes;
}

TEST(PaceMessage, IsReadOrRefused) {
  PaceMessage read;
  ASSERT_EQ(decode(pace_message(3, 0.25F), read), ParseResult::ok);
  EXPECT_EQ(read.steps, 3);
  EXPECT_EQ(read.speed, 0.25);
  ASSERT_EQ(decode(pace_message(0, std::numeric_limits<float>::infinity()), read), ParseResult::ok);
  EXPECT_EQ(read.speed, ViewPace::unlimited);
  for (const float speed : {-0.1F, 101.0F, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_EQ(decode(pace_message(0, speed), read), ParseResult::bad_value) << speed;
  EXPECT_EQ(decode(pace_message(1001, 0), read), ParseResult::bad_value);
  EXPECT_EQ(decode(pace_message(0, 0, 2), read), ParseResult::bad_value);
  EXPECT_EQ(decode(std::vector<std::uint8_t>(12), read), ParseResult::other_message);
  EXPECT_EQ(decode(std::vector<std::uint8_t>(11), read), ParseResult::too_short);
  EXPECT_EQ(read.speed, ViewPace::unlimited) << "unchanged";
}

TEST(ResetMessage, IsReadOrRefused) {
  std::vector<std::uint8_t> bytes{'G', 'O', 'V', 'R', 1, 0, 0, 0};
  ResetMessage read;
  EXPECT_EQ(decode(bytes, read), ParseResult::ok);
  for (const std::size_t i : {4U, 6U}) {
    std::vector<std::uint8_t> other = bytes;
    other[i] = 2;
    EXPECT_EQ(decode(other, read), ParseResult::bad_value);
  }
  bytes[3] = 'P';
  EXPECT_EQ(decode(bytes, read), ParseResult::other_message);
  bytes.pop_back();
  EXPECT_EQ(decode(bytes, read), ParseResult::too_short);
}

TEST(Pace, PausesStepsAndSlows) {
  constexpr Nanoseconds step = 1'000'000;
  ViewPace pace;
  EXPECT_TRUE(pace.may_run(0, step));
  pace.set(0, 0);
  EXPECT_TRUE(pace.paused());
  EXPECT_FALSE(pace.may_run(step, step));
  pace.set(0, 2);
  EXPECT_TRUE(pace.may_run(2 * step, step));
  EXPECT_TRUE(pace.may_run(3 * step, step));
  EXPECT_FALSE(pace.may_run(4 * step, step));
  pace.set(0.25, 0);
  EXPECT_FALSE(pace.paused());
  int runs = 0;
  for (int i = 0; i < 400; ++i) runs += pace.may_run((5 + i) * step, step) ? 1 : 0;
  EXPECT_NEAR(runs, 100, 1);
  runs = 0;  // after a second without a wake-up it catches up by 20 ms at most
  for (int i = 0; i < 100; ++i) runs += pace.may_run((1405 + i) * step, step) ? 1 : 0;
  EXPECT_NEAR(runs, 30, 2);
  pace.set(ViewPace::unlimited, 0);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(pace.may_run(1505 * step, step));
}

TEST(JointsMessage, IsReadBackAsItWasWritten) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-max_joint_shift, max_joint_shift);
  for (int round = 0; round < 1000; ++round) {
    JointsMessage sent{.number = static_cast<std::uint32_t>(random()),
                       .holds = random() % 2 == 0,
                       .num_joints = static_cast<std::uint32_t>(random() % (max_joints + 1))};
    for (std::size_t i = 0; i < sent.num_joints; ++i) sent.dq[i] = number(random);
    JointsMessage read;
    ASSERT_EQ(decode(encode(sent), read), ParseResult::ok);
    EXPECT_EQ(read.number, sent.number);
    EXPECT_EQ(read.holds, sent.holds);
    EXPECT_EQ(read.num_joints, sent.num_joints);
    for (std::size_t i = 0; i < max_joints; ++i)
      EXPECT_EQ(read.dq[i], static_cast<double>(static_cast<float>(sent.dq[i])));
  }
}

TEST(JointsMessage, IsRefusedWhereItIsNone) {
  const auto with = [](std::size_t place, std::uint8_t byte) {
    auto bytes = encode(JointsMessage{.num_joints = 3});
    bytes[place] = byte;
    return bytes;
  };
  JointsMessage out{.number = 7};
  EXPECT_EQ(decode(with(0, 'X'), out), ParseResult::other_message);
  EXPECT_EQ(decode(with(4, 1), out), ParseResult::bad_value) << "another version";
  EXPECT_EQ(decode(with(6, 2), out), ParseResult::bad_value) << "a button that there is not";
  EXPECT_EQ(decode(with(12, max_joints + 1), out), ParseResult::bad_value) << "more joints than there are";
  const auto bytes = encode(JointsMessage{.num_joints = 3});
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_EQ(decode(std::span(bytes).first(size), out), ParseResult::too_short);
  std::vector<std::uint8_t> longer(bytes.begin(), bytes.end());
  longer.push_back(0);
  EXPECT_EQ(decode(longer, out), ParseResult::too_long);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (std::size_t joint = 0; joint < 3; ++joint)
    for (const double x : {nan, inf, -inf, 1.01, -1.01}) {
      JointsMessage message{.num_joints = 3};
      message.dq[joint] = x;
      EXPECT_EQ(decode(encode(message), out), ParseResult::bad_value) << x;
    }
  JointsMessage beyond{.num_joints = 3};
  beyond.dq[3] = 0.01;
  EXPECT_EQ(decode(encode(beyond), out), ParseResult::bad_value) << "a shift of no joint";
  EXPECT_EQ(out.number, 7u) << "untouched";
  PointerMessage pointer;
  EXPECT_NE(decode(bytes, pointer), ParseResult::ok) << "of version 2 alone";
  EXPECT_NE(decode(encode(PointerMessage{}), out), ParseResult::ok) << "of version 1 alone";
}

}  // namespace
}  // namespace godobject::test_frame
