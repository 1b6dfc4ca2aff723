#include "sim/bus/can_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <tuple>
#include <vector>

namespace godobject::test_sim_can_bus {
namespace {

using testing::ElementsAre;

constexpr Nanoseconds us = 1000;

CanFrame frame_of(std::uint32_t id, std::uint8_t size = 8, std::uint8_t fill = 0x55) {
  CanFrame frame{.id = id, .size = size};
  for (std::uint8_t i = 0; i < size; ++i) frame.data[i] = fill;
  return frame;
}

Nanoseconds wire_time(const CanFrame& frame) { return duration_ns(exact_bits(frame), {}); }
Nanoseconds error_end(const CanFrame& frame, int flag_bits) {  // from its start, including the intermission
  return wire_time(frame) + (-11 + flag_bits + 8 + 3) * us;
}

/// A wire with open ports on it and a list of completed frames.
struct Bus {
  explicit Bus(int num_nodes, const SimWireParams& params = {}) : wire(params) {
    for (int i = 0; i < num_nodes; ++i) EXPECT_TRUE(ports.emplace_back(wire).open());
    wire.set_observer(
        {[](void* context, const ReceivedFrame& f) { static_cast<Bus*>(context)->log.push_back(f); }, this});
  }

  std::vector<std::uint32_t> ids() const {
    std::vector<std::uint32_t> out;
    for (const ReceivedFrame& f : log) out.push_back(f.frame.id);
    return out;
  }
  void send(std::size_t node, const CanFrame& frame) {
    ASSERT_EQ(ports[node].try_send(frame), SendResult::queued);
  }

  SimCanWire wire;
  std::deque<SimCanPort> ports;
  std::vector<ReceivedFrame> log;
};

TEST(SimCanBus, DeliversToAllOthersAtTheEndOfTheFrame) {
  Bus bus(3);
  const CanFrame frame = frame_of(0x123);
  bus.wire.advance_to(5 * us);
  bus.send(0, frame);
  EXPECT_EQ(bus.wire.next_event(), 5 * us);
  const Nanoseconds end = 5 * us + wire_time(frame) - 3 * us;
  ReceivedFrame received;
  bus.wire.advance_to(end - 1);
  EXPECT_FALSE(bus.ports[1].try_receive(received));
  bus.wire.advance_to(end);
  for (const std::size_t node : {1u, 2u}) {
    ASSERT_TRUE(bus.ports[node].try_receive(received));
    EXPECT_EQ(received.frame.id, 0x123u);
    EXPECT_EQ(received.frame.data, frame.data);
    EXPECT_EQ(received.t_ns, end);
    EXPECT_EQ(bus.ports[node].counters().received, 1u);
    EXPECT_FALSE(bus.ports[node].try_receive(received));
  }
  EXPECT_FALSE(bus.ports[0].try_receive(received));
  EXPECT_EQ(bus.ports[0].counters().sent, 1u);
  bus.wire.advance_to(end + 3 * us);
  EXPECT_EQ(bus.wire.next_event(), std::nullopt);
}

TEST(SimCanBus, LowestIdentifierWinsWhoeverQueuedFirst) {
  Bus bus(4);
  bus.send(0, frame_of(0x300));
  bus.send(1, frame_of(0x200));
  bus.send(2, frame_of(0x100));
  bus.wire.advance_to(1000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x100, 0x200, 0x300));
}

TEST(SimCanBus, QueuesAreFirstInFirstOutPerNode) {
  Bus bus(3);
  bus.send(0, frame_of(0x300));
  bus.send(0, frame_of(0x001));  // behind the earlier one
  bus.send(1, frame_of(0x200));
  bus.wire.advance_to(1000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x200, 0x300, 0x001));
}

TEST(SimCanBus, FrameOnTheWireIsNotInterrupted) {
  Bus bus(3);
  const CanFrame slow = frame_of(0x700), urgent = frame_of(0x001, 0);
  bus.send(0, slow);
  bus.wire.advance_to(10 * us);
  bus.send(1, urgent);
  bus.send(2, frame_of(0x002, 0));
  bus.wire.advance_to(1000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x700, 0x001, 0x002));
  EXPECT_EQ(bus.log[0].t_ns, wire_time(slow) - 3 * us);
  EXPECT_EQ(bus.log[1].t_ns, wire_time(slow) + wire_time(urgent) - 3 * us);
}

