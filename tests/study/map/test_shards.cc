// Shards of the stability map: their union is the whole run, bit for bit; a killed one is continued; others
// are refused by name. The job scripts run them.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/study/map/shard.h"
#include "tests/study/tool.h"

namespace godobject::study::test_shards {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* program = GODOBJECT_MAP_PROGRAM;
constexpr std::uint64_t samples = 37;  // not a multiple of the shards

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Tests write into a folder of their own, and share the run of all samples.
class Shards : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    root_ = fs::temp_directory_path() / ("godobject-shards-" + std::to_string(::getpid()));
    fs::create_directories(root_);
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }
  void SetUp() override { fs::create_directories(directory()); }

  /// Both run once, when a test needs them first.
  static fs::path whole() {
    const fs::path file = root_ / "whole.csv";
    if (!fs::exists(file)) run(file, {});
    return file;
  }
  static fs::path shard(int k) {
    const fs::path file = root_ / ("shard-" + std::to_string(k) + ".csv");
    if (!fs::exists(file)) run(file, {"--shard", std::to_string(k) + "/3"});
    return file;
  }
  static fs::path directory() {
    return root_ / ::testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  static ToolResult call(const std::vector<std::string>& arguments) {
    std::vector<std::string> all{program, "stability-map"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run_tool(all);
  }
  static void run(const fs::path& out, const std::vector<std::string>& more) {
    std::vector<std::string> all{"--samples", std::to_string(samples), "--out", out.string()};
    all.insert(all.end(), more.begin(), more.end());
    const ToolResult result = call(all);
    ASSERT_TRUE(result.ok()) << result.output;
  }
  static ToolResult merge(const std::vector<fs::path>& files) {
    std::vector<std::string> all{"--out", (directory() / "merged.csv").string(), "--merge"};
    for (const fs::path& file : files) all.push_back(file.string());
    return call(all);
  }
  /// Returns a copy of a shard with a text of its replaced.
  static fs::path changed(int k, const std::string& text, const std::string& by) {
    std::string content = content_of(shard(k));
    const std::size_t at = content.find(text);
    EXPECT_NE(at, std::string::npos) << text;
    content.replace(at, text.size(), by);
    const fs::path file = directory() / "changed.csv";
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }
  static void expect_refused(const ToolResult& result, const fs::path& file, const std::string& why) {
    EXPECT_EQ(result.status, 1) << result.output;
    EXPECT_THAT(result.output, AllOf(HasSubstr(file.filename().string()), HasSubstr(why)));
    EXPECT_FALSE(fs::exists(directory() / "merged.csv"));
  }

  static inline fs::path root_;
};

TEST_F(Shards, AreTheWholeRunBitForBit) {
  const ToolResult result = merge({shard(3), shard(1), shard(2)});  // in any order
  ASSERT_TRUE(result.ok()) << result.output;
  EXPECT_EQ(content_of(directory() / "merged.csv"), content_of(whole()));
  EXPECT_EQ(read_map(whole()).rows.size(), samples);
  EXPECT_NE(content_of(shard(1)), content_of(shard(2)));
}

TEST_F(Shards, OneSampleIsRepeatedAlone) {
  const MapFile map = read_map(whole());
  for (const std::uint64_t number : {0u, 5u, 20u}) {
    const ToolResult alone = call({"--sample", std::to_string(number)});
    EXPECT_EQ(alone.output, map_columns() + "\n" + map.rows[number] + "\n");
  }
  EXPECT_NE(call({"--sample", "5", "--seed", "2"}).output, call({"--sample", "5"}).output);
}

TEST_F(Shards, OthersAreRefusedByName) {
  expect_refused(merge({shard(1), shard(2), shard(2)}), shard(2), "overlaps");
  expect_refused(merge({shard(1), shard(3)}), "--merge", "missing shards 2/3");
  expect_refused(merge({shard(1), shard(2), changed(3, "seed=1", "seed=2")}), "changed.csv", "seed 2, not 1");
  expect_refused(merge({shard(1), shard(2), changed(3, "samples=37", "samples=38")}), "changed.csv",
                 "samples 38, not 37");
  expect_refused(merge({shard(1), shard(2), changed(3, "shard=3/3", "shard=3/4")}), "changed.csv", "");
  expect_refused(merge({shard(1), shard(2), changed(3, "fingerprint=", "fingerprint=0")}), "changed.csv",
                 "another program or processor");
  expect_refused(merge({shard(1), shard(2), changed(3, "sample,family", "sample,kin")}), "changed.csv",
                 "line 2");
  expect_refused(merge({shard(1), shard(2), changed(3, "\n5,", "\n6,")}), "changed.csv", "line 4");
  expect_refused(merge({shard(1), shard(2), directory() / "absent.csv"}), "absent.csv", "cannot be read");
  const std::string last = read_map(shard(3)).rows.back() + "\n";
  expect_refused(merge({shard(1), shard(2), changed(3, last, "")}), "changed.csv", "incomplete: 11 of 12");
  expect_refused(merge({shard(1), shard(2), changed(3, last, last.substr(0, 9))}), "changed.csv",
                 "incomplete: 11 of 12");
}

TEST_F(Shards, FilesOfOtherRunsAreNotContinued) {
  const fs::path file = directory() / "other.csv";
  fs::copy_file(shard(2), file);
  const std::string before = content_of(file);
  const auto refused = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all{"--out", file.string()};
    all.insert(all.end(), more.begin(), more.end());
    expect_refused(call(all), file, "write to another one");
    EXPECT_EQ(content_of(file), before) << "nothing is lost";
  };
  refused({"--samples", "37", "--shard", "1/3"});
  refused({"--samples", "37", "--shard", "2/4"});
  refused({"--samples", "38", "--shard", "2/3"});
  refused({"--samples", "37", "--shard", "2/3", "--seed", "9"});
  std::ofstream(file, std::ios::binary) << "a letter\n";
  expect_refused(call({"--out", file.string()}), file, "no head of a stability map");
  std::ofstream(file, std::ios::binary) << "a letter";
  expect_refused(call({"--out", file.string()}), file, "no result of a stability map");
  EXPECT_EQ(content_of(file), "a letter");
}

