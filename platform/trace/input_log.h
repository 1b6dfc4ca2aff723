// Input logs: every input of engine and rig in each cycle of a run, with outputs, hashes and states.
// `godobject replay` repeats the run from them bit for bit. A file is a list of chunks, so it is readable up
// to a cut, and again after a damaged chunk. Numbers are little-endian:
//   file     "godolog1", where 1 is the number of the format, then chunks
//   chunk    marker, kind, bytes of the payload (u32 each), the payload, and the CRC-32 of all from kind on
//   head     the members of InputLogHead, texts with their length (u32) before them
//   links    number of the first event (u64), their number (u32), then events of the rig: see put_link()
//   rows     their number (u32), then rows; the first one follows a row of zeros
//   state    cycle and hash of the state (u64), then the engine's snapshot as one row
//   end      number of rows that were lost (u64)
//   row      a bit for each word that differs from the row before, then these words (u64)
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/device/link_record.h"
#include "platform/scene/toml.h"
#include "platform/session/record.h"

namespace godobject {

/// Ending of the names of input logs.
inline constexpr std::string_view input_log_ending = ".godo";

/// True if a file of this name is an input log.
inline bool is_input_log(std::string_view path) noexcept { return path.ends_with(input_log_ending); }

/// Largest number of rows in a chunk, and their longest time, s: later rows are in memory only.
inline constexpr std::uint64_t input_log_chunk_rows = 128;
inline constexpr double input_log_chunk_s = 0.2;

/// Returns the number of cycles from one state to the next: a second, but at most 1000 of them. step: s.
constexpr std::uint64_t cycles_between_states(double step) noexcept {
  return std::clamp<std::uint64_t>(static_cast<std::uint64_t>(1 / step + 0.5), 1, 1000);
}

// Beginning of a file, and of each chunk.
inline constexpr std::string_view input_log_magic = "godolog1", input_log_marker = "CHNK";
enum class InputLogKind : std::uint32_t { head = 1, rows, state, end, links };

/// Numbers of elements of the vectors of a record.
struct InputLogSizes {
  std::uint32_t bodies = 0, targets = 0, device_q = 0, drives = 0, joint_q = 0;
};

/// Returns the sizes of a record; input logs have no others of its vectors.
InputLogSizes sizes_of(const CycleRecord& record);
/// Returns a record of these sizes.
CycleRecord record_of(const InputLogSizes& sizes);

/// A file that the scene refers to.
struct InputLogFile {
  std::string name;  // relative to the folder of the scene
  std::string bytes;
};

/// Beginning of an input log: the whole configuration of the engine.
struct InputLogHead {
  std::string version;            // of the program that recorded
  std::string scene_file, scene;  // name of the file, and all values in effect as its text
  std::vector<InputLogFile> files;
  std::string composition;  // name of the engine's composition
  std::uint64_t snapshot_bytes = 0;
  std::int64_t log_origin_ns = 0;  // added to times of the buses in traces
  InputLogSizes sizes{};
  // The next two are empty in older files.
  std::string revision{};              // of the sources of that program
  std::vector<double> device_start{};  // coordinates of the device's joints at the start of the motion
};

/// State of the engine after a cycle.
struct EngineState {
  std::uint64_t cycle = 0, hash = 0;
  std::vector<std::byte> bytes{};  // see Engine::save()
};

// ---- rows of words ---------------------------------------------------------------------------------

/// Returns the number of words of a row. Outputs of the bodies come last.
std::size_t num_words(const InputLogSizes& sizes) noexcept;
std::size_t first_output_word(const InputLogSizes& sizes) noexcept;
/// Returns the name of an output word: its body and its quantity, "tool.vx".
/// bodies: names of the bodies.
std::string output_name(const InputLogSizes& sizes, std::span<const std::string> bodies, std::size_t word);

/// Writes a record as words. words: num_words() of its sizes.
void to_words(const CycleRecord& record, std::span<std::uint64_t> words) noexcept;
/// Reads a record from words. Returns false if it names a body that is not there.
[[nodiscard]] bool from_words(std::span<const std::uint64_t> words, CycleRecord& record) noexcept;

// ---- writing ---------------------------------------------------------------------------------------

/// Encodes an input log. Not for the real-time thread.
class InputLogWriter {
 public:
  struct Chunk {
    std::string_view bytes;  // valid during the call
    std::uint64_t num_rows = 0;
    bool is_state = false;  // true: replay can begin here
  };
  using Sink = std::function<void(const Chunk& chunk)>;

  /// Writes the head, and the row of the start, whose cycle is 0.
  InputLogWriter(InputLogHead head, const CycleRecord& start, Sink sink);

  /// Adds a row of the sizes of the start.
  void add(const CycleRecord& record);
  /// Adds the state after the last added row.
  void add(const EngineState& state);
  /// Adds an event of the rig. All events before the command of a row come before the row.
  void add(const LinkEvent& event);
  /// Writes the events and rows that wait for a full chunk.
  void flush();
  /// Returns the last chunk of a log. lost: number of rows that were lost for it.
  static std::string end_of(std::uint64_t lost);

