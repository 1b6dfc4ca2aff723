// Reading of input logs: files in memory, and the scene of a log.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "hal/base/crc32.h"
#include "platform/trace/input_log.h"
#include "platform/trace/log_bytes.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t chunk_head_bytes = 12, crc_bytes = 4;
// Bounds of a readable head, far above those of any composition.
constexpr std::uint32_t max_of_a_size = 1u << 16;
constexpr std::uint64_t max_snapshot_bytes = 1u << 28;

std::uint64_t word_at(std::string_view bytes) {
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < 8; ++i) word |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  return word;
}

/// Reads a row into `row`, which has the row before. Returns false if the bytes end within it.
bool take_row(std::string_view& bytes, std::span<std::uint64_t> row) {
  const std::size_t mask_bytes = (row.size() + 7) / 8;
  if (bytes.size() < mask_bytes) return false;
  const std::string_view mask = bytes.substr(0, mask_bytes);
  bytes.remove_prefix(mask_bytes);
  for (std::size_t i = 0; i < row.size(); ++i) {
    if ((static_cast<unsigned char>(mask[i / 8]) >> (i % 8) & 1) == 0) continue;
    if (bytes.size() < 8) return false;
    row[i] = word_at(bytes);
    bytes.remove_prefix(8);
  }
  return true;
}

/// True if a file of this name stays in the folder that it is written into.
bool is_below(const fs::path& name) {
  return !name.empty() && name.is_relative() && std::ranges::find(name, "..") == name.end();
}

}  // namespace

MappedFile::MappedFile(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat about {};
  if (file < 0 || fstat(file, &about) != 0) why_not_ = std::generic_category().message(errno);
  else if (!S_ISREG(about.st_mode)) why_not_ = "is no regular file";
  else if (about.st_size > 0) {
    size_ = static_cast<std::size_t>(about.st_size);
    void* const memory = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    if (memory != MAP_FAILED) memory_ = static_cast<const char*>(memory);
    else why_not_ = std::generic_category().message(errno);
  }
  if (file >= 0) ::close(file);
}

MappedFile::~MappedFile() {
  if (memory_ != nullptr) munmap(const_cast<char*>(memory_), size_);
}

InputLogReader::InputLogReader(std::string_view file) : file_(file) {
  if (!file.starts_with(input_log_magic.substr(0, input_log_magic.size() - 1)))
    why_not_ = "is no input log: it does not begin with \"" + std::string(input_log_magic) +
               "\"; record one with run --record FILE" + std::string(input_log_ending);
  else if (!file.starts_with(input_log_magic))
    why_not_ = "has another format than \"" + std::string(input_log_magic) +
               "\": replay it with the version that recorded it";
  if (!why_not_.empty()) return;
  at_ = input_log_magic.size();
  Chunk chunk;
  if (!next_chunk(chunk) || chunk.kind != InputLogKind::head || damaged_ > 0 || !read_head(chunk.payload)) {
    why_not_ = "has no head: it is damaged, or was cut at its beginning";
    return;
  }
  row_ = record_of(head_.sizes);
  words_.resize(num_words(head_.sizes));
  if (next() != Item::row || row_.cycle != 0) {
    why_not_ = "has no start: it is damaged, or was cut at its beginning";
    return;
  }
  start_ = row_;
  first_ = at_;
}

InputLogReader::Item InputLogReader::next() {
  for (Chunk chunk;;) {
    if (next_row()) return Item::row;
    if (!next_chunk(chunk)) return Item::cut;
    if (chunk.kind == InputLogKind::rows) {
      LogBytes bytes(chunk.payload);
      rows_left_ = bytes.number<std::uint32_t>();
      rows_ = bytes.rest();
      std::ranges::fill(words_, 0);
    } else if (chunk.kind == InputLogKind::state) {
      if (read_state(chunk.payload)) return Item::state;
      damaged_ += chunk.payload.size();
    } else if (chunk.kind == InputLogKind::links) {
      if (read_links(chunk.payload)) return Item::links;
      damaged_ += chunk.payload.size();
    } else if (chunk.kind == InputLogKind::end) {
      lost_ = LogBytes(chunk.payload).number<std::uint64_t>();
      return Item::end;
    }
  }
}

/// Decodes the next row of the present chunk. Returns false if there is none.
bool InputLogReader::next_row() {
  if (rows_left_ == 0) return false;
  --rows_left_;
  if (take_row(rows_, words_) && from_words(words_, row_)) return true;
  damaged_ += rows_.size();
  rows_left_ = 0;
  return false;
}