TEST_F(Shards, WithReplaceOnlyFilesOfOtherRunsAreReplaced) {
  const std::vector<std::string> run{"--samples", "37", "--shard", "2/3", "--replace", "--out"};
  const auto call_on = [&](const fs::path& file) {
    std::vector<std::string> all = run;
    all.push_back(file.string());
    return call(all);
  };
  const fs::path other = changed(2, "fingerprint=", "fingerprint=0");
  ASSERT_TRUE(call_on(other).ok());
  EXPECT_EQ(content_of(other), content_of(shard(2)));
  // killed after four rows, the first one marked: a run from the start would not have the mark
  const std::vector<std::string> rows = read_map(shard(2)).rows;
  const std::string marked = rows[0].substr(0, rows[0].rfind(',')) + ",0.125\n";
  const std::string content = content_of(shard(2)), rest = rows[1] + "\n" + rows[2] + "\n" + rows[3] + "\n";
  const std::string first = content.substr(0, content.find(rows[0])) + marked;
  const fs::path killed = directory() / "killed.csv";
  std::ofstream(killed, std::ios::binary) << first << rest << rows[4].substr(0, 5);
  ASSERT_TRUE(call_on(killed).ok());
  EXPECT_EQ(content_of(killed), first + content.substr(content.find(rows[1])));
  const fs::path older = directory() / "older.csv";
  std::ofstream(older, std::ios::binary) << content.substr(0, content.find(",distance_m")) << '\n' << rest;
  ASSERT_TRUE(call_on(older).ok()) << "other columns";
  EXPECT_EQ(content_of(older), content);
}

TEST_F(Shards, BadPartsAreRefused) {
  const std::string none = (directory() / "none.csv").string(), first = shard(1).string();
  EXPECT_EQ(call({}).status, 2);
  EXPECT_EQ(call({"--merge", first}).status, 2) << "where to?";
  EXPECT_EQ(call({"--out", none, "--merge", first, "--seed", "1"}).status, 2) << "the files have it";
  EXPECT_EQ(call({"--out", none, "--sample", "1"}).status, 2);
  EXPECT_EQ(call({"--out", none, "--shard", "1/2", "--report", none}).status, 2) << "of a part";
  for (const char* shard : {"0/3", "4/3", "1", "1/", "/3", "-1/3", "1/-3", "1/3x", "a/b", ""}) {
    const ToolResult result = call({"--out", none, "--shard", shard});
    EXPECT_NE(result.status, 0) << shard;
    EXPECT_FALSE(fs::exists(none)) << shard;
  }
}

