// Recorded runs are repeated bit for bit, and the first difference is named.
#include <gmock/gmock.h>

#include <functional>
#include <random>

#include "platform/trace/input_log.h"
#include "tests/support/held_run.h"
#include "tests/support/program.h"

namespace godobject::test::test_replay {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class ReplayTest : public ProgramTest {
 protected:
  /// Runs a scene into run.godo and run.csv.
  void record(const std::string& scene, const std::string& options) {
    ProgramResult result;
    run_unless_held(
        scene + " --quiet --record " + path("run.godo") + " --trace " + path("run.csv") + " " + options,
        path("run.json"), result);
    EXPECT_EQ(result.exit_code, 0) << scene << " " << options << "\n" << result.output;
  }
  ProgramResult replay(const std::string& options = "", const std::string& file = "run.godo") {
    return run_program("replay " + path(file) + " " + options);
  }

  /// Copies run.godo row by row into edited.godo. edit: changes a row; returns false to leave it out.
  /// edit_link: likewise with the events of the rig.
  void rewrite(
      const std::function<bool(CycleRecord&)>& edit, const std::string& version = "",
      const std::function<bool(LinkEvent&)>& edit_link = [](LinkEvent&) { return true; },
      const std::string& revision = "") {
    const std::string bytes = read_file(path("run.godo"));
    InputLogReader reader(bytes);
    InputLogHead head = reader.head();
    if (!version.empty()) head.version = version;
    if (!revision.empty()) head.revision = revision;
    std::string out;
    InputLogWriter writer(head, reader.start(),
                          [&](const InputLogWriter::Chunk& chunk) { out += chunk.bytes; });
    for (InputLogReader::Item item = reader.next(); item != InputLogReader::Item::end; item = reader.next()) {
      ASSERT_NE(item, InputLogReader::Item::cut);
      CycleRecord row = reader.row();
      if (item == InputLogReader::Item::state) writer.add(reader.state());
      else if (item == InputLogReader::Item::row && edit(row)) writer.add(row);
      if (item != InputLogReader::Item::links) continue;
      for (LinkEvent event : reader.links())
        if (edit_link(event)) writer.add(event);
    }
    writer.flush();
    write("edited.godo", out + InputLogWriter::end_of(0));
  }
};

struct RecordedRun {
  const char *scene, *options;
};

class EveryRun : public ReplayTest, public testing::WithParamInterface<RecordedRun> {};

TEST_P(EveryRun, IsRepeatedWithAnEqualTrace) {
  record(std::string("sim/scenes/") + GetParam().scene + ".toml", GetParam().options);
  const ProgramResult result = replay("--trace " + path("again.csv"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const bool has_rig =
      std::string(GetParam().options).find("direct") == std::string::npos &&
      read_file(GODOBJECT_SOURCE_DIR "/sim/scenes/" + std::string(GetParam().scene) + ".toml")
              .find("[[bus]]") != std::string::npos;
  EXPECT_THAT(result.output,
              ContainsRegex(std::string("^replayed [0-9]+ cycles, t = 0.00[0-9]+ to .* s, identical") +
                            (has_rig ? ", also the rig\n$" : "\n$")));
  EXPECT_TRUE(read_file(path("run.csv")) == read_file(path("again.csv")));
}

INSTANTIATE_TEST_SUITE_P(Runs, EveryRun,
                         testing::Values(RecordedRun{"rigid", "--duration 2.5"},               //
                                         RecordedRun{"rigid", "--duration 2.5 --bus direct"},  //
                                         RecordedRun{"rigid", "--duration 1.2 --realtime"},    //
                                         RecordedRun{"grasper", "--duration 1.5"},             //
                                         RecordedRun{"organ", "--duration 1"},                 //
                                         RecordedRun{"endobag", "--duration 0.05"},            //
                                         RecordedRun{"admittance", "--duration 1.5"},          //
                                         RecordedRun{"relative", "--duration 1.5"},            //
                                         RecordedRun{"desk", "--duration 1.5 --bus direct"},   //
                                         RecordedRun{"desk", "--duration 1.5"},                //
                                         RecordedRun{"scissors-imposed", "--duration 1.5"},    //
                                         RecordedRun{"grasp", "--duration 0.8"},               //
                                         RecordedRun{"tracked", "--duration 1.5"},             //
                                         RecordedRun{"catheter", "--duration 0.1"},            //
                                         RecordedRun{"palpate", "--duration 0.3 --integrator implicit-euler"},
                                         RecordedRun{"wall", "--duration 1 --step 0.0005"}),
                         [](const auto& run) {
                           std::string name = std::string(run.param.scene) + run.param.options;
                           std::erase_if(name, [](unsigned char c) { return !std::isalnum(c); });
                           return name;
                         });

TEST_F(ReplayTest, BeginsAtAState) {
  record("sim/scenes/grasper.toml", "--duration 4");
  ProgramResult result = replay("--from 2.5 --to 3.2 --trace " + path("part.csv"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("replayed 701 cycles, t = 2.5 to 3.2 s, identical"));
  const std::string part = read_file(path("part.csv")), whole = read_file(path("run.csv"));
  const std::string rows = part.substr(part.find('\n') + 1);
  EXPECT_TRUE(rows.starts_with("2.5,"));
  const std::size_t begin = whole.find("\n2.5,");
  ASSERT_NE(begin, std::string::npos);
  EXPECT_TRUE(whole.compare(begin + 1, rows.size(), rows) == 0);
}

TEST_F(ReplayTest, ACutFileIsRepeatedUpToTheCut) {
  record("sim/scenes/rigid.toml", "--duration 1.5");
  const std::string file = read_file(path("run.godo"));
  for (const double share : {0.5, 0.9, 0.99}) {
    write("cut.godo", file.substr(0, static_cast<std::size_t>(share * static_cast<double>(file.size()))));
    const ProgramResult result = replay("", "cut.godo");
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_THAT(result.output, ContainsRegex("was cut after cycle [0-9]+"));
    EXPECT_THAT(result.output, ContainsRegex("replayed [0-9]+ cycles, .*identical"));
  }
  write("cut.godo", file.substr(0, 40));
  EXPECT_EQ(replay("", "cut.godo").exit_code, 2);
}

TEST_F(ReplayTest, DamageIsAGap) {
  record("sim/scenes/rigid.toml", "--duration 3");
  std::string file = read_file(path("run.godo"));
  file[file.size() / 2] ^= 0x10;
  write("damaged.godo", file);
  const ProgramResult result = replay("", "damaged.godo");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, ContainsRegex("gap: cycles [0-9]+ to [0-9]+ are not replayed"));
  EXPECT_THAT(result.output, HasSubstr("damaged bytes"));
  EXPECT_THAT(result.output, ContainsRegex("to 3 s, identical"));
}

TEST_F(ReplayTest, LostRowsAreAGap) {
  record("sim/scenes/rigid.toml", "--duration 2.2");
  rewrite([](const CycleRecord& row) { return row.cycle != 700; });
  ProgramResult result = replay("", "edited.godo");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("gap: cycles 700 to 1000 are not replayed"));
  EXPECT_THAT(result.output, HasSubstr("replayed 1899 cycles, t = 0.001 to 2.2 s, identical"));
  rewrite([](const CycleRecord& row) { return row.cycle != 2100; });
  result = replay("", "edited.godo");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("gap: cycles 2100 to 2200 are not replayed"));
}

TEST_F(ReplayTest, TheFirstDifferenceIsNamed) {
  record("sim/scenes/rigid.toml", "--duration 1.5");
  rewrite([](CycleRecord& row) {
    if (row.cycle == 1234) row.samples[0].target.X_WD.p.y() += 1e-12;
    return true;
  });
  ProgramResult result = replay("", "edited.godo");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("first difference in cycle 1234, t = 1.234 s: tool.y is "));
  EXPECT_THAT(result.output, Not(HasSubstr("identical")));
  rewrite([](CycleRecord& row) {
    if (row.cycle == 77) row.bodies[0].feedback_D.f.z() += 1;
    if (row.cycle == 900) ++row.state_hash;
    return true;
  });
  result = replay("", "edited.godo");
  EXPECT_THAT(result.output, HasSubstr("first difference in cycle 77, t = 0.077 s: tool.feedback.fz is "));
  rewrite([](CycleRecord& row) {
    if (row.cycle == 77) row.bodies[0].X_WB.p.z() += 1;  // no input of the rig
    return true;
  });
  EXPECT_EQ(replay("", "edited.godo").exit_code, 1);
  result = replay("--from 1.1", "edited.godo");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  rewrite([](CycleRecord& row) {
    if (row.cycle == 900) ++row.state_hash;
    return true;
  });
  result = replay("", "edited.godo");
  EXPECT_THAT(result.output, HasSubstr("first difference in cycle 900, t = 0.9 s: the state hash is "));
}

