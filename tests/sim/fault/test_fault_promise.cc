// The table of docs/faults.md, executed: each verb causes the promised faults and no others.
// They occur within the documented time, and the motors are at zero in time.
#include "sim/fault/promise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <fstream>
#include <sstream>

#include "tests/support/fault_reactions.h"
#include "tests/support/faulty_rig.h"

namespace godobject {

void PrintTo(const FaultPromise& promise, std::ostream* out) { *out << promise.words; }

namespace test_fault_promise {
namespace {

using testing::HasSubstr;

constexpr Nanoseconds watchdog_ns = 20'000'000;  // of the simulated drives
constexpr Nanoseconds more_ns = 200'000'000;     // watched beyond that

TEST(FaultPromise, DocumentHoldsTheGeneratedTable) {
  std::ifstream file(GODOBJECT_SOURCE_DIR "/docs/faults.md");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("<!-- fault promises: begin -->\n\n" + fault_promises_markdown() +
                                    "\n<!-- fault promises: end -->"))
      << "paste the table of fault_promises_markdown() between the markers";
}

TEST(FaultPromise, ThereIsOneOfEveryVerbThatIsNotATrackersAlone) {
  for (const FaultVerbText& verb : fault_verb_texts()) {
    if (verb.place == FaultPlace::tracker) continue;
    const bool promised = std::ranges::any_of(fault_promises(), [&](const FaultPromise& promise) {
      return promise.words.substr(0, promise.words.find(' ')) == verb.name;
    });
    EXPECT_TRUE(promised) << verb.name;
  }
}

class FaultPromiseKept : public testing::TestWithParam<FaultPromise> {
 protected:
  const RigParams& params() const { return *device.scene.device->rig; }
  const RigFaultLog& log() const { return device.rig.fault_log(); }

  /// Plays the fault and runs until all promised faults should have come.
  void play() {
    ASSERT_TRUE(device.boot()) << device.rig.fault_text();
    const std::string words = test::words_for(GetParam(), params());
    std::string error;
    fault = *resolve(*parse_fault(words, error), params()).fault;
    device.play(words);
    begin_ns = device.t_sync_ns + test::FaultyRig::period_ns;
    Nanoseconds watched_ns = to_ns(params().heartbeat_timeout_s);
    for (const PromisedFault& promised : GetParam().faults)
      watched_ns = std::max(watched_ns, within(promised).value_or(0));
    while (device.t_sync_ns < begin_ns + watched_ns + more_ns) {
      device.cycle();
      if (device.motor_torque() > 0) last_torque_ns = device.t_sync_ns;
    }
  }
  std::optional<Nanoseconds> within(const PromisedFault& promised) const {
    return bound(promised.within, params(), test::FaultyRig::period_s, fault.duration_ns.value_or(0));
  }
  Nanoseconds after(Nanoseconds t) const { return t - begin_ns; }

  void expect_what_is_promised_and_nothing_else() {
    RigFault allowed = RigFault::none;
    for (const PromisedFault& promised : GetParam().faults) {
      allowed = allowed | promised.fault;
      if (promised.fault == RigFault::none || !promised.always) continue;
      const std::string_view name = text_of(promised.fault).name;
      ASSERT_TRUE(any(device.rig.faults() & promised.fault)) << name << " has not come\n"
                                                             << device.rig.fault_text();
      const auto within_ns = within(promised);
      if (!within_ns) continue;  // of travel: tests/sim/fault/test_fault_injector.cc
      EXPECT_LE(after(log().first(promised.fault).t_ns), *within_ns) << name;
    }
    for (const RigFaultRecord& record : log().records())
      EXPECT_TRUE(any(allowed & record.place.fault)) << device.rig.fault_text();
  }

  void expect_places() {
    for (const RigFaultRecord& record : log().records()) {
      if (record.place.fault == RigFault::sensors_disagree) continue;  // of two sensors: it names the drive
      ASSERT_TRUE(record.place.bus);
      EXPECT_GE(*record.place.bus, fault.first_bus) << device.rig.fault_text();
      EXPECT_LT(*record.place.bus, fault.end_bus) << device.rig.fault_text();
      if (fault.node_id == 0 || fault.verb == FaultVerb::swap_ids) continue;
      EXPECT_EQ(record.place.node_id, fault.node_id) << device.rig.fault_text();
    }
  }

  void expect_motors_at_zero() {
    ASSERT_FALSE(log().records().empty());
    const DriveParams& drive = params().drives[0];
    const Nanoseconds cycle_ns = test::FaultyRig::period_ns;
    const Nanoseconds ramp_ns = to_ns(drive.torque_max_Nm / drive.torque_rate_Nm_per_s);
    const bool cut = GetParam().motors == MotorsEnd::cut;
    Nanoseconds zero_ns = log().records().front().t_ns + (cut ? 2 * cycle_ns : ramp_ns + 3 * cycle_ns);
    if (GetParam().motors == MotorsEnd::watchdog)
      zero_ns = std::max(zero_ns, begin_ns + watchdog_ns + 2 * cycle_ns);
    EXPECT_LE(after(last_torque_ns), after(zero_ns));
    EXPECT_EQ(device.motor_torque(), 0);
  }

  void expect_device_can_be_armed_again() {
    device.link.rig().faults().clear(device.t_sync_ns);
    for (const char* const words :
         {"restart", "restart bus=can0 node=1", "restart bus=can0 node=2", "restart bus=can1 node=1"})
      device.play(words);
    device.cycles(100);
    EXPECT_EQ(device.motor_torque(), 0);
    device.rig.clear_faults(device.t_sync_ns);
    EXPECT_TRUE(device.boot()) << device.rig.fault_text();
  }

  test::FaultyRig device;
  SimFault fault;
  Nanoseconds begin_ns = 0, last_torque_ns = 0;
};

TEST_P(FaultPromiseKept, InTimeAtItsPlaceAndWithTheMotorsAtZero) {
  play();
  expect_what_is_promised_and_nothing_else();
  expect_places();
  if (GetParam().motors == MotorsEnd::keep) {
    EXPECT_EQ(device.rig.state(), RigState::armed) << device.rig.fault_text();
    EXPECT_GT(device.motor_torque(), 0);
    return;
  }
  expect_motors_at_zero();
  expect_device_can_be_armed_again();
}

std::string name_of(const testing::TestParamInfo<FaultPromise>& each) {
  std::string name = std::to_string(each.index) + "_";
  for (const char c : each.param.words) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Table, FaultPromiseKept,
                         testing::ValuesIn(fault_promises().begin(), fault_promises().end()), name_of);

}  // namespace
}  // namespace test_fault_promise
}  // namespace godobject
