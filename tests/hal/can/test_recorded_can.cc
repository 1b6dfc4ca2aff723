// Recordings of real CiA 402 drives on real buses decode to the values in their README.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "hal/drive/cia402.h"
#include "tests/support/shared_data.h"

namespace godobject::test_recorded_can {
namespace {

using cia402::DriveState;

/// Reads lines "  can0  184   [7]  18 02 ...": candump's terminal format, without time stamps. Skips other
/// lines.
std::vector<CanFrame> read_terminal_candump(const std::filesystem::path& path) {
  std::vector<CanFrame> frames;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string interface, size;
    CanFrame frame;
    unsigned byte = 0;
    if (!(words >> interface >> std::hex >> frame.id >> size) || size.front() != '[') continue;
    while (words >> byte) frame.data[frame.size++] = static_cast<std::uint8_t>(byte);
    EXPECT_EQ("[" + std::to_string(frame.size) + "]", size) << line;
    frames.push_back(frame);
  }
  return frames;
}

class RecordedCan : public ::testing::Test {
 protected:
  /// Returns false if the recording is missing; the test is then skipped.
  bool load(const char* name) {
    const std::filesystem::path path = test::shared_file(name);
    if (path.empty()) return false;
    frames = read_terminal_candump(path);
    return true;
  }
  std::vector<CanFrame> with_id(std::uint32_t id) const {
    std::vector<CanFrame> found;
    for (const CanFrame& frame : frames)
      if (frame.id == id) found.push_back(frame);
    return found;
  }
  std::vector<CanFrame> frames;
};

std::uint16_t first_word(const CanFrame& frame) {
  std::uint16_t word = 0;
  ByteReader(frame.bytes()).get(word);
  return word;
}

// Fault reset, then enabled step by step, then an emergency.
TEST_F(RecordedCan, RobotrainerDriveIsResetAndEnabled) {
  if (!load("data/can/robotrainer_cia402/candump.log"))
    GTEST_SKIP() << "no recording: ../shared/data/can/robotrainer_cia402 is not there";
  EXPECT_EQ(frames.size(), 31u);

  std::vector<std::uint16_t> controlwords, statuswords;
  for (const CanFrame& frame : with_id(canopen::rpdo_cob_id(1, 4))) controlwords.push_back(first_word(frame));
  for (const CanFrame& frame : with_id(canopen::tpdo_cob_id(1, 4)))
    if (statuswords.empty() || statuswords.back() != first_word(frame))
      statuswords.push_back(first_word(frame));
  EXPECT_EQ(controlwords, (std::vector<std::uint16_t>{0x018F, 0x010E, 0x0107, 0x010F}));
  EXPECT_EQ(statuswords, (std::vector<std::uint16_t>{0x0218, 0x0250, 0x0231, 0x0233}));

  std::vector<DriveState> states;
  for (const std::uint16_t word : statuswords) states.push_back(cia402::decode_state(word));
  EXPECT_EQ(states, (std::vector{DriveState::fault, DriveState::switch_on_disabled,
                                 DriveState::ready_to_switch_on, DriveState::switched_on}));
  for (const std::uint16_t word : statuswords) EXPECT_TRUE(word & cia402::status_remote);

  // Our state machine's next command equals that of the recorded master, in the bits that matter.
  std::uint16_t last = 0;
  for (std::size_t i = 0; i < controlwords.size(); ++i) {
    constexpr std::uint16_t command_bits = 0x8F;
    const std::uint16_t ours = cia402::next_controlword(states[i], last, true);
    const bool fault_reset = (controlwords[i] & cia402::fault_reset_bit) != 0;
    if (fault_reset) {
      EXPECT_EQ(ours & cia402::fault_reset_bit, cia402::fault_reset_bit);
    } else {  // 0x0E commands "shutdown" as 0x06 does: bit 3 is ignored
      EXPECT_EQ(ours | 0x08, (controlwords[i] & command_bits) | 0x08) << i;
    }
    last = ours;
  }

  for (const CanFrame& frame : with_id(canopen::tpdo_cob_id(3, 4))) {
    std::int32_t position = 0, velocity = 0;
    ASSERT_TRUE(ByteReader(frame.bytes()).get(position).get(velocity).ok());
    EXPECT_NEAR(position, -2512, 17);
  }
  canopen::Emergency emergency;
  ASSERT_EQ(with_id(0x084).size(), 1u);
  ASSERT_EQ(canopen::parse_emergency(with_id(0x084).front(), emergency), ParseResult::ok);
  EXPECT_EQ(emergency.node, 4);
  EXPECT_EQ(emergency.error_code, 0xFF10);
  canopen::Heartbeat heartbeat;
  for (const CanFrame& frame : with_id(0x704)) {
    ASSERT_EQ(canopen::parse_heartbeat(frame, heartbeat), ParseResult::ok);
    EXPECT_EQ(heartbeat.state, canopen::NmtState::operational);
  }
}

// An idle motor: four RPDOs and two TPDOs between SYNCs, the latter all zero, and emergencies of node 1 about
// a PDO that is too long.
TEST_F(RecordedCan, RoboteqDriveIdles) {
  if (!load("data/can/roboteq_cia402/candump.txt"))
    GTEST_SKIP() << "no recording: ../shared/data/can/roboteq_cia402 is not there";
  EXPECT_EQ(frames.size(), 596u);
  for (int number = 1; number <= 4; ++number)
    EXPECT_EQ(with_id(canopen::rpdo_cob_id(number, 12)).size(), 102u);
  for (int number = 1; number <= 2; ++number) {
    EXPECT_EQ(with_id(canopen::tpdo_cob_id(number, 12)).size(), 20u);
    for (const CanFrame& frame : with_id(canopen::tpdo_cob_id(number, 12))) {
      EXPECT_TRUE(std::ranges::all_of(frame.bytes(), [](std::uint8_t byte) { return byte == 0; }));
      EXPECT_EQ(cia402::decode_state(first_word(frame)), DriveState::not_ready_to_switch_on);
    }
  }
  const std::vector<CanFrame> emergencies = with_id(0x081);
  EXPECT_EQ(emergencies.size(), 38u);
  for (const CanFrame& frame : emergencies) {
    canopen::Emergency emergency;
    ASSERT_EQ(canopen::parse_emergency(frame, emergency), ParseResult::ok);
    EXPECT_EQ(emergency.error_code, canopen::emcy_pdo_too_long);
    EXPECT_EQ(emergency.error_register, 0x11);
  }
  std::uint8_t counter = 1;
  EXPECT_EQ(with_id(canopen::sync_cob_id).size(), 103u);
  for (const CanFrame& frame : with_id(canopen::sync_cob_id)) {
    ASSERT_EQ(canopen::parse_sync(frame, counter), ParseResult::ok);
    EXPECT_EQ(counter, 0);
  }
  for (const CanFrame& frame : with_id(0x70C)) {
    canopen::Heartbeat heartbeat;
    ASSERT_EQ(canopen::parse_heartbeat(frame, heartbeat), ParseResult::ok);
    EXPECT_EQ(heartbeat.node, 12);
  }
}

}  // namespace
}  // namespace godobject::test_recorded_can
