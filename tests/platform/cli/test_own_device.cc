// The device of a program of one's own: in runs with all their outputs, supervised from booting to closing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "platform/cli/program.h"
#include "tests/support/program.h"

namespace godobject::test::test_own_device {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr int boot_periods = 20, run_down_periods = 30;

// Calls to the device, in their order; repeated ones once.
std::vector<std::string>& calls() {
  static std::vector<std::string> all;
  return all;
}
void call(const std::string& name) {
  if (calls().empty() || calls().back() != name) calls().push_back(name);
}

/// Boots, moves the first body along x at 0.1 m/s, and takes some periods until its torque has run down.
class Arm final : public HandDevice {
 public:
  std::optional<double> boot_limit_s() const noexcept override { return 1; }
  void boot(Period&) noexcept override {
    call("boot");
    ++num_booted_;
  }
  bool ready() const noexcept override { return num_booted_ >= boot_periods; }
  bool arm() noexcept override {
    call("arm");
    return true;
  }
  void read(Period& period, std::span<BodySample> samples) noexcept override {
    call("read and command");
    samples[0].target.X_WD.p.x() += 0.1 * period.t;
    samples[0].target.V_WD.v.x() = 0.1;
  }
  void command(Period&, std::span<const Wrench> F_hand_W, Shown&) noexcept override {
    call("read and command");
    largest_N = std::max(largest_N, F_hand_W[0].f.norm());
  }
  bool makes_torque() const noexcept override { return true; }
  void disarm() noexcept override { call("disarm"); }
  bool run_down(Period&) noexcept override {
    call("run down");
    return ++num_run_down_ < run_down_periods;
  }
  void stop(Period&) noexcept override { call("stop"); }

  static inline double largest_N = 0;

 private:
  int num_booted_ = 0, num_run_down_ = 0;
};

std::unique_ptr<HandDevice> make_arm(const SceneConfig&, std::string&) { return std::make_unique<Arm>(); }
std::unique_ptr<HandDevice> no_arm(const SceneConfig&, std::string& why_not) {
  why_not = "the arm is switched off: switch it on";
  return nullptr;
}

class OwnDevice : public ProgramTest {
 protected:
  OwnDevice() {
    calls().clear();
    Arm::largest_N = 0;
  }

  /// Runs the program in this process.
  static int run(DeviceMaker device, std::initializer_list<std::string> arguments) {
    std::vector<std::string> words{"program"};
    words.insert(words.end(), arguments);
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    return godobject::run_program(static_cast<int>(argv.size()), argv.data(), {.device = device});
  }

  const std::string wall_ = GODOBJECT_SOURCE_DIR "/sim/scenes/wall.toml";
};

TEST_F(OwnDevice, MovesTheToolInARunWithAllItsOutputs) {
  ASSERT_EQ(run(make_arm, {"run", wall_, "--fast", "--quiet", "--duration", "1.5", "--trace", path("t.csv"),
                           "--record", path("r.godo"), "--report", path("r.json")}),
            0);
  EXPECT_THAT(calls(), ElementsAre("boot", "arm", "read and command", "disarm", "run down", "stop"));
  EXPECT_GT(Arm::largest_N, 5) << "pressed 80 mm into the wall";
  const std::string trace = read_file(path("t.csv"));
  EXPECT_EQ(std::ranges::count(trace, '\n'), 1502) << "a head, the start, 1500 steps";
  EXPECT_THAT(read_file(path("r.json")), HasSubstr("\"cycles\": 1500"));
  EXPECT_EQ(run(nullptr, {"replay", path("r.godo")}), 0) << "a replay needs no device";
}

TEST_F(OwnDevice, IsNotMadeWhereTheRunHasAnother) {
  ASSERT_EQ(run(make_arm, {"run", wall_, "--fast", "--quiet", "--duration", "0.1", "--bus", "direct"}), 0);
  ASSERT_EQ(run(make_arm, {"check", wall_}), 0);
  EXPECT_THAT(calls(), ElementsAre());
}

TEST_F(OwnDevice, ThatCannotBeMadeEndsTheRunWithItsReason) {
  testing::internal::CaptureStderr();
  const int code = run(no_arm, {"run", wall_, "--fast", "--duration", "0.1"});
  EXPECT_EQ(code, static_cast<int>(ExitCode::not_available));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("the arm is switched off: switch it on"));
}

}  // namespace
}  // namespace godobject::test::test_own_device
