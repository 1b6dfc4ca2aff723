// Wrong input of every kind: exit code 2, the place in the message, no file overwritten.
#include <gmock/gmock.h>

#include <algorithm>

#include "tests/support/program.h"

namespace godobject::test::test_cli_errors {
namespace {

using testing::HasSubstr;

const std::string rigid = "sim/scenes/rigid.toml";

using CliErrors = ProgramTest;

TEST_F(CliErrors, OptionsAreNamedWithWhatIsAdmissible) {
  struct Case {
    std::string arguments;
    std::string message;
  };
  const std::vector<Case> cases{
      {"", "Usage: godobject"},
      {"fly", "not expected: fly"},
      {"run", "SCENE"},
      {"check", "SCENE"},
      {"run " + rigid + " --no-such-option", "--no-such-option"},
      {"run " + rigid + " --fast --realtime", "--fast"},
      {"run " + rigid + " --duration -1", "--duration: '-1' is not a number > 0 and <= 1e+06"},
      {"run " + rigid + " --duration nan", "--duration: 'nan'"},
      {"run " + rigid + " --duration 1s", "--duration: '1s'"},
      {"run " + rigid + " --step 0", "--step: '0' is not a number 1e-06 to 0.1"},
      {"run " + rigid + " --step inf", "--step: 'inf'"},
      {"run " + rigid + " --integrator rk4", "--integrator: rk4 not in {implicit-euler,tr-bdf2}"},
      {"run " + rigid + " --bus socketcan:can0",
       "--bus: 'socketcan:can0' names no bus of the scene, which has 'can0', 'can1': give --bus can0=ADDRESS "
       "--bus "
       "can1=ADDRESS"},
      {"run " + rigid + " --bus socketcam:can0",
       "unknown bus kind 'socketcam'; did you mean 'socketcan'? expected socketcan:, slcan:, "},
      {"run " + rigid + " --bus nosuch:1", "unknown bus kind 'nosuch'; expected socketcan:, slcan:, "},
      {"chek " + rigid, "did you mean 'check' in place of 'chek'?"},
      {"simulte " + rigid, "did you mean 'simulate' in place of 'simulte'?"},
      {"run " + rigid + " --durtion=1", "did you mean '--duration' in place of '--durtion'?"},
      {"check --ful " + rigid, "did you mean '--full' in place of '--ful'?"},
      {"run " + rigid + " --bus can0=socketcan:a",
       "--bus: bus 'can1' of the scene has no address: give --bus"},
      {"run " + rigid + " --bus can9=socketcan:a --bus can1=socketcan:b",
       "--bus: scene 'rigid' has no bus 'can9': its buses are 'can0', 'can1'"},
      {"run " + rigid + " --bus can0=socketcan:a --bus can0=socketcan:b --bus can1=socketcan:c",
       "--bus: bus 'can0' is given twice"},
      {"run " + rigid + " --bus can0=usb:a --bus can1=socketcan:b", "--bus: "},
      {"run " + rigid + " --device d.sock --fast", "--device: excludes --fast, since the program moves"},
      {"run " + rigid + " --device d.sock --bus sim", "--device: excludes --bus"},
      {"run sim/scenes/admittance.toml --device d.sock",
       "has an admittance device, and the program sends poses"},
      {"run " + rigid + " --bus sim --bus direct", "--bus: sim and direct apply to all buses"},
      {"run " + rigid + " --bus can0=socketcan:a --bus can1=socketcan:b --fast",
       "--fast: real buses and trackers run in wall time"},
      {"run sim/scenes/admittance.toml --bus socketcan:a", "--bus: scene 'admittance' describes no buses"},
      {"run " + rigid + " --bus direct --rearm auto",
       "--rearm: with --bus direct there is no device to arm: remove --rearm"},
      {"run " + rigid + " --rearm always", "--rearm"},
      {"run " + rigid + " --trace /no/such/folder/t.csv",
       "--trace: '/no/such/folder/t.csv' cannot be written"},
      {"run " + rigid + " --report /", "--report: '/' is a directory"},
      {"run " + rigid + " --bus direct --record " + path("b.log"), "--record: with --bus direct"},
      {"run " + rigid + " --motion /no/such.csv", "/no/such.csv: cannot be read"},
      {"run sim/scenes/admittance.toml --bus sim",
       "sim/scenes/admittance.toml: scene 'admittance' describes no buses"},
      {"run sim/scenes/admittance.toml --record " + path("b.log"), "--record: scene 'admittance'"},
      {"run sim/scenes/admittance.toml --bus sim --record " + path("b.log"), "--record: scene 'admittance'"},
      {"run " + rigid + " --step 2e-4", "with --step 2e-04: bus can0: worst-case load "},
      {"run /no/such.toml", "/no/such.toml: cannot be read"},
  };
  for (const Case& c : cases) {
    const ProgramResult result = run_program(c.arguments);
    EXPECT_EQ(result.exit_code, 2) << c.arguments << '\n' << result.output;
    EXPECT_THAT(result.output, HasSubstr(c.message)) << c.arguments;
  }
}

TEST_F(CliErrors, SceneFilesAreRefusedWithThePlace) {
  const std::string good =
      "[scene]\nname = \"s\"\n[[body]]\nname = \"tool\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n";
  struct Case {
    std::string text;
    std::string place;
    std::string message;
  };
  const std::vector<Case> cases{
      {"[scene\n", ":1:", "not TOML"},
      {good + "[scene.extra]\n", ":7:", "extra"},
      {good + "colour = 1\n", ":7:1: ", "colour"},
      {good + "velocity = \"fast\"\n", ":7:12: ", "velocity"},
      {good + "velocity = [nan, 0.0, 0.0]\n", ":7:", "velocity"},
      {"[scene]\nname = \"s\"\nstep = -1.0\n[[body]]\nname = \"t\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n",
       ":3:8: ", "step"},
      {"[scene]\nname = \"s\"\n[[body]]\nname = \"t\"\nmass = 0.0\ninertia = [1.0, 1.0, 1.0]\n",
       ":5:8: ", "mass"},
  };
  int number = 0;
  for (const Case& c : cases) {
    const std::string file = write("bad" + std::to_string(number++) + ".toml", c.text);
    const std::string trace = write("trace.csv", "kept");
    for (const std::string& arguments : {"check " + file, "run " + file + " --trace " + trace}) {
      const ProgramResult result = run_program(arguments);
      EXPECT_EQ(result.exit_code, 2) << c.text << result.output;
      EXPECT_THAT(result.output, HasSubstr(file + c.place)) << c.text;
      EXPECT_THAT(result.output, HasSubstr(c.message)) << c.text;
    }
    EXPECT_EQ(read_file(trace), "kept");
  }
}

/// Replaces a text in the shipped scene, which must contain it.
std::string rigid_with(const std::string& what, const std::string& by) {
  std::string text = read_file(GODOBJECT_SOURCE_DIR "/" + rigid);
  text.replace(text.find(what), what.size(), by);
  return text;
}

TEST_F(CliErrors, RunRefusesWhatCheckRefuses) {
  const std::string full = write("full.toml", rigid_with("bit_rate = 1e6", "bit_rate = 5e5"));
  const std::string stale = write(
      "stale.toml", rigid_with("[device.chain]", "[device.supervision]\nstale_after = 5e-4\n[device.chain]"));
  const std::string pushed =
      write("pushed.toml", rigid_with("kind = \"impedance\"", "kind = \"admittance\""));
  struct Case {
    std::string scene;
    std::string message;
  };
  for (const Case& c : {Case{full, full + ": bus can0: worst-case load 1"},
                        Case{stale, stale + ": stale_after is 0.0005, must be at least step (0.001)"},
                        Case{pushed, "an admittance device runs only with --bus direct"}}) {
    for (const std::string verb : {"check ", "run --duration 0.1 "}) {
      const ProgramResult result = run_program(verb + c.scene);
      EXPECT_EQ(result.exit_code, 2) << result.output;
      EXPECT_THAT(result.output, HasSubstr(c.message)) << verb;
    }
  }
}

TEST_F(CliErrors, MotionMuchTooFarIsRefused) {
  const std::string motion = write("motion.csv",
                                   "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz\n"
                                   "0,0,0,0,1,0,0,0\n0.1,0,2e6,0,1,0,0,0\n");
  const ProgramResult result = run_program("run " + rigid + " --motion " + motion);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr(motion + ":3:7: 'tool.y' must be within 1e6 m"));
}

TEST_F(CliErrors, MotionIsRefusedWithThePlace) {
  const std::string motion = write("motion.csv",
                                   "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz\n"
                                   "0,0,0,0,1,0,0,0\n0.1,0,zero,0,1,0,0,0\n");
  const ProgramResult result = run_program("run " + rigid + " --motion " + motion);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr(motion + ":3:7: "));
}