/// The rig is stepped with the recorded results of its buses, not copied from the rows.
TEST_F(ReplayTest, TheFirstDifferenceOfTheRigIsNamed) {
  record("sim/scenes/rigid.toml", "--duration 1.5");
  const auto keep = [](CycleRecord&) { return true; };
  const auto found = [this] {
    const ProgramResult result = replay("", "edited.godo");
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.output, Not(HasSubstr("identical")));
    return result.output;
  };
  rewrite([](CycleRecord& row) {
    if (row.cycle == 321) row.drive_torque[1] += 1e-12;
    return true;
  });
  EXPECT_THAT(found(), ContainsRegex("first difference in cycle 321, t = 0.321 s: drive\\..*\\.torque is "));
  rewrite([](CycleRecord& row) {
    if (row.cycle == 322) row.rig_faults = RigFault::bus_down;
    return true;
  });
  EXPECT_THAT(found(), HasSubstr("first difference in cycle 322, t = 0.322 s: rig_fault is "));

  std::uint64_t cycle = 0;
  bool is_edited = false;
  // Edits the first event of a kind from the command of cycle 500 on.
  const auto edit_from_500 = [&](auto edit) {
    cycle = 0;
    is_edited = false;
    rewrite(keep, "", [&, edit](LinkEvent& event) {
      cycle = std::max<std::uint64_t>(cycle, event.cycle);
      return cycle != 500 || is_edited || edit(event);
    });
    EXPECT_TRUE(is_edited);
  };
  edit_from_500([&](LinkEvent& event) {
    is_edited = event.kind == LinkEvent::Kind::received && event.frame.id == 0x181;
    if (is_edited) event.frame.data[0] ^= 1;
    return true;
  });
  EXPECT_THAT(found(), ContainsRegex("first difference in cycle 501, t = 0.501 s: device\\..*\\.q is "));
  edit_from_500([&](LinkEvent& event) {
    is_edited = event.kind == LinkEvent::Kind::call;
    if (is_edited) ++event.sent;
    return true;
  });
  EXPECT_THAT(found(), HasSubstr("first difference in cycle 500, t = 0.5 s: the frames that the rig sends"));
  edit_from_500([&](LinkEvent& event) {
    is_edited = event.kind == LinkEvent::Kind::call;
    if (is_edited) event.rig_state = RigState::hold;
    return true;
  });
  EXPECT_THAT(found(), HasSubstr("the state of the rig is hold in the recording, armed in the replay"));
  edit_from_500([&](LinkEvent& event) { return !(is_edited = event.kind == LinkEvent::Kind::waited); });
  EXPECT_THAT(found(), HasSubstr("first difference in cycle 501, t = 0.501 s: the order of the rig's calls"));
}

