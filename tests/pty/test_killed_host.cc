// `godobject run` against `godobject simulate` over pseudo-terminals, until SIGKILL ends the host. It cannot
// react, so the configuration of the drives must stop the motors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>

#include "hal/canopen/canopen.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/run_over_ptys.h"

namespace godobject::test::test_killed_host {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::SizeIs;

constexpr double step_s = 5e-3;

class KilledHost : public RunOverPtys {
 protected:
  /// Keeps the errors that the drives report.
  void hear(const CanFrame& frame) override {
    canopen::Emergency emergency;
    if (canopen::parse_emergency(frame, emergency) == ParseResult::ok && emergency.error_code != 0)
      emergencies_.push_back(emergency.error_code);
  }

  std::vector<std::uint16_t> emergencies_;
};

TEST_F(KilledHost, MotorsAreOffTwentyMillisecondsLater) {
  const std::string scene = write("scene.toml", patient_toml());
  constexpr int tries = 5;
  for (int i = 0; i < tries; ++i) {
    emergencies_.clear();
    if (!start(scene)) continue;
    host_->end_by(SIGKILL);
    if (!emergencies_.empty()) continue;  // the machine stalled: a drive had stopped before
    listen(std::chrono::milliseconds(600));
    const nlohmann::json status = state();
    for (const auto& drive : status["drives"]) {
      EXPECT_EQ(drive["torque_Nm"], 0) << status;
      const double t_nonzero_s = drive["nonzero_at_s"];
      EXPECT_LE(t_nonzero_s - status["sync_at_s"].get<double>(), 0.02 + step_s) << status;
      // the watchdog over the commands counts from the last of them
      const double time_s = t_nonzero_s - drive["commanded_at_s"].get<double>();
      std::printf("zero torque %.1f ms after the last command\n", 1e3 * time_s);
      EXPECT_GT(time_s, 0.019) << status;
      EXPECT_LE(time_s, 0.02 + step_s) << status;
    }
    EXPECT_THAT(emergencies_, SizeIs(2));
    EXPECT_THAT(emergencies_, Each(canopen::emcy_rpdo_timeout));
    return;
  }
  FAIL() << "the host did not come up in " << tries << " tries";
}

}  // namespace
}  // namespace godobject::test::test_killed_host