TEST_F(CliErrors, NoOutputGoesOverAnInputOrAnotherOutput) {
  const std::string scene = write("scene.toml", read_file(GODOBJECT_SOURCE_DIR "/" + rigid));
  const std::string before = read_file(scene);
  EXPECT_EQ(run_program("run " + scene + " --trace " + scene).exit_code, 2);
  EXPECT_EQ(read_file(scene), before);
  const ProgramResult same = run_program("run " + rigid + " --trace " + path("x") + " --record " + path("x"));
  EXPECT_EQ(same.exit_code, 2);
  EXPECT_THAT(same.output, HasSubstr("is also --trace"));
  EXPECT_FALSE(std::filesystem::exists(path("x")));
}

TEST_F(CliErrors, ADiskThatIsFullIsAFault) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const ProgramResult result = run_program("run " + rigid + " --duration 0.5 --trace /dev/full");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("/dev/full could not be written in full"));
}

TEST_F(CliErrors, AMotionOutOfTheDevicesReachIsAFault) {
  const std::string motion = write("far.csv",
                                   "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz\n"
                                   "0,0,0,0,1,0,0,0\n0.5,5,0,0,1,0,0,0\n");
  const ProgramResult result = run_program("run " + rigid + " --motion " + motion);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("unreachable"));
}

