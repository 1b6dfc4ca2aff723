// godobject export: every format has the numbers of the recording, up to a cut, and replaces no file unasked.
#include <gmock/gmock.h>

#include <bit>
#include <map>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>

#ifdef GODOBJECT_TEST_HDF5
#include <hdf5.h>
#endif

#include "tests/support/program.h"

namespace godobject::test::test_cli_export {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr const char* scene = "sim/scenes/rigid.toml";

class CliExport : public ProgramTest {
 protected:
  /// A trace of a body with these rows after the header.
  std::string trace(const std::string& rows) const {
    return write("trace.csv",
                 "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz,tool.vx,energy\n" + rows);
  }
  std::string good_trace() const { return trace("0,1,2,3,1,0,0,0,0.5,-7\n0.25,1.5,2,3,1,0,0,0,nan,-8\n"); }
  void record(const std::string& options) const {
    const ProgramResult run = run_program(std::string("run ") + scene + " --duration 0.5 --quiet " + options);
    ASSERT_EQ(run.exit_code, 0) << run.output;
  }
  ProgramResult exported(const std::string& arguments, int exit_code = 0) const {
    ProgramResult result = run_program("export " + arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments << "\n" << result.output;
    return result;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }
  std::string text(const std::string& name) const { return read_file(path(name)); }
};

// ---- rows and frames -------------------------------------------------------------------------------

TEST_F(CliExport, CsvHasTheBytesOfTheTrace) {
  record("--trace " + path("run.csv") + " --record " + path("run.godo"));
  EXPECT_THAT(exported(path("run.csv") + " --csv " + path("a.csv")).output, HasSubstr("exported 501 rows\n"));
  EXPECT_TRUE(text("a.csv") == text("run.csv"));
  const std::string output = exported(path("run.godo") + " --csv " + path("b.csv")).output;
  EXPECT_THAT(output, HasSubstr("identical, also the rig\nexported 501 rows\n"));
  EXPECT_TRUE(text("b.csv") == text("run.csv"));
}

TEST_F(CliExport, EveryNthRowIsKept) {
  exported(good_trace() + " --every 2 --csv " + path("a.csv"));
  EXPECT_THAT(text("a.csv"), HasSubstr("\n0,1,2,3"));
  EXPECT_THAT(text("a.csv"), Not(HasSubstr("\n0.25")));
}

TEST_F(CliExport, FramesOfALogHaveTheirTimesAndBytes) {
  const std::string log = write("bus.log",
                                "(1631416514.717133) can0 0D2#0000FFFF\n"
                                "(1631416514.717133456) can1 1234567F##10102\n"
                                "(1631416515.000000) can0 123#R\n");
  exported(log + " --csv " + path("a.csv") + " --candump " + path("a.log"));
  EXPECT_TRUE(text("a.log") == text("bus.log"));
  EXPECT_EQ(text("a.csv"),
            "t,bus,id,extended,remote,fd,bit_rate_switch,size,data\n"
            "1631416514.717133000,can0,0xd2,0,0,0,0,4,0x0000ffff\n"
            "1631416514.717133456,can1,0x1234567f,1,0,1,1,2,0x0102\n"
            "1631416515.000000000,can0,0x123,0,1,0,0,0,0x\n");
}

TEST_F(CliExport, ALogWithItsSceneHasTheRowsOfItsReplay) {
  record("--trace " + path("run.csv") + " --record " + path("bus.log") + " 2> /dev/null");
  exported(path("bus.log") + " --scene " + scene + " --csv " + path("a.csv"));
  std::istringstream a(text("a.csv")), b(text("run.csv"));
  std::string header_a, header_b;
  std::getline(a, header_a);
  std::getline(b, header_b);
  EXPECT_EQ(header_a, header_b);
  EXPECT_GT(std::ranges::count(text("a.csv"), '\n'), 450);
}

// ---- cut and damaged files -------------------------------------------------------------------------

TEST_F(CliExport, ACutFileIsExportedUpToTheCut) {
  record("--trace " + path("run.csv") + " --record " + path("run.godo"));
  record("--record " + path("bus.log") + " 2> /dev/null");
  const auto cut = [&](const std::string& name) {
    const std::string whole = text(name);
    return write("cut-" + name, whole.substr(0, whole.size() * 2 / 3 + 5));
  };
  EXPECT_THAT(exported(cut("run.csv") + " --csv " + path("a.csv")).output, HasSubstr("run.csv was cut"));
  EXPECT_THAT(exported(cut("bus.log") + " --candump " + path("a.log")).output, HasSubstr("bus.log was cut"));
  EXPECT_THAT(exported(cut("run.godo") + " --csv " + path("b.csv")).output,
              HasSubstr("run.godo was cut after cycle"));
  for (const auto& [part, whole] :
       std::map<std::string, std::string>{{"a.csv", "run.csv"}, {"a.log", "bus.log"}, {"b.csv", "run.csv"}}) {
    EXPECT_TRUE(text(whole).starts_with(text(part))) << part;
    EXPECT_TRUE(text(part).ends_with('\n')) << part;
    EXPECT_GT(text(part).size(), text(whole).size() / 3) << part;
    EXPECT_LT(text(part).size(), text(whole).size()) << part;
  }
}

TEST_F(CliExport, RowsBeforeADamagedOneAreKept) {
  const std::string file = trace("0,1,2,3,1,0,0,0,0.5,-7\n0.25,oops\n0.5,1,2,3,1,0,0,0,0.5,-7\n");
  EXPECT_THAT(exported(file + " --csv " + path("a.csv"), 1).output,
              HasSubstr("trace.csv:3: not the 10 numbers of a row\nexported 1 rows\n"));
  EXPECT_THAT(text("a.csv"), testing::EndsWith("\n0,1,2,3,1,0,0,0,0.5,-7\n"));
  const std::string log = write("bus.log", "(1.000000) can0 0D2#00\n(1.5) can0 0D2#00\n");
  EXPECT_THAT(exported(log + " --candump " + path("a.log"), 1).output,
              HasSubstr("bus.log:2: no frame in candump's format\nexported 1 frames\n"));
  EXPECT_EQ(text("a.log"), "(1.000000) can0 0D2#00\n");
  EXPECT_THAT(exported(trace("-1,1,2,3,1,0,0,0,0.5,-7\n") + " --mcap " + path("a.mcap"), 2).output,
              HasSubstr("trace.csv:2: its time is not in [0, 9e9] s"));
  EXPECT_FALSE(exists("a.mcap"));
}

TEST_F(CliExport, OtherFilesAreRefused) {
  const auto refuses = [&](const std::string& file, const std::string& options, const std::string& why) {
    EXPECT_THAT(exported(file + " " + options, 2).output, HasSubstr(why));
    EXPECT_FALSE(exists("out"));
    EXPECT_FALSE(exists("out.part"));
  };
  const std::string out = path("out"), rows = good_trace(),
                    frames = write("bus.log", "(1.000000) can0 0D2#00\n");
  refuses(rows, "", "name a file to write");
  refuses(path("none"), "--csv " + out, "cannot be read");
  refuses(write("empty", ""), "--csv " + out, "is empty");
  refuses(write("text", "once upon a time,\nthere was\n"), "--csv " + out, "is no trace");
  refuses(write("head", "t,tool.x\n"), "--csv " + out, "has no rows");
  refuses(write("half", "t,tool.x\n0,"), "--csv " + out, "has no rows");
  refuses(write("bad.godo", "godolog1 and nothing else"), "--csv " + out, "has no head");
  refuses(write("cut.log", "(1.000000) ca"), "--candump " + out, "has no frames");
  refuses(rows, "--candump " + out, "--candump needs frames");
  refuses(frames, "--hdf5 " + out, "--hdf5 needs rows");
  refuses(rows, std::string("--scene ") + scene + " --csv " + out, "--scene is for logs of buses");
  refuses(frames, std::string("--scene ") + scene + " --candump " + out, "--candump needs frames");
  refuses(rows, "--every 0 --csv " + out, "--every");
}

// ---- outputs ---------------------------------------------------------------------------------------

TEST_F(CliExport, NoFileIsReplacedUnasked) {
  const std::string input = good_trace(), before = "precious\n", out = write("out", before);
  for (const char* format : {"--csv ", "--mcap ", "--hdf5 "}) {
    EXPECT_THAT(exported(input + " " + format + out, 2).output,
                HasSubstr("exists: give another name, or --force"));
    EXPECT_EQ(text("out"), before);
  }
  // An input that cannot be read leaves the old file, also by force.
  exported(write("bad", "t,tool.x\n0,oops\n") + " --force --csv " + out, 2);
  EXPECT_EQ(text("out"), before);
  EXPECT_FALSE(exists("out.part"));
  exported(input + " --force --csv " + out);
  EXPECT_TRUE(text("out") == text("trace.csv"));
  EXPECT_FALSE(exists("out.part"));
  // The input itself and files that are none are not replaced by force either.
  const std::string whole = text("trace.csv");
  EXPECT_THAT(exported(input + " --force --csv " + input, 2).output, HasSubstr("is also read"));
  EXPECT_EQ(text("trace.csv"), whole);
  EXPECT_THAT(exported(input + " --force --csv /dev/null", 2).output, HasSubstr("is no regular file"));
  write("new.part", before);
  EXPECT_THAT(exported(input + " --force --csv " + path("new"), 2).output,
              HasSubstr("is left of another export"));
  EXPECT_EQ(text("new.part"), before);
}

TEST_F(CliExport, AFullDiskLeavesTheOldFile) {
  std::string rows;
  for (int i = 0; i < 20000; ++i)
    rows += std::to_string(i) + ",1,2,3,1,0,0,0,0.5," + std::to_string(i * 7919 % 1009) + "\n";
  const std::string input = trace(rows), out = write("out", "precious\n");
  for (const char* format : {"--csv ", "--mcap ", "--hdf5 "}) {
    if (format == std::string_view("--hdf5 ") &&
        run_program("export " + input + " --hdf5 " + path("try")).exit_code == 2)
      continue;  // built without it
    const ProgramResult result =
        run_program("export " + input + " --force " + format + out, "ulimit -f 16 && trap '' XFSZ && ");
    EXPECT_EQ(result.exit_code, 1) << format << result.output;
    EXPECT_THAT(result.output, HasSubstr("could not be written in full: the disk may be full"));
    EXPECT_EQ(text("out"), "precious\n") << format;
    EXPECT_FALSE(exists("out.part")) << format;
  }
}

// ---- MCAP, read as its specification has it --------------------------------------------------------

/// CRC-32, bit by bit.
std::uint32_t crc_of(std::string_view bytes) {
  std::uint32_t crc = ~0u;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

/// Numbers and texts from the front of bytes.
struct Reader {
  std::string_view bytes;

  std::string_view take(std::size_t size) {
    EXPECT_LE(size, bytes.size());
    const std::string_view taken = bytes.substr(0, size);
    bytes.remove_prefix(std::min(size, bytes.size()));
    return taken;
  }
  std::uint64_t number(std::size_t size) {
    std::uint64_t value = 0, shift = 0;
    for (const char byte : take(size))
      value |= std::uint64_t{static_cast<unsigned char>(byte)} << std::exchange(shift, shift + 8);
    return value;
  }
  std::string_view text() { return take(number(4)); }
  /// Opcode and content of the next record.
  std::pair<std::uint64_t, std::string_view> record() {
    const std::uint64_t op = number(1);
    return {op, take(number(8))};
  }
};

struct McapFile {
  std::map<std::uint64_t, std::string> topics;
  std::map<std::string, std::vector<std::pair<std::uint64_t, nlohmann::json>>> messages;  // of each topic
  std::map<std::string, std::string> schemas;  // name of each topic's
};

/// Reads a file, and checks every position, length and CRC in it.
McapFile read_mcap(const std::string& file) {
  constexpr std::string_view magic = "\x89MCAP0\r\n";
  McapFile read;
  EXPECT_TRUE(file.starts_with(magic) && file.ends_with(magic));
  std::map<std::uint64_t, std::string> schemas;
  std::map<std::size_t, std::vector<std::uint64_t>> chunk_indices;  // of the chunk at this place
  std::map<std::uint64_t, std::string> repeated;                    // records of the data by opcode
  std::string_view chunk;
  std::size_t num_messages = 0, num_indexed = 0;
  Reader reader{std::string_view(file).substr(magic.size())};
  const auto place = [&] { return file.size() - reader.bytes.size(); };
  for (std::size_t begin = place(); reader.bytes.size() > magic.size(); begin = place()) {
    auto [op, content] = reader.record();
    Reader r{content};
    if (op == 3 || op == 4) repeated[op] += file.substr(begin, place() - begin);
    if (op == 3) {
      const std::uint64_t id = r.number(2);
      schemas[id] = r.text();
      EXPECT_EQ(r.text(), "jsonschema");
      EXPECT_TRUE(nlohmann::json::parse(r.text()).contains("title"));
    } else if (op == 4) {
      const std::uint64_t id = r.number(2), schema = r.number(2);
      read.topics[id] = r.text();
      read.schemas[read.topics[id]] = schemas.at(schema);
      EXPECT_EQ(r.text(), "json");
    } else if (op == 6) {
      const std::uint64_t first = r.number(8), last = r.number(8), size = r.number(8), crc = r.number(4);
      EXPECT_EQ(r.text(), "");
      EXPECT_EQ(r.number(8), size);
      chunk = r.bytes;
      EXPECT_EQ(chunk.size(), size);
      EXPECT_EQ(crc_of(chunk), crc);
      chunk_indices[begin] = {first, last, place() - begin, size};
      for (Reader inner{chunk}; !inner.bytes.empty(); ++num_messages) {
        const auto [message, bytes] = inner.record();
        EXPECT_EQ(message, 5u);
        Reader m{bytes};
        const std::string topic = read.topics.at(m.number(2));
        EXPECT_EQ(m.number(4), read.messages[topic].size());
        const std::uint64_t t = m.number(8);
        EXPECT_EQ(m.number(8), t);
        EXPECT_TRUE(first <= t && t <= last);
        read.messages[topic].emplace_back(t, nlohmann::json::parse(m.bytes));
      }
    } else if (op == 7) {
      const std::uint64_t channel = r.number(2);
      for (Reader entries{r.text()}; !entries.bytes.empty(); ++num_indexed) {
        const std::uint64_t t = entries.number(8), at = entries.number(8);
        Reader m{Reader{chunk.substr(at)}.record().second};
        EXPECT_EQ(m.number(2), channel);
        m.number(4);
        EXPECT_EQ(m.number(8), t);
      }
    } else if (op == 15) {
      EXPECT_EQ(r.number(4), crc_of(file.substr(0, begin)));
    } else if (op == 8) {
      const std::uint64_t first = r.number(8), last = r.number(8), at = r.number(8), length = r.number(8);
      r.text();
      r.number(8);
      r.text();
      EXPECT_THAT(chunk_indices[at], ElementsAre(first, last, length, r.number(8)));
    } else if (op == 11) {
      EXPECT_EQ(r.number(8), num_messages);
    } else if (op == 2) {
      const std::uint64_t summary = r.number(8), offsets = r.number(8);
      EXPECT_TRUE(file.substr(summary).starts_with(repeated[3].substr(0, repeated[3].size() / 2)));
      EXPECT_EQ(static_cast<unsigned char>(file[offsets]), 14);
      EXPECT_EQ(r.number(4), crc_of(file.substr(summary, place() - 4 - summary)));
    }
  }
  EXPECT_EQ(num_indexed, num_messages);
  return read;
}

TEST_F(CliExport, McapHasEachNumberOfTheTrace) {
  exported(good_trace() + " --mcap " + path("a.mcap"));
  const McapFile mcap = read_mcap(text("a.mcap"));
  ASSERT_EQ(mcap.messages.size(), 3u);
  const auto& tool = mcap.messages.at("/tool");
  ASSERT_EQ(tool.size(), 2u);
  EXPECT_EQ(tool[1].first, 250'000'000u);
  EXPECT_EQ(tool[0].second["vx"], 0.5);
  EXPECT_EQ(tool[1].second["x"], 1.5);
  EXPECT_FALSE(tool[1].second.contains("vx"));  // not a number
  EXPECT_EQ(mcap.messages.at("/run")[1].second, nlohmann::json({{"energy", -8}}));
  EXPECT_EQ(mcap.schemas.at("/tf"), "foxglove.FrameTransforms");
  const nlohmann::json& pose = mcap.messages.at("/tf")[1].second["transforms"][0];
  EXPECT_EQ(pose["child_frame_id"], "tool");
  EXPECT_EQ(pose["translation"], nlohmann::json({{"x", 1.5}, {"y", 2}, {"z", 3}}));
  EXPECT_EQ(pose["rotation"]["w"], 1);
  EXPECT_EQ(pose["timestamp"]["nsec"], 250'000'000);
}

TEST_F(CliExport, McapOfALongRunHasManyChunksAndTheTimesOfTheBus) {
  record("--trace " + path("run.csv"));
  exported(path("run.csv") + " --mcap " + path("a.mcap"));
  const McapFile mcap = read_mcap(text("a.mcap"));
  std::istringstream rows(text("run.csv"));
  std::string line;
  std::getline(rows, line);
  const std::string header = "," + line;
  const auto column = static_cast<std::size_t>(
      std::count(header.begin(), header.begin() + static_cast<std::ptrdiff_t>(header.find(",t_bus")), ','));
  for (const auto& [t, message] : mcap.messages.at("/tool")) {
    std::getline(rows, line);
    std::istringstream numbers(line);
    std::vector<std::string> row;
    for (std::string number; std::getline(numbers, number, ',');) row.push_back(number);
    ASSERT_NEAR(static_cast<double>(t), 1e9 * std::stod(row[column]), 1);
    ASSERT_EQ(message["x"].get<double>(), std::stod(row[1]));
  }
  EXPECT_EQ(mcap.messages.at("/tool").size(), 501u);
  EXPECT_GT(text("a.mcap").size(), 1u << 20);  // more than a chunk
}

TEST_F(CliExport, McapOfALogHasAChannelForEachBus) {
  const std::string log =
      write("bus.log", "(1631416514.717133) can0 0D2#00FF\n(1631416514.717134) can1 1234567F#R\n");
  exported(log + " --mcap " + path("a.mcap"));
  const McapFile mcap = read_mcap(text("a.mcap"));
  const auto& [t, frame] = mcap.messages.at("/can0").at(0);
  EXPECT_EQ(t, 1631416514717133000u);
  EXPECT_EQ(frame["id"], 0xD2);
  EXPECT_EQ(frame["data"], "00ff");
  EXPECT_EQ(mcap.messages.at("/can1").at(0).second["extended"], true);
}

// ---- HDF5, read by its library ---------------------------------------------------------------------

TEST_F(CliExport, Hdf5HasADataSetForEachColumn) {
#ifdef GODOBJECT_TEST_HDF5
  std::string rows;
  for (int i = 0; i < 5000; ++i)
    rows += std::to_string(0.001 * i) + ",1,2,3,1,0,0,0,nan," + std::to_string(-i) + "\n";
  exported(trace(rows) + " --hdf5 " + path("a.h5"));
  const hid_t file = H5Fopen(path("a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  const auto column = [&](const char* name) {
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(set);
    std::vector<double> numbers(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    EXPECT_GE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()), 0);
    H5Sclose(space);
    H5Dclose(set);
    return numbers;
  };
  const std::vector<double> t = column("t"), energy = column("energy"), vx = column("tool.vx");
  ASSERT_EQ(t.size(), 5000u);
  for (std::size_t i = 0; i < t.size(); ++i) {
    ASSERT_EQ(t[i], std::stod(std::to_string(0.001 * static_cast<double>(i))));
    ASSERT_EQ(energy[i], -static_cast<double>(i));
    ASSERT_TRUE(vx[i] != vx[i]);
  }
  H5Fclose(file);
#else
  EXPECT_THAT(exported(good_trace() + " --hdf5 " + path("a.h5"), 2).output,
              HasSubstr("install Debian's libhdf5-dev"));
  EXPECT_FALSE(exists("a.h5"));
#endif
}

}  // namespace
}  // namespace godobject::test::test_cli_export
