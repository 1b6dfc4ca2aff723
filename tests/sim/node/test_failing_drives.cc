// Rigs with drives that fail when powered, read their commands seldom, or report limits in other bits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <random>

#include "hal/rig/rig.h"
#include "sim/node/drive.h"
#include "sim/node/moteus.h"
#include "sim/node/odrive.h"
#include "tests/support/one_drive.h"

namespace godobject::test_failing_drives {
namespace {

using test::cia402_with;
using test::drive_of;
using test::OneDrive;
using testing::HasSubstr;

constexpr Nanoseconds ms = 1'000'000;
constexpr std::uint8_t id = OneDrive::id;

/// Returns the number of times that the statusword became Operation Enabled.
int times_enabled(const std::vector<ReceivedFrame>& frames) {
  int times = 0;
  bool was = false;
  for (const ReceivedFrame& received : frames) {
    cia402::Status status;
    if (cia402::parse_status(received.frame, id, status) != ParseResult::ok) continue;
    const bool is = cia402::decode_state(status.statusword) == cia402::DriveState::operation_enabled;
    if (is && !was) ++times;
    was = is;
  }
  return times;
}

TEST(FailingDrives, Cia402ThatFailsWithoutEmergencyIsGivenPowerOnce) {
  std::mt19937 random(38);
  for (const std::uint16_t error : std::initializer_list<std::uint16_t>{0x2310, 0x7305, 0x3220, 0xFF01})
    for (int k = 0; k < 5; ++k) {
      const auto after = static_cast<Nanoseconds>(1 + random() % 9) * ms;
      OneDrive device(drive_of(DriveProtocol::cia402),
                      cia402_with({.error_when_enabled = error, .error_after_ns = after}));
      const int cycles = device.boot();
      ASSERT_EQ(device.rig->faults(), RigFault::drive_error) << device.rig->fault_text();
      EXPECT_EQ(times_enabled(device.frames), 1);
      EXPECT_LT(cycles, 200);
      EXPECT_EQ(device.rig->fault_log().first(RigFault::drive_error).place.drive_code, error);
      char code[32];
      std::snprintf(code, sizeof code, "603Fh = %04Xh", unsigned{error});
      EXPECT_THAT(device.rig->fault_text(), HasSubstr(code));
    }
}

TEST(FailingDrives, Cia402ThatLosesPowerWithoutAFaultIsGivenPowerOnce) {
  for (const Nanoseconds after : {1 * ms, 4 * ms, 8 * ms}) {
    OneDrive device(
        drive_of(DriveProtocol::cia402),
        cia402_with({.error_when_enabled = 1, .error_after_ns = after, .loses_power_only = true}));
    EXPECT_LT(device.boot(), 300);
    ASSERT_EQ(device.rig->faults(), RigFault::drive_not_enabled) << device.rig->fault_text();
    EXPECT_EQ(times_enabled(device.frames), 1);
    EXPECT_THAT(device.rig->fault_text(), HasSubstr("switch on disabled (6041h = 0250h)"));
  }
}

TEST(FailingDrives, AFaultThatStoodBeforeIsCleared) {
  OneDrive device(drive_of(DriveProtocol::cia402), cia402_with({}));
  device.node->trip(0x8611);
  device.boot();
  EXPECT_TRUE(device.rig->ready()) << device.rig->fault_text();
}

TEST(FailingDrives, AFaultWithoutEmergencyWhileArmedIsNamedByItsCode) {
  OneDrive device(drive_of(DriveProtocol::cia402),
                  cia402_with({.error_when_enabled = 0x2310, .error_after_ns = 60 * ms}));
  device.boot();
  ASSERT_TRUE(device.rig->arm()) << device.rig->fault_text();
  for (int k = 0; k < 120; ++k) device.cycle();
  EXPECT_EQ(device.rig->faults(), RigFault::drive_not_enabled | RigFault::drive_error);
  EXPECT_THAT(device.rig->fault_text(), HasSubstr("603Fh = 2310h, continuous over-current"));
  EXPECT_EQ(times_enabled(device.frames), 1);
}

TEST(FailingDrives, OdriveThatFailsInClosedLoopIsGivenPowerOnce) {
  for (const std::uint32_t error : {0x1u, 0x10u, 0x0400'0000u, 0x4000'0000u}) {
    OneDrive device(drive_of(DriveProtocol::odrive), [error](CanBus& bus, const DriveParams& drive) {
      return std::make_unique<SimOdrive>(bus, drive, SimOdriveQuirks{.error_in_closed_loop = error});
    });
    device.boot();
    ASSERT_EQ(device.rig->faults(), RigFault::drive_error) << device.rig->fault_text();
    EXPECT_EQ(dynamic_cast<SimOdrive&>(*device.node).times_enabled(), 1);
    EXPECT_EQ(device.rig->fault_log().first(RigFault::drive_error).place.drive_code, error);
  }
}

TEST(FailingDrives, MoteusThatFailsInMode10IsGivenPowerOnce) {
  for (const int fault : {33, 36, 39, 40}) {
    OneDrive device(drive_of(DriveProtocol::moteus), [fault](CanBus& bus, const DriveParams& drive) {
      return std::make_unique<SimMoteus>(bus, drive, fault);
    });
    device.boot();
    ASSERT_EQ(device.rig->faults(), RigFault::drive_error) << device.rig->fault_text();
    EXPECT_EQ(dynamic_cast<SimMoteus&>(*device.node).times_enabled(), 1);
    EXPECT_EQ(device.rig->fault_log().first(RigFault::drive_error).place.drive_code,
              static_cast<std::uint32_t>(fault));
    const char* const name = fault == 39 ? "fault 39, outside its limits" : "fault ";
    EXPECT_THAT(device.rig->fault_text(), HasSubstr(name));
  }
}

TEST(FailingDrives, FaultIsResetWhereTheDriveLooksAtItsControlwordSeldom) {
  std::vector<SimDriveQuirks> all;
  for (int n = 2; n <= 12; ++n) all.push_back({.controlword_every_nth_sync = n});
  for (int k = 1; k <= 16; ++k) all.push_back({.controlword_period_ns = k * ms / 2 + 13'000});
  all.push_back({.controlword_period_ns = 40 * ms});
  for (const SimDriveQuirks& quirks : all)
    for (int phase = 0; phase < 4; ++phase) {
      OneDrive device(drive_of(DriveProtocol::cia402), cia402_with(quirks));
      device.node->trip(0x8611);
      for (int k = 0; k < phase; ++k) device.cycle();
      device.boot();
      EXPECT_TRUE(device.rig->ready()) << quirks.controlword_every_nth_sync << ' '
                                       << quirks.controlword_period_ns << ' ' << device.rig->fault_text();
    }
}

TEST(FailingDrives, ALimitThatClearsBit12IsNoLossOfTheDrive) {
  constexpr std::uint16_t bit_11 = 1u << 11;
  for (const auto& [limit, without_bit] :
       {std::pair<std::int16_t, std::uint16_t>{50, 0}, {120, 0}, {300, 0}, {50, bit_11}, {200, bit_11}}) {
    OneDrive device(drive_of(DriveProtocol::cia402), cia402_with({.max_torque_per_mille = limit,
                                                                  .limit_clears_follow_bit = true,
                                                                  .status_clear = without_bit}));
    device.boot();
    ASSERT_TRUE(device.rig->arm()) << device.rig->fault_text();
    device.F.f = Vec3(0, 0.4, 0);  // 0.04 N m at the joint: 400 per mille
    bool limited = false;
    for (int k = 0; k < 50; ++k) {
      device.cycle();
      limited = limited || device.report.drive_limited != 0;
    }
    EXPECT_EQ(device.rig->faults(), RigFault::none) << device.rig->fault_text();
    EXPECT_TRUE(limited);
    EXPECT_NEAR(device.rig->drive_feedback(0, device.now).torque_Nm, 1e-3 * limit * 0.1, 1e-4);
    for (int k = 0; k < 60; ++k) {  // from one end to the other at once, and by ramps
      device.F.f.y() = k < 20 ? (k % 4 < 2 ? -0.4 : 0.4) : 0.4 * std::sin(0.3 * k);
      device.cycle();
      ASSERT_EQ(device.rig->faults(), RigFault::none) << k << device.rig->fault_text();
    }
    device.F = {};
    for (int k = 0; k < 10; ++k) device.cycle();
    EXPECT_EQ(device.report.drive_limited, 0u);
    EXPECT_TRUE(device.rig->state() == RigState::armed) << device.rig->fault_text();
  }
}

/// Answers SYNC with scripted frames; a heartbeat every 50 ms.
class ScriptedNode final : public SimNode {
 public:
  ScriptedNode(CanBus& bus, std::vector<CanFrame> answers, std::vector<CanFrame> heartbeats)
      : bus_(bus), answers_(std::move(answers)), heartbeats_(std::move(heartbeats)) {}
  void poll(Nanoseconds now) noexcept override {
    for (ReceivedFrame received; bus_.try_receive(received);) {
      const bool is_request = received.frame.id == canopen::sync_cob_id || received.frame.remote;
      for (const CanFrame& frame : answers_)
        if (is_request) static_cast<void>(bus_.try_send(frame));
    }
    for (; t_next_ <= now; t_next_ += 50 * ms)
      for (const CanFrame& frame : heartbeats_) static_cast<void>(bus_.try_send(frame));
  }
  Nanoseconds next_timer() const noexcept override { return t_next_; }
  std::uint8_t node_id() const noexcept override { return id; }
  void power_cycle(Nanoseconds) noexcept override {}
  void trip(std::uint16_t) noexcept override {}
  void set_clock_error(double, Nanoseconds) noexcept override {}

 private:
  CanBus& bus_;
  std::vector<CanFrame> answers_, heartbeats_;
  Nanoseconds t_next_ = 0;
};

std::string text_of_boot(DriveProtocol protocol, const std::vector<CanFrame>& answers,
                         const std::vector<CanFrame>& heartbeats) {
  OneDrive device(drive_of(protocol), [&](CanBus& bus, const DriveParams&) {
    return std::make_unique<ScriptedNode>(bus, answers, heartbeats);
  });
  device.boot();
  EXPECT_EQ(device.rig->faults(), RigFault::boot_timeout);
  return device.rig->fault_text();
}

TEST(BootTimeout, IsRecognisedByTheFramesOfTheNode) {
  const CanFrame operational = canopen::make_heartbeat(id, canopen::NmtState::operational);
  const CanFrame status = cia402::make_status(id, {.statusword = 0x0250});
  EXPECT_THAT(text_of_boot(DriveProtocol::cia402, {}, {}), HasSubstr("no frame of it was received"));
  EXPECT_THAT(text_of_boot(DriveProtocol::cia402, {}, {operational}),
              HasSubstr("it is operational, no TPDO1 with its status was received"));
  EXPECT_THAT(text_of_boot(DriveProtocol::cia402, {},
                           {canopen::make_heartbeat(id, canopen::NmtState::pre_operational)}),
              HasSubstr("it is pre-operational"));
  EXPECT_THAT(text_of_boot(DriveProtocol::cia402, {status}, {}), HasSubstr("no heartbeat was received"));
  const std::string stuck =
      text_of_boot(DriveProtocol::cia402,
                   {status, cia402::make_event(id, {.mode = 10, .error_code = 0x3220})}, {operational});
  EXPECT_THAT(stuck, HasSubstr("switch on disabled (6041h = 0250h), 603Fh = 3220h, DC link under-voltage"));
  const std::string deaf = text_of_boot(
      DriveProtocol::cia402,
      {cia402::make_status(id, {.statusword = 0x0237}), cia402::make_event(id, {.mode = 8})}, {operational});
  EXPECT_THAT(deaf,
              HasSubstr("operation enabled (6041h = 0237h), its mode 6061h is 8, not 10, bit 12 is not set"));
}

TEST(BootTimeout, IsRecognisedByTheLengthOfFramesThatWereNotUnderstood) {
  const CanFrame operational = canopen::make_heartbeat(id, canopen::NmtState::operational);
  for (const std::uint8_t size : std::initializer_list<std::uint8_t>{0, 1, 4, 5, 7}) {
    CanFrame status = cia402::make_status(id, {.statusword = 0x0250});
    status.size = size;
    const std::string text = text_of_boot(DriveProtocol::cia402, {status}, {operational});
    EXPECT_THAT(text, HasSubstr("of its frames were invalid, the last 187 of " + std::to_string(size) +
                                " bytes, which is too short"));
  }
}

TEST(BootTimeout, IsRecognisedByTheReportsOfAnOdrive) {
  const auto heartbeat = [](const odrive::Heartbeat& h) { return odrive::make_heartbeat(id, h); };
  const CanFrame estimates = odrive::make_encoder_estimates(id, {});
  const auto text = [&](const odrive::Heartbeat& h) {
    return text_of_boot(DriveProtocol::odrive, {estimates}, {heartbeat(h)});
  };
  EXPECT_THAT(text({.error = 0x200, .axis_state = 1}), HasSubstr("error 00000200h DC bus under-voltage"));
  EXPECT_THAT(text({.axis_state = 1, .flags = {14, 1, 0}}), HasSubstr("procedure result 14 not calibrated"));
  EXPECT_THAT(text({.axis_state = 1, .flags = {1, 0, 0x80}}), HasSubstr("idle, error of the motor"));
  EXPECT_THAT(text({.axis_state = 1, .flags = {0, 1, 0x81}}),
              HasSubstr("idle, error of the encoder, error of the controller"));
  EXPECT_THAT(text({.error = 0x800, .axis_state = 1, .flags = {0, 0, 0x80}}),
              HasSubstr("error 00000800h watchdog"));
}

TEST(BootTimeout, ErrorsThatOdrivesOfFirmware05OnlyFlagAreCleared) {
  OneDrive device(drive_of(DriveProtocol::odrive), [](CanBus& bus, const DriveParams& drive) {
    return std::make_unique<SimOdrive>(bus, drive, SimOdriveQuirks{.firmware_0_5 = true, .motor_error = 1});
  });
  device.boot();
  EXPECT_TRUE(device.rig->ready()) << device.rig->fault_text();
}

TEST(FailingDrives, LossOfBit12WithoutALimitIsLossOfTheDrive) {
  for (const double force : {0.0, 0.2}) {
    OneDrive device(drive_of(DriveProtocol::cia402), cia402_with({}));
    device.boot();
    ASSERT_TRUE(device.rig->arm());
    device.F.f = Vec3(0, force, 0);
    for (int k = 0; k < 20; ++k) device.cycle();
    ASSERT_EQ(device.rig->faults(), RigFault::none);
    dynamic_cast<SimDrive&>(*device.node).set_quirks({.status_clear = 1u << 12});
    for (int k = 0; k < 3; ++k) device.cycle();
    EXPECT_EQ(device.rig->faults(), RigFault::drive_not_enabled) << force;
  }
}

TEST(FailingDrives, ModeAndBitsAreOfTheDrivesParameters) {
  constexpr std::uint16_t bit_12 = 1u << 12, bit_14 = 1u << 14;
  const auto boots = [](const Cia402Params& bits, const SimDriveQuirks& quirks) {
    DriveParams drive = drive_of(DriveProtocol::cia402);
    drive.cia402 = bits;
    OneDrive device(drive, cia402_with(quirks));
    device.boot();
    return device.rig->ready();
  };
  EXPECT_TRUE(boots({.torque_mode = 4}, {}));
  EXPECT_FALSE(boots({}, {.status_clear = bit_12}));
  EXPECT_TRUE(boots({.follows_mask = 0}, {.status_clear = bit_12}));
  EXPECT_TRUE(boots({.follows_mask = bit_14}, {.status_clear = bit_12, .status_set = bit_14}));
  EXPECT_FALSE(boots({.follows_mask = bit_14}, {.status_clear = bit_14, .status_set = bit_12}));
}

}  // namespace
}  // namespace godobject::test_failing_drives
