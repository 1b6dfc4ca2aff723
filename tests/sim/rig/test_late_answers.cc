// Answers that reach the host late and are stamped on arrival, as from an adapter on a serial line. Their
// samples have their true age, and are stale beyond the limit.
#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <random>

#include "tests/support/simulated_rig.h"

namespace godobject::test_late_answers {
namespace {

using test::SimulatedRig;

constexpr double speed = 2;  // rad/s, of every joint
constexpr double cycle_s = 1e-3;

/// Host's end of a bus. A frame can be read `delay_ns` and a jitter after its arrival, in order, stamped
/// then.
class LateBus final : public CanBus {
 public:
  LateBus(CanBus& bus, const Nanoseconds& now) : bus_(bus), now_(now) {}
  bool open() noexcept override { return bus_.open(); }
  void close() noexcept override { bus_.close(); }
  SendResult try_send(const CanFrame& frame) noexcept override { return bus_.try_send(frame); }
  bool try_receive(ReceivedFrame& out) noexcept override {
    for (ReceivedFrame received; bus_.try_receive(received);) {
      if (lost(random_)) continue;
      received.t_ns += delay_ns + static_cast<Nanoseconds>(jitter_ns * uniform_(random_));
      t_last_ = received.t_ns = std::max(t_last_, received.t_ns);
      arriving_.push_back(received);
    }
    if (arriving_.empty() || arriving_.front().t_ns > now_) return false;
    out = arriving_.front();
    arriving_.pop_front();
    return true;
  }
  BusState state() const noexcept override { return bus_.state(); }
  BusCounters counters() const noexcept override { return bus_.counters(); }

  Nanoseconds delay_ns = 0;
  double jitter_ns = 0;
  std::bernoulli_distribution lost{0};

 private:
  CanBus& bus_;
  const Nanoseconds& now_;
  std::deque<ReceivedFrame> arriving_;
  Nanoseconds t_last_ = 0;
  std::mt19937 random_{5};
  std::uniform_real_distribution<double> uniform_;
};

RigParams params_with(double stale_after_s, std::uint8_t status_every_nth_sync) {
  RigParams params = test::arm_rig_params();
  params.stale_after_s = stale_after_s;
  for (DriveParams& drive : params.drives) drive.status_every_nth_sync = status_every_nth_sync;
  return params;
}

/// An arm with encoders on can0 and drives on can1, whose joints turn.
class LateArm {
 public:
  explicit LateArm(double stale_after_s = 3e-3, std::uint8_t status_every_nth_sync = 1)
      : device(params_with(stale_after_s, status_every_nth_sync)) {
    for (CanBus* const bus : device.hosts) buses.emplace_back(*bus, device.now);
    std::vector<CanBus*> ports;
    for (LateBus& bus : buses) ports.push_back(&bus);
    device.rig = std::make_unique<Rig>(device.params, cycle_s, ports);
    device.q_ref = [](double t) { return q(t); };
    device.q_ref_dot = [](double) { return JointVector(JointVector::Constant(6, speed)); };
  }
  static JointVector q(double t) { return JointVector::Constant(6, speed * t - 0.5); }

  bool boot() { return device.boot() && device.rig->arm(); }
  void delay_ms(std::size_t bus, double ms) { buses[bus].delay_ns = std::llround(1e6 * ms); }
  /// Returns the number of cycles with valid samples. `furthest` keeps the largest error of each sample
  /// against its joint at the sampling time.
  int cycles(int count) {
    int valid = 0;
    for (int i = 0; i < count; ++i) {
      device.cycle();
      valid += device.sample.valid && device.sample.fresh ? 1 : 0;
      for (std::size_t k = 0; k < device.rig->num_encoders(); ++k) {
        const JointSample joint = device.rig->encoder(k).sample(device.now);
        const double off = joint.q - q(1e-9 * static_cast<double>(joint.t_ns))(static_cast<Eigen::Index>(k));
        furthest[k] = std::max(furthest[k], std::abs(off));
      }
    }
    return valid;
  }
  /// Returns the number of encoders whose samples match their sampling time to `error` rad.
  auto num_right(double error) const {
    return std::ranges::count_if(furthest, [error](double off) { return off < error; });
  }
  RigFault faults() const { return device.rig->faults(); }
  std::string fault_text() const { return device.rig->fault_text(); }

