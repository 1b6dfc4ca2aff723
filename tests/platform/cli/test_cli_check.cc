// `check` reports the same errors as `run` with the same options, before any motion.
#include <gmock/gmock.h>

#include "tests/support/program.h"

namespace godobject::test::test_cli_check {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string rigid = "sim/scenes/rigid.toml";
const std::string pose_columns = "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz\n";

/// Replaces every occurrence of a text in the shipped scene, which must contain it.
std::string rigid_with(const std::string& what, const std::string& by) {
  std::string text = read_file(GODOBJECT_SOURCE_DIR "/" + rigid);
  EXPECT_THAT(text, HasSubstr(what));
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

class CliCheck : public ProgramTest {
 protected:
  /// Expects this exit code and message from both verbs.
  static void expect_both(const std::string& arguments, int exit_code, const std::string& message) {
    for (const std::string verb : {"check ", "run "}) {
      const ProgramResult result = run_program(verb + arguments);
      EXPECT_EQ(result.exit_code, exit_code) << verb << arguments << '\n' << result.output;
      EXPECT_THAT(result.output, HasSubstr(message)) << verb << arguments;
    }
  }
};

TEST_F(CliCheck, TakesTheOptionsOfRunAndGivesItsVerdict) {
  expect_both(rigid + " --step 2e-4 --duration 0.01", 2, "with --step 2e-04: bus can0: worst-case load ");
  expect_both(rigid + " --bus can9=socketcan:a --bus can1=socketcan:b", 2, "has no bus 'can9'");
  expect_both(rigid + " --bus direct --rearm auto", 2,
              "--rearm: with --bus direct there is no device to arm: remove --rearm");
  expect_both(rigid + " --trace /no/such/folder/t.csv", 2, "--trace: '/no/such/folder/t.csv'");
  expect_both(rigid + " --motion /no/such.csv", 2, "/no/such.csv: cannot be read");
  expect_both("sim/scenes/tracked.toml --tracker nobody=/dev/ttyS0", 2, "the scene's trackers are");
  const std::string motion = write("m.csv", pose_columns + "0,0.05,zero,0.03,1,0,0,0\n");
  expect_both(rigid + " --motion " + motion, 2, motion + ":2:8: ");
  expect_both("sim/scenes/s1.toml --integrator tr-bdf2 --bus direct --fast --duration 0.01", 0, "tr-bdf2");
}

TEST_F(CliCheck, OpensNothingAndWritesNothing) {
  const std::string options = rigid +
                              " --bus can0=slcan:/dev/not-there --bus can1=slcan:/dev/not-there-either"
                              " --trace " +
                              path("t.csv") + " --record " + path("r.log") + " --report " + path("r.json");
  const ProgramResult result = run_program("check " + options);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  for (const char* file : {"t.csv", "r.log", "r.json"}) EXPECT_FALSE(std::filesystem::exists(path(file)));
  EXPECT_EQ(run_program("check sim/scenes/tracked.toml --tracker scene").exit_code, 0);
}

TEST_F(CliCheck, ResolvesProfilesOnSimulatedBusesToo) {
  const auto scene_with = [&](const std::string& profile) {
    return rigid_with("profile = \"generic-402\"", "profile = \"" + profile + "\"");
  };
  expect_both(write("misspelt.toml", scene_with("generic-42")) + " --duration 0.01", 2,
              "drive of joint 'turret': profile \"generic-42\" was found neither in ");
  expect_both(write("misspelt.toml", scene_with("generic-42")) + " --duration 0.01 --bus sim", 2,
              "the nearest is \"generic-402\"");
  expect_both(write("encoder.toml", scene_with("generic-406")) + " --duration 0.01", 2,
              "device_profile is 406, but the drive of joint 'turret' is a node of CiA 402");
}

TEST_F(CliCheck, PrintsANetAndItsRequiredStep) {
  const ProgramResult result = run_program("check sim/scenes/endobag.toml");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  for (const char* text : {"950 of 1536 nodes, 2844 of 9216 springs", "at most 768 contacts of nodes at once",
                           "2 stages, each at most 12 iterations over 2844 springs",
                           "time constants: fastest ", "; slowest <= ", " s, carriers held"})
    EXPECT_THAT(result.output, HasSubstr(text));
  EXPECT_THAT(result.output, testing::Not(HasSubstr("attachments")));
  expect_both("sim/scenes/net-small.toml --duration 0.01", 0, "nets");
  const ProgramResult sewn = run_program("check sim/scenes/sewn.toml");
  EXPECT_EQ(sewn.exit_code, 0) << sewn.output;
  EXPECT_THAT(sewn.output,
              HasSubstr("7 of 256 attachments to other bodies, assumed held in the time constants"));
}

/// Copies the binary alone to another folder, without its source.
TEST_F(CliCheck, ACopiedProgramHasTheShippedProfiles) {
  std::filesystem::copy_file(GODOBJECT_PROGRAM, path("godobject"));
  const std::string binary = read_file(path("godobject"));
  EXPECT_THAT(binary, HasSubstr("generic CiA 406 encoder; tried on the simulated encoder only"));
  const std::string check =
      "cd '" GODOBJECT_SOURCE_DIR "' && '" + path("godobject") + "' check --quiet " + rigid;
  EXPECT_EQ(std::system((check + " 2> /dev/null").c_str()), 0);
  EXPECT_EQ(binary.find(std::string(GODOBJECT_SOURCE_DIR) + "/hal/profiles"), std::string::npos);
}

TEST_F(CliCheck, ABodyFarFromItsTargetAtTheStartIsAWarningAndThenAnError) {
  const auto motion_at = [&](const std::string& name, const std::string& place) {
    return " --bus direct --duration 0.01 --motion " +
           write(name, pose_columns + "0," + place + "\n1," + place + "\n");
  };
  const std::string q = "0.946280831965686,0.154097076063857,0.190505913314892,0.210983826856366";
  const auto both_say = [&](const std::string& motion, int exit_code, const std::string& message) {
    expect_both(rigid + motion, exit_code, message);
  };
  both_say(motion_at("off.csv", "0.35,0.04,0.03," + q), 0,
           "warning: " + rigid + ": body 'tool' starts 0.300 m and 0.000 rad from its target");
  both_say(motion_at("turned.csv", "0.05,0.04,0.03,0,0,0,1"), 0,
           "warning: " + rigid + ": body 'tool' starts 0.000 m");
  both_say(motion_at("mm.csv", "50,40,30," + q), 2, "body 'tool' starts 70.6");
  const std::string degrees = write("degrees.csv",
                                    "t,turret,shoulder,elbow,wrist_yaw,wrist_pitch,wrist_roll\n"
                                    "0,45,0,0,0,0,0\n1,45,0,0,0,0,0\n");
  EXPECT_THAT(run_program("check " + rigid + " --bus direct --motion " + degrees).output,
              HasSubstr("joint 'turret' starts at 45 rad, more than a turn: give angles in radians"));
  const ProgramResult near = run_program("check " + rigid + motion_at("near.csv", "0.06,0.04,0.03," + q));
  EXPECT_EQ(near.exit_code, 0);
  EXPECT_THAT(near.output, Not(HasSubstr("starts")));
}

/// Steady, sinusoidal and joint motions, just above 5 m/s and just below.
TEST_F(CliCheck, AMotionFasterThanAHandIsAWarning) {
  const std::string q = ",1,0,0,0\n";
  const auto moved_by = [&](double distance) {
    return rigid + " --bus direct --motion " +
           write("m.csv", pose_columns + "0,0.05,0.04,0.03" + q + "0.5," +
                              std::to_string(0.05 + distance / 2) + ",0.04,0.03" + q + "1," +
                              std::to_string(0.05 + distance) + ",0.04,0.03" + q);
  };
  EXPECT_THAT(run_program("check " + moved_by(9)).output,
              HasSubstr("m.csv: the motion moves the target of 'tool' at "));
  EXPECT_THAT(run_program("check " + moved_by(2)).output, Not(HasSubstr("m/s at")));
  const auto with_amplitude = [&](const std::string& amplitude) {
    const std::string scene = read_file(GODOBJECT_SOURCE_DIR "/sim/scenes/s1.toml");
    const std::size_t at = scene.find("\namplitude");
    EXPECT_NE(at, std::string::npos);
    return write("s.toml",
                 scene.substr(0, at) + "\namplitude = " + amplitude + scene.substr(scene.find('\n', at + 1)));
  };
  EXPECT_THAT(run_program("check " + with_amplitude("[50.0, 0.0, 0.0]")).output,
              HasSubstr("expected are at most 5 m/s, the speed of a hand"));
  EXPECT_THAT(run_program("check " + with_amplitude("[0.05, 0.0, 0.0]")).output,
              Not(HasSubstr("speed of a hand")));
}

TEST_F(CliCheck, AMisspeltMotionColumnIsNamedWithTheRightOne) {
  const std::string misspelt = write("m.csv",
                                     "t,tool.x,tool_y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz,tool.engagd\n"
                                     "0,0.05,0.04,0.03,1,0,0,0,1\n");
  expect_both(rigid + " --motion " + misspelt, 2, "column 'tool.y' is missing: is 'tool_y' misspelt?");
  expect_both(rigid + " --motion " + misspelt, 2,
              "column 'tool.engagd' is not used; the nearest known column is 'tool.engaged'");
  const std::string joints =
      write("j.csv", "t,turret,sholder,elbow,wrist_yaw,wrist_pitch,wrist_roll\n0,0,0,0,0,0,0\n");
  expect_both(rigid + " --motion " + joints, 2, "column 'shoulder' is missing: is 'sholder' misspelt?");
}

TEST_F(CliCheck, StatesTheRotationFromWhichStepsAreOfFirstOrder) {
  const auto scene = [&](const std::string& body, const std::string& more) {
    return write("spin.toml",
                 "[scene]\nname = \"spin\"\nduration = 0.05\n[[body]]\nname = \"rod\"\nmass = 0.1\n"
                 "inertia = [1e-4, 1e-4, 1e-4]\n" +
                     body + more);
  };
  const auto counted = [](const std::string& file) { return run_program("run --fast " + file).output; };
  const std::string net =
      "[[net]]\nname = \"net\"\nbody = \"rod\"\nkind = \"sphere\"\nradius = 0.01\nspacing = 0.006\n"
      "surface_density = 2.0\nmembrane_stiffness = 20.0\nsettling_time = 0.02\nthickness = 0.0\n";
  EXPECT_THAT(run_program("check " + scene("", "")).output, HasSubstr("'rod' exceeds 500 rad/s"));
  EXPECT_THAT(run_program("check " + scene("", net)).output, HasSubstr("'rod' exceeds 100 rad/s"));
  EXPECT_THAT(counted(scene("angular_velocity = [0.0, 0.0, 90.0]\n", net)),
              HasSubstr("first_order 1 cycles"));
  EXPECT_THAT(counted(scene("angular_velocity = [0.0, 0.0, 110.0]\n", net)),
              HasSubstr("first_order 50 cycles"));
}

TEST_F(CliCheck, ABadNodeIdIsReportedOnceAsItIsWritten) {
  const std::string scene = write("id.toml", rigid_with("node_id = 2\n", "node_id = 200\n"));
  const ProgramResult result = run_program("check " + scene);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("'node_id' is 200, out of range: admissible is 1 to 127"));
  EXPECT_THAT(result.output, Not(HasSubstr("is taken")));
  const std::string zero = write("zero.toml", rigid_with("node_id = 2\n", "node_id = 0\n"));
  EXPECT_THAT(run_program("check " + zero).output, HasSubstr("'node_id' is 0, out of range"));
  const std::string bus = write("bus.toml", rigid_with("bus = \"can1\"\n", "bus = \"cam1\"\n"));
  EXPECT_THAT(run_program("check " + bus).output, Not(HasSubstr("is taken")));
}

}  // namespace
}  // namespace godobject::test::test_cli_check
