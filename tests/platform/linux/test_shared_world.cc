// The shared memory of a slow simulation: whole packets alone, names, and leftovers of killed runs.
#include "platform/linux/shared_world.h"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <utility>

namespace godobject::test_shared_world {
namespace {

using testing::HasSubstr;

std::string name_of_test() { return "godobject-test-" + std::to_string(getpid()); }

/// The other simulation: its own mapping of the segment.
class Mapped {
 public:
  explicit Mapped(const std::string& name) {
    const int fd = shm_open(("/" + name).c_str(), O_RDWR, 0);
    EXPECT_GE(fd, 0);
    segment_ = static_cast<WorldSegment*>(
        mmap(nullptr, sizeof(WorldSegment), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0));
    close(fd);
  }
  ~Mapped() { munmap(segment_, sizeof(WorldSegment)); }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  WorldSegment* operator->() { return segment_; }

  void write(const WorldPacket& packet) {
    segment_->world_sequence |= 1;
    segment_->world = packet;
    segment_->world_crc = crc32({reinterpret_cast<const char*>(&packet), sizeof packet});
    ++segment_->world_sequence;
  }

 private:
  WorldSegment* segment_;
};

TEST(SharedWorld, HasThePagesLayout) {  // docs/how-to/slow-world.md
  EXPECT_EQ(sizeof(WorldSegment), 2104u);
  EXPECT_EQ(offsetof(WorldSegment, world_sequence), 1320u);
  EXPECT_EQ(sizeof(ToolPacket), 1248u);
  EXPECT_EQ(sizeof(WorldPacket), 768u);
}

TEST(SharedWorld, PassesWholePacketsOnce) {
  SharedWorld shared;
  ASSERT_EQ(shared.open(name_of_test(), 6, 1e-3), "");
  Mapped other(name_of_test());
  EXPECT_EQ(other->state, std::uint32_t{WorldSegment::runs});
  EXPECT_EQ(other->num_planes, 6u);
  WorldPacket packet;
  EXPECT_FALSE(shared.receive(packet));
  other.write({.number = 7});
  ASSERT_TRUE(shared.receive(packet));
  EXPECT_EQ(packet.number, 7u);
  EXPECT_FALSE(shared.receive(packet));

  ++other->world_sequence;  // it writes
  other->world.number = 8;
  EXPECT_FALSE(shared.receive(packet));
  ++other->world_sequence;  // without a new CRC
  EXPECT_FALSE(shared.receive(packet));
  EXPECT_EQ(shared.broken(), 1u);
  EXPECT_FALSE(shared.receive(packet));
  EXPECT_EQ(shared.broken(), 1u);

  const std::uint64_t sequence = std::exchange(other->world_sequence, 0);  // written byte by byte
  EXPECT_FALSE(shared.receive(packet));
  EXPECT_EQ(shared.broken(), 1u);
  other->world_sequence = sequence;

  ToolPacket tool;
  tool.number = 3;
  shared.send(tool);
  EXPECT_EQ(other->tool_sequence, 2u);
  EXPECT_EQ(other->tool.number, 3u);
}

TEST(SharedWorld, RefusesNamesAndSegmentsInUse) {
  for (const char* name : {"", "a/b", "../x", ".x", "a b", "\xc3\xa4"})
    EXPECT_THAT(SharedWorld().open(name, 6, 1e-3), HasSubstr("is no name")) << name;
  EXPECT_THAT(SharedWorld().open(std::string(61, 'x'), 6, 1e-3), HasSubstr("is no name"));
  SharedWorld first;
  ASSERT_EQ(first.open(name_of_test(), 6, 1e-3), "");
  EXPECT_THAT(SharedWorld().open(name_of_test(), 6, 1e-3), HasSubstr("end the program that has it"));
}

TEST(SharedWorld, TakesOverTheNameOfAKilledRun) {
  const std::string name = name_of_test();
  const pid_t child = fork();
  if (child == 0) {
    auto* const lost = new SharedWorld;
    _exit(lost->open(name, 6, 1e-3).empty() ? 0 : 1);  // without its destructor, as if killed
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_EQ(status, 0);
  const int left = shm_open(("/" + name).c_str(), O_RDONLY, 0);
  EXPECT_GE(left, 0);
  close(left);
  {
    SharedWorld next;
    EXPECT_EQ(next.open(name, 6, 1e-3), "");
  }
  EXPECT_EQ(shm_open(("/" + name).c_str(), O_RDONLY, 0), -1);
}

}  // namespace
}  // namespace godobject::test_shared_world
