// `godobject run` against `godobject simulate` over pseudo-terminals, until SIGKILL ends the host. It cannot
// react, so the configuration of the drives must stop the motors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "hal/canopen/canopen.h"
#include "platform/linux/bus/bus.h"
#include "tests/support/background_program.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_killed_host {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::SizeIs;

constexpr double step_s = 5e-3;

class KilledHost : public ProgramTest {
 protected:
  /// Starts both programs, up to torque on both motors. Returns false if the machine stalled and the host
  /// gave up.
  bool start(const std::string& scene) {
    host_.reset();
    far_.emplace(std::vector<std::string>{"simulate", scene, "--realtime", "--control", "-", "--bus",
                                          "can0=pty", "--bus", "can1=pty", "--tap", "can1=pty"});
    std::vector<std::string> arguments{"run", scene, "--duration", "60"};
    std::string tap;
    for (std::string line = far_->line(); line != "ready" && !line.empty(); line = far_->line()) {
      const std::string address = line.substr(line.find(": ") + 2);
      if (line.starts_with("tap")) tap = address;
      else arguments.insert(arguments.end(), {"--bus", line.substr(4, 4) + "=slcan:" + address});
    }
    std::string error;
    tap_ = make_bus(parse_bus_address("slcan:" + tap, error).value(), {});
    EXPECT_TRUE(tap_->open()) << error;
    host_.emplace(arguments);
    for (int i = 0; i < 500; ++i) {
      listen(std::chrono::milliseconds(20));
      const nlohmann::json drives = state()["drives"];
      if (std::ranges::all_of(drives, [](const auto& drive) { return drive["torque_Nm"] != 0; })) return true;
    }
    return false;
  }
  nlohmann::json state() { return nlohmann::json::parse(far_->say("status")); }

  /// Collects the drives' reports for this time.
  void listen(std::chrono::milliseconds time) {
    for (const auto end = std::chrono::steady_clock::now() + time; std::chrono::steady_clock::now() < end;) {
      for (ReceivedFrame received; tap_->try_receive(received);) {
        canopen::Emergency emergency;
        if (canopen::parse_emergency(received.frame, emergency) == ParseResult::ok &&
            emergency.error_code != 0)
          emergencies_.push_back(emergency.error_code);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  std::optional<BackgroundProgram> far_, host_;
  std::unique_ptr<LinuxBus> tap_;
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
