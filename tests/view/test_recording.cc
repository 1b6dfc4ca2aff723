// Traces are read back as written, and invalid ones are refused with their line.
#include "platform/view/recorded/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/cli/report/files.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/program.h"

namespace godobject::test_recording {
namespace {

using testing::HasSubstr;

SceneConfig scene_named(const std::string& name) {
  return *load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/" + name + ".toml").scene;
}

class RecordingTest : public test::ProgramTest {
 protected:
  /// Writes a trace of so many steps; returns all records.
  std::vector<CycleRecord> trace(const SceneConfig& scene, int steps) {
    Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
    RunFileNames names;
    names.trace = path("t.csv");
    RunFiles files(names, scene, 0);
    made.session->start(1);
    CycleRecord record = made.session->at_start();
    std::vector<CycleRecord> records{record};
    files.add(record);
    for (int i = 0; i < steps; ++i) {
      static_cast<void>(made.session->advance(record));
      records.push_back(record);
      files.add(record);
    }
    EXPECT_TRUE(files.close().empty());
    return records;
  }
};

TEST_F(RecordingTest, OfATraceHasItsPoses) {
  for (const char* name : {"organ", "lego", "grasp", "wall"}) {
    const SceneConfig scene = scene_named(name);
    const std::vector<CycleRecord> records = trace(scene, 100);
    const RecordingResult result = read_trace(path("t.csv"), scene);
    ASSERT_TRUE(result.recording.has_value()) << name << ": " << result.errors.front();
    ASSERT_EQ(result.recording->samples.size(), 11u) << "100 a second";
    for (std::size_t i = 0; i < result.recording->samples.size(); ++i) {
      const CycleRecord &read = result.recording->samples[i].record, &written = records[10 * i];
      EXPECT_EQ(read.t, written.t);
      EXPECT_EQ(read.fault, written.fault);
      EXPECT_EQ(read.limited, written.limited);
      EXPECT_EQ(read.held, written.held);
      EXPECT_EQ(read.energy.balance, written.energy.balance);
      for (std::size_t body = 0; body < scene.bodies.size(); ++body) {
        EXPECT_EQ(read.bodies[body].X_WB.p, written.bodies[body].X_WB.p) << name << " " << body;
        EXPECT_EQ(read.bodies[body].X_WB.q.coeffs(), written.bodies[body].X_WB.q.coeffs());
      }
      for (const std::size_t body : driven_bodies(scene)) {
        EXPECT_EQ(read.bodies[body].target.X_WD.p, written.bodies[body].target.X_WD.p);
        EXPECT_EQ(read.bodies[body].coupling_B.f, written.bodies[body].coupling_B.f);
        EXPECT_EQ(read.bodies[body].feedback_D.tau, written.bodies[body].feedback_D.tau);
      }
    }
  }
}

TEST_F(RecordingTest, OfARunThatWasKilledEndsWithItsLastWholeRow) {
  const SceneConfig scene = scene_named("wall");
  trace(scene, 50);
  std::string text = test::read_file(path("t.csv"));
  text.resize(text.size() - 40);
  const RecordingResult result = read_trace(write("cut.csv", text), scene);
  ASSERT_TRUE(result.recording.has_value());
  EXPECT_EQ(result.recording->samples.size(), 5u);
}

TEST_F(RecordingTest, IsRefusedWhereItIsNone) {
  const SceneConfig scene = scene_named("wall");
  trace(scene, 5);
  const std::string text = test::read_file(path("t.csv"));
  const auto error_of = [&](const std::string& changed, const SceneConfig& of) {
    const RecordingResult result = read_trace(write("x.csv", changed), of);
    return result.errors.empty() ? std::string("none") : result.errors.front();
  };
  EXPECT_THAT(error_of(text, scene_named("organ")),
              HasSubstr("x.csv:1: column 2 is 'peg.x', and a trace of scene 'organ' has 'trocar.x'"));
  EXPECT_THAT(error_of("", scene), HasSubstr("is empty"));
  EXPECT_THAT(error_of(text.substr(0, text.find('\n') + 1), scene), HasSubstr("no rows"));
  EXPECT_THAT(error_of(text + "a,b\n", scene), HasSubstr("x.csv:8: not the"));
  EXPECT_THAT(error_of(text + "9,1\n", scene), HasSubstr("x.csv:8: not the"));
  EXPECT_THAT(error_of(text + "nan,1\n", scene), HasSubstr("x.csv:8: not the"));
}

TEST_F(RecordingTest, TakesEveryOtherInstantOfOneThatIsTooLong) {
  const SceneConfig scene = scene_named("wall");
  trace(scene, 1);
  std::string text = test::read_file(path("t.csv"));
  const std::size_t first = text.find('\n') + 1;
  const std::string row =
      text.substr(text.find(',', first), text.find('\n', first) - text.find(',', first)) + "\n";
  text.resize(first);
  for (int i = 0; i < 30'000; ++i) text += std::to_string(0.01 * i) + row;
  const RecordingResult result = read_trace(write("long.csv", text), scene);
  ASSERT_TRUE(result.recording.has_value());
  EXPECT_LT(result.recording->samples.size(), max_recorded);
  EXPECT_NEAR(result.recording->samples.back().record.t, 300, 0.05);
}

class NetRecordingTest : public RecordingTest {
 protected:
  /// Writes a row every 4th step of 200; returns the nodes of each row.
  std::vector<std::vector<Vec3>> nets(const SceneConfig& scene) {
    Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
    RunFileNames names;
    names.nets = path("nets.csv");
    names.nets_every = 4;
    RunFiles files(names, scene, 0);
    made.session->list_net_nodes();
    made.session->start(1);
    CycleRecord record = made.session->at_start();
    std::vector<std::vector<Vec3>> rows;
    for (int i = 0; i <= 200; ++i) {
      files.add(record);
      if (i % 4 == 0) rows.push_back(record.net_nodes);
      static_cast<void>(made.session->advance(record));
    }
    EXPECT_TRUE(files.close().empty());
    return rows;
  }
};

TEST_F(NetRecordingTest, HasTheNodesThatWereWrittenAndGoesStraightBetweenThem) {
  const SceneConfig scene = scene_named("net-small");
  const std::vector<std::vector<Vec3>> rows = nets(scene);
  const NetRecordingResult result = read_nets(path("nets.csv"), scene);
  ASSERT_TRUE(result.nets.has_value()) << result.errors.front();
  ASSERT_EQ(result.nets->num_rows(), rows.size());
  const double period = 4 * scene.step;
  constexpr double rounding = 1e-7;  // m, of a float
  double moved = 0;
  for (std::size_t row = 0; row + 1 < rows.size(); ++row) {
    const std::vector<Vec3> at = result.nets->at(static_cast<double>(row) * period),
                            between = result.nets->at((static_cast<double>(row) + 0.25) * period);
    ASSERT_EQ(at.size(), rows[row].size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      EXPECT_LT((at[i] - rows[row][i]).norm(), rounding);
      EXPECT_LT((between[i] - (0.75 * rows[row][i] + 0.25 * rows[row + 1][i])).norm(), rounding);
      moved = std::max(moved, (rows[row][i] - rows[0][i]).norm());
    }
  }
  EXPECT_GT(moved, 1e-3);
  for (std::size_t i = 0; i < rows[0].size(); ++i) {
    EXPECT_LT((result.nets->at(-1)[i] - rows.front()[i]).norm(), rounding);
    EXPECT_LT((result.nets->at(99)[i] - rows.back()[i]).norm(), rounding);
  }
}

TEST_F(NetRecordingTest, IsRefusedWhereItDoesNotFit) {
  const SceneConfig scene = scene_named("net-small");
  nets(scene);
  const std::string text = test::read_file(path("nets.csv"));
  const std::string row =
      text.substr(text.find('\n') + 1, text.find('\n', text.find('\n') + 1) - text.find('\n'));
  const auto error_of = [&](const std::string& changed, const SceneConfig& of) {
    const NetRecordingResult result = read_nets(write("x.csv", changed), of);
    return result.errors.empty() ? std::string("none") : result.errors.front();
  };
  EXPECT_THAT(error_of(text, scene_named("wall")),
              HasSubstr("scene 'wall' has no nets: remove --nets, or add a [[net]] table"));
  EXPECT_THAT(error_of(text, scene_named("endobag")),
              HasSubstr("x.csv:1: column 2 is 'tube.0.x', and `run --nets` of scene 'endobag' writes"));
  EXPECT_THAT(error_of("t\n", scene), HasSubstr("column 2 is missing"));
  EXPECT_THAT(error_of("", scene), HasSubstr("is empty"));
  EXPECT_THAT(error_of(text.substr(0, text.find('\n') + 1), scene), HasSubstr("has no rows"));
  EXPECT_THAT(error_of(text + "9,1\n", scene), HasSubstr("x.csv:53: not the 76 numbers"));
  EXPECT_THAT(error_of(text + row, scene), HasSubstr("x.csv:53: its time is not after"));
  std::string infinite = "9" + row.substr(row.find(','));
  infinite.replace(infinite.rfind(',') + 1, std::string::npos, "inf\n");
  EXPECT_THAT(error_of(text + infinite, scene), HasSubstr("x.csv:53: a number is not finite"));
  EXPECT_EQ(error_of(text + row.substr(0, 9), scene), "none") << "of a run that was killed";
}

TEST(Recording, OfASceneIsItsStart) {
  const Recording recording = recording_of(scene_named("organ"));
  ASSERT_EQ(recording.samples.size(), 1u);
  EXPECT_EQ(recording.samples[0].record.bodies[1].X_WB.p, recording.scene.bodies[1].X_WB.p);
}

}  // namespace
}  // namespace godobject::test_recording
