// Files that a thread writes: stalled, full, removed and unreadable ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "platform/rt/background_file.h"
#include "tests/support/program.h"

namespace godobject::test::test_background_file {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::IsEmpty;
using Clock = BackgroundFile::Clock;

constexpr std::size_t room = 1 << 16;

class BackgroundFiles : public ProgramTest {
 protected:
  std::string fifo() const {
    const std::string name = path("fifo");
    EXPECT_EQ(mkfifo(name.c_str(), 0600), 0);
    return name;
  }
};

TEST_F(BackgroundFiles, HasAllThatWasWritten) {
  std::string expected;
  BackgroundFile file(path("file"), room);
  for (int i = 0; i < 20'000; ++i) {
    const std::string line = "line " + std::to_string(i) + "\n";
    ASSERT_TRUE(file.write(line, milliseconds(60'000))) << "it waits for room";
    expected += line;
  }
  const BackgroundFile::Result result = file.close(Clock::now() + milliseconds(60'000));
  EXPECT_THAT(result.why, IsEmpty());
  EXPECT_EQ(result.lost_lines, 0u);
  EXPECT_EQ(read_file(path("file")), expected);
}

TEST_F(BackgroundFiles, NobodyWhoReadsKeepsNobody) {
  BackgroundFile file(fifo(), room);
  const Clock::time_point begin = Clock::now();
  for (int i = 0; i < 10; ++i) file.write("a line\n");
  EXPECT_FALSE(file.write(std::string(2 * room, '\n'))) << "no room: all of it is left out";
  const BackgroundFile::Result result = file.close(Clock::now() + milliseconds(100));
  EXPECT_LT(Clock::now() - begin, milliseconds(1500));
  EXPECT_THAT(result.why, HasSubstr("accepted no more"));
  EXPECT_EQ(result.lost_lines, 10 + 2 * room);
}

TEST_F(BackgroundFiles, AFileThatTakesNothingIsGivenUp) {
  BackgroundFile file(fifo(), room);
  EXPECT_TRUE(file.write("a line\n", milliseconds(50)));
  EXPECT_FALSE(file.write(std::string(room, '\n'), milliseconds(50)));
  EXPECT_FALSE(file.write("a line\n", milliseconds(60'000))) << "and not waited for again";
  EXPECT_THAT(file.close(Clock::now()).why, HasSubstr("accepted no bytes for 50 ms"));
}

TEST_F(BackgroundFiles, SaysWhyNot) {
  BackgroundFile nowhere(path("no/such/folder"), room);
  EXPECT_THAT(nowhere.close(Clock::now() + milliseconds(10'000)).why, HasSubstr("No such file"));
  BackgroundFile full("/dev/full", room);
  full.write("one\ntwo\n");
  const BackgroundFile::Result result = full.close(Clock::now() + milliseconds(10'000));
  EXPECT_THAT(result.why, HasSubstr("No space left"));
  EXPECT_EQ(result.lost_lines, 2u);
}

/// Limits the size of files, as a full disk does, until it is destroyed.
class SizeLimit {
 public:
  explicit SizeLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit lowered{.rlim_cur = bytes, .rlim_max = before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &lowered);
  }
  ~SizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }
  SizeLimit(const SizeLimit&) = delete;
  SizeLimit& operator=(const SizeLimit&) = delete;

 private:
  rlimit before_{};
};

/// Lines 0, 1, ... in order.
std::string numbered_lines(int begin, int end) {
  std::string text;
  for (int i = begin; i < end; ++i) text += "line " + std::to_string(i) + "\n";
  return text;
}

TEST_F(BackgroundFiles, AFullDiskThatHasSpaceAgainLosesNothing) {
  BackgroundFile file(path("file"), room);
  {
    const SizeLimit limit(1003);
    ASSERT_TRUE(file.write(numbered_lines(0, 1000)));
    for (int i = 0; i < 1000 && read_file(path("file")).size() < 1003; ++i)
      std::this_thread::sleep_for(milliseconds(10));
    std::this_thread::sleep_for(2 * BackgroundFile::gather_period);
    ASSERT_EQ(read_file(path("file")).size(), 1003u);
    ASSERT_TRUE(file.write(numbered_lines(1000, 1010)));
  }
  const BackgroundFile::Result result = file.close(Clock::now() + milliseconds(10'000));
  EXPECT_THAT(result.why, IsEmpty());
  EXPECT_EQ(result.lost_lines, 0u);
  EXPECT_EQ(read_file(path("file")), numbered_lines(0, 1010));
}

TEST_F(BackgroundFiles, AFullDiskEndsWithAWholeLineAndTheOthersAreCounted) {
  const SizeLimit limit(1003);
  BackgroundFile file(path("file"), room);
  ASSERT_TRUE(file.write(numbered_lines(0, 1000)));
  const BackgroundFile::Result result = file.close(Clock::now() + milliseconds(10'000));
  EXPECT_THAT(result.why, HasSubstr("File too large"));
  const std::string text = read_file(path("file"));
  const int num_lines = static_cast<int>(std::ranges::count(text, '\n'));
  EXPECT_GT(text.size(), 990u);
  EXPECT_EQ(text, numbered_lines(0, num_lines));
  EXPECT_EQ(result.lost_lines, static_cast<std::uint64_t>(1000 - num_lines));
  EXPECT_EQ(result.written_bytes, text.size());
}

TEST_F(BackgroundFiles, ARemovedFolderIsWrittenAgain) {
  const std::string folder = path("out"), name = folder + "/file";
  std::filesystem::create_directory(folder);
  BackgroundFile file(name, room);
  ASSERT_TRUE(file.write(numbered_lines(0, 1000)));
  for (int i = 0; i < 1000 && !std::filesystem::exists(name); ++i)
    std::this_thread::sleep_for(milliseconds(10));
  std::filesystem::remove_all(folder);
  ASSERT_TRUE(file.write(numbered_lines(1000, 1010)));
  EXPECT_THAT(file.close(Clock::now() + milliseconds(10'000)).why, IsEmpty());
  EXPECT_EQ(read_file(name), numbered_lines(0, 1010));
}

TEST_F(BackgroundFiles, ARemovedFileWhoseNameIsTakenIsLost) {
  const std::string name = path("file");
  BackgroundFile file(name, room);
  ASSERT_TRUE(file.write(numbered_lines(0, 1000)));
  for (int i = 0; i < 1000 && read_file(name).empty(); ++i) std::this_thread::sleep_for(milliseconds(10));
  std::filesystem::remove(name);
  write("file", "of another program");
  const BackgroundFile::Result result = file.close(Clock::now() + milliseconds(10'000));
  EXPECT_THAT(result.why, HasSubstr("was removed, and cannot be created again: File exists"));
  EXPECT_EQ(result.lost_lines, 1000u);
  EXPECT_EQ(read_file(name), "of another program");
}

}  // namespace
}  // namespace godobject::test::test_background_file
