// Bus addresses as typed by a user, right and wrong.
#include <gmock/gmock.h>

#include "platform/linux/bus/bus.h"

namespace godobject::test_bus_address {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

TEST(BusAddress, EveryKindIsParsedAndMade) {
  for (const auto& [text, name, where] : {std::tuple{"socketcan:can0", "socketcan", "can0"},
                                          {"slcan:/dev/ttyACM0", "slcan", "/dev/ttyACM0"},
                                          {"slcan:/dev/ttyUSB0,3000000", "slcan", "/dev/ttyUSB0,3000000"},
                                          {"board:/dev/ttyACM0", "board", "/dev/ttyACM0"},
                                          {"board:/dev/ttyUSB0,2000000", "board", "/dev/ttyUSB0,2000000"},
                                          {"pty:", "pty", ""},
                                          {"pty", "pty", ""},
                                          {"replay:a:b.log", "replay", "a:b.log"},
                                          {"replay:run.log,can1", "replay", "run.log,can1"}}) {
    std::string error = "of before";
    const std::optional<BusAddress> address = parse_bus_address(text, error);
    ASSERT_TRUE(address.has_value()) << text << ": " << error;
    EXPECT_THAT(error, IsEmpty());
    EXPECT_EQ(address->backend->name, name) << text;
    EXPECT_EQ(address->where, where) << text;
    const std::unique_ptr<LinuxBus> bus = make_bus(*address, {});
    ASSERT_TRUE(bus) << text;
    EXPECT_EQ(bus->state(), BusState::closed);
    EXPECT_EQ(bus->descriptor(), -1);
    ReceivedFrame frame;
    EXPECT_FALSE(bus->try_receive(frame));
    EXPECT_EQ(bus->try_send({.id = 0x80}), SendResult::down);
    EXPECT_EQ(bus->counters().send_refused, 1u);
  }
}

TEST(BusAddress, ErrorsAreReported) {
  for (const auto& [text, expected] :
       {std::pair{"socketcam:can0", "did you mean 'socketcan'?"},
        {"scan:/dev/ttyACM0", "did you mean 'slcan'?"},
        {"", "socketcan:, slcan:, pty:, board:, replay:"},
        {"kvaser:0", "unknown bus kind 'kvaser'; expected socketcan:, slcan:, pty:, board:, replay:"},
        {"can0", "the bus kind is missing: give socketcan:can0"},
        {"/dev/ttyACM0", "slcan:/dev/ttyACM0"},
        {"socketcan", "needs INTERFACE"},
        {"slcan:", "needs PATH"},
        {"board:", "needs PATH"},
        {"replay:", "needs FILE"},
        {"pty:/dev/pts/3", "pty takes no address"},
        {"socketcan:a-name-of-16-ch.", "at most 15"}}) {
    std::string error;
    EXPECT_FALSE(parse_bus_address(text, error).has_value()) << text;
    EXPECT_THAT(error, HasSubstr(expected)) << text;
    EXPECT_THAT(error, testing::StartsWith("'" + std::string(text) + "': "));
  }
  std::string error;
  EXPECT_FALSE(parse_bus_address("kvaser:0", error));
  EXPECT_THAT(error, testing::Not(HasSubstr("did you mean")));
}

}  // namespace
}  // namespace godobject::test_bus_address
