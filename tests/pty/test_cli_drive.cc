// `godobject drive`, run as by a user, against a simulated drive with a small motor behind a pseudo-terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

#include "platform/cli/drive/drive.h"
#include "sim/node/drive.h"
#include "tests/support/node_on_pty.h"
#include "tests/support/program.h"

namespace godobject::test_cli_drive {
namespace {

using testing::HasSubstr;

DriveParams drive_params() {
  DriveParams params{};
  params.node_id = 4;
  params.calibration.counts_per_unit = 1000;
  params.torque_rated_Nm = 0.1;
  params.torque_max_Nm = 0.05;
  return params;
}

/// A simulated drive with an inertia on the motor's shaft.
class DriveOnPty : public test::NodeOnPty<SimDrive> {
 public:
  explicit DriveOnPty(SimDefaults defaults = SimDefaults::rig, const SimDriveQuirks& quirks = {})
      : NodeOnPty([defaults, quirks](CanBus& bus) {
          return std::make_unique<SimDrive>(
              bus, SimDriveParams{.drive = drive_params(), .quirks = quirks, .defaults = defaults});
        }) {
    start([q = 0.0, q_dot = 0.0](SimDrive& drive, double dt) mutable {
      constexpr double inertia_kgm2 = 2e-5;
      q_dot += dt * drive.applied_torque_Nm() / inertia_kgm2;
      q += dt * q_dot;
      if (drive.drive_state() != cia402::DriveState::operation_enabled) q_dot = 0;
      drive.set_joint(q, q_dot);
    });
  }

