// `run --require-rt` on interfaces of the kernel: one that loses frames is no real-time machine.
#include <gmock/gmock.h>

#include "tests/socketcan/can_test.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_require_rt {
namespace {

using testing::HasSubstr;
using testing::Not;

class RequireRtOnSocketCan : public ProgramTest {
 protected:
  void SetUp() override {
    if (const std::string reason = why_no_interfaces(); !reason.empty()) GTEST_SKIP() << reason;
    set("1000");
  }
  void TearDown() override {
    if (!IsSkipped()) set("1000");
  }
  /// Sets the length of vcan1's queue, frames.
  static void set(const std::string& frames) { run("ip link set vcan1 txqueuelen " + frames); }
};

TEST_F(RequireRtOnSocketCan, AQueueThatIsShorterThanACycleIsNamed) {
  const std::string arguments = "run " + write("scene.toml", two_joints_toml) +
                                " --bus can0=socketcan:vcan0 --bus can1=socketcan:vcan1 --require-rt "
                                "--duration 0.1";
  set("1");
  const ProgramResult short_queue = run_program(arguments);
  EXPECT_EQ(short_queue.exit_code, 3) << short_queue.output;
  EXPECT_THAT(short_queue.output, HasSubstr("can1 (degraded)"));
  EXPECT_THAT(short_queue.output, HasSubstr("ip link set vcan1 txqueuelen 100"));
  set("1000");
  const ProgramResult long_queue = run_program(arguments);
  EXPECT_THAT(long_queue.output, Not(HasSubstr("can1 (")));
}

}  // namespace
}  // namespace godobject::test::test_require_rt
