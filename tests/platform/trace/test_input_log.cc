// Input logs are read back as they were written, up to a cut and around damage. The engine continues from
// their states bit for bit.
#include "platform/trace/input_log.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <random>

#include "hal/base/crc32.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject::test_input_log {
namespace {

constexpr std::uint64_t num_rows = 1000, state_every = 250;

InputLogHead head_of_test() {
  return {.version = "1.2.3",
          .scene_file = "some/scene.toml",
          .scene = "name = \"scene\"",
          .files = {{.name = "a.obj", .bytes = std::string("\0\n", 2)}, {.name = "b.stl", .bytes = ""}},
          .composition = "rigid-1 tr-bdf2",
          .snapshot_bytes = 80,
          .log_origin_ns = -5};
}

/// A record with numbers of which some change from row to row.
CycleRecord record_at(std::uint64_t cycle) {
  CycleRecord record = record_of({.bodies = 2, .targets = 1, .device_q = 3, .drives = 1, .joint_q = 2});
  record.cycle = cycle;
  record.t = 1e-3 * static_cast<double>(cycle);
  record.state_hash = 0x9e3779b97f4a7c15u * cycle;
  if (cycle % 3 == 0) record.held = 1;
  record.bodies[1].X_WB.q = Quat(Eigen::AngleAxisd(record.t, Vec3::UnitZ()));
  record.bodies[0].contact_W.tau.z() = -record.t;
  record.samples[1].F_WB.f.x() = static_cast<double>(cycle / 10);
  record.samples[0].valid = cycle % 7 != 0;
  record.samples[1].joint.q_dot.y() = std::nan("");
  record.device_q[2] = -0.0;
  record.drive_energy[0] = 1e-6 * record.t;
  record.t_bus_ns = -1;
  record.fault = static_cast<Fault>(cycle % 2);
  return record;
}

std::string log_of_test() {
  std::string file;
  InputLogWriter writer(head_of_test(), record_at(0),
                        [&](const InputLogWriter::Chunk& chunk) { file += chunk.bytes; });
  EngineState state{.bytes = std::vector<std::byte>(80, std::byte{7})};
  writer.add(state);
  for (std::uint64_t cycle = 1; cycle <= num_rows; ++cycle) {
    writer.add(record_at(cycle));
    if (cycle % state_every != 0) continue;
    state.cycle = cycle;
    state.hash = ~cycle;
    writer.add(state);
  }
  writer.flush();
  return file + InputLogWriter::end_of(3);
}

std::vector<std::uint64_t> words_of(const CycleRecord& record) {
  std::vector<std::uint64_t> words(num_words(sizes_of(record)));
  to_words(record, words);
  return words;
}

/// Rows and states of a file, each of which is as it was written.
struct Found {
  std::vector<std::uint64_t> rows;  // cycles
  std::size_t states = 0;
  bool has_end = false, can_be_read = false;
  std::uint64_t damaged = 0;
};

Found read(std::string_view file) {
  Found found;
  InputLogReader reader(file);
  found.can_be_read = reader.why_not().empty();
  if (!found.can_be_read) return found;
  EXPECT_EQ(words_of(reader.start()), words_of(record_at(0)));
  for (;;) {
    const InputLogReader::Item item = reader.next();
    found.damaged = reader.damaged_bytes();
    found.has_end = item == InputLogReader::Item::end;
    if (found.has_end || item == InputLogReader::Item::cut) return found;
    if (item == InputLogReader::Item::state) {
      ++found.states;
      EXPECT_EQ(reader.state().hash, reader.state().cycle == 0 ? 0 : ~reader.state().cycle);
      EXPECT_EQ(reader.state().bytes, std::vector<std::byte>(80, std::byte{7}));
      continue;
    }
    const std::uint64_t cycle = reader.row().cycle;
    EXPECT_GT(cycle, found.rows.empty() ? 0 : found.rows.back());
    found.rows.push_back(cycle);
    const std::vector<std::uint64_t> written = words_of(record_at(cycle));
    EXPECT_EQ(words_of(reader.row()), written);
    EXPECT_TRUE(std::ranges::equal(reader.words(), written));
  }
}

TEST(InputLog, ChecksumIsThatOfTheStandard) { EXPECT_EQ(crc32("123456789"), 0xCBF43926u); }

TEST(InputLog, IsReadAsItWasWritten) {
  const std::string file = log_of_test();
  const Found found = read(file);
  EXPECT_EQ(found.rows.size(), num_rows);
  EXPECT_EQ(found.states, 1 + num_rows / state_every);
  EXPECT_TRUE(found.has_end);
  EXPECT_EQ(found.damaged, 0u);
  const InputLogReader reader(file);
  const InputLogHead &head = reader.head(), written = head_of_test();
  EXPECT_EQ(head.version, written.version);
  EXPECT_EQ(head.scene_file, written.scene_file);
  EXPECT_EQ(head.scene, written.scene);
  EXPECT_EQ(head.composition, written.composition);
  EXPECT_EQ(head.log_origin_ns, written.log_origin_ns);
  ASSERT_EQ(head.files.size(), 2u);
  EXPECT_EQ(head.files[0].bytes, written.files[0].bytes);
  EXPECT_EQ(reader.start().samples.size(), 2u);
}

TEST(InputLog, ConstantQuantitiesTakeLittleSpace) {
  EXPECT_LT(static_cast<double>(log_of_test().size()), 120.0 * num_rows);
}

TEST(InputLog, ACutFileIsReadUpToTheCut) {
  const std::string file = log_of_test();
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const std::size_t size = std::uniform_int_distribution<std::size_t>(0, file.size() - 1)(random);
    const Found found = read(std::string_view(file).substr(0, size));
    EXPECT_FALSE(found.has_end);
    EXPECT_EQ(found.damaged, 0u);
    // whole chunks before the cut
    const double share = static_cast<double>(size) / static_cast<double>(file.size());
    EXPECT_GE(static_cast<double>(found.rows.size()) + 1.5 * input_log_chunk_rows, share * num_rows);
    for (std::size_t row = 0; row < found.rows.size(); ++row) EXPECT_EQ(found.rows[row], row + 1);
  }
}

