#include "hal/canopen/lss.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/may_allocate.h"

namespace godobject::lss::test_lss {
namespace {

constexpr Nanoseconds ms = 1'000'000;

class Recorder final : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame& frame) noexcept override {
    [[maybe_unused]] const test::MayAllocate here;
    if (room == 0) return SendResult::full;
    --room;
    sent.push_back(frame);
    return SendResult::queued;
  }
  bool try_receive(ReceivedFrame&) noexcept override { return false; }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  int room = 100;
  std::vector<CanFrame> sent;
};

CanFrame answer(std::uint8_t command, std::uint8_t error = 0, std::uint8_t vendor = 0) {
  return make_frame(response_cob_id, {command, error, vendor});
}

struct LssMaster : ::testing::Test {
  Message last() const {
    Message message{};
    EXPECT_EQ(parse_frame(bus.sent.back(), request_cob_id, message), ParseResult::ok);
    return message;
  }
  Recorder bus;
  Master master{100 * ms};
};

// SICK AHM36 manual p. 22: 04 01 switches to configuration, 11 <id>, 13 00 <index>, 17 stores.
TEST_F(LssMaster, MessagesOfTheManual) {
  ASSERT_TRUE(master.switch_global(Mode::configuration));
  master.poll(0, bus);
  EXPECT_EQ(last(), (Message{0x04, 0x01}));
  EXPECT_EQ(master.outcome(), Outcome::done) << "it has no answer";
  EXPECT_EQ(bus.sent.back().id, 0x7E5u);

  ASSERT_TRUE(master.set_node_id(5));
  master.poll(0, bus);
  EXPECT_EQ(last(), (Message{0x11, 5}));
  EXPECT_TRUE(master.on_frame(answer(0x11)));
  EXPECT_EQ(master.outcome(), Outcome::done);

  ASSERT_TRUE(master.set_bit_timing(2));
  master.poll(0, bus);
  EXPECT_EQ(last(), (Message{0x13, 0, 2}));
  EXPECT_TRUE(master.on_frame(answer(0x13)));

  ASSERT_TRUE(master.store());
  master.poll(0, bus);
  EXPECT_EQ(last(), (Message{0x17}));
  EXPECT_TRUE(master.on_frame(answer(0x17)));

  ASSERT_TRUE(master.activate_bit_timing(1000));
  master.poll(0, bus);
  EXPECT_EQ(last(), (Message{0x15, 0xE8, 0x03}));
}

TEST_F(LssMaster, SelectsByTheIdentityInFourMessages) {
  bus.room = 3;
  ASSERT_TRUE(master.select({.vendor = 0x01000056, .product = 0x7721, .revision = 3, .serial = 4}));
  master.poll(0, bus);
  EXPECT_FALSE(master.on_frame(answer(0x44))) << "the fourth has not been sent";
  bus.room = 1;
  master.poll(1 * ms, bus);
  ASSERT_EQ(bus.sent.size(), 4u);
  Message first{};
  ASSERT_EQ(parse_frame(bus.sent[0], request_cob_id, first), ParseResult::ok);
  EXPECT_EQ(first, (Message{0x40, 0x56, 0x00, 0x00, 0x01}));
  EXPECT_EQ(last(), (Message{0x43, 4}));
  EXPECT_TRUE(master.on_frame(answer(0x44)));
  EXPECT_EQ(master.outcome(), Outcome::done);
}

TEST_F(LssMaster, RejectionHasItsText) {
  ASSERT_TRUE(master.set_bit_timing(1));
  master.poll(0, bus);
  EXPECT_TRUE(master.on_frame(answer(0x13, 1)));
  EXPECT_EQ(master.outcome(), Outcome::rejected);
  EXPECT_STREQ(text_of(Command::set_bit_timing, master.error_code()), "the node does not have this bit rate");
  ASSERT_TRUE(master.store());
  master.poll(0, bus);
  EXPECT_TRUE(master.on_frame(answer(0x17, 255, 7)));
  EXPECT_EQ(master.vendor_error(), 7);
}

TEST_F(LssMaster, NobodyAnswersAndNothingCouldBeSent) {
  ASSERT_TRUE(master.store());
  EXPECT_FALSE(master.set_node_id(5));
  master.poll(0, bus);
  EXPECT_FALSE(master.on_frame(answer(0x11))) << "another service's";
  master.poll(100 * ms, bus);
  EXPECT_EQ(master.outcome(), Outcome::no_answer);
  bus.room = 0;
  ASSERT_TRUE(master.store());
  master.poll(200 * ms, bus);
  master.poll(300 * ms, bus);
  EXPECT_EQ(master.outcome(), Outcome::not_sent);
}

TEST(Lss, BitTimingTable) {
  EXPECT_EQ(bit_timing_index(1e6), 0);
  EXPECT_EQ(bit_timing_index(500e3), 2);
  EXPECT_EQ(bit_timing_index(125e3), 4);
  EXPECT_EQ(bit_timing_index(10e3), 8);
  EXPECT_EQ(bit_timing_index(100e3), std::nullopt);
  EXPECT_EQ(bit_timing_index(0), std::nullopt);
}

}  // namespace
}  // namespace godobject::lss::test_lss
