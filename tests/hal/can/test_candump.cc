#include "hal/can/candump.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <string>

#include "tests/support/shared_data.h"

namespace godobject::test_candump {
namespace {

std::string line_of(const ReceivedFrame& received, std::string_view interface = "can0") {
  char buffer[max_candump_line];
  std::size_t length = 0;
  if (format_candump(received, interface, buffer, length) != CandumpResult::ok) return "(refused)";
  return std::string(buffer, length);
}

CandumpResult result_of(std::string_view line) {
  ReceivedFrame received;
  std::string_view interface;
  return parse_candump(line, received, interface);
}

TEST(Candump, FormatsTheFormsOfTheFormat) {
  CanFrame frame{.id = 0x0D2, .size = 3};
  frame.data = {0x00, 0xAB, 0x10};
  EXPECT_EQ(line_of({frame, 1'631'416'514'717'133'999}), "(1631416514.717133) can0 0D2#00AB10");
  frame.extended = true;
  EXPECT_EQ(line_of({frame, 1'000}), "(0000000000.000001) can0 000000D2#00AB10");
  frame = {.id = 0x80};
  EXPECT_EQ(line_of({frame, 0}), "(0000000000.000000) can0 080#");
  frame = {.id = 0x123, .remote = true};
  EXPECT_EQ(line_of({frame, 0}), "(0000000000.000000) can0 123#R");
  frame.size = 4;
  EXPECT_EQ(line_of({frame, 0}), "(0000000000.000000) can0 123#R4");
  frame = {.id = 0x123, .fd = true, .bit_rate_switch = true, .size = 1};
  EXPECT_EQ(line_of({frame, 0}), "(0000000000.000000) can0 123##100");
}

TEST(Candump, FormatRefusesWhatTheFormatCannotSay) {
  char buffer[max_candump_line];
  std::size_t length = 77;
  const CanFrame frame{.id = 1};
  EXPECT_EQ(format_candump({frame, -1}, "can0", buffer, length), CandumpResult::bad_time);
  EXPECT_EQ(format_candump({frame, 0}, "", buffer, length), CandumpResult::bad_interface);
  EXPECT_EQ(format_candump({frame, 0}, "can 0", buffer, length), CandumpResult::bad_interface);
  EXPECT_EQ(format_candump({frame, 0}, "a_name_too_long_", buffer, length), CandumpResult::bad_interface);
  EXPECT_EQ(format_candump({{.id = 0x800}, 0}, "can0", buffer, length), CandumpResult::bad_identifier);
  EXPECT_EQ(format_candump({{.size = 9}, 0}, "can0", buffer, length), CandumpResult::bad_data);
  EXPECT_EQ(format_candump({frame, 0}, "can0", std::span(buffer).first(10), length),
            CandumpResult::buffer_too_small);
  EXPECT_EQ(length, 77u);
}

TEST(Candump, LongestLineFits) {
  CanFrame frame{.id = 0x1FFFFFFF, .extended = true, .fd = true, .bit_rate_switch = true, .size = 64};
  EXPECT_LE(line_of({frame, std::numeric_limits<Nanoseconds>::max()}, "fifteen_letters").size(),
            max_candump_line);
  EXPECT_NE(line_of({frame, std::numeric_limits<Nanoseconds>::max()}, "fifteen_letters"), "(refused)");
}

TEST(Candump, RoundTripOfRandomFrames) {
  std::mt19937_64 random(3);
  const std::uint8_t fd_sizes[] = {0, 1, 7, 8, 12, 16, 20, 24, 32, 48, 64};
  for (int i = 0; i < 5000; ++i) {
    ReceivedFrame in;
    CanFrame& f = in.frame;
    f.extended = random() % 2 != 0;
    f.id = static_cast<std::uint32_t>(random()) & (f.extended ? 0x1FFFFFFFu : 0x7FFu);
    f.fd = random() % 2 != 0;
    f.bit_rate_switch = f.fd && random() % 2 != 0;
    f.remote = !f.fd && random() % 4 == 0;
    f.size = f.fd ? fd_sizes[random() % 11] : static_cast<std::uint8_t>(random() % 9);
    if (!f.remote)
      for (std::uint8_t k = 0; k < f.size; ++k) f.data[k] = static_cast<std::uint8_t>(random());
    in.t_ns = static_cast<Nanoseconds>(random() % 4'000'000'000'000'000) * 1000;
    const std::string line = line_of(in);
    ReceivedFrame out;
    std::string_view interface;
    ASSERT_EQ(parse_candump(line, out, interface), CandumpResult::ok) << line;
    EXPECT_EQ(interface, "can0");
    EXPECT_EQ(out.t_ns, in.t_ns);
    EXPECT_EQ(out.frame.id, f.id);
    EXPECT_EQ(out.frame.extended, f.extended);
    EXPECT_EQ(out.frame.remote, f.remote);
    EXPECT_EQ(out.frame.fd, f.fd);
    EXPECT_EQ(out.frame.bit_rate_switch, f.bit_rate_switch);
    EXPECT_EQ(out.frame.size, f.size);
    EXPECT_EQ(out.frame.data, f.data);
  }
}

TEST(Candump, AcceptsLineEndsAndDirections) {
  EXPECT_EQ(result_of("(1.000001) can0 123#00\n"), CandumpResult::ok);
  EXPECT_EQ(result_of("(1.000001) can0 123#00\r\n"), CandumpResult::ok);
  EXPECT_EQ(result_of("(1.000001) can0 123#00 R"), CandumpResult::ok);
  EXPECT_EQ(result_of("(1.000001) can0 123#00 T\n"), CandumpResult::ok);
  EXPECT_EQ(result_of("(1.000001) can0 123##200"), CandumpResult::ok);    // FD, error state indicator
  EXPECT_EQ(result_of("(1.000001) can0 123##51122"), CandumpResult::ok);  // FD as newer kernels flag it
}

TEST(Candump, NamesWhatIsWrong) {
  EXPECT_EQ(result_of(""), CandumpResult::ignored);
  EXPECT_EQ(result_of("# DROPCOUNT: 3"), CandumpResult::ignored);
  for (const char* line :
       {"(1.00001) can0 123#", "(1.0000001) can0 123#", "(1.0000000001) can0 123#", "(1) can0 123#",
        "(.000001) can0 123#", "(-1.000001) can0 123#", "(1.-00001) can0 123#", "(1.000001 can0 123#", "(",
        "(99999999999999999999.000000) can0 123#", "(9999999999999.000000) can0 123#"}) {
    EXPECT_EQ(result_of(line), CandumpResult::bad_time) << line;
  }
  EXPECT_EQ(result_of("(1.000000)"), CandumpResult::bad_interface);
  EXPECT_EQ(result_of("(1.000000)  123#"), CandumpResult::bad_interface);
  for (const char* line : {"(1.000000) can0 12#", "(1.000000) can0 1234#", "(1.000000) can0 800#",
                           "(1.000000) can0 40000000#", "(1.000000) can0 12G#", "(1.000000) can0 #00"}) {
    EXPECT_EQ(result_of(line), CandumpResult::bad_identifier) << line;
  }
  for (const char* line :
       {"(1.000000) can0", "(1.000000) can0 123", "(1.000000) can0 123#0", "(1.000000) can0 123#0G",
        "(1.000000) can0 123#001122334455667788", "(1.000000) can0 123##", "(1.000000) can0 123##8",
        "(1.000000) can0 123##000112233445566778899", "(1.000000) can0 123#R9", "(1.000000) can0 123#R12",
        "(1.000000) can0 123#00 X"}) {
    EXPECT_EQ(result_of(line), CandumpResult::bad_data) << line;
  }
  EXPECT_EQ(result_of("(1.000000) can0 20000080#0000000000000000"), CandumpResult::error_frame);
}

// candump of can-utils 2023 and later, with several interfaces, option -8 (DLC above 8) and hardware time
// stamps.
TEST(Candump, ReadsWhatNewerCandumpsWrite) {
  const auto parsed = [](std::string_view line) {
    ReceivedFrame received;
    std::string_view interface;
    EXPECT_EQ(parse_candump(line, received, interface), CandumpResult::ok) << line;
    return std::pair(received, std::string(interface));
  };
  EXPECT_EQ(parsed("(1631416514.717133)  can0 0D2#00").second, "can0");
  EXPECT_EQ(parsed("(1631416514.717133)         can0 0D2#00 R").second, "can0");
  EXPECT_EQ(parsed("(1631416514.717133456) can0 0D2#00").first.t_ns, 1'631'416'514'717'133'456);
  EXPECT_EQ(parsed("(1.000000001) can0 123#").first.t_ns, 1'000'000'001);
  for (const std::string dlc : {"9", "A", "B", "C", "D", "E", "F"}) {
    const CanFrame data = parsed("(1.000000) can0 123#0102030405060708_" + dlc).first.frame;
    EXPECT_EQ(data.size, 8);
    EXPECT_EQ(data.data[7], 8);
    const CanFrame remote = parsed("(1.000000) vcan12 00000123#R8_" + dlc + " T").first.frame;
    EXPECT_TRUE(remote.remote && remote.extended);
    EXPECT_EQ(remote.size, 8);
  }
  for (const char* line :
       {"(1.000000) can0 123#0102030405060708_8", "(1.000000) can0 123#0102030405060708_G",
        "(1.000000) can0 123#0102030405060708_", "(1.000000) can0 123#01020304050607_9",
        "(1.000000) can0 123#0102030405060708_9A", "(1.000000) can0 123#R_9", "(1.000000) can0 123#R7_9",
        "(1.000000) can0 123##00102030405060708_9", "(1.000000) can0 123#_9"})
    EXPECT_EQ(result_of(line), CandumpResult::bad_data) << line;
  EXPECT_EQ(result_of("(1.000000)     "), CandumpResult::bad_interface);
}

// 90 s of a real car's bus, as written by candump.
TEST(Candump, ReadsAndWritesARealRecording) {
  const std::filesystem::path path = test::shared_file("data/can/vehicle/can_sample.log");
  if (path.empty()) GTEST_SKIP() << "no data/can/vehicle/can_sample.log under ../shared or GODOBJECT_SHARED";
  std::ifstream file(path);
  int lines = 0;
  for (std::string line; std::getline(file, line); ++lines) {
    ReceivedFrame received;
    std::string_view interface;
    ASSERT_EQ(parse_candump(line, received, interface), CandumpResult::ok) << line;
    ASSERT_EQ(line_of(received, interface), line);
  }
  EXPECT_EQ(lines, 82558);
}

TEST(Candump, ErrorLeavesTheOutputs) {
  ReceivedFrame received{{.id = 5}, 7};
  std::string_view interface = "kept";
  EXPECT_EQ(parse_candump("(1.000000) can0 123#0", received, interface), CandumpResult::bad_data);
  EXPECT_EQ(received.frame.id, 5u);
  EXPECT_EQ(received.t_ns, 7);
  EXPECT_EQ(interface, "kept");
}

}  // namespace
}  // namespace godobject::test_candump