  test::ProgramResult drive(const std::string& rest, const std::string& prefix = "") const {
    return test::run_program("drive --bus slcan:" + name() + " --node 4 " + rest, prefix);
  }
};

TEST(CliDrive, PrintsWhatTheDriveSays) {
  const DriveOnPty rig;
  const test::ProgramResult status = rig.drive("status");
  EXPECT_EQ(status.exit_code, 0);
  for (const char* line : {"switch on disabled", "10 cyclic synchronous torque", "603Fh = 0000h, no error",
                           "0 counts\n", "rated torque     100 (6076h",
                           "6 homing, 8 cyclic synchronous position, 9 cyclic synchronous velocity"})
    EXPECT_THAT(status.output, HasSubstr(line));
}

TEST(CliDrive, ResetsAFaultOfADriveThatLooksAtItsControlwordSeldom) {
  for (const Nanoseconds period_ns : {1'300'000, 4'700'000, 8'000'000, 33'000'000}) {
    DriveOnPty rig(SimDefaults::rig, {.controlword_period_ns = period_ns});
    for (int k = 0; k < 3; ++k) {
      rig.call([](SimDrive& drive) { drive.trip(0x8611); });
      const test::ProgramResult reset = rig.drive("reset");
      EXPECT_EQ(reset.exit_code, 0) << period_ns << ": " << reset.output;
      EXPECT_THAT(reset.output, HasSubstr("reset: switch on disabled"));
    }
  }
}

TEST(CliDrive, ResetsAFaultAndSaysWhatRemains) {
  DriveOnPty rig;
  rig.call([](SimDrive& drive) { drive.trip(0x2310); });
  EXPECT_THAT(rig.drive("status").output, HasSubstr("603Fh = 2310h, continuous over-current"));
  const test::ProgramResult refused = rig.drive("home");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(
      refused.output,
      HasSubstr("is in fault (603Fh = 2310h, continuous over-current): reset it with godobject drive"));
  const test::ProgramResult reset = rig.drive("reset");
  EXPECT_EQ(reset.exit_code, 0);
  EXPECT_THAT(reset.output, HasSubstr("reset: switch on disabled; 603Fh = 0000h"));
  EXPECT_THAT(rig.drive("reset").output, HasSubstr("nothing to reset"));
}

TEST(CliDrive, HomesByTheMethodsItHas) {
  const DriveOnPty rig;
  const test::ProgramResult home = rig.drive("home --offset 750");
  EXPECT_EQ(home.exit_code, 0) << home.output;
  EXPECT_THAT(home.output, HasSubstr("home was found, at 750 counts\noff\n"));
  const test::ProgramResult switches = rig.drive("home --method 33");
  EXPECT_EQ(switches.exit_code, 2);
  EXPECT_THAT(switches.output, HasSubstr("--hand-on-the-stop"));
  const test::ProgramResult failed = rig.drive("home --method 33 --hand-on-the-stop");
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.output, HasSubstr("homing failed: "));
  EXPECT_THAT(failed.output, HasSubstr("off\n"));
  EXPECT_THAT(rig.drive("status").output, HasSubstr("switch on disabled"));
}

std::int64_t counts(DriveOnPty& rig) {
  return rig.call([](SimDrive& drive) { return drive.objects().value(position_object); });
}

TEST(CliDrive, MovesByVelocityPositionAndTorque) {
  DriveOnPty rig;
  const test::ProgramResult by_position = rig.drive("move --position 500 --duration 0.8 --hand-on-the-stop");
  EXPECT_EQ(by_position.exit_code, 0) << by_position.output;
  EXPECT_THAT(by_position.output, HasSubstr("off\n"));
  EXPECT_NEAR(static_cast<double>(counts(rig)), 500, 100);
  const std::int64_t from = counts(rig);
  EXPECT_EQ(rig.drive("move --velocity -1000 --duration 0.8 --hand-on-the-stop").exit_code, 0);
  EXPECT_LT(counts(rig), from - 100);
  const std::int64_t before_torque = counts(rig);
  EXPECT_EQ(rig.drive("move --torque 2 --duration 0.2 --hand-on-the-stop").exit_code, 0);
  EXPECT_GT(counts(rig), before_torque);
}

TEST(CliDrive, LeavesADriveOutOfItsBoxOffAndAsItWas) {
  DriveOnPty rig(SimDefaults::factory);
  const auto settings = [](SimDrive& drive) {
    const ObjectDictionary& objects = drive.objects();
    return std::array{objects.value(mode_object), objects.value(abort_connection_option),
                      objects.value({0x1016, 1})};
  };
  const auto before = rig.call(settings);
  const test::ProgramResult move = rig.drive("move --velocity 1000 --duration 0.2 --hand-on-the-stop");
  EXPECT_EQ(move.exit_code, 0) << move.output;
  EXPECT_GT(counts(rig), 0);
  EXPECT_EQ(rig.call(settings), before);
  EXPECT_EQ(rig.call([](SimDrive& drive) { return drive.drive_state(); }),
            cia402::DriveState::switch_on_disabled);
}

TEST(CliDrive, RefusesMovesThatNobodyWatchesOrThatAreTooBig) {
  struct Case {
    std::string options, message;
  };
  // The bus does not exist, and must not be opened.
  for (const Case& c : std::vector<Case>{
           {"--velocity 100 --duration 1", "--hand-on-the-stop"},
           {"--velocity 2001 --duration 1", "2001 is beyond the limit of 2000"},
           {"--torque 51 --duration 1", "51 is beyond the limit of 50"},
           {"--position -2000 --duration 0.5", "beyond the limit of 2000 counts/s: raise --duration"},
           {"--duration 1", "exactly one of --velocity, --position and --torque"},
           {"--velocity 1 --torque 1 --duration 1", "exactly one of --velocity, --position and --torque"},
           {"--velocity 1 --duration 61", "--duration"},
       }) {
    const test::ProgramResult result =
        test::run_program("drive --bus slcan:/dev/nothing --node 4 move " + c.options);
    EXPECT_EQ(result.exit_code, 2) << c.options;
    EXPECT_THAT(result.output, HasSubstr(c.message)) << c.options;
  }
}

constexpr const char* long_move = "move --velocity 500 --duration 30 --hand-on-the-stop";

constexpr auto is_enabled = [](SimDrive& drive) {
  return drive.drive_state() == cia402::DriveState::operation_enabled;
};
constexpr auto is_off = [](SimDrive& drive) {
  return drive.drive_state() == cia402::DriveState::switch_on_disabled;
};

/// Starts a long move, and sends `signal` to the program as soon as the motor has power.
test::ProgramResult signalled_move(DriveOnPty& rig, int signal) {
  const std::string pid_file = testing::TempDir() + "godobject-move-" + std::to_string(getpid());
  rig.call_once_when(is_enabled, [=](SimDrive&) { kill(std::stoi(test::read_file(pid_file)), signal); });
  test::ProgramResult result =
      rig.drive(long_move, "sh -c 'ulimit -c 0; echo $$ > \"" + pid_file + "\"; exec \"$0\" \"$@\"' ");
  std::filesystem::remove(pid_file);
  return result;
}

TEST(CliDrive, AnInterruptSwitchesOff) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGUSR1}) {
    DriveOnPty rig;
    const test::ProgramResult result = signalled_move(rig, signal);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.output, HasSubstr("interrupted after"));
    EXPECT_THAT(result.output, HasSubstr("off\n"));
    EXPECT_TRUE(rig.call(is_off));
  }
}

