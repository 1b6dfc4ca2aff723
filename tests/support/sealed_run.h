// Sealed runs of the program in real time: where they are possible, their lengths, and the checks of their
// reports.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "platform/rt/seal.h"
#include "tests/support/nightly.h"
#include "tests/support/program.h"

namespace godobject::test {

/// Returns why this build or kernel cannot be tested; empty if it can.
inline std::string why_not_sealed() {
#ifdef GODOBJECT_SANITIZED
  return "a sanitizer's run-time library makes calls of its own";
#else
  return Seal::why_not();
#endif
}

/// Returns the duration of a sealed run, s: nightly 100 000 cycles. step: s.
inline int sealed_seconds(int usual, double step = 1e-3) {
  return length_of(usual, static_cast<int>(1e5 * step));
}

/// While one exists, programs are started with the guard that counts heap calls and locks of the loop.
class LoopGuard {
 public:
  explicit LoopGuard(std::string path) : path_(std::move(path)) {
    setenv("GODOBJECT_LOOP_GUARD", path_.c_str(), 1);
    setenv("LD_PRELOAD", GODOBJECT_LOOP_GUARD_LIBRARY, 1);
  }
  ~LoopGuard() {
    unsetenv("LD_PRELOAD");
    unsetenv("GODOBJECT_LOOP_GUARD");
  }
  LoopGuard(const LoopGuard&) = delete;
  LoopGuard& operator=(const LoopGuard&) = delete;

  void expect_nothing() const {
    long sleeps = 0, heap_calls = -1, locks = -1;
    std::ifstream(path_) >> sleeps >> heap_calls >> locks;
    std::printf("%ld periods of the loop: %ld heap calls, %ld locks\n", sleeps, heap_calls, locks);
    EXPECT_GT(sleeps, 0);
    EXPECT_EQ(heap_calls, 0);
    EXPECT_EQ(locks, 0);
  }

 private:
  std::string path_;
};

/// Expects a report without a refused call, and with each step of a run of this length. A late run has them
/// too, because it ends after their number. seconds, step: s. output: for messages.
inline void expect_sealed(const std::string& report_path, int seconds, double step, const LoopGuard& guard,
                          const std::string& output = "") {
  guard.expect_nothing();
  const nlohmann::json report = nlohmann::json::parse(read_file(report_path), nullptr, false);
  ASSERT_TRUE(report.contains("seal")) << output;
  EXPECT_TRUE(report["seal"]["broken_by"].is_null()) << report["seal"];
  EXPECT_EQ(report["seal"]["refused_calls"], 0);
  EXPECT_EQ(report["cycles"], std::lround(seconds / step)) << output;
  ASSERT_TRUE(report.contains("page_faults")) << output;
  std::printf("%s cycles, %s missed deadlines\n", report["cycles"].dump().c_str(),
              report["timing"]["missed_deadlines"].dump().c_str());
  for (const auto& done : report["machine"]["rt_setup"])
    if (done["step"] == "lock memory" && done["result"] == "ok") {
      EXPECT_EQ(report["page_faults"]["minor"], 0);
      EXPECT_EQ(report["page_faults"]["major"], 0);
      EXPECT_TRUE(report["page_faults"]["first_cycle"].is_null()) << report["page_faults"];
    }
}

}  // namespace godobject::test
