// Sealed runs of the program in real time: where they are possible, their lengths, and the checks of their
// reports.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "platform/rt/seal.h"
#include "tests/support/nightly.h"
#include "tests/support/program.h"

namespace godobject::test {

/// Returns why this build or kernel cannot be tested; empty if it can.
inline std::string why_not_sealed() {
  if (!AllocationGuard::works()) return "a sanitizer's run-time library makes calls of its own";
  return Seal::why_not();
}

/// Returns the duration of a sealed run, s: nightly 100 000 cycles. step: s.
inline int sealed_seconds(int usual, double step = 1e-3) {
  return length_of(usual, static_cast<int>(1e5 * step));
}

inline void expect_sealed(const std::string& report_path, const std::string& output) {
  const nlohmann::json report = nlohmann::json::parse(read_file(report_path), nullptr, false);
  ASSERT_TRUE(report.contains("seal")) << output;
  EXPECT_TRUE(report["seal"]["broken_by"].is_null()) << report["seal"];
  EXPECT_EQ(report["seal"]["refused_calls"], 0);
  EXPECT_GT(report["cycles"], 100);  // a sixth of those of an idle machine, and enough for the next lines
  ASSERT_TRUE(report.contains("page_faults")) << output;
  std::printf("%s cycles, %s missed deadlines\n", report["cycles"].dump().c_str(),
              report["timing"]["missed_deadlines"].dump().c_str());
  for (const auto& step : report["machine"]["rt_setup"])
    if (step["step"] == "lock memory" && step["result"] == "ok") {
      EXPECT_EQ(report["page_faults"]["minor"], 0);
      EXPECT_EQ(report["page_faults"]["major"], 0);
    }
}

}  // namespace godobject::test
