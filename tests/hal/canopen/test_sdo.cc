#include "hal/canopen/sdo/sdo.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "hal/canopen/sdo/client.h"
#include "tests/support/may_allocate.h"

namespace godobject::sdo::test_sdo {
namespace {

constexpr std::uint8_t node = 9;
constexpr Nanoseconds ms = 1'000'000;

/// A bus that stores sent frames; can be full.
class Recorder final : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame& frame) noexcept override {
    [[maybe_unused]] const test::MayAllocate here;
    if (full) return SendResult::full;
    sent.push_back(frame);
    return SendResult::queued;
  }
  bool try_receive(ReceivedFrame&) noexcept override { return false; }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  bool full = false;
  std::vector<CanFrame> sent;
};

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    constexpr const char* digits = "0123456789ABCDEF";
    text += (text.empty() ? "" : " ");
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

CanFrame response(std::initializer_list<unsigned> bytes) {
  CanFrame frame{.id = 0x580u + node, .size = 8};
  std::size_t i = 0;
  for (const unsigned byte : bytes) frame.data[i++] = static_cast<std::uint8_t>(byte);
  return frame;
}

struct Dialogue {
  /// Returns the next request in hexadecimal; empty if there is none.
  std::string request(Nanoseconds now = 0) {
    bus.sent.clear();
    client.poll(now, bus);
    if (bus.sent.empty()) return "";
    EXPECT_EQ(bus.sent.front().id, 0x600u + node);
    return hex(bus.sent.front().bytes());
  }
  bool answer(std::initializer_list<unsigned> bytes) { return client.on_frame(response(bytes)); }

  Recorder bus;
  Client client{node, 100 * ms};
};

// ros_canopen #380, node 9: the statusword's neighbour 6077h, and the heartbeat producer.
TEST(Sdo, ReadsAsOnTheRealBus) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x6077, 0}));
  EXPECT_EQ(d.request(), "40 77 60 00 00 00 00 00");
  EXPECT_TRUE(d.answer({0x4B, 0x77, 0x60, 0x00, 0xFE, 0xFF, 0, 0}));
  EXPECT_EQ(d.client.state(), TransferState::done);
  EXPECT_EQ(hex(d.client.data()), "FE FF");
  EXPECT_EQ(canopen::decode_number(d.client.data(), true), -2);
}

TEST(Sdo, WritesAsOnTheRealBus) {
  Dialogue d;
  const std::array<std::uint8_t, 2> period{0xC8, 0x00};
  ASSERT_TRUE(d.client.write({0x1017, 0}, period));
  EXPECT_EQ(d.request(), "2B 17 10 00 C8 00 00 00");
  EXPECT_TRUE(d.answer({0x60, 0x17, 0x10, 0x00}));
  EXPECT_EQ(d.client.state(), TransferState::done);
}

TEST(Sdo, CommandOfEachSize) {
  const std::array<std::uint8_t, 4> bytes{1, 2, 3, 4};
  const std::array<unsigned, 4> downloads{0x2F, 0x2B, 0x27, 0x23}, uploads{0x4F, 0x4B, 0x47, 0x43};
  for (std::size_t size = 1; size <= 4; ++size) {
    const auto data = std::span(bytes).first(size);
    const Message down = make_expedited(Request::initiate_download, {0x6060, 0}, data);
    const Message up = make_expedited(Response::initiate_upload, {0x6060, 0}, data);
    EXPECT_EQ(down[0], downloads[size - 1]);
    EXPECT_EQ(up[0], uploads[size - 1]);
    EXPECT_EQ(expedited_data(up).size(), size);
    EXPECT_EQ(address_of(up), (ObjectAddress{0x6060, 0}));
  }
}

TEST(Sdo, ReadsSegments) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x1008, 0}));
  EXPECT_EQ(d.request(), "40 08 10 00 00 00 00 00");
  EXPECT_TRUE(d.answer({0x41, 0x08, 0x10, 0x00, 9, 0, 0, 0}));
  EXPECT_EQ(d.request(), "60 00 00 00 00 00 00 00");
  EXPECT_TRUE(d.answer({0x00, 'E', 'P', 'O', 'S', '4', ' ', '5'}));
  EXPECT_EQ(d.request(), "70 00 00 00 00 00 00 00");
  EXPECT_TRUE(d.answer({0x1B, '0', '/'}));  // toggle, five bytes unused, last
  EXPECT_EQ(d.client.state(), TransferState::done);
  EXPECT_EQ(std::string(d.client.data().begin(), d.client.data().end()), "EPOS4 50/");
}