/// read() compares each row with the written one.
TEST(InputLog, DamagedChunksAreLeftOut) {
  const std::string file = log_of_test();
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    std::string damaged = file;
    const std::size_t at = std::uniform_int_distribution<std::size_t>(0, file.size() - 1)(random);
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (i % 8)));
    const Found found = read(damaged);
    if (!found.can_be_read) continue;  // head or start
    EXPECT_TRUE(found.damaged > 0 || !found.has_end) << at;
    EXPECT_GE(found.rows.size() + input_log_chunk_rows, num_rows);
  }
}

TEST(InputLog, SeekingContinuesWithTheStateBefore) {
  const std::string file = log_of_test();
  InputLogReader reader(file);
  for (const std::uint64_t cycle : {0, 1, 249, 250, 251, 700, 5000}) {
    const std::uint64_t before = std::min(cycle, num_rows) / state_every * state_every;
    EXPECT_EQ(reader.continue_at(cycle), before);
    ASSERT_EQ(reader.next(), InputLogReader::Item::state);
    EXPECT_EQ(reader.state().cycle, before);
    if (cycle >= num_rows) continue;
    ASSERT_EQ(reader.next(), InputLogReader::Item::row);
    EXPECT_EQ(words_of(reader.row()), words_of(record_at(reader.state().cycle + 1)));
  }
}

TEST(InputLog, OtherFilesAreRefused) {
  EXPECT_FALSE(InputLogReader("").why_not().empty());
  EXPECT_FALSE(InputLogReader("t,tool.x\n0,1\n").why_not().empty());
  EXPECT_NE(InputLogReader("godolog2").why_not().find("another format"), std::string::npos);
  EXPECT_NE(InputLogReader("godolog1").why_not().find("cut at its beginning"), std::string::npos);
}

