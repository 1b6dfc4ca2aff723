// `godobject encoder`, run as by a user, against a simulated encoder behind a pseudo-terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/node/encoder.h"
#include "tests/support/node_on_pty.h"

namespace godobject::test_cli_encoder {
namespace {

using testing::HasSubstr;

class EncoderOnPty : public test::NodeOnPty<SimEncoder> {
 public:
  EncoderOnPty()
      : NodeOnPty([](CanBus& bus) {
          return std::make_unique<SimEncoder>(bus, std::uint8_t{5},
                                              Calibration{.counts_per_unit = 1000, .modulus_counts = 4096},
                                              Nanoseconds{0});
        }) {
    start([](SimEncoder& encoder, double) { encoder.set_position(0.5, 2); });
  }
  test::ProgramResult encoder(const std::string& rest) const {
    return test::run_program("encoder --bus slcan:" + name() + " --node 5 " + rest);
  }
};

TEST(CliEncoder, PrintsWhatTheEncoderSays) {
  EncoderOnPty node;
  node.call([](SimEncoder& encoder) {
    encoder.objects().find({0x6503, 0})->value = 0x0001;
    encoder.objects().find({0x6505, 0})->value = 0x1010;
  });
  const test::ProgramResult status = node.encoder("status");
  EXPECT_EQ(status.exit_code, 0);
  for (const char* line :
       {"simulated CiA 406 encoder", "vendor           0x00000DEB", "position         500 counts",
        "speed            2000 (6030h", "counts of a turn 4096", "alarms           position error\n",
        "warnings         battery low, bit 12 (the maker's)\n"})
    EXPECT_THAT(status.output, HasSubstr(line));
}

TEST(CliEncoder, PresetsAndSaysWhatChanged) {
  const EncoderOnPty node;
  const test::ProgramResult preset = node.encoder("preset 100");
  EXPECT_EQ(preset.exit_code, 0);
  EXPECT_THAT(preset.output, HasSubstr("position 500 -> 100 counts"));
  const test::ProgramResult beyond = node.encoder("preset 4096");
  EXPECT_EQ(beyond.exit_code, 1);
  EXPECT_THAT(beyond.output, HasSubstr("the position 4096 is not below the encoder's range of 4096 counts"));
  EXPECT_THAT(node.encoder("status").output, HasSubstr("100 counts"));
}

TEST(CliEncoder, DoesNotPresetUnderARunningHost) {
  EncoderOnPty node;
  node.send_syncs(true);
  const test::ProgramResult refused = node.encoder("preset 100");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.output, HasSubstr("a host runs this bus (SYNC) and would see the joint jump"));
  EXPECT_THAT(node.encoder("status").output, HasSubstr("position         500 counts"));
  EXPECT_EQ(node.encoder("preset 100 --despite-host").exit_code, 0);
}

TEST(CliEncoder, OptionsAreChecked) {
  for (const char* options : {"", "preset", "preset -1", "preset 4294967296", "preset x"})
    EXPECT_EQ(
        test::run_program(std::string("encoder --bus slcan:/dev/nothing --node 5 ") + options).exit_code, 2)
        << options;
  EXPECT_EQ(test::run_program("encoder --bus slcan:/dev/nothing --node 5 status").exit_code, 3);
}

}  // namespace
}  // namespace godobject::test_cli_encoder