// A node that answers within the intermission competes with frames that waited longer.
TEST(SimCanBus, AnswerInTheIntermissionTakesPart) {
  Bus bus(3);
  bus.send(0, frame_of(0x080, 0));
  bus.send(1, frame_of(0x300));
  bus.wire.advance_to(wire_time(frame_of(0x080, 0)) - 3 * us);
  bus.send(2, frame_of(0x181));
  bus.wire.advance_to(1000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x080, 0x181, 0x300));
}

TEST(SimCanBus, ArbitrationFollowsTheBitsOfStandardAndExtendedFrames) {
  const std::uint32_t base = 0x123;
  CanFrame remote{.id = base, .remote = true};
  CanFrame extended{.id = base << 18, .extended = true};
  CanFrame extended_remote = extended;
  extended_remote.remote = true;
  const CanFrame extended_lower{.id = (base << 18) - 1, .extended = true};  // base 0x122
  Bus bus(5);
  bus.send(0, extended_remote);
  bus.send(1, extended);
  bus.send(2, remote);
  bus.send(3, frame_of(base));
  bus.send(4, extended_lower);
  bus.wire.advance_to(10'000 * us);
  ASSERT_EQ(bus.log.size(), 5u);
  const auto kind = [](const ReceivedFrame& f) {
    return std::tuple(f.frame.id, f.frame.extended, f.frame.remote);
  };
  EXPECT_EQ(kind(bus.log[0]), std::tuple((base << 18) - 1, true, false));
  EXPECT_EQ(kind(bus.log[1]), std::tuple(base, false, false));
  EXPECT_EQ(kind(bus.log[2]), std::tuple(base, false, true));
  EXPECT_EQ(kind(bus.log[3]), std::tuple(base << 18, true, false));
  EXPECT_EQ(kind(bus.log[4]), std::tuple(base << 18, true, true));
}

TEST(SimCanBus, BusyTimeIsTheSumOfTheFrameTimes) {
  Bus bus(3);
  Nanoseconds sum = 0;
  for (std::uint32_t i = 0; i < 16; ++i) {
    const CanFrame a =
        frame_of(0x100 + i, static_cast<std::uint8_t>(i % 9), static_cast<std::uint8_t>(17 * i));
    const CanFrame b = frame_of(0x200 + i, 8, 0);
    bus.send(0, a);
    bus.send(1, b);
    sum += wire_time(a) + wire_time(b);
  }
  bus.wire.advance_to(sum - 1);
  EXPECT_LT(bus.wire.counters().busy_ns, sum);
  bus.wire.advance_to(2 * sum);
  EXPECT_EQ(bus.wire.counters().busy_ns, sum);
  EXPECT_EQ(bus.wire.counters().frames, 32u);
}

TEST(SimCanBus, WireTimeFollowsTheBitRates) {
  Bus bus(2, {.rates = {.nominal = 500e3, .data = 5e6}});
  CanFrame fd = frame_of(0x100, 64);
  fd.fd = fd.bit_rate_switch = true;
  bus.send(0, frame_of(0x001));
  bus.send(0, fd);
  bus.wire.advance_to(10'000 * us);
  const Nanoseconds first = 2 * wire_time(frame_of(0x001));
  EXPECT_EQ(bus.wire.counters().busy_ns,
            first + duration_ns(worst_bits(fd), {.nominal = 500e3, .data = 5e6}));
}

TEST(SimCanBus, RefusalsAreReportedAndCounted) {
  SimCanWire wire({});
  SimCanPort port(wire);
  EXPECT_EQ(port.state(), BusState::closed);
  EXPECT_EQ(port.try_send(frame_of(1)), SendResult::down);
  ASSERT_TRUE(port.open());
  EXPECT_EQ(port.state(), BusState::error_active);
  EXPECT_EQ(port.try_send(frame_of(0x800)), SendResult::invalid);
  for (std::size_t i = 0; i < SimCanPort::transmit_capacity; ++i) {
    EXPECT_EQ(port.try_send(frame_of(1)), SendResult::queued);
  }
  EXPECT_EQ(port.try_send(frame_of(1)), SendResult::full);
  EXPECT_EQ(port.counters().send_refused, 3u);
}

TEST(SimCanBus, FullReceiveQueueLosesTheNewestAndCounts) {
  Bus bus(2);
  const std::size_t extra = 3;
  for (std::size_t i = 0; i < SimCanPort::receive_capacity + extra; ++i) {
    bus.send(0, frame_of(static_cast<std::uint32_t>(i + 1), 0));
    bus.wire.advance_to(bus.wire.now() + 100 * us);
  }
  EXPECT_EQ(bus.ports[1].counters().receive_overflow, extra);
  ReceivedFrame received;
  ASSERT_TRUE(bus.ports[1].try_receive(received));
  EXPECT_EQ(received.frame.id, 1u);
}

TEST(SimCanBus, WireHasAFixedNumberOfPlaces) {
  SimCanWire wire({});
  std::deque<SimCanPort> ports;
  for (std::size_t i = 0; i < SimCanWire::max_nodes; ++i) EXPECT_TRUE(ports.emplace_back(wire).open());
  {
    SimCanPort one_too_many(wire);
    EXPECT_FALSE(one_too_many.open());
    one_too_many.set_connected(false);
    EXPECT_EQ(one_too_many.try_send(frame_of(1)), SendResult::down);
  }
  ports.pop_back();
  EXPECT_TRUE(ports.emplace_back(wire).open());
}

// Errors.

TEST(SimCanBus, LoneNodeBecomesPassiveButNotBusOff) {
  Bus bus(1);
  bus.send(0, frame_of(0x100));
  Nanoseconds t = 0;
  for (int attempt = 1; attempt <= 16; ++attempt) {
    t += error_end(frame_of(0x100), 6);
    bus.wire.advance_to(t - 1);
    EXPECT_EQ(bus.ports[0].counters().transmit_error_counter, 8 * attempt);
  }
  EXPECT_EQ(bus.ports[0].state(), BusState::error_passive);
  bus.wire.advance_to(1'000'000 * us);
  EXPECT_EQ(bus.ports[0].counters().transmit_error_counter, 128);
  EXPECT_EQ(bus.ports[0].counters().bus_off_events, 0u);
  EXPECT_EQ(bus.ports[0].counters().sent, 0u);
  // From the 17th attempt on each lasts longer by the suspend transmission time.
  const Nanoseconds period = error_end(frame_of(0x100), 6) + 8 * us;
  const auto attempts = 16 + (1'000'000 * us - t - 8 * us) / period;
  EXPECT_NEAR(static_cast<double>(bus.wire.counters().error_frames), static_cast<double>(attempts), 1);
}

TEST(SimCanBus, FrameNobodyAcknowledgedIsSentWhenSomebodyListens) {
  Bus bus(2);
  bus.ports[1].close();
  bus.send(0, frame_of(0x100));
  bus.wire.advance_to(100'000 * us);
  EXPECT_TRUE(bus.log.empty());
  ASSERT_TRUE(bus.ports[1].open());
  bus.wire.advance_to(101'000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x100));
  EXPECT_EQ(bus.ports[0].counters().transmit_error_counter, 127);
}

TEST(SimCanBus, CorruptedFrameIsRepeatedAfterAnErrorFrame) {
  Bus bus(3, {.corruption_probability = 1});
  const CanFrame frame = frame_of(0x100);
  bus.send(0, frame);
  const Nanoseconds idle = error_end(frame, 7);
  bus.wire.advance_to(idle - 1);
  bus.wire.set_corruption_probability(0);
  EXPECT_EQ(bus.ports[0].counters().transmit_error_counter, 8);
  EXPECT_EQ(bus.ports[1].counters().receive_error_counter, 1);
  EXPECT_EQ(bus.ports[2].counters().error_frames, 1u);
  bus.wire.advance_to(1000 * us);
  ASSERT_EQ(bus.log.size(), 1u);
  EXPECT_EQ(bus.log[0].t_ns, idle + wire_time(frame) - 3 * us);
  EXPECT_EQ(bus.ports[0].counters().transmit_error_counter, 7);
  EXPECT_EQ(bus.ports[1].counters().receive_error_counter, 0);
  EXPECT_EQ(bus.wire.counters().error_frames, 1u);
  EXPECT_EQ(bus.wire.counters().busy_ns, idle + wire_time(frame));
}

TEST(SimCanBus, ErrorCostsAtMostTheFrameAnd31Bits) {
  const CanFrame frame = frame_of(0x100);
  EXPECT_LE(error_end(frame, 7) + 8 * us, wire_time(frame) + 31 * us);
}

// After 16 failures the sender is passive and waits 8 bits: a frame of lower priority overtakes its retry.
TEST(SimCanBus, PassiveSenderSuspendsTransmission) {
  Bus bus(3, {.corruption_probability = 1});
  const CanFrame frame = frame_of(0x100);
  bus.send(0, frame);
  const Nanoseconds attempt = error_end(frame, 7);
  bus.wire.advance_to(16 * attempt - 1);
  EXPECT_EQ(bus.ports[0].state(), BusState::error_passive);
  bus.wire.set_corruption_probability(0);
  bus.wire.advance_to(16 * attempt + 4 * us);
  bus.send(1, frame_of(0x700, 0));
  bus.wire.advance_to(16 * attempt + 2000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x700, 0x100));
}

TEST(SimCanBus, BusOffDropsTheQueueAndStaysWithoutRestart) {
  Bus bus(3, {.corruption_probability = 1});
  bus.send(0, frame_of(0x100));
  bus.send(0, frame_of(0x101));
  bus.wire.advance_to(10'000'000 * us);
  EXPECT_EQ(bus.ports[0].state(), BusState::bus_off);
  EXPECT_EQ(bus.ports[0].counters().bus_off_events, 1u);
  EXPECT_EQ(bus.wire.counters().error_frames, 32u);
  EXPECT_EQ(bus.ports[0].try_send(frame_of(0x102)), SendResult::off);
  EXPECT_EQ(bus.ports[1].counters().receive_error_counter, 32);

  bus.wire.set_corruption_probability(0);
  bus.send(1, frame_of(0x200));
  bus.wire.advance_to(20'000'000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x200));
  ReceivedFrame received;
  EXPECT_FALSE(bus.ports[0].try_receive(received));
}

TEST(SimCanBus, RecoveryTakes128Times11RecessiveBits) {
  Bus bus(3, {.corruption_probability = 1});
  EXPECT_FALSE(bus.ports[0].restart());
  bus.send(0, frame_of(0x100));
  bus.wire.advance_to(10'000 * us);
  ASSERT_EQ(bus.ports[0].state(), BusState::bus_off);
  bus.wire.set_corruption_probability(0);
  EXPECT_TRUE(bus.ports[0].restart());
  bus.wire.advance_to(10'500 * us);
  EXPECT_TRUE(bus.ports[0].restart());  // does not start again
  bus.wire.advance_to(10'000 * us + 1'408'000 - 1);
  EXPECT_EQ(bus.ports[0].state(), BusState::bus_off);
  bus.wire.advance_to(10'000 * us + 1'408'000);
  EXPECT_EQ(bus.ports[0].state(), BusState::error_active);
  EXPECT_EQ(bus.ports[0].counters().transmit_error_counter, 0);
  bus.send(0, frame_of(0x111));
  bus.wire.advance_to(13'000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x111));
}

// A frame on the wire counts as one sequence of recessive bits, however long it is.
TEST(SimCanBus, TrafficDelaysTheRecovery) {
  Bus bus(3, {.corruption_probability = 1});
  bus.send(0, frame_of(0x100));
  bus.wire.advance_to(10'000 * us);
  bus.wire.set_corruption_probability(0);
  const CanFrame frame = frame_of(0x200);
  for (int i = 0; i < 10; ++i) bus.send(1, frame);
  EXPECT_TRUE(bus.ports[0].restart());
  const Nanoseconds recovered = 10'000 * us + 10 * wire_time(frame) + (128 - 10) * (11 * us);
  bus.wire.advance_to(recovered - 1);
  EXPECT_EQ(bus.ports[0].state(), BusState::bus_off);
  bus.wire.advance_to(recovered);
  EXPECT_EQ(bus.ports[0].state(), BusState::error_active);
}

TEST(SimCanBus, AutomaticRestartComesAfterItsDelay) {
  Bus bus(2, {.corruption_probability = 1});
  bus.ports[0].set_automatic_restart(50'000 * us);
  bus.send(0, frame_of(0x100));
  while (bus.ports[0].state() != BusState::bus_off) bus.wire.advance_to(*bus.wire.next_event());
  const Nanoseconds recovered = bus.wire.now() + 50'000 * us + 1'408'000;
  bus.wire.advance_to(recovered - 1);
  EXPECT_EQ(bus.ports[0].state(), BusState::bus_off);
  bus.wire.advance_to(recovered);
  EXPECT_EQ(bus.ports[0].state(), BusState::error_active);
}

TEST(SimCanBus, SameIdentifierFromTwoNodesIsAnErrorUntilBothAreBusOff) {
  Bus bus(3);
  bus.send(0, frame_of(0x181, 4, 1));
  bus.send(1, frame_of(0x181, 4, 2));
  bus.wire.advance_to(100'000 * us);
  EXPECT_TRUE(bus.log.empty());
  EXPECT_EQ(bus.ports[0].state(), BusState::bus_off);
  EXPECT_EQ(bus.ports[1].state(), BusState::bus_off);
  EXPECT_EQ(bus.wire.counters().error_frames, 32u);
}

TEST(SimCanBus, EqualFramesMerge) {
  Bus bus(3);
  bus.send(0, frame_of(0x080, 0));
  bus.send(1, frame_of(0x080, 0));
  bus.wire.advance_to(1000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x080));
  EXPECT_EQ(bus.ports[0].counters().sent, 1u);
  EXPECT_EQ(bus.ports[1].counters().sent, 1u);
  EXPECT_EQ(bus.ports[2].counters().error_frames, 0u);
}

// Faults on request.

TEST(SimCanBus, LostFrameIsMissedByOneReceiverOnly) {
  Bus bus(3);
  bus.ports[1].set_loss_probability(1);
  bus.send(0, frame_of(0x100));
  bus.wire.advance_to(1000 * us);
  bus.ports[1].set_loss_probability(0);
  bus.send(0, frame_of(0x101));
  bus.wire.advance_to(2000 * us);
  ReceivedFrame received;
  ASSERT_TRUE(bus.ports[1].try_receive(received));
  EXPECT_EQ(received.frame.id, 0x101u);
  EXPECT_EQ(bus.ports[1].lost(), 1u);
  ASSERT_TRUE(bus.ports[2].try_receive(received));
  EXPECT_EQ(received.frame.id, 0x100u);
  EXPECT_THAT(bus.ids(), ElementsAre(0x100, 0x101));
  EXPECT_EQ(bus.ports[0].counters().error_frames, 0u);
}

TEST(SimCanBus, LossHasTheSpecifiedProbability) {
  Bus bus(2);
  bus.ports[1].set_loss_probability(0.1);
  ReceivedFrame received;
  for (int i = 0; i < 10000; ++i) {
    bus.send(0, frame_of(0x100, 0));
    bus.wire.advance_to(bus.wire.now() + 100 * us);
    while (bus.ports[1].try_receive(received)) {
    }
  }
  EXPECT_NEAR(static_cast<double>(bus.ports[1].lost()), 1000, 5 * 30);  // five standard deviations
  EXPECT_EQ(bus.ports[1].counters().received + bus.ports[1].lost(), 10000u);
}

TEST(SimCanBus, DelayedFrameKeepsItsTimeStamp) {
  Bus bus(2);
  bus.ports[1].set_receive_delay(500 * us);
  bus.send(0, frame_of(0x100));
  bus.wire.advance_to(300 * us);
  const Nanoseconds end = bus.log.at(0).t_ns;
  EXPECT_EQ(bus.wire.next_event(), end + 500 * us);
  ReceivedFrame received;
  bus.wire.advance_to(end + 500 * us - 1);
  EXPECT_FALSE(bus.ports[1].try_receive(received));
  bus.wire.advance_to(end + 500 * us);
  ASSERT_TRUE(bus.ports[1].try_receive(received));
  EXPECT_EQ(received.t_ns, end);
}

TEST(SimCanBus, DisconnectedNodeTalksToItself) {
  Bus bus(3);
  bus.ports[0].set_connected(false);
  bus.send(0, frame_of(0x001));
  bus.send(1, frame_of(0x200));
  bus.wire.advance_to(100'000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x200));
  EXPECT_EQ(bus.log[0].t_ns, wire_time(frame_of(0x200)) - 3 * us);  // the others' wire is not disturbed
  EXPECT_EQ(bus.wire.counters().error_frames, 0u);
  EXPECT_EQ(bus.ports[0].state(), BusState::error_passive);
  ReceivedFrame received;
  EXPECT_FALSE(bus.ports[0].try_receive(received));
  bus.ports[0].set_connected(true);
  bus.wire.advance_to(101'000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x200, 0x001));
}

TEST(SimCanBus, PlugPulledInMidFrameIsAnErrorForTheOthers) {
  Bus bus(3);
  bus.send(0, frame_of(0x100));
  bus.wire.advance_to(50 * us);
  bus.ports[0].set_connected(false);
  bus.send(1, frame_of(0x200));
  bus.wire.advance_to(1000 * us);
  EXPECT_THAT(bus.ids(), ElementsAre(0x200));
  EXPECT_EQ(bus.log[0].t_ns, 50 * us + (6 + 6 + 8 + 3) * us + wire_time(frame_of(0x200)) - 3 * us);
  EXPECT_EQ(bus.ports[2].counters().error_frames, 1u);
  EXPECT_EQ(bus.ports[1].counters().receive_error_counter, 1);
}

TEST(SimCanBus, NodeThatJoinsInMidFrameDoesNotReceiveIt) {
  Bus bus(3);
  bus.ports[2].close();
  bus.send(0, frame_of(0x100));
  bus.wire.advance_to(50 * us);
  ASSERT_TRUE(bus.ports[2].open());
  bus.wire.advance_to(1000 * us);
  ReceivedFrame received;
  EXPECT_FALSE(bus.ports[2].try_receive(received));
  EXPECT_TRUE(bus.ports[1].try_receive(received));
}

// Determinism: a run with every fault on is a function of the seed.

using Event = std::tuple<std::uint32_t, Nanoseconds>;

std::vector<Event> noisy_run(std::uint64_t seed, Nanoseconds advance_by) {
  Bus bus(4, {.corruption_probability = 0.05, .seed = seed});
  std::vector<Event> events;
  for (SimCanPort& port : bus.ports) {
    port.set_loss_probability(0.1);
    port.set_automatic_restart(1000 * us);
  }
  for (int cycle = 0; cycle < 300; ++cycle) {
    for (std::uint32_t node = 0; node < 4; ++node) {
      static_cast<void>(bus.ports[node].try_send(frame_of(0x100 + node)));
    }
    const Nanoseconds end = bus.wire.now() + 1000 * us;
    while (bus.wire.now() < end) bus.wire.advance_to(std::min(end, bus.wire.now() + advance_by));
    ReceivedFrame received;
    for (SimCanPort& port : bus.ports) {
      while (port.try_receive(received)) events.emplace_back(received.frame.id, received.t_ns);
    }
  }
  return events;
}

TEST(SimCanBus, SameSeedSameEvents) {
  const auto events = noisy_run(7, 1000 * us);
  EXPECT_GT(events.size(), 2000u);
  EXPECT_EQ(events, noisy_run(7, 1000 * us));
  EXPECT_NE(events, noisy_run(8, 1000 * us));
}

TEST(SimCanBus, StepsOfTheClockDoNotMatter) { EXPECT_EQ(noisy_run(7, 1000 * us), noisy_run(7, 3777)); }

}  // namespace
}  // namespace godobject::test_sim_can_bus
