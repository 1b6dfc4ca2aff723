// Random faults, one after the other, for a long bus time. Each is detected, named as documented and
// recovered from, with zero torque within the watchdog time.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "sim/bus/random.h"
#include "tests/support/fault_reactions.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test {

/// Returns the bus time from GODOBJECT_SOAK_SECONDS, s: 3600 for a release.
inline double soak_seconds(double unless_given) {
  const char* const text = std::getenv("GODOBJECT_SOAK_SECONDS");
  return text ? std::strtod(text, nullptr) : unless_given;
}

template <class Link>
class FaultSoak {
 public:
  explicit FaultSoak(const std::vector<FaultReaction>& reactions) {
    for (const FaultReaction& reaction : reactions) kinds_.push_back({.reaction = reaction});
  }
  virtual ~FaultSoak() = default;

  /// Runs rounds of all kinds, each in a random order; the last round begins before `seconds` are over.
  void run(double seconds) {
    ASSERT_TRUE(device.boot()) << device.rig.fault_text();
    double reported_s = 0;
    while (device.motion_time < seconds && !testing::Test::HasFailure()) {
      shuffle();
      for (Kind& kind : kinds_) {
        play(kind);
        if (testing::Test::HasFailure()) break;
      }
      if (device.motion_time - reported_s < 300) continue;
      reported_s = device.motion_time;
      std::printf("%.0f s of bus time\n", reported_s);
      std::fflush(stdout);
    }
    report();
  }

 protected:
  virtual void begin(const FaultReaction& reaction) { device.play(reaction.words); }
  /// Ends all active faults and restarts every controller.
  virtual void repair() {
    device.link.rig().faults().clear(device.t_sync_ns);
    device.play("restart");
    for (const char* const words : {"restart bus=can0 node=1", "restart bus=can0 node=2",
                                    "restart bus=can1 node=1", "restart bus=can1 node=2"})
      device.play(words);
  }

  FaultyRigOn<Link> device;

 private:
  static constexpr int cycles_of_late_watch = 120;  // the host's heartbeat has 100 ms

  struct Kind {
    FaultReaction reaction;
    int played = 0;
    // Largest values, cycles:
    int to_fault = 0;
    int to_zero = 0;
  };

  std::size_t below(std::size_t n) {
    return static_cast<std::size_t>(random_.uniform() * static_cast<double>(n));
  }
  int cycles_below(std::size_t n) { return static_cast<int>(below(n)); }
  void shuffle() {
    for (std::size_t i = kinds_.size(); i > 1; --i) std::swap(kinds_[i - 1], kinds_[below(i)]);
  }

  void play(Kind& kind) {
    SCOPED_TRACE(kind.reaction.words + " at " + std::to_string(device.motion_time) + " s");
    expect_no_fault(1 + cycles_below(200));
    ++kind.played;
    begin(kind.reaction);
    if (kind.reaction.expected == RigFault::none) expect_no_fault(50 + cycles_below(200));
    else expect_fault(kind);
    device.cycles(cycles_below(100));
    repair();
    device.cycles(20);  // 128 times 11 bits take 1.4 ms
    if (device.rig.state() != RigState::fault) return;
    EXPECT_EQ(device.motor_torque(), 0);
    device.rig.clear_faults(device.t_sync_ns);
    if (device.boot() && !device.cycles_to_fault(cycles_of_late_watch)) return;
    // A drive that could not receive the host may report its own supervision timeout while it boots, or up to
    // one heartbeat later. It is cleared as any other fault.
    EXPECT_NE(device.rig.fault_text().find("0x8130"), std::string::npos) << device.rig.fault_text();
    device.cycles(100);
    device.rig.clear_faults(device.t_sync_ns);
    EXPECT_TRUE(device.boot()) << device.rig.fault_text();
  }

  void expect_no_fault(int cycles) {
    EXPECT_FALSE(device.cycles_to_fault(cycles)) << device.rig.fault_text();
    EXPECT_GT(device.motor_torque(), 0);
  }

  void expect_fault(Kind& kind) {
    const std::optional<int> to_fault = device.cycles_to_fault(kind.reaction.within);
    EXPECT_TRUE(to_fault) << "no fault came up";
    EXPECT_TRUE(any(device.rig.faults() & kind.reaction.expected)) << device.rig.fault_text();
    if (!any(kind.reaction.expected & RigFault::sensors_disagree)) expect_place(kind.reaction.words);
    const std::optional<int> to_zero = device.cycles_to_zero(cycles_of_watchdog);
    EXPECT_TRUE(to_zero) << device.motor_torque() << " N m";
    kind.to_fault = std::max(kind.to_fault, to_fault.value_or(0));
    kind.to_zero = std::max(kind.to_zero, to_zero.value_or(0));
  }

  /// Checks that the fault text names the bus of the injected fault.
  void expect_place(const std::string& words) {
    const std::size_t at = words.find("bus=");
    if (at == std::string::npos) return;
    const std::string bus = words.substr(at + 4, words.find(' ', at) - at - 4);
    EXPECT_NE(device.rig.fault_text().find("(" + bus), std::string::npos) << device.rig.fault_text();
  }

  void report() const {
    int faults = 0, seen = 0, to_zero = 0;
    for (const Kind& kind : kinds_) {
      std::printf("  %5d  %-44s", kind.played, kind.reaction.words.c_str());
      if (kind.reaction.expected == RigFault::none) std::printf("no fault\n");
      else
        std::printf("fault within %d cycles, motors at zero within %d more\n", kind.to_fault, kind.to_zero);
      faults += kind.played;
      seen += kind.reaction.expected == RigFault::none ? 0 : kind.played;
      to_zero = std::max(to_zero, kind.to_zero);
    }
    std::printf("%.0f s of bus time: %d faults of %zu kinds; %d stopped the motors, within %d cycles each\n",
                device.motion_time, faults, kinds_.size(), seen, to_zero);
  }

  SplitMix64 random_{20260};
  std::vector<Kind> kinds_;
};

}  // namespace godobject::test