TEST(Sdo, WritesSegments) {
  Dialogue d;
  const std::array<std::uint8_t, 9> data{1, 2, 3, 4, 5, 6, 7, 8, 9};
  ASSERT_TRUE(d.client.write({0x2000, 1}, data));
  EXPECT_EQ(d.request(), "21 00 20 01 09 00 00 00");
  EXPECT_TRUE(d.answer({0x60, 0x00, 0x20, 0x01}));
  EXPECT_EQ(d.request(), "00 01 02 03 04 05 06 07");
  EXPECT_TRUE(d.answer({0x20}));
  EXPECT_EQ(d.request(), "1B 08 09 00 00 00 00 00");
  EXPECT_TRUE(d.answer({0x30}));
  EXPECT_EQ(d.client.state(), TransferState::done);
}

TEST(Sdo, NodeAborts) {
  Dialogue d;
  const std::array<std::uint8_t, 1> mode{10};
  ASSERT_TRUE(d.client.write({0x6060, 0}, mode));
  EXPECT_EQ(d.request(), "2F 60 60 00 0A 00 00 00");
  EXPECT_TRUE(d.answer({0x80, 0x60, 0x60, 0x00, 0x30, 0x00, 0x09, 0x06}));
  EXPECT_EQ(d.client.state(), TransferState::aborted);
  EXPECT_EQ(d.client.abort_code(), AbortCode::invalid_value);
}

TEST(Sdo, ToggleThatDoesNotAlternateIsAborted) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x1008, 0}));
  d.request();
  d.answer({0x41, 0x08, 0x10, 0x00, 14});
  d.request();
  d.answer({0x00, 1, 2, 3, 4, 5, 6, 7});
  d.request();
  EXPECT_TRUE(d.answer({0x00, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(d.client.state(), TransferState::bad_answer);
  EXPECT_EQ(d.client.abort_code(), AbortCode::toggle_not_alternated);
  EXPECT_EQ(d.request(), "80 08 10 00 00 00 03 05");
}

TEST(Sdo, MoreOrFewerBytesThanAnnouncedAreAborted) {
  for (const unsigned announced : {6u, 8u}) {
    Dialogue d;
    ASSERT_TRUE(d.client.read({0x1008, 0}));
    d.request();
    d.answer({0x41, 0x08, 0x10, 0x00, announced});
    d.request();
    d.answer({0x01, 1, 2, 3, 4, 5, 6, 7});
    EXPECT_EQ(d.client.state(), TransferState::bad_answer) << announced;
    EXPECT_EQ(d.client.abort_code(), AbortCode::wrong_length);
  }
}

TEST(Sdo, ObjectLargerThanTheBufferIsAborted) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x1F50, 1}));
  d.request();
  d.answer({0x41, 0x50, 0x1F, 0x01, 0x01, 0x01, 0, 0});  // 257 bytes
  EXPECT_EQ(d.client.state(), TransferState::too_large);
  EXPECT_EQ(d.request(), "80 50 1F 01 05 00 04 05");
}

// A server that does not indicate the size cannot write beyond the buffer either.
TEST(Sdo, EndlessSegmentsEnd) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x1F50, 1}));
  d.request();
  d.answer({0x40, 0x50, 0x1F, 0x01});
  for (unsigned i = 0; i < 100 && d.client.busy(); ++i) {
    d.request();
    d.answer({(i % 2) << 4, 1, 2, 3, 4, 5, 6, 7});
  }
  EXPECT_EQ(d.client.state(), TransferState::too_large);
}

TEST(Sdo, AnswerOfAnotherTransferIsLeftAlone) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x6061, 0}));
  EXPECT_FALSE(d.answer({0x4F, 0x61, 0x60, 0x00, 1})) << "before the request has been sent";
  d.request();
  EXPECT_FALSE(d.answer({0x4F, 0x60, 0x60, 0x00, 1}));
  EXPECT_FALSE(d.answer({0x80, 0x60, 0x60, 0x00, 0, 0, 2, 6}));
  CanFrame other_node = response({0x4F, 0x61, 0x60, 0x00, 1});
  other_node.id = 0x58A;
  EXPECT_FALSE(d.client.on_frame(other_node));
  EXPECT_TRUE(d.client.busy());
  EXPECT_TRUE(d.answer({0x4F, 0x61, 0x60, 0x00, 7}));
  EXPECT_EQ(canopen::decode_number(d.client.data(), true), 7);
}