/// Events of each kind, as a rig on two buses has them.
std::vector<LinkEvent> link_events() {
  using Kind = LinkEvent::Kind;
  CanFrame frame{.id = 0x1FFF'FFFF, .extended = true, .fd = true, .bit_rate_switch = true, .size = 64};
  frame.data.fill(0xA5);
  const Nanoseconds t = 1'700'000'000'000'000'000;
  return {{.kind = Kind::live, .bus = 1, .value = 0, .results = 300},
          {.kind = Kind::call,
           .value = 1,
           .call = RigCall::command,
           .rig_state = RigState::armed,
           .sent = 0xFEDC'BA98,
           .cycle = 70'000},
          {.kind = Kind::began, .t_ns = t},
          {.kind = Kind::received, .bus = 1, .results = 2, .t_ns = t - 5, .frame = frame},
          {.kind = Kind::received, .t_ns = t + 7, .frame = {.id = 0x181, .remote = true, .size = 0}},
          {.kind = Kind::waited, .t_ns = t + 1'000'000},
          {.kind = Kind::refused, .bus = 0, .value = 1},
          {.kind = Kind::state, .bus = 1, .value = 4}};
}

void expect_equal(const LinkEvent& a, const LinkEvent& b) {
  EXPECT_TRUE(a.kind == b.kind && a.bus == b.bus && a.value == b.value && a.call == b.call &&
              a.rig_state == b.rig_state && a.sent == b.sent && a.cycle == b.cycle &&
              a.results == b.results && a.t_ns == b.t_ns)
      << static_cast<int>(b.kind);
  EXPECT_TRUE(a.frame.id == b.frame.id && a.frame.extended == b.frame.extended &&
              a.frame.remote == b.frame.remote && a.frame.fd == b.frame.fd &&
              a.frame.bit_rate_switch == b.frame.bit_rate_switch && a.frame.size == b.frame.size &&
              a.frame.data == b.frame.data);
}

TEST(InputLog, EventsOfTheRigComeBeforeTheirRows) {
  const std::vector<LinkEvent> events = link_events();
  std::string file;
  InputLogHead head = head_of_test();
  head.revision = "0123456789ab+cdef0123";
  head.device_start = {0.25, -0.0};
  InputLogWriter writer(head, record_at(0), [&](const InputLogWriter::Chunk& chunk) { file += chunk.bytes; });
  constexpr std::uint64_t cycles = 3000;  // more than a chunk of events
  for (std::uint64_t cycle = 1; cycle <= cycles; ++cycle) {
    for (const LinkEvent& event : events) writer.add(event);
    writer.add(record_at(cycle));
  }
  writer.flush();
  file += InputLogWriter::end_of(0);

  InputLogReader reader(file);
  EXPECT_EQ(reader.head().revision, head.revision);
  EXPECT_EQ(reader.head().device_start, head.device_start);
  std::uint64_t num_events = 0, num_rows_read = 0;
  for (auto item = reader.next(); item != InputLogReader::Item::end; item = reader.next()) {
    ASSERT_NE(item, InputLogReader::Item::cut);
    if (item == InputLogReader::Item::row) {
      ++num_rows_read;
      EXPECT_GE(num_events, events.size() * num_rows_read);
      continue;
    }
    EXPECT_EQ(reader.first_link(), num_events);
    for (const LinkEvent& event : reader.links()) expect_equal(event, events[num_events++ % events.size()]);
  }
  EXPECT_EQ(num_events, cycles * events.size());
  EXPECT_EQ(num_rows_read, cycles);
  EXPECT_EQ(reader.damaged_bytes(), 0u);
}

TEST(LastChunks, KeepTheLastRowsAfterAState) {
  const InputLogSizes sizes = sizes_of(record_at(0));
  LastChunks last(sizes, 80, 2000, 1000);
  std::string file;
  bool has_state = false;
  InputLogWriter writer(head_of_test(), record_at(0), [&](const InputLogWriter::Chunk& chunk) {
    has_state = has_state || chunk.is_state;
    if (!has_state) file += chunk.bytes;
    else last.add(chunk);
  });
  EngineState state{.bytes = std::vector<std::byte>(80, std::byte{7})};
  writer.add(state);
  for (std::uint64_t cycle = 1; cycle <= 7654; ++cycle) {
    writer.add(record_at(cycle));
    if (cycle % 1000 != 0) continue;
    state.cycle = cycle;
    state.hash = ~cycle;
    writer.add(state);
  }
  writer.flush();
  last.each([&](std::string_view piece) { file += piece; });
  const Found found = read(file);
  EXPECT_EQ(found.rows.size(), last.num_rows());
  EXPECT_EQ(found.rows.front(), 5001u);
  EXPECT_EQ(found.rows.back(), 7654u);
  EXPECT_EQ(found.states, 3u);
}

TEST(LastChunks, MoreThanTheMemoryHoldsIsNotKept) {
  LastChunks last({.bodies = 1}, 8, 1, 1);
  const std::string large(LastChunks::max_bytes + 1, 'x');
  last.add({.bytes = "state", .num_rows = 0, .is_state = true});
  EXPECT_FALSE(last.is_bounded());
  last.add({.bytes = large, .num_rows = 9, .is_state = false});
  EXPECT_EQ(last.num_rows(), 0u);
  EXPECT_TRUE(last.is_bounded());
}

TEST(LastChunks, FewerRowsThanWantedAreReported) {
  constexpr std::size_t state_bytes = 40u << 20;
  LastChunks last({.bodies = 1}, state_bytes, 10, 1);
  const std::string state(state_bytes, 'x');
  last.add({.bytes = state, .num_rows = 0, .is_state = true});
  last.add({.bytes = "row", .num_rows = 1, .is_state = false});
  EXPECT_FALSE(last.is_bounded());
  last.add({.bytes = state, .num_rows = 0, .is_state = true});
  EXPECT_TRUE(last.is_bounded());
  EXPECT_EQ(last.num_rows(), 0u);
}

class EngineStates : public testing::TestWithParam<const char*> {};

/// A new engine that has the state of a running one computes the same from then on.
TEST_P(EngineStates, AreAllThatAStepLeavesToTheNext) {
  const LoadResult loaded =
      load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + GetParam() + ".toml");
  ASSERT_TRUE(loaded.scene.has_value());
  Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::direct);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  Session& session = *made.session;
  session.list_inputs();
  session.start(5);
  CycleRecord record = session.at_start();
  const std::vector<BodySample> at_start = record.samples;
  for (int i = 0; i < 250; ++i) session.cycle(record);

  std::vector<std::byte> state(session.engine().snapshot_bytes());
  session.engine().save(state);
  std::string why_not;
  const std::unique_ptr<Engine> other = make_engine(*loaded.scene, at_start, why_not);
  ASSERT_NE(other, nullptr) << why_not;
  EXPECT_FALSE(make_engine(*loaded.scene, at_start, why_not)->restore(std::span(state).first(8)));
  ASSERT_TRUE(other->restore(state));
  ASSERT_EQ(other->state_hash(), session.engine().state_hash());
  for (int i = 0; i < 150; ++i) {
    session.cycle(record);
    const StepReport report = other->step(record.samples);
    ASSERT_EQ(other->state_hash(), record.state_hash) << "step " << i << " after the state";
    EXPECT_EQ(report.fault, record.fault);
    EXPECT_EQ(other->energy().balance, record.energy.balance);
    EXPECT_EQ(other->energy().gained, record.energy.gained);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EngineStates,
                         testing::Values("rigid", "grasper", "organ", "admittance", "relative", "scissors",
                                         "scissors-imposed", "grasp", "lego", "net-small", "wall", "desk",
                                         "catheter", "needle-driver"));

}  // namespace
}  // namespace godobject::test_input_log