  SimulatedRig device;
  std::deque<LateBus> buses;
  std::array<double, 6> furthest{};  // rad, by encoder
};

constexpr double off_by_a_period = speed * cycle_s + 2 / test::arm_counts_per_rad;

// Answers of two encoders may come now in one period, now in the next: their delay is not believed.
// A delay within a period of stale_after may be either.
bool is_near(double delay_s, double stale_after_s) {
  return std::abs(delay_s - stale_after_s) < 1.01 * cycle_s;
}

TEST(LateAnswers, ConstantDelayIsSeenWhileBooting) {
  for (const double stale_after_s : {3e-3, 12e-3})
    for (const double share : {0.0, 0.1, 0.3, 0.6, 1.5, 3.0, 6.0}) {
      const double delay_s = share * stale_after_s + 0.2e-3;
      if (is_near(delay_s, stale_after_s)) continue;
      LateArm arm(stale_after_s);
      arm.delay_ms(0, 1e3 * delay_s);
      EXPECT_EQ(arm.boot(), delay_s < stale_after_s) << delay_s << ", " << stale_after_s << arm.fault_text();
      if (delay_s > stale_after_s) {
        arm.cycles(3000);
        EXPECT_EQ(arm.faults(), RigFault::boot_timeout) << delay_s << arm.fault_text();
        EXPECT_NE(arm.fault_text().find("later than stale_after"), std::string::npos) << arm.fault_text();
        continue;
      }
      arm.furthest = {};
      EXPECT_GT(arm.cycles(2000), 1500) << delay_s;  // one may come after the deadline
      EXPECT_EQ(arm.faults(), RigFault::none) << delay_s << arm.fault_text();
      EXPECT_GE(arm.num_right(off_by_a_period), 4) << delay_s << ", " << stale_after_s;
    }
}

TEST(LateAnswers, DelayThatBeginsWhileRunningIsSampleStaleInTime) {
  for (const double stale_after_s : {3e-3, 12e-3})
    for (double share = 0.05; share < 7; share *= 1.25) {
      const double delay_s = share * stale_after_s;
      if (is_near(delay_s, stale_after_s)) continue;
      LateArm arm(stale_after_s);
      ASSERT_TRUE(arm.boot()) << arm.fault_text();
      arm.cycles(50);
      arm.delay_ms(0, 1e3 * delay_s);
      const Nanoseconds begin = arm.device.now;
      arm.cycles(200);
      arm.furthest = {};
      arm.cycles(1000);
      if (delay_s < stale_after_s) {
        EXPECT_EQ(arm.faults(), RigFault::none) << delay_s << ", " << stale_after_s << arm.fault_text();
        EXPECT_GE(arm.num_right(off_by_a_period), 4) << delay_s << ", " << stale_after_s;
        continue;
      }
      ASSERT_TRUE(any(arm.faults() & RigFault::sample_stale)) << delay_s << ", " << stale_after_s;
      EXPECT_EQ(arm.faults() | RigFault::sensors_disagree,  // until the delay is known
                RigFault::sample_stale | RigFault::sensors_disagree)
          << delay_s << ", " << stale_after_s << arm.fault_text();
      const double took_s =
          1e-9 * static_cast<double>(arm.device.rig->fault_log().first(RigFault::sample_stale).t_ns - begin);
      EXPECT_LT(took_s, delay_s + 2 * arm.device.params.lost_after_s + 8 * stale_after_s + 50 * cycle_s)
          << delay_s << ", " << stale_after_s;
    }
}

TEST(LateAnswers, OfDrivesAreDriveSilent) {
  for (const std::uint8_t nth : {std::uint8_t{1}, std::uint8_t{3}})
    for (const double delay_s : {0.5e-3, 1.4e-3, 8e-3, 20e-3}) {
      LateArm arm(3e-3, nth);
      ASSERT_TRUE(arm.boot()) << arm.fault_text();
      arm.delay_ms(1, 1e3 * delay_s);
      arm.cycles(1000);
      EXPECT_EQ(arm.faults(), delay_s > 3e-3 ? RigFault::drive_silent : RigFault::none)
          << delay_s << ", " << int{nth} << arm.fault_text();
    }
}

TEST(LateAnswers, DelayThatGrowsSlowlyIsSeen) {
  LateArm arm;
  ASSERT_TRUE(arm.boot()) << arm.fault_text();
  for (double ms = 0; ms < 9; ms += 0.01) {
    arm.delay_ms(0, ms);
    arm.cycles(1);
    ASSERT_TRUE(ms > 2 || !any(arm.faults())) << ms << arm.fault_text();
  }
  EXPECT_EQ(arm.faults(), RigFault::sample_stale) << arm.fault_text();
}

TEST(LateAnswers, LossesAreNoDelay) {
  for (const double share : {0.001, 0.01, 0.1}) {
    LateArm arm;
    ASSERT_TRUE(arm.boot()) << arm.fault_text();
    for (LateBus& bus : arm.buses) bus.lost = std::bernoulli_distribution(share);
    arm.furthest = {};
    arm.cycles(5000);
    EXPECT_EQ(arm.faults(), RigFault::none) << share << arm.fault_text();
    EXPECT_EQ(arm.num_right(2 / test::arm_counts_per_rad + 0.1 * speed * cycle_s), 6) << share;
  }
}

TEST(LateAnswers, LossesDoNotHideADelay) {
  for (const double share : {0.001, 0.01, 0.1}) {
    LateArm arm;
    ASSERT_TRUE(arm.boot()) << arm.fault_text();
    arm.buses[0].lost = std::bernoulli_distribution(share);
    arm.delay_ms(0, 9);
    arm.cycles(5000);
    EXPECT_TRUE(any(arm.faults() & RigFault::sample_stale)) << share << arm.fault_text();
  }
}

TEST(LateAnswers, JitterBelowAPeriodIsNoDelay) {
  for (const double jitter_ms : {0.2, 0.5, 0.7, 0.9}) {
    LateArm arm;
    ASSERT_TRUE(arm.boot()) << arm.fault_text();
    for (LateBus& bus : arm.buses) bus.jitter_ns = 1e6 * jitter_ms;
    arm.cycles(10'000);
    EXPECT_EQ(arm.faults(), RigFault::none) << jitter_ms << arm.fault_text();
  }
}

// The host sleeps, and reads the frames of that time when it wakes.
TEST(LateAnswers, HostThatWakesLateIsNoDelay) {
  LateArm arm(12e-3);
  ASSERT_TRUE(arm.boot()) << arm.fault_text();
  std::mt19937 random(3);
  std::uniform_int_distribution<Nanoseconds> sleeps(100'000, 9'000'000);
  for (int i = 0; i < 300; ++i) {
    arm.cycles(7);
    arm.device.idle(sleeps(random));
  }
  arm.cycles(100);
  EXPECT_EQ(arm.faults(), RigFault::none) << arm.fault_text();
}

TEST(LateAnswers, BusWithoutTroubleLeavesOutOneSync) {
  LateArm arm;
  ASSERT_TRUE(arm.boot()) << arm.fault_text();
  const std::uint64_t syncs = arm.device.rig->counters().syncs;
  EXPECT_EQ(arm.cycles(5000), 5000);
  EXPECT_EQ(arm.device.rig->counters().syncs, syncs + 5000);
  EXPECT_EQ(arm.device.rig->counters().incomplete_syncs, 0u);
}

}  // namespace
}  // namespace godobject::test_late_answers