/// The rig is repeated from its start, and compared from the given time on.
TEST_F(ReplayTest, TheRigIsComparedFromATimeOn) {
  record("sim/scenes/rigid.toml", "--duration 1.5");
  ProgramResult result = replay("--from 1.2 --trace " + path("part.csv"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("replayed 301 cycles, t = 1.2 to 1.5 s, identical, also the rig\n"));
  EXPECT_THAT(read_file(path("part.csv")), HasSubstr("\n1.2,"));
  EXPECT_THAT(read_file(path("part.csv")), Not(HasSubstr("\n1.199,")));
  rewrite([](CycleRecord& row) {
    if (row.cycle == 321 || row.cycle == 1300) row.drive_torque[1] += 1e-12;
    return true;
  });
  EXPECT_THAT(replay("--from 1.2", "edited.godo").output,
              ContainsRegex("first difference in cycle 1300, t = 1.3 s: drive\\..*\\.torque is "));
  EXPECT_THAT(replay("--from 0.9 --to 1.25", "edited.godo").output,
              HasSubstr("replayed 351 cycles, t = 0.9 to 1.25 s, identical, also the rig\n"));
  const auto keep = [](CycleRecord&) { return true; };
  // A wrench before that time has later effects on the drives.
  rewrite([](CycleRecord& row) {
    if (row.cycle == 990) row.bodies[0].feedback_D.f.z() += 1;
    return true;
  });
  EXPECT_THAT(replay("--from 1.2", "edited.godo").output,
              HasSubstr("first difference in cycle 1200, t = 1.2 s: the frames that the rig sends differ"));
  // Without one of its inputs the rig cannot be repeated.
  bool is_missing = false;
  std::uint64_t cycle = 0;
  rewrite(keep, "", [&](LinkEvent& event) {
    cycle = std::max<std::uint64_t>(cycle, event.cycle);
    if (is_missing || cycle != 500 || event.kind != LinkEvent::Kind::waited) return true;
    is_missing = true;
    return false;
  });
  ASSERT_TRUE(is_missing);
  EXPECT_THAT(replay("--from 1.2", "edited.godo").output,
              HasSubstr("first difference in cycle 501, t = 0.501 s: the order of the rig's calls"));
}

TEST_F(ReplayTest, MissingInputsOfTheRigAreNamed) {
  record("sim/scenes/rigid.toml", "--duration 1.5");
  std::string file = read_file(path("run.godo"));
  // Damages the second chunk of events.
  std::size_t at = 0;
  for (int chunks = 0; chunks < 2; ++chunks) at = file.find(std::string("CHNK\5\0\0\0", 8), at + 1);
  ASSERT_NE(at, std::string::npos);
  file[at + 30] ^= 1;
  write("damaged.godo", file);
  const ProgramResult result = replay("", "damaged.godo");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, ContainsRegex("lacks inputs of the rig after cycle [0-9]+\n"));
  EXPECT_THAT(result.output, ContainsRegex("to 1.5 s, identical\n"));
}