// CiA 301 7.2.4.3.6: s = 0, the size is not indicated.
TEST(Sdo, TheBytesOfTheKnownTypeCountWhereTheSizeIsNotIndicated) {
  for (const unsigned first : {0x42u, 0x4Eu, 0x46u})
    for (std::size_t type_size : {1u, 2u, 4u}) {
      Dialogue d;
      ASSERT_TRUE(d.client.read({0x6041, 0}));
      d.request();
      EXPECT_TRUE(d.answer({first, 0x41, 0x60, 0x00, 0x37, 0x02, 0xAA, 0x55}));
      ASSERT_EQ(d.client.state(), TransferState::done);
      EXPECT_EQ(hex(d.client.data()), "37 02 AA 55");
      EXPECT_EQ(d.client.data(type_size).size(), type_size);
    }
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x6041, 0}));
  d.request();
  d.answer({0x4B, 0x41, 0x60, 0x00, 0x37, 0x02, 0xAA, 0x55});
  EXPECT_EQ(hex(d.client.data(1)), "37 02") << "the size is indicated: it has another type";
}

TEST(Sdo, SegmentsWithoutASizeAreTakenByTheKnownType) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x1018, 1}));
  d.request();
  d.answer({0x40, 0x18, 0x10, 0x01, 0, 0, 0, 0});
  d.request();
  EXPECT_TRUE(d.answer({0x01, 0xFB, 0, 0, 0, 0xEE, 0xEE, 0xEE}));
  EXPECT_EQ(hex(d.client.data(4)), "FB 00 00 00");
}

CanFrame shortened(CanFrame frame, std::uint8_t size) {
  frame.size = size;
  return frame;
}

TEST(Sdo, AnswersOfFewerThanEightBytesAreRight) {
  for (const std::uint8_t size : std::initializer_list<std::uint8_t>{6, 7, 8}) {
    Dialogue d;
    ASSERT_TRUE(d.client.read({0x6041, 0}));
    d.request();
    EXPECT_TRUE(d.client.on_frame(shortened(response({0x4B, 0x41, 0x60, 0x00, 0x37, 0x02}), size)));
    EXPECT_EQ(hex(d.client.data(2)), "37 02");
  }
  for (const std::uint8_t size : std::initializer_list<std::uint8_t>{4, 5, 8}) {
    Dialogue d;
    ASSERT_TRUE(d.client.write({0x6060, 0}, std::array<std::uint8_t, 1>{10}));
    d.request();
    EXPECT_TRUE(d.client.on_frame(shortened(response({0x60, 0x60, 0x60, 0x00}), size)));
    EXPECT_EQ(d.client.state(), TransferState::done);
  }
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x1008, 0}));
  d.request();
  d.answer({0x41, 0x08, 0x10, 0x00, 3, 0, 0, 0});
  d.request();
  EXPECT_TRUE(d.client.on_frame(shortened(response({0x09, 'a', 'b', 'c'}), 4)));
  EXPECT_EQ(d.client.data().size(), 3u);
}

TEST(Sdo, AnAnswerThatLacksBytesOfItsIndicatedSizeIsNone) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x6064, 0}));
  d.request();
  EXPECT_TRUE(d.client.on_frame(shortened(response({0x43, 0x64, 0x60, 0x00, 1, 2}), 6)));
  EXPECT_EQ(d.client.state(), TransferState::bad_answer);
  EXPECT_EQ(d.client.abort_code(), AbortCode::wrong_length);
}