/// Starts a shard and kills it when its file has so many lines. Returns the status of the process.
int run_and_kill(const fs::path& file, std::size_t lines) {
  const pid_t child = ::fork();
  if (child == 0) {
    const int null = ::open("/dev/null", O_WRONLY);
    ::dup2(null, 1);
    ::dup2(null, 2);
    ::execl(program, program, "stability-map", "--samples", "300", "--shard", "2/3", "--out", file.c_str(),
            nullptr);
    ::_exit(127);
  }
  int status = 0;
  for (;;) {
    const std::string content = content_of(file);
    if (static_cast<std::size_t>(std::ranges::count(content, '\n')) >= lines) ::kill(child, SIGKILL);
    if (::waitpid(child, &status, WNOHANG) == child) return status;
    ::usleep(1000);
  }
}

TEST_F(Shards, AKilledOneIsContinued) {
  const fs::path file = directory() / "killed.csv", reference = directory() / "reference.csv";
  ASSERT_TRUE(call({"--samples", "300", "--shard", "2/3", "--out", reference.string()}).ok());
  for (const std::size_t lines : {4u, 9u}) {
    const int status = run_and_kill(file, lines);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
    const std::string killed = content_of(file);
    ASSERT_LT(killed.size(), content_of(reference).size());
    EXPECT_EQ(killed, content_of(reference).substr(0, killed.size()));
    fs::resize_file(file, killed.size() - 7);  // torn
  }
  const ToolResult rest = call({"--samples", "300", "--shard", "2/3", "--out", file.string()});
  ASSERT_TRUE(rest.ok()) << rest.output;
  EXPECT_THAT(rest.output, HasSubstr("of 100 samples")) << "progress";
  EXPECT_EQ(content_of(file), content_of(reference));
  // a whole file stays
  ASSERT_TRUE(call({"--samples", "300", "--shard", "2/3", "--out", file.string()}).ok());
  EXPECT_EQ(content_of(file), content_of(reference));
  // a torn head is replaced
  fs::resize_file(file, 20);
  ASSERT_TRUE(call({"--samples", "300", "--shard", "2/3", "--out", file.string()}).ok());
  EXPECT_EQ(content_of(file), content_of(reference));
}

TEST_F(Shards, RunAsASlurmArray) {
  const std::string script = std::string(GODOBJECT_MAP_JOBS) + "/slurm.sh";
  const auto task = [&](const std::string& id, const std::string& count, const std::string& shards) {
    return run_tool({"env", "SLURM_ARRAY_TASK_ID=" + id, "SLURM_ARRAY_TASK_COUNT=" + count,
                     "SHARDS=" + shards, script, program, directory().string(), "1",
                     std::to_string(samples)});
  };
  for (const char* id : {"1", "3"}) ASSERT_TRUE(task(id, "3", "").ok());
  ASSERT_TRUE(task("2", "1", "3").ok()) << "one task again";
  const ToolResult result =
      merge({directory() / "shard-1.csv", directory() / "shard-2.csv", directory() / "shard-3.csv"});
  ASSERT_TRUE(result.ok()) << result.output;
  EXPECT_EQ(content_of(directory() / "merged.csv"), content_of(whole()));
  const ToolResult outside =
      run_tool({"env", "-u", "SLURM_ARRAY_TASK_ID", script, program, directory().string()});
  EXPECT_EQ(outside.status, 2);
  EXPECT_THAT(outside.output, HasSubstr("sbatch --array"));
}

TEST_F(Shards, RunInParallel) {
  if (!tool_exists("parallel")) GTEST_SKIP() << "GNU parallel is not installed (Debian package parallel)";
  const std::string script = std::string(GODOBJECT_MAP_JOBS) + "/parallel.sh";
  const ToolResult result =
      run_tool({script, program, directory().string(), "3", "1", std::to_string(samples)});
  ASSERT_TRUE(result.ok()) << result.output;
  EXPECT_EQ(content_of(directory() / "stability-map.csv"), content_of(whole()));
}

TEST_F(Shards, JobScriptsAreClean) {
  if (!tool_exists("shellcheck")) GTEST_SKIP() << "shellcheck is not installed";
  for (const char* name : {"/slurm.sh", "/parallel.sh"}) {
    const ToolResult result = run_tool({"shellcheck", std::string(GODOBJECT_MAP_JOBS) + name});
    EXPECT_TRUE(result.ok()) << result.output;
  }
}

}  // namespace
}  // namespace godobject::study::test_shards