/// Finds the next whole chunk. Returns false at the end of the file.
bool InputLogReader::next_chunk(Chunk& chunk) {
  const std::size_t begin = at_;
  while (at_ < file_.size()) {
    LogBytes bytes(file_.substr(at_));
    const bool is_marked = bytes.text(input_log_marker.size()) == input_log_marker;
    const std::string_view checked = bytes.rest();
    chunk.kind = bytes.number<InputLogKind>();
    chunk.payload = bytes.text();
    const auto crc = bytes.number<std::uint32_t>();
    if (is_marked && bytes.is_complete() &&
        crc == crc32(checked.substr(0, chunk_head_bytes - input_log_marker.size() + chunk.payload.size()))) {
      damaged_ += at_ - begin;
      at_ += chunk_head_bytes + chunk.payload.size() + crc_bytes;
      return true;
    }
    at_ = std::min(file_.find(input_log_marker, at_ + 1), file_.size());
  }
  return false;
}

bool InputLogReader::read_head(std::string_view payload) {
  LogBytes bytes(payload);
  for (std::string* text : {&head_.version, &head_.scene_file, &head_.scene, &head_.composition})
    *text = bytes.text();
  head_.snapshot_bytes = bytes.number<std::uint64_t>();
  head_.log_origin_ns = bytes.number<std::int64_t>();
  InputLogSizes& n = head_.sizes;
  for (std::uint32_t* size : {&n.bodies, &n.targets, &n.device_q, &n.drives, &n.joint_q}) {
    *size = bytes.number<std::uint32_t>();
    if (*size > max_of_a_size) return false;
  }
  for (auto left = bytes.number<std::uint32_t>(); left > 0 && bytes.is_complete(); --left) {
    InputLogFile file;
    file.name = bytes.text();
    file.bytes = bytes.text();
    head_.files.push_back(std::move(file));
  }
  if (bytes.is_complete() && !bytes.rest().empty()) {  // older files end here
    head_.revision = bytes.text();
    for (auto left = bytes.number<std::uint32_t>(); left > 0 && bytes.is_complete(); --left)
      head_.device_start.push_back(std::bit_cast<double>(bytes.number<std::uint64_t>()));
  }
  return bytes.is_complete() && head_.snapshot_bytes % sizeof(std::uint64_t) == 0 &&
         head_.snapshot_bytes <= max_snapshot_bytes;
}

bool InputLogReader::read_state(std::string_view payload) {
  LogBytes bytes(payload);
  state_.cycle = bytes.number<std::uint64_t>();
  state_.hash = bytes.number<std::uint64_t>();
  state_words_.assign(head_.snapshot_bytes / sizeof(std::uint64_t), 0);
  std::string_view row = bytes.rest();
  if (!bytes.is_complete() || !take_row(row, state_words_)) return false;
  state_.bytes.resize(head_.snapshot_bytes);
  std::ranges::copy(std::as_bytes(std::span(state_words_)), state_.bytes.begin());
  return true;
}

bool InputLogReader::read_links(std::string_view payload) {
  LogBytes bytes(payload);
  first_link_ = bytes.number<std::uint64_t>();
  const auto count = bytes.number<std::uint32_t>();
  links_.clear();
  Nanoseconds t = 0;
  while (links_.size() < count && bytes.is_complete()) {
    links_.push_back(take_link(bytes, t));
    if (links_.back().t_ns != 0) t = links_.back().t_ns;
  }
  return bytes.is_complete();
}

std::uint64_t InputLogReader::continue_at(std::uint64_t cycle) {
  begin_again();
  std::size_t found = first_;
  std::uint64_t found_cycle = 0;
  for (Chunk chunk; next_chunk(chunk);) {
    if (chunk.kind != InputLogKind::state) continue;
    const auto of_state = LogBytes(chunk.payload).number<std::uint64_t>();
    if (of_state > cycle) break;
    found_cycle = of_state;
    found = at_ - (chunk_head_bytes + chunk.payload.size() + crc_bytes);
  }
  damaged_ = 0;
  at_ = found;
  return found_cycle;
}

void InputLogReader::begin_again() noexcept {
  at_ = first_;
  rows_left_ = 0;
  damaged_ = 0;
}

LoadResult parse_scene_of(const InputLogHead& head, const FaultChecks& checks) {
  const std::string name = fs::path(head.scene_file).filename().string();
  if (head.files.empty()) return parse_scene(head.scene, name, checks);
  std::string folder = (fs::temp_directory_path() / "godobject-XXXXXX").string();
  LoadResult result;
  if (mkdtemp(folder.data()) == nullptr) {
    result.errors.push_back(folder + " cannot be created: " + std::generic_category().message(errno));
    return result;
  }
  std::error_code error;
  for (const InputLogFile& file : head.files) {
    if (!is_below(file.name)) continue;
    const fs::path path = fs::path(folder) / file.name;
    fs::create_directories(path.parent_path(), error);
    std::ofstream(path, std::ios::binary) << file.bytes;
  }
  result = parse_scene(head.scene, (fs::path(folder) / name).string(), checks);
  fs::remove_all(folder, error);
  return result;
}

}  // namespace godobject