TEST(Sdo, AnAbortWithIndexZeroIsOfTheTransferUnderWay) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x60C2, 1}));
  d.request();
  EXPECT_TRUE(d.answer({0x80, 0, 0, 0, 0x00, 0x00, 0x02, 0x06}));
  EXPECT_EQ(d.client.state(), TransferState::aborted);
  EXPECT_EQ(d.client.abort_code(), AbortCode::no_object);
  // A second answer to a repeated request belongs to no other transfer.
  ASSERT_TRUE(d.client.read({0x60C2, 1}));
  d.request(0);
  d.request(40 * ms);
  d.answer({0x80, 0, 0, 0, 0x00, 0x00, 0x02, 0x06});
  ASSERT_TRUE(d.client.read({0x6061, 0}));
  d.request(41 * ms);
  EXPECT_FALSE(d.answer({0x80, 0, 0, 0, 0x00, 0x00, 0x02, 0x06}));
  EXPECT_TRUE(d.client.busy());
  d.answer({0x4F, 0x61, 0x60, 0x00, 7});
  EXPECT_EQ(d.client.state(), TransferState::done);
}

TEST(Sdo, OneTransferAtATime) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x6061, 0}));
  EXPECT_FALSE(d.client.read({0x6041, 0}));
  EXPECT_FALSE(d.client.write({0x6041, 0}, std::array<std::uint8_t, 1>{}));
  EXPECT_FALSE(Client(node).write({0x6041, 0}, {}));
}

TEST(Sdo, TimesOutAndTellsTheNode) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x6061, 0}));
  const std::string request = d.request(0);
  EXPECT_EQ(d.request(33 * ms), "");
  EXPECT_EQ(d.request(34 * ms), request);
  EXPECT_EQ(d.request(68 * ms), request);
  EXPECT_EQ(d.request(99 * ms), "");
  EXPECT_TRUE(d.client.busy());
  d.request(100 * ms);
  EXPECT_EQ(d.client.state(), TransferState::timed_out);
  EXPECT_NE(d.client.failure_text().find("no answer within 100 ms to 3 requests: "), std::string::npos);
  EXPECT_EQ(d.request(101 * ms), "80 61 60 00 00 00 04 05");
  EXPECT_FALSE(d.answer({0x4F, 0x61, 0x60, 0x00, 7})) << "late";
}

TEST(Sdo, ARepeatedRequestIsAnsweredAndItsLateAnswerDisturbsNoOther) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x1400, 1}));
  d.request(0);
  EXPECT_NE(d.request(40 * ms), "");
  EXPECT_EQ(d.client.repeats(), 1);
  ASSERT_TRUE(d.answer({0x43, 0x00, 0x14, 0x01, 4, 2, 0, 0}));
  EXPECT_EQ(d.client.state(), TransferState::done);
  ASSERT_TRUE(d.client.write({0x1400, 1}, std::array<std::uint8_t, 4>{4, 2, 0, 0x80}));
  d.request(50 * ms);
  d.answer({0x43, 0x00, 0x14, 0x01, 4, 2, 0, 0});
  EXPECT_TRUE(d.client.busy()) << "of the read, whose first answer was only late";
  d.answer({0x60, 0x00, 0x14, 0x01});
  EXPECT_EQ(d.client.state(), TransferState::done);
}

TEST(Sdo, ALateAnswerAmongSegmentsDisturbsThemNot) {
  Dialogue d;
  ASSERT_TRUE(d.client.read({0x1008, 0}));
  d.request(0);
  d.request(40 * ms);
  d.answer({0x41, 0x08, 0x10, 0x00, 3, 0, 0, 0});
  d.answer({0x41, 0x08, 0x10, 0x00, 3, 0, 0, 0});  // before the segment was requested
  EXPECT_EQ(d.request(41 * ms), "60 00 00 00 00 00 00 00");
  d.answer({0x41, 0x08, 0x10, 0x00, 3, 0, 0, 0});  // and after
  EXPECT_TRUE(d.client.busy());
  d.answer({0x09, 'a', 'b', 'c', 0, 0, 0, 0});
  EXPECT_EQ(d.client.state(), TransferState::done);
}

TEST(Sdo, NothingIsRepeatedAmongSegments) {
  Dialogue d;
  ASSERT_TRUE(d.client.write({0x1008, 0}, std::array<std::uint8_t, 9>{}));
  EXPECT_NE(d.request(0), "");
  EXPECT_EQ(d.request(50 * ms), "");
  d.answer({0x60, 0x08, 0x10, 0x00});
  EXPECT_NE(d.request(60 * ms), "");
  EXPECT_EQ(d.request(120 * ms), "");
  d.request(160 * ms);
  EXPECT_EQ(d.client.state(), TransferState::timed_out);
  EXPECT_NE(d.client.failure_text().find("no answer within 100 ms: "), std::string::npos);
}

