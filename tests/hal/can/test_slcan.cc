// The SLCAN codec: golden lines, refusals, round trips, and random bytes.
#include "hal/can/slcan.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace godobject::slcan::test_slcan {
namespace {

CanFrame data_frame(std::uint32_t id, bool extended, std::initializer_list<int> bytes) {
  CanFrame frame{.id = id, .extended = extended, .size = static_cast<std::uint8_t>(bytes.size())};
  std::size_t i = 0;
  for (const int byte : bytes) frame.data[i++] = static_cast<std::uint8_t>(byte);
  return frame;
}

std::string line_of(const CanFrame& frame, std::optional<std::uint16_t> timestamp_ms = std::nullopt) {
  std::array<char, max_line> out{};
  return {out.data(), format_frame(frame, out, timestamp_ms)};
}

void expect_equal(const CanFrame& a, const CanFrame& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.extended, b.extended);
  EXPECT_EQ(a.remote, b.remote);
  EXPECT_EQ(a.fd, b.fd);
  ASSERT_EQ(a.size, b.size);
  EXPECT_EQ(a.data, b.data);
}

std::vector<std::string> lines_of(LineReader& reader, const std::string& bytes) {
  std::vector<std::string> lines;
  for (const char c : bytes)
    if (reader.put(static_cast<std::uint8_t>(c))) lines.emplace_back(reader.line());
  return lines;
}