TEST_F(CliErrors, AMissingProfileIsReportedWithItsLine) {
  std::string text = rigid_with("profile = \"generic-402\"", "profile = \"nosuch\"");
  const auto line =
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find("nosuch")), '\n');
  const std::string file = write("p.toml", text);
  const ProgramResult result = run_program("check " + file);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr(file + ":" + std::to_string(line) + ": drive of joint "));
  EXPECT_THAT(result.output,
              HasSubstr("was found neither in the scene's folder nor among the shipped profiles"));
}

TEST_F(CliErrors, APointerNeedsACoupledBody) {
  for (const std::string scene : {"admittance", "chain", "four-bar", "pendulum"}) {
    const ProgramResult result =
        run_program("run sim/scenes/" + scene + ".toml --view --view-input --duration 0.05");
    EXPECT_EQ(result.exit_code, 2) << scene;
    EXPECT_THAT(result.output, HasSubstr("--view-input: scene '" + scene + "' has no coupled body"));
  }
}

/// fixed, ball: neither has a named coordinate.
TEST_F(CliErrors, AStopNeedsACoordinate) {
  for (const std::string kind : {"fixed", "ball"})
    for (const std::string coordinate : {"", "coordinate = \"q\"\n"}) {
      const std::string file =
          write("s.toml",
                "[scene]\nname = \"s\"\n[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [1e-3, 1e-3, 1e-3]\n"
                "[[joint]]\nname = \"j\"\nkind = \"" +
                    kind + "\"\nchild = \"b\"\n[[joint.stop]]\n" + coordinate +
                    "lower = -1.0\nupper = 1.0\nstiffness = 1.0\nwidth = 0.1\n");
      const ProgramResult result = run_program("check " + file);
      EXPECT_EQ(result.exit_code, 2);
      EXPECT_THAT(result.output, HasSubstr(file + ":11:1: joint 'j' has no coordinate for a stop"));
      EXPECT_THAT(result.output, testing::Not(HasSubstr("coordinate' is")));
    }
}

}  // namespace
}  // namespace godobject::test::test_cli_errors