TEST(Sdo, FullBusIsTriedAgainUntilTheTimeout) {
  Dialogue d;
  d.bus.full = true;
  ASSERT_TRUE(d.client.read({0x6061, 0}));
  EXPECT_EQ(d.request(0), "");
  d.bus.full = false;
  EXPECT_EQ(d.request(50 * ms), "40 61 60 00 00 00 00 00");
  d.answer({0x4F, 0x61, 0x60, 0x00, 7});
  d.bus.full = true;
  ASSERT_TRUE(d.client.read({0x6061, 0}));
  d.request(200 * ms);
  d.request(300 * ms);
  EXPECT_EQ(d.client.state(), TransferState::not_sent);
  d.bus.full = false;
  EXPECT_EQ(d.request(400 * ms), "") << "nothing of it is sent later";
}

TEST(Sdo, EveryAbortCodeOfTheStandardHasItsText) {
  for (const std::uint32_t code :
       {0x05030000u, 0x05040000u, 0x05040001u, 0x05040002u, 0x05040003u, 0x05040004u, 0x05040005u,
        0x06010000u, 0x06010001u, 0x06010002u, 0x06020000u, 0x06040041u, 0x06040042u, 0x06040043u,
        0x06040047u, 0x06060000u, 0x06070010u, 0x06070012u, 0x06070013u, 0x06090011u, 0x06090030u,
        0x06090031u, 0x06090032u, 0x06090036u, 0x060A0023u, 0x08000000u, 0x08000020u, 0x08000021u,
        0x08000022u, 0x08000023u, 0x08000024u})
    EXPECT_EQ(std::string(text_of(AbortCode{code})).find("not in CiA 301"), std::string::npos)
        << std::hex << code;
  EXPECT_STREQ(text_of(AbortCode{0x06020000}), "object does not exist in the object dictionary");
  EXPECT_STREQ(text_of(AbortCode{0x12345678}), "not in CiA 301: see the device's manual");
}

// Random bytes in any state: no write out of bounds (checked by the sanitizers), and every transfer ends.
TEST(Sdo, SurvivesAnyAnswer) {
  std::uint32_t random = 1;
  const auto next = [&random] { return random = random * 1664525u + 1013904223u; };
  for (int i = 0; i < 20000; ++i) {
    Dialogue d;
    std::vector<std::uint8_t> data(1 + next() % 20);
    ASSERT_TRUE(i % 2 == 0 ? d.client.read({0x1008, 0}) : d.client.write({0x1008, 0}, data));
    for (int k = 0; k < 12; ++k) {
      d.request();
      CanFrame frame = response({});
      for (std::uint8_t& byte : std::span(frame.data).first(8))
        byte = static_cast<std::uint8_t>(next() >> 16);
      frame.data[1] = 0x08;
      frame.data[2] = 0x10;
      frame.data[3] = 0;
      frame.size = next() % 4 == 0 ? static_cast<std::uint8_t>((next() >> 16) % 9) : std::uint8_t{8};
      d.client.on_frame(frame);
      ASSERT_LE(d.client.data().size(), Client::capacity);
    }
  }
}

TEST(ObjectNumbers, RoundTripAtTheirLimits) {
  using canopen::ObjectType;
  for (const ObjectType type :
       {ObjectType::u8, ObjectType::u16, ObjectType::u32, ObjectType::i8, ObjectType::i16, ObjectType::i32}) {
    for (const std::int64_t value : {canopen::lowest(type), std::int64_t{0}, canopen::highest(type)}) {
      std::array<std::uint8_t, 4> bytes{};
      const auto used = std::span(bytes).first(canopen::size_of(type));
      canopen::encode_number(value, used);
      EXPECT_EQ(canopen::decode_number(used, canopen::is_signed(type)), value);
    }
    EXPECT_FALSE(canopen::in_range(type, canopen::highest(type) + 1));
    EXPECT_FALSE(canopen::in_range(type, canopen::lowest(type) - 1));
  }
}

}  // namespace
}  // namespace godobject::sdo::test_sdo