TEST(Slcan, FormatsTheFourKindsOfFrame) {
  EXPECT_EQ(line_of(data_frame(0x123, false, {0x11, 0xAB})), "t123211AB\r");
  EXPECT_EQ(line_of(data_frame(0x080, false, {})), "t0800\r");
  EXPECT_EQ(line_of(data_frame(0x1ABCDEF0, true, {1, 2, 3, 4, 5, 6, 7, 8})), "T1ABCDEF080102030405060708\r");
  EXPECT_EQ(line_of({.id = 0x7FF, .remote = true, .size = 4}), "r7FF4\r");
  EXPECT_EQ(line_of({.id = 0x7FF, .extended = true, .remote = true, .size = 0}), "R000007FF0\r");
  EXPECT_EQ(line_of(data_frame(0x1FFFFFFF, true, {1, 2, 3, 4, 5, 6, 7, 8}), 59'999).size(), max_line);
  EXPECT_EQ(line_of(data_frame(0x123, false, {0xFF}), 0x1234), "t1231FF1234\r");
}

TEST(Slcan, RefusesToFormatWhatItCannotCarry) {
  EXPECT_EQ(line_of({.id = 0x123, .fd = true, .size = 8}), "");
  EXPECT_EQ(line_of({.id = 0x800}), "");
  EXPECT_EQ(line_of({.id = 0x123, .size = 9}), "");
  const CanFrame frame = data_frame(0x123, false, {1, 2});
  std::array<char, max_line> out{};
  const std::size_t size = format_frame(frame, out);
  for (std::size_t room = 0; room < size; ++room)
    EXPECT_EQ(format_frame(frame, std::span(out).first(room)), 0u);
}

TEST(Slcan, BitRatesAreThoseOfTheList) {
  EXPECT_EQ(bit_rate_command(10e3), "S0\r");
  EXPECT_EQ(bit_rate_command(125e3), "S4\r");
  EXPECT_EQ(bit_rate_command(500e3), "S6\r");
  EXPECT_EQ(bit_rate_command(1e6), "S8\r");
  EXPECT_EQ(bit_rate_command(83.3e3), "");
  EXPECT_EQ(bit_rate_command(0), "");
}

TEST(Slcan, ParsesRepliesOfAnAdapter) {
  Reply reply;
  ASSERT_EQ(parse_reply("", reply), ParseResult::ok);
  EXPECT_EQ(reply.kind, ReplyKind::ok);
  ASSERT_EQ(parse_reply("\a", reply), ParseResult::ok);
  EXPECT_EQ(reply.kind, ReplyKind::refused);
  for (const char* line : {"z", "Z"}) {
    ASSERT_EQ(parse_reply(line, reply), ParseResult::ok);
    EXPECT_EQ(reply.kind, ReplyKind::taken);
  }
  ASSERT_EQ(parse_reply("FA4", reply), ParseResult::ok);
  EXPECT_EQ(reply.kind, ReplyKind::flags);
  EXPECT_EQ(reply.flags, status::bus_error | status::error_passive | status::error_warning);
  for (const char* line : {"V1013", "N4711", "V"}) {
    ASSERT_EQ(parse_reply(line, reply), ParseResult::ok);
    EXPECT_EQ(reply.kind, ReplyKind::identity);
  }
}

TEST(Slcan, ParsesReceivedFrames) {
  Reply reply;
  ASSERT_EQ(parse_reply("t18548fa3b0c012345", reply), ParseResult::too_long);
  ASSERT_EQ(parse_reply("t1852AB", reply), ParseResult::too_short);
  ASSERT_EQ(parse_reply("t18540a3B0c00", reply), ParseResult::ok);
  EXPECT_EQ(reply.kind, ReplyKind::frame);
  expect_equal(reply.frame, data_frame(0x185, false, {0x0A, 0x3B, 0x0C, 0x00}));
  EXPECT_FALSE(reply.timestamp_ms);
  ASSERT_EQ(parse_reply("T000001851FFEA5F", reply), ParseResult::ok);
  expect_equal(reply.frame, data_frame(0x185, true, {0xFF}));
  EXPECT_EQ(reply.timestamp_ms, 59'999);
  ASSERT_EQ(parse_reply("r1858", reply), ParseResult::ok);
  expect_equal(reply.frame, {.id = 0x185, .remote = true, .size = 8});
  EXPECT_FALSE(reply.timestamp_ms) << "of the reply before";
}

TEST(Slcan, ParsesTheErrorLinesOfTheKernelsDialect) {
  struct Case {
    const char* line;
    BusState state;
    int receive, transmit;
  };
  for (const Case& c :
       {Case{"sa057033", BusState::error_active, 57, 33}, Case{"sw096100", BusState::error_warning, 96, 100},
        Case{"sp128200", BusState::error_passive, 128, 200}, Case{"sb255000", BusState::bus_off, 255, 0},
        Case{"sb000256", BusState::bus_off, 0, 255}}) {
    Reply reply;
    ASSERT_EQ(parse_reply(c.line, reply), ParseResult::ok) << c.line;
    EXPECT_EQ(reply.kind, ReplyKind::error_report);
    EXPECT_EQ(reply.report.state, c.state) << c.line;
    EXPECT_EQ(reply.report.error, BusError::none);
    ASSERT_TRUE(reply.report.counters.has_value());
    EXPECT_EQ(reply.report.counters->receive, c.receive) << c.line;
    EXPECT_EQ(reply.report.counters->transmit, c.transmit) << c.line;
  }
  for (const auto& [line, error] : {std::pair{"e1a", BusError::acknowledge},
                                    {"e1b", BusError::bit},
                                    {"e1B", BusError::bit},
                                    {"e1c", BusError::crc},
                                    {"e1f", BusError::form},
                                    {"e1s", BusError::stuff},
                                    {"e1o", BusError::receive_overflow},
                                    {"e1O", BusError::transmit_overflow},
                                    {"e3bcO", BusError::bit}}) {
    Reply reply;
    ASSERT_EQ(parse_reply(line, reply), ParseResult::ok) << line;
    EXPECT_EQ(reply.kind, ReplyKind::error_report);
    EXPECT_EQ(reply.report.error, error) << line;
    EXPECT_FALSE(reply.report.state || reply.report.counters);
  }
}

TEST(Slcan, LeavesTheOutputAloneWhereALineIsWrong) {
  for (const char* line : {"t",        "t12",        "t1239",        "t123G",     "tGGG0", "t1232ABC",
                           "t80000",   "T200000000", "t12300000000", "t1230zzzz", "x1",    "F",
                           "F0",       "F000",       "Fxy",          "zz",        "\a\a",  "s",
                           "sx000000", "sw96100",    "sw0961000",    "sw09x100",  "e",     "e0",
                           "e1",       "e2a",        "e1x",          "e1aa",      "ea1",   "\x80t1230"}) {
    Reply reply{.kind = ReplyKind::identity};
    EXPECT_NE(parse_reply(line, reply), ParseResult::ok) << line;
    EXPECT_EQ(reply.kind, ReplyKind::identity) << line;
  }
}

TEST(Slcan, ParsesRequestsOfAHost) {
  for (const auto& [line, kind, value] : {std::tuple{"S8", RequestKind::set_bit_rate, 8},
                                          {"S0", RequestKind::set_bit_rate, 0},
                                          {"O", RequestKind::open, 0},
                                          {"L", RequestKind::listen, 0},
                                          {"C", RequestKind::close, 0},
                                          {"F", RequestKind::flags, 0},
                                          {"V", RequestKind::version, 0},
                                          {"N", RequestKind::serial_number, 0},
                                          {"Z1", RequestKind::timestamps, 1},
                                          {"Z0", RequestKind::timestamps, 0},
                                          {"t0800", RequestKind::send, 0}}) {
    Request request;
    ASSERT_EQ(parse_request(line, request), ParseResult::ok) << line;
    EXPECT_EQ(request.kind, kind) << line;
    EXPECT_EQ(request.value, value) << line;
  }
  for (const char* line : {"", "S", "S9", "S88", "Z2", "OO", "t08001234", "s031C", "M00000000", "z", "\a"}) {
    Request request{.kind = RequestKind::listen};
    EXPECT_NE(parse_request(line, request), ParseResult::ok) << line;
    EXPECT_EQ(request.kind, RequestKind::listen) << line;
  }
}

TEST(Slcan, ReaderCutsLines) {
  LineReader reader;
  EXPECT_EQ(lines_of(reader, "z\rt0800\r\n\r\aF00"), (std::vector<std::string>{"z", "t0800", "", "\a"}));
  EXPECT_EQ(lines_of(reader, "\r"), std::vector<std::string>{"F00"});
}

TEST(Slcan, ALineEndsWithReturnLineFeedOrBoth) {
  for (const std::string end : {"\r", "\n", "\r\n", "\n\r"}) {
    LineReader reader;
    const std::vector<std::string> expected{"", "z", "", "", "t0800"};
    EXPECT_EQ(lines_of(reader, end + "z" + end + end + end + "t0800" + end), expected);
    EXPECT_EQ(lines_of(reader, "F00" + end), std::vector<std::string>{"F00"});
  }
}

TEST(Slcan, LinesThatABelCutsOffAreCounted) {
  LineReader reader;
  EXPECT_EQ(lines_of(reader, "t12\a\at0800\r\az\a"),
            (std::vector<std::string>{"\a", "\a", "t0800", "\a", "\a"}));
  EXPECT_EQ(reader.num_cut(), 2u);
}

TEST(Slcan, FramesOfCanFdAreKnownAndNotDecoded) {
  static constexpr std::array sizes{0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
  std::mt19937 random(3);
  for (const char command : {'d', 'D', 'b', 'B'}) {
    for (std::size_t dlc = 0; dlc < sizes.size(); ++dlc) {
      for (const bool stamped : {false, true}) {
        std::string line(1, command);
        line += command == 'd' || command == 'b' ? "7FF" : "1FFFFFFF";
        line += "0123456789ABCDEF"[dlc];
        for (int i = 0; i < 2 * sizes[dlc] + (stamped ? 4 : 0); ++i)
          line += "0123456789abcdef"[random() % 16];
        LineReader reader;
        const std::vector<std::string> lines = lines_of(reader, line + "\rz\r");
        EXPECT_EQ(lines.back(), "z");
        EXPECT_EQ(reader.num_overlong(), 0u) << line;
        if (lines.size() == 1) {
          EXPECT_EQ(reader.num_fd(), 1u) << line;
          continue;
        }
        Reply reply;
        ASSERT_EQ(parse_reply(lines[0], reply), ParseResult::ok) << line;
        EXPECT_EQ(reply.kind, ReplyKind::fd_frame);
        EXPECT_NE(parse_reply(line.substr(0, line.size() - 1), reply), ParseResult::ok);
        EXPECT_NE(parse_reply(line + "0", reply), ParseResult::ok);
        line[2] = 'x';
        EXPECT_NE(parse_reply(line, reply), ParseResult::ok);
      }
    }
  }
}

TEST(Slcan, ReaderRecoversFromGarbageAtTheNextLineEnd) {
  LineReader reader;
  const std::string garbage(1000, 'x');
  EXPECT_EQ(lines_of(reader, garbage + "\rt0800\r"), std::vector<std::string>{"t0800"});
  EXPECT_EQ(reader.num_overlong(), 1u);
  EXPECT_EQ(lines_of(reader, "t12\at0800\r"), (std::vector<std::string>{"\a", "t0800"}));
  const std::string longest = line_of(data_frame(0x1FFFFFFF, true, {1, 2, 3, 4, 5, 6, 7, 8}), 0);
  EXPECT_EQ(lines_of(reader, longest), std::vector<std::string>{longest.substr(0, longest.size() - 1)});
}

TEST(Slcan, RandomFramesSurviveTheRoundTripThroughTheReader) {
  std::mt19937 random(1);
  LineReader reader;
  for (int i = 0; i < 2000; ++i) {
    CanFrame frame{.extended = random() % 2 == 0,
                   .remote = random() % 4 == 0,
                   .size = static_cast<std::uint8_t>(random() % 9)};
    frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFu : 0x7FFu);
    if (!frame.remote)
      for (std::size_t k = 0; k < frame.size; ++k) frame.data[k] = static_cast<std::uint8_t>(random());
    const std::vector<std::string> lines = lines_of(reader, line_of(frame));
    ASSERT_EQ(lines.size(), 1u);
    Reply reply;
    ASSERT_EQ(parse_reply(lines[0], reply), ParseResult::ok);
    expect_equal(reply.frame, frame);
    Request request;
    ASSERT_EQ(parse_request(lines[0], request), ParseResult::ok);
    expect_equal(request.frame, frame);
  }
}

TEST(Slcan, AnyBytesAreReadWithoutHarm) {
  std::mt19937 random(2);
  const std::string alphabet = "tTrRzZFVNse0123456789abwpb\r\a\n";
  LineReader reader;
  for (int i = 0; i < 200'000; ++i) {
    const bool any_byte = random() % 16 == 0;
    const auto byte = static_cast<std::uint8_t>(any_byte ? random() : alphabet[random() % alphabet.size()]);
    if (!reader.put(byte)) continue;
    ASSERT_LE(reader.line().size(), max_line);
    Reply reply;
    if (parse_reply(reader.line(), reply) == ParseResult::ok && reply.kind == ReplyKind::frame) {
      ASSERT_TRUE(is_valid(reply.frame)) << reader.line();
    }
    Request request;
    if (parse_request(reader.line(), request) == ParseResult::ok && request.kind == RequestKind::send) {
      ASSERT_TRUE(is_valid(request.frame)) << reader.line();
    }
  }
}

}  // namespace
}  // namespace godobject::slcan::test_slcan