 private:
  void write(InputLogKind kind, std::uint64_t rows, bool is_state);
  void flush_links();

  Sink sink_;
  std::vector<std::uint64_t> row_, before_;
  std::string rows_, payload_, chunk_;
  std::uint64_t num_rows_ = 0;    // in rows_
  double t_ = 0, t_flushed_ = 0;  // time of the last row, and of the last one in a chunk, s
  std::string links_;
  std::uint64_t num_links_ = 0, written_links_ = 0;  // in links_; in all chunks before
  Nanoseconds t_link_ns_ = 0;                        // time of the latest event in links_
};

/// Chunks of the last seconds before a fault, in memory of a fixed size.
class LastChunks {
 public:
  /// Allocates and touches the memory for at least `rows` rows, but at most max_bytes.
  /// state_every: number of rows from one state to the next.
  LastChunks(const InputLogSizes& sizes, std::uint64_t snapshot_bytes, std::uint64_t rows,
             std::uint64_t state_every);
  static constexpr std::size_t max_bytes = 64u << 20;

  /// Adds a chunk, in place of the oldest ones. Chunks before the first state are not kept.
  void add(const InputLogWriter::Chunk& chunk);
  /// Passes all chunks, oldest first, as pieces of bytes.
  void each(const std::function<void(std::string_view)>& use) const;
  /// Number of rows of these chunks.
  std::uint64_t num_rows() const noexcept;
  /// True if max_bytes hold fewer rows than were wanted.
  bool is_bounded() const noexcept { return is_bounded_; }

 private:
  /// A state and the rows after it.
  struct Group {
    std::uint64_t begin = 0, rows = 0;  // begin: number of bytes that were added before
  };
  std::size_t num_states_;
  std::vector<char> memory_;
  std::vector<Group> groups_;
  std::uint64_t end_ = 0;  // number of bytes added so far
  bool is_bounded_ = false;
};

// ---- reading ---------------------------------------------------------------------------------------

/// Bytes of a file, mapped into memory.
class MappedFile {
 public:
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  /// Returns why the file cannot be read; empty if it can.
  const std::string& why_not() const noexcept { return why_not_; }
  std::string_view bytes() const noexcept {
    return memory_ != nullptr ? std::string_view(memory_, size_) : "";
  }

 private:
  const char* memory_ = nullptr;
  std::size_t size_ = 0;
  std::string why_not_;
};

/// Parses the scene of a log, whose files are written to a temporary folder meanwhile.
LoadResult parse_scene_of(const InputLogHead& head, const FaultChecks& checks);

/// Decodes an input log in memory, which must outlive it.
class InputLogReader {
 public:
  enum class Item : std::uint8_t { row, state, links, end, cut };

  /// Reads the head and the start; see why_not().
  explicit InputLogReader(std::string_view file);

  /// Returns why the file cannot be read; empty if it can.
  const std::string& why_not() const noexcept { return why_not_; }
  const InputLogHead& head() const noexcept { return head_; }
  /// Record of the start, whose cycle is 0.
  const CycleRecord& start() const noexcept { return start_; }

  /// Returns the kind of the next item, which row(), state() or links() then has. The last item is the end,
  /// or the cut of a file without one.
  Item next();
  const CycleRecord& row() const noexcept { return row_; }
  std::span<const std::uint64_t> words() const noexcept { return words_; }
  const EngineState& state() const noexcept { return state_; }
  /// Events of the rig, and the number of the first one.
  std::span<const LinkEvent> links() const noexcept { return links_; }
  std::uint64_t first_link() const noexcept { return first_link_; }
  std::uint64_t lost_rows() const noexcept { return lost_; }
  /// Number of bytes of damaged chunks so far; those after the last whole chunk do not count.
  std::uint64_t damaged_bytes() const noexcept { return damaged_; }
  /// Continues with the last state up to a cycle, or else with the first row. Returns the cycle of the state
  /// or of the start.
  std::uint64_t continue_at(std::uint64_t cycle);
  /// Continues with the first item after the start.
  void begin_again() noexcept;

 private:
  struct Chunk {
    InputLogKind kind{};
    std::string_view payload;
  };
  bool next_chunk(Chunk& chunk);
  bool read_head(std::string_view payload);
  bool read_state(std::string_view payload);
  bool read_links(std::string_view payload);
  bool next_row();

  std::string_view file_;
  std::size_t at_ = 0, first_ = 0;  // positions of the next chunk, and of the first after the start
  std::uint64_t damaged_ = 0, lost_ = 0;
  std::string_view rows_;  // undecoded rows of the present chunk
  std::uint32_t rows_left_ = 0;
  InputLogHead head_;
  CycleRecord start_, row_;
  std::vector<std::uint64_t> words_, state_words_;
  EngineState state_;
  std::vector<LinkEvent> links_;
  std::uint64_t first_link_ = 0;
  std::string why_not_;
};

}  // namespace godobject
