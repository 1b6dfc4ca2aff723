#include "hal/can/transmit_slots.h"

#include <gmock/gmock.h>

#include <random>
#include <vector>

#include "tests/support/may_allocate.h"

namespace godobject::test_transmit_slots {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr Nanoseconds ms = 1'000'000;

/// A bus that accepts `room` frames.
class NarrowBus final : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override { bus_state = BusState::closed; }
  SendResult try_send(const CanFrame& frame) noexcept override {
    [[maybe_unused]] const test::MayAllocate here;
    if (!is_valid(frame)) return SendResult::invalid;
    if (bus_state == BusState::bus_off) return SendResult::off;
    if (is_cut_off(bus_state)) return SendResult::down;
    if (room == 0) return SendResult::full;
    --room;
    sent.push_back(frame);
    return SendResult::queued;
  }
  bool try_receive(ReceivedFrame&) noexcept override { return false; }
  BusState state() const noexcept override { return bus_state; }
  BusCounters counters() const noexcept override { return {}; }

  /// Returns identifier and first byte as one number for each sent frame.
  std::vector<std::uint32_t> take_sent() {
    std::vector<std::uint32_t> out;
    for (const CanFrame& frame : sent) out.push_back(frame.id << 8 | frame.data[0]);
    sent.clear();
    return out;
  }

  std::size_t room = 0;
  BusState bus_state = BusState::error_active;
  std::vector<CanFrame> sent;
};

CanFrame frame_of(std::uint32_t id, std::uint8_t value) { return {.id = id, .size = 1, .data = {value}}; }

struct Paced : testing::Test {
  Paced() {
    EXPECT_TRUE(bus.add_slot(0x080, 1 * ms));
    EXPECT_TRUE(bus.add_slot(0x201, 1 * ms));
    EXPECT_TRUE(bus.add_slot(0x202, 2 * ms));
  }
  void send(std::uint32_t id, std::uint8_t value, SendResult expected = SendResult::queued) {
    EXPECT_EQ(bus.try_send(frame_of(id, value)), expected) << std::hex << id;
  }

  NarrowBus wire;
  PacedCanBus bus{wire, 10 * ms};
};

TEST_F(Paced, FramesGoStraightThroughWhileThereIsRoom) {
  wire.room = 10;
  send(0x202, 1);
  send(0x601, 2);
  send(0x201, 3);
  EXPECT_THAT(wire.take_sent(), ElementsAre(0x20201, 0x60102, 0x20103));
  EXPECT_EQ(bus.waiting(), 0u);
  EXPECT_EQ(bus.transmit_counters().retried, 0u);
}

TEST_F(Paced, TheNewestCommandTakesThePlaceOfTheOneThatWaits) {
  send(0x201, 1);
  send(0x201, 2);
  send(0x201, 3);
  wire.room = 10;
  bus.advance_to(0);
  EXPECT_THAT(wire.take_sent(), ElementsAre(0x20103));
  EXPECT_EQ(bus.transmit_counters().replaced, 2u);
  EXPECT_EQ(bus.counters().send_dropped, 2u);
  EXPECT_EQ(bus.counters().send_refused, 0u);
}

// Space appears with the new command; the old one must not use it.
TEST_F(Paced, AStaleCommandDoesNotLeaveBeforeTheNewOne) {
  send(0x201, 1);
  wire.room = 1;
  send(0x201, 2);
  EXPECT_THAT(wire.take_sent(), ElementsAre(0x20102));
  EXPECT_EQ(bus.waiting(), 0u);
}

TEST_F(Paced, TheQueueKeepsItsOrderAndGoesFirst) {
  send(0x202, 1);
  send(0x601, 2);
  send(0x201, 3);
  send(0x601, 4);
  send(0x000, 5);
  wire.room = 10;
  ReceivedFrame ignored;
  EXPECT_FALSE(bus.try_receive(ignored));  // any call offers the waiting frames
  EXPECT_THAT(wire.take_sent(), ElementsAre(0x60102, 0x60104, 0x00005, 0x20103, 0x20201));
  EXPECT_EQ(bus.transmit_counters().retried, 5u);
}

TEST_F(Paced, ANewFrameDoesNotOvertakeTheQueue) {
  send(0x601, 1);
  wire.room = 1;
  send(0x601, 2);
  EXPECT_THAT(wire.take_sent(), ElementsAre(0x60101));
  wire.room = 1;
  bus.advance_to(1);
  EXPECT_THAT(wire.take_sent(), ElementsAre(0x60102));
}

