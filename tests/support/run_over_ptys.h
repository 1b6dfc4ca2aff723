// `godobject run` against `godobject simulate` over pseudo-terminals, with a tap of the drives' bus.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "platform/linux/bus/bus.h"
#include "tests/support/background_program.h"
#include "tests/support/program.h"

namespace godobject::test {

class RunOverPtys : public ProgramTest {
 protected:
  /// Starts both programs, up to torque on all motors. options: further ones of `run`. limit_s: end of the
  /// run, s. Returns false if the machine stalled and the host gave up.
  bool start(const std::string& scene, const std::vector<std::string>& options = {}, int limit_s = 60) {
    host_.reset();
    far_.emplace(std::vector<std::string>{"simulate", scene, "--realtime", "--control", "-", "--bus",
                                          "can0=pty", "--bus", "can1=pty", "--tap", "can1=pty"});
    std::vector<std::string> arguments{"run",        scene, "--duration", std::to_string(limit_s),
                                       "--on-fault", "none"};
    arguments.insert(arguments.end(), options.begin(), options.end());
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

  /// Hands the frames of the tap to hear() for so long.
  void listen(std::chrono::milliseconds time) {
    for (const auto end = std::chrono::steady_clock::now() + time; std::chrono::steady_clock::now() < end;) {
      for (ReceivedFrame received; tap_->try_receive(received);) hear(received.frame);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  virtual void hear(const CanFrame& frame) = 0;

  std::optional<BackgroundProgram> far_, host_;

 private:
  std::unique_ptr<LinuxBus> tap_;
};

}  // namespace godobject::test