TEST_F(ReplayTest, AFileWithoutInputsOfTheRigIsRepeatedAsBefore) {
  record("sim/scenes/rigid.toml", "--duration 1.5");
  rewrite([](CycleRecord&) { return true; }, "", [](LinkEvent&) { return false; });
  const ProgramResult result = replay("", "edited.godo");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("to 1.5 s, identical\n"));
}

TEST_F(ReplayTest, AnotherRevisionIsNamed) {
  record("sim/scenes/rigid.toml", "--duration 1.5");
  rewrite([](CycleRecord&) { return true; }, "", [](LinkEvent&) { return true; }, "0123456789ab");
  ProgramResult result = replay("--from 1.2", "edited.godo");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output,
              ContainsRegex("was recorded by version [0-9.]+, revision 0123456789ab, and this is "));
  EXPECT_THAT(result.output, HasSubstr("states of another build"));
  result = replay("--from 1.2");
  EXPECT_EQ(result.exit_code, 0) << result.output;
}

TEST_F(ReplayTest, AnotherVersionIsNamed) {
  record("sim/scenes/rigid.toml", "--duration 1.5");
  rewrite([](const CycleRecord&) { return true; }, "0.0.1");
  ProgramResult result = replay("", "edited.godo");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("was recorded by version 0.0.1"));
  EXPECT_THAT(result.output, HasSubstr("replayed 1500 cycles"));
  result = replay("--from 1.2", "edited.godo");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("states of another build"));
}

TEST_F(ReplayTest, AnotherSceneHasTheSameInputs) {
  record("sim/scenes/rigid.toml", "--duration 1");
  std::string scene = read_file(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml");
  const std::size_t at = scene.find("mass = ");
  ASSERT_NE(at, std::string::npos);
  scene.insert(at + 7, "1");
  ProgramResult result = replay("--scene " + write("heavy.toml", scene) + " --trace " + path("heavy.csv"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output,
              HasSubstr("replayed 1000 cycles, t = 0.001 to 1 s; another scene is not compared"));
  EXPECT_TRUE(read_file(path("heavy.csv")) != read_file(path("run.csv")));
  result = replay("--scene sim/scenes/rigid.toml --trace " + path("same.csv"));
  EXPECT_TRUE(read_file(path("same.csv")) == read_file(path("run.csv")));
  result = replay("--scene sim/scenes/grasper.toml");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("its bodies are "));
}

TEST_F(ReplayTest, TheLastSecondsBeforeAFaultAreWritten) {
  const std::string hil = GODOBJECT_SOURCE_DIR "/tests/hil/";
  write("patient-402.toml", read_file(hil + "patient-402.toml"));
  const auto run = [&](const std::string& at, const std::string& duration) {
    const std::string scene = write(
        "rig.toml",
        read_file(hil + "rig.toml") +
            "\n[[fault]]\nverb = \"emcy\"\nbus = \"can0\"\nnode_id = 1\nvalue = 20480\nat = " + at + "\n");
    return run_program("run " + scene + " --duration " + duration + " --on-fault " + path("fault.godo"));
  };
  ProgramResult result = run("15.3", "20");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, ContainsRegex("file +" + path("fault.godo")));
  result = replay("", "fault.godo");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, ContainsRegex("begins after cycle [0-9]+\n"));
  EXPECT_THAT(result.output, ContainsRegex("t = [45]\\.[0-9]+ to 1[67]\\.?[0-9]* s, identical"));
  EXPECT_THAT(result.output, Not(HasSubstr("was cut")));

  std::filesystem::remove(path("fault.godo"));
  result = run("30", "1");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, Not(HasSubstr("fault.godo")));
  EXPECT_FALSE(std::filesystem::exists(path("fault.godo")));
  result = run_program("run sim/scenes/rigid.toml --on-fault " + path("fault.log"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("--on-fault: "));
}

TEST_F(ReplayTest, OtherFilesAreRefused) {
  EXPECT_THAT(replay().output, HasSubstr("cannot be read"));
  write("run.godo", "t,tool.x\n");
  ProgramResult result = replay();
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("is no input log"));
  result = replay("--trace " + path("run.godo"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("is also read"));
  EXPECT_EQ(read_file(path("run.godo")), "t,tool.x\n");
}

}  // namespace
}  // namespace godobject::test::test_replay