// By the last frames, long before the drive misses its heartbeat.
TEST(CliDrive, ADefectSwitchesOff) {
  for (const int signal : {SIGABRT, SIGSEGV}) {
    DriveOnPty rig;
    const test::ProgramResult result = signalled_move(rig, signal);
    EXPECT_THAT(result.output, HasSubstr("the drives were commanded to switch their motors off"));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_TRUE(rig.call(is_off));
  }
}

// A killed program cannot switch off: the drive misses its heartbeat.
TEST(CliDrive, TheDriveSwitchesItselfOffWhenTheProgramIsKilled) {
  DriveOnPty rig;
  EXPECT_NE(signalled_move(rig, SIGKILL).exit_code, 0);
  EXPECT_TRUE(rig.wait_until(is_off));
}

TEST(CliDrive, SaysWhenItCannotConfirmThatTheMotorIsOff) {
  DriveOnPty rig;
  rig.call_once_when(is_enabled, [&rig](SimDrive&) { rig.silence(); });
  const test::ProgramResult result = rig.drive(std::string("--timeout 0.1 ") + long_move);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("no answer within 100 ms"));
  EXPECT_THAT(result.output, HasSubstr("NOT CONFIRMED that the motor is off (6040h:00 <- 0: no answer"));
}

TEST(CliDrive, AFaultOnTheWayEndsTheMove) {
  DriveOnPty rig;
  rig.call_once_when(is_enabled, [](SimDrive& drive) { drive.trip(0x8611); });
  const test::ProgramResult result = rig.drive(long_move);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("603Fh = 8611h, following error"));
}

TEST(CliDrive, LeavesADriveAloneThatAHostRuns) {
  DriveOnPty rig;
  rig.send_syncs(true);
  const test::ProgramResult move = rig.drive("move --velocity 100 --duration 1 --hand-on-the-stop");
  EXPECT_EQ(move.exit_code, 1);
  EXPECT_THAT(move.output, HasSubstr("a host runs this bus (SYNC): stop the host first"));
  EXPECT_THAT(rig.drive("status").output, HasSubstr("host             SYNC"));
}

TEST(CliDrive, QuickStopEndsWithoutPower) {
  for (const std::int64_t option : {2, 6}) {
    DriveOnPty rig;
    rig.call([option](SimDrive& drive) {
      drive.objects().find(quick_stop_option_object)->value = option;
      for (const std::uint16_t word : {cia402::shutdown, cia402::switch_on, cia402::enable_operation}) {
        const std::array<std::uint8_t, 2> bytes{static_cast<std::uint8_t>(word), 0};
        static_cast<void>(drive.objects().write(controlword_object, bytes));
      }
      EXPECT_EQ(drive.drive_state(), cia402::DriveState::operation_enabled);
    });
    const test::ProgramResult result = rig.drive("quick-stop");
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.output, "switch on disabled\n");
  }
}

TEST(CliDrive, SaysThatNobodyAnswersAndWhatIsNoDrive) {
  const DriveOnPty rig;
  const test::ProgramResult silent =
      test::run_program("drive --bus slcan:" + rig.name() + " --node 9 --timeout 0.1 status");
  EXPECT_EQ(silent.exit_code, 1);
  EXPECT_THAT(silent.output, HasSubstr("node 9: 1000h:00 read: no answer within 100 ms"));
  const test::ProgramResult other =
      test::run_program("encoder --bus slcan:" + rig.name() + " --node 4 status");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.output, HasSubstr("node 4: is not a CiA 406 encoder: its profile (1000h) is 402"));
}

TEST(MoveRamp, BeginsAndEndsAtRestAndItsWayIsItsIntegral) {
  const MoveRamp ramp(2);
  EXPECT_EQ(ramp.rate(0), 0);
  EXPECT_EQ(ramp.rate(1), 1);
  EXPECT_EQ(ramp.rate(2), 0);
  EXPECT_DOUBLE_EQ(ramp.rate(0.25), 0.5);
  EXPECT_DOUBLE_EQ(ramp.rate(1.75), 0.5);
  double way = 0;
  constexpr double dt = 1e-3;
  for (double t = 0; t < 2; t += dt) {
    EXPECT_NEAR(ramp.way(t), way, 1e-3) << t;
    way += dt * ramp.rate(t) * ramp.peak_rate();
  }
  EXPECT_NEAR(way, 1, 1e-3);
}

}  // namespace
}  // namespace godobject::test_cli_drive
