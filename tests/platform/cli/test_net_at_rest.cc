// A net at rest converges at once and reports it: TR-BDF2 keeps its second order.
#include <gmock/gmock.h>

#include "tests/support/program.h"

namespace godobject::test::test_net_at_rest {
namespace {

class NetAtRest : public ProgramTest {
 protected:
  /// Runs a sheet without gravity or motion.
  ProgramResult run(const std::string& more) const {
    const std::string scene =
        write("net.toml",
              "[scene]\nname = \"rest\"\nintegrator = \"tr-bdf2\"\n[[body]]\nname = \"b\"\nmass = 1.0\n"
              "inertia = [1e-3, 1e-3, 1e-3]\nposition = [1.0, 0.0, 0.0]\n[[net]]\nname = \"sheet\"\nkind = "
              "\"sheet\"\n"
              "length = 0.1\nwidth = 0.1\nspacing = 0.02\nsurface_density = 2.0\nmembrane_stiffness = 20.0\n"
              "settling_time = 0.2\n" +
                  more);
    return run_program("run " + scene + " --fast --bus direct --duration 0.5");
  }
};

TEST_F(NetAtRest, IsNotOfFirstOrder) {
  for (const char* more : {"", "rim = true\n", "bending = 0.1\n", "anchor_stiffness = 1e4\n"}) {
    const ProgramResult result = run(more);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_THAT(result.output, testing::HasSubstr("first_order 1 cycles")) << more;
    EXPECT_THAT(result.output, testing::Not(testing::HasSubstr("WARNING"))) << more;
  }
}

}  // namespace
}  // namespace godobject::test::test_net_at_rest
