// POSIX shared memory between a run and another simulation, with a seqlock in each direction: no end waits
// for the other (docs/how-to/slow-world.md).
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include "hal/base/crc32.h"
#include "platform/session/world.h"

namespace godobject {

/// Segment in memory, little-endian. A block is whole if its sequence is even, and unchanged by the end of
/// the copy. Its writer makes the sequence odd before it writes; sequences rise.
struct WorldSegment {
  static constexpr std::uint32_t magic_of_segments = 0x31575347, version_of_segments = 1;  // "GSW1"
  enum State : std::uint32_t { preparing, runs, has_ended };

  std::uint32_t magic = 0, version = 0;
  std::uint32_t size = 0;        // of the segment, bytes
  std::uint32_t num_planes = 0;  // that a packet may have
  std::uint32_t state = preparing;
  std::uint32_t owner = 0;  // process id of the run
  double step_s = 0;
  std::array<std::uint64_t, 4> reserved{};
  std::uint64_t tool_sequence = 0;
  ToolPacket tool{};
  std::uint64_t world_sequence = 0;
  WorldPacket world{};
  std::uint32_t world_crc = 0;  // CRC-32 of `world`
  std::uint32_t reserved_end = 0;
};
static_assert(offsetof(WorldSegment, tool_sequence) == 64 && offsetof(WorldSegment, tool) == 72);
static_assert(offsetof(WorldSegment, world_sequence) == 72 + sizeof(ToolPacket));
static_assert(std::endian::native == std::endian::little);

class SharedWorld final : public WorldLink {
 public:
  SharedWorld() = default;
  SharedWorld(const SharedWorld&) = delete;
  SharedWorld& operator=(const SharedWorld&) = delete;
  /// Marks the segment as ended and removes its name.
  ~SharedWorld() override {
    if (segment_ == nullptr) return;
    word(segment_->state).store(WorldSegment::has_ended, std::memory_order_release);
    munmap(segment_, sizeof(WorldSegment));
    shm_unlink(name_.c_str());
  }

  /// Makes the segment. num_planes: planes of the scene. step_s: its step. Returns why this failed; empty on
  /// success.
  std::string open(const std::string& name, std::size_t num_planes, double step_s);

  bool receive(WorldPacket& packet) noexcept override {
    const std::uint64_t sequence = word(segment_->world_sequence).load(std::memory_order_acquire);
    if (sequence <= received_ || sequence % 2 != 0) return false;
    load(segment_->world, packet);
    const std::uint32_t crc = word(segment_->world_crc).load(std::memory_order_acquire);
    if (word(segment_->world_sequence).load(std::memory_order_relaxed) != sequence) return false;
    received_ = sequence;
    if (crc == crc32({reinterpret_cast<const char*>(&packet), sizeof packet})) return true;
    ++broken_;
    return false;
  }

  void send(const ToolPacket& packet) noexcept override {
    const auto sequence = word(segment_->tool_sequence);
    const std::uint64_t next = (sequence.load(std::memory_order_relaxed) | 1) + 1;
    sequence.store(next - 1, std::memory_order_relaxed);
    store(packet, segment_->tool);
    sequence.store(next, std::memory_order_release);
  }

  /// Returns the packets whose CRC was wrong.
  std::uint64_t broken() const noexcept { return broken_; }
  /// Returns the name in /dev/shm, with a slash before it.
  const std::string& name() const noexcept { return name_; }

 private:
  template <class T>
  static std::atomic_ref<T> word(T& value) noexcept {
    return std::atomic_ref<T>(value);
  }
  template <class T>
  using Words = std::array<std::uint64_t, sizeof(T) / sizeof(std::uint64_t)>;
  template <class T>
  static std::atomic_ref<std::uint64_t> word_of(T& packet, std::size_t i) noexcept {
    static_assert(sizeof(T) % sizeof(std::uint64_t) == 0 && alignof(T) == alignof(std::uint64_t));
    return word(reinterpret_cast<std::uint64_t*>(&packet)[i]);
  }
  /// Copies a packet out of the segment. Acquire: the sequence is read again after all words.
  template <class T>
  static void load(T& shared, T& packet) noexcept {
    Words<T> words;
    for (std::size_t i = 0; i < words.size(); ++i)
      words[i] = word_of(shared, i).load(std::memory_order_acquire);
    std::memcpy(static_cast<void*>(&packet), words.data(), sizeof packet);
  }
  /// Copies a packet into the segment. Release: the odd sequence is written before all words.
  template <class T>
  static void store(const T& packet, T& shared) noexcept {
    Words<T> words;
    std::memcpy(words.data(), &packet, sizeof packet);
    for (std::size_t i = 0; i < words.size(); ++i)
      word_of(shared, i).store(words[i], std::memory_order_release);
  }
  static bool is_left_behind(const std::string& path);

  WorldSegment* segment_ = nullptr;
  std::string name_;
  std::uint64_t received_ = 0, broken_ = 0;
};

/// True if the segment is one whose run was killed.
inline bool SharedWorld::is_left_behind(const std::string& path) {
  const int fd = shm_open(path.c_str(), O_RDONLY, 0);
  if (fd < 0) return false;
  WorldSegment found;
  const bool is_one = pread(fd, &found, sizeof found, 0) == sizeof found &&
                      found.magic == WorldSegment::magic_of_segments && found.owner > 0;
  ::close(fd);
  return is_one && kill(static_cast<pid_t>(found.owner), 0) != 0 && errno == ESRCH;
}

inline std::string SharedWorld::open(const std::string& name, std::size_t num_planes, double step_s) {
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  constexpr std::size_t max_name = 60;
  const std::string option = "--world: '" + name + "' ";
  if (name.empty() || name.size() > max_name || name.find_first_not_of(letters) != std::string::npos ||
      name.front() == '.')
    return option + "is no name of shared memory: give 1 to 60 letters, digits, '.', '_' and '-'";
  const std::string path = "/" + name;
  constexpr int flags = O_RDWR | O_CREAT | O_EXCL;
  int fd = shm_open(path.c_str(), flags, S_IRUSR | S_IWUSR);
  if (fd < 0 && errno == EEXIST && is_left_behind(path)) {
    shm_unlink(path.c_str());
    fd = shm_open(path.c_str(), flags, S_IRUSR | S_IWUSR);
  }
  const auto failed = [&] {
    return option + "cannot be made: " + std::generic_category().message(errno) +
           ": give another name, or end the program that has it";
  };
  if (fd < 0) return failed();
  void* const memory =
      ftruncate(fd, sizeof(WorldSegment)) == 0
          ? mmap(nullptr, sizeof(WorldSegment), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd, 0)
          : MAP_FAILED;
  const std::string why_not = memory == MAP_FAILED ? failed() : "";
  ::close(fd);
  if (memory == MAP_FAILED) {
    shm_unlink(path.c_str());
    return why_not;
  }
  name_ = path;
  segment_ = new (memory) WorldSegment{.magic = WorldSegment::magic_of_segments,
                                       .version = WorldSegment::version_of_segments,
                                       .size = sizeof(WorldSegment),
                                       .num_planes = static_cast<std::uint32_t>(num_planes),
                                       .owner = static_cast<std::uint32_t>(getpid()),
                                       .step_s = step_s};
  word(segment_->state).store(WorldSegment::runs, std::memory_order_release);
  return "";
}

}  // namespace godobject