TEST_F(Paced, AFullQueueSaysSo) {
  for (std::uint8_t i = 0; i < PacedCanBus::queue_capacity; ++i) send(0x601, i);
  send(0x601, 99, SendResult::full);
  EXPECT_EQ(bus.counters().send_refused, 1u);
  send(0x201, 1);  // a slot is free nevertheless
  wire.room = 1;
  send(0x601, 100);  // the earlier one has just left
  EXPECT_THAT(wire.take_sent(), ElementsAre(0x60100));
  EXPECT_EQ(bus.waiting(), PacedCanBus::queue_capacity + 1);
}

TEST_F(Paced, WhatHasWaitedTooLongIsNotSent) {
  bus.advance_to(100 * ms);
  send(0x201, 1);
  send(0x202, 2);
  send(0x601, 3);
  bus.advance_to(102 * ms);
  wire.room = 10;
  bus.advance_to(102 * ms);
  EXPECT_THAT(wire.take_sent(), ElementsAre(0x60103, 0x20202));
  EXPECT_EQ(bus.transmit_counters().expired, 1u);
}

TEST_F(Paced, NothingOutlivesABusThatIsCutOff) {
  for (const BusState state : {BusState::bus_off, BusState::down, BusState::gone}) {
    send(0x201, 1);
    send(0x601, 2);
    const std::uint64_t abandoned = bus.transmit_counters().abandoned;
    wire.bus_state = state;
    send(0x202, 3, state == BusState::bus_off ? SendResult::off : SendResult::down);
    EXPECT_EQ(bus.waiting(), 0u);
    EXPECT_EQ(bus.transmit_counters().abandoned, abandoned + 2);
    wire.bus_state = BusState::error_active;
    wire.room = 10;
    bus.advance_to(1);
    EXPECT_THAT(wire.take_sent(), IsEmpty());
    wire.room = 0;
  }
  send(0x201, 1);
  bus.close();
  EXPECT_EQ(bus.waiting(), 0u);
}

TEST_F(Paced, ImpossibleFramesAreRefused) {
  EXPECT_EQ(bus.try_send({.id = 0x800}), SendResult::invalid);
  send(0x601, 1);
  EXPECT_EQ(bus.try_send({.id = 0x800}), SendResult::invalid);
  EXPECT_EQ(bus.waiting(), 1u);
  EXPECT_EQ(bus.counters().send_refused, 2u);
}

TEST_F(Paced, SlotsAreLimitedAndUnique) {
  EXPECT_FALSE(bus.add_slot(0x201, ms));
  for (std::uint32_t id = 0x300; id < 0x300 + PacedCanBus::max_slots - 3; ++id)
    EXPECT_TRUE(bus.add_slot(id, ms));
  EXPECT_FALSE(bus.add_slot(0x400, ms));
}

// For any behaviour of the bus: each accepted frame is sent once, dropped and counted, or waits; each
// identifier keeps its order.
TEST_F(Paced, EveryFrameIsAccountedFor) {
  std::mt19937 random(3);
  std::uint64_t accepted = 0, sent = 0;
  std::array<int, 0x800> last{};
  for (int i = 0; i < 20'000; ++i) {
    bus.advance_to(i * ms / 4);
    wire.room = random() % 3;
    const std::uint32_t id = std::array{0x080u, 0x201u, 0x202u, 0x601u, 0x000u}[random() % 5];
    CanFrame frame{.id = id, .size = 4};
    for (int k = 0; k < 4; ++k)
      frame.data[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(i >> (8 * k));
    if (bus.try_send(frame) == SendResult::queued) ++accepted;
    for (const CanFrame& f : wire.sent) {
      const int value = f.data[0] | f.data[1] << 8 | f.data[2] << 16;
      EXPECT_GE(value, last[f.id]);
      last[f.id] = value + 1;
      if (f.id == 0x201) {
        EXPECT_LE(i - value, 4);  // valid for a millisecond
      }
      ++sent;
    }
    wire.sent.clear();
  }
  EXPECT_EQ(accepted, sent + bus.transmit_counters().dropped() + bus.waiting());
  EXPECT_GT(bus.transmit_counters().replaced, 0u);
}

}  // namespace
}  // namespace godobject::test_transmit_slots
