// `godobject sdo` and `lss`, run as by a user, against a simulated encoder behind a pseudo-terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/node/encoder.h"
#include "tests/support/background_program.h"
#include "tests/support/node_on_pty.h"

namespace godobject::test_cli_sdo {
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
    start([](SimEncoder&, double) {});
  }
  test::ProgramResult run(const std::string& verb, const std::string& rest) const {
    return test::run_program(verb + " --bus slcan:" + name() + " " + rest);
  }
};

TEST(CliSdo, ReadsAndWritesObjects) {
  const EncoderOnPty encoder;
  const test::ProgramResult name = encoder.run("sdo", "--node 5 read 1008 --type string");
  EXPECT_EQ(name.output, "simulated CiA 406 encoder\n");
  EXPECT_EQ(name.exit_code, 0);
  EXPECT_EQ(encoder.run("sdo", "--node 5 write 6003 1234 --type u32").exit_code, 0);
  EXPECT_EQ(encoder.run("sdo", "--node 5 read 6004:00 --type u32").output, "1234\n");
  EXPECT_EQ(encoder.run("sdo", "--node 5 read 6004").output, "hex D2 04 00 00, u32 1234, i32 1234\n");
}

TEST(CliSdo, SaysWhyNot) {
  const EncoderOnPty encoder;
  const test::ProgramResult rejected = encoder.run("sdo", "--node 5 write 6004 1 --type u32");
  EXPECT_EQ(rejected.exit_code, 1);
  EXPECT_THAT(rejected.output, HasSubstr("node 5, 6004h:00 <- 1: rejected: 06010002 "));
  EXPECT_THAT(rejected.output, HasSubstr("read-only"));
  const test::ProgramResult silent = encoder.run("sdo", "--node 6 --timeout 0.1 read 1000");
  EXPECT_EQ(silent.exit_code, 1);
  EXPECT_THAT(silent.output,
              HasSubstr("no answer within 100 ms to 3 requests: check that the node is powered"));
  EXPECT_EQ(encoder.run("sdo", "--node 5 read 60X4").exit_code, 2);
  EXPECT_EQ(encoder.run("sdo", "--node 128 read 6004").exit_code, 2);
  EXPECT_EQ(encoder.run("sdo", "--node 5 write 6003 x --type u32").exit_code, 2);
  EXPECT_EQ(test::run_program("sdo --bus slcan:/dev/nothing --node 5 read 6004").exit_code, 3);
  EXPECT_THAT(test::run_program("sdo --bus replay:x.log --node 5 read 6004").output,
              HasSubstr("a log does not answer requests"));
}

/// All nodes would get the same ID; none is changed or left in configuration mode.
TEST(CliLss, RefusesToRenumberSeveralNodes) {
  test::BackgroundProgram rig({"simulate", "sim/scenes/rigid.toml", "--bus", "pty"});
  const std::string first = rig.line();
  ASSERT_THAT(first, testing::StartsWith("bus can0: "));
  while (rig.line() != "ready") continue;
  const auto lss = [&](const std::string& rest) {
    return test::run_program("lss --bus slcan:" + first.substr(std::string("bus can0: ").size()) +
                             " --timeout 0.3 " + rest);
  };
  const test::ProgramResult several = lss("node-id 9");
  EXPECT_EQ(several.exit_code, 1) << several.output;
  EXPECT_THAT(several.output, HasSubstr("6 nodes are on the bus, and each would get the ID 9: "));
  EXPECT_THAT(several.output, HasSubstr("--select VENDOR PRODUCT REVISION SERIAL"));
  EXPECT_THAT(several.output, testing::Not(HasSubstr("in effect")));
  EXPECT_THAT(lss("node-id 9").output, HasSubstr("6 nodes are on the bus"));
}

TEST(CliLss, GivesANodeItsIdAndBitRate) {
  const EncoderOnPty encoder;
  EXPECT_EQ(encoder.run("lss", "node-id 9").exit_code, 0);
  EXPECT_EQ(encoder.run("lss", "store").exit_code, 0);
  EXPECT_EQ(encoder.run("lss", "--select 0xDEB 0x406 0x10000 1 bit-rate 500000").exit_code, 0);
  const test::ProgramResult other = encoder.run("lss", "--timeout 0.1 --select 1 2 3 4 node-id 9");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.output, HasSubstr("check that a node has this identity"));
  EXPECT_EQ(encoder.run("lss", "--select 0xDEB 0x406 0x10000 1 node-id 9").exit_code, 0);
  EXPECT_EQ(encoder.run("lss", "node-id 9 --alone").exit_code, 0);
  EXPECT_EQ(encoder.run("lss", "bit-rate 100000").exit_code, 2);
  EXPECT_EQ(encoder.run("lss", "node-id 128").exit_code, 2);
}

}  // namespace
}  // namespace godobject::test_cli_sdo
