#include "platform/trace/input_log.h"

#include <algorithm>
#include <array>
#include <bit>
#include <type_traits>
#include <utility>

#include "hal/base/crc32.h"
#include "platform/trace/log_bytes.h"

namespace godobject {
namespace {

// ---- rows ------------------------------------------------------------------------------------------

/// Appends the words of a row that differ from the row before, after a bit for each word.
void put_row(std::string& out, std::span<const std::uint64_t> row, std::span<const std::uint64_t> before) {
  const std::size_t mask = out.size();
  out.append((row.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (row[i] == before[i]) continue;
    char& bits = out[mask + i / 8];
    bits = static_cast<char>(bits | (1 << (i % 8)));
    put(out, row[i]);
  }
}

// ---- records and words -----------------------------------------------------------------------------

constexpr std::size_t scalar_words = 17, input_words = 26;
constexpr std::array output_names{
    "x",           "y",           "z",           "qw",          "qx",          "qy",          "qz",
    "vx",          "vy",          "vz",          "wx",          "wy",          "wz",          "coupling.fx",
    "coupling.fy", "coupling.fz", "coupling.tx", "coupling.ty", "coupling.tz", "feedback.fx", "feedback.fy",
    "feedback.fz", "feedback.tx", "feedback.ty", "feedback.tz", "joint.fx",    "joint.fy",    "joint.fz",
    "joint.tx",    "joint.ty",    "joint.tz",    "contact.fx",  "contact.fy",  "contact.fz",  "contact.tx",
    "contact.ty",  "contact.tz"};

struct ToWords {
  std::uint64_t* next;

  template <class T>
  void operator()(const T& x) noexcept {
    if constexpr (std::is_same_v<T, double>) *next++ = std::bit_cast<std::uint64_t>(x);
    else *next++ = static_cast<std::uint64_t>(x);
  }
};

struct FromWords {
  const std::uint64_t* next;

  template <class T>
  void operator()(T& x) noexcept {
    if constexpr (std::is_same_v<T, double>) x = std::bit_cast<double>(*next++);
    else if constexpr (std::is_same_v<T, bool>) x = (*next++ & 1) != 0;
    else x = static_cast<T>(*next++);
  }
};

template <class Words, class V>
void each_vector(Words& words, V& v) noexcept {
  for (Eigen::Index i = 0; i < v.size(); ++i) words(v[i]);
}
template <class Words, class X>
void each_pose(Words& words, X& pose) noexcept {
  each_vector(words, pose.p);
  words(pose.q.w());
  words(pose.q.x());
  words(pose.q.y());
  words(pose.q.z());
}
template <class Words, class F>
void each_wrench(Words& words, F& wrench) noexcept {
  each_vector(words, wrench.f);
  each_vector(words, wrench.tau);
}

/// Visits all words of a record but that of the held body, in their order.
template <class Words, class Record>
void each_word(Words& words, Record& r) noexcept {
  words(r.cycle);
  words(r.state_hash);
  words(r.t);
  words(r.passed_s);
  words(r.t_bus_ns);
  words(r.motion_start_ns);
  words(r.fault);
  words(r.limited);
  words(r.rig_faults);
  words(r.engaged);
  each_wrench(words, r.hand_W);
  for (auto* numbers : {&r.device_q, &r.drive_torque, &r.drive_energy, &r.joint_q})
    for (auto& x : *numbers) words(x);
  for (auto& sample : r.samples) {
    words(sample.valid);
    words(sample.engaged);
    words(sample.clutch);
    each_pose(words, sample.target.X_WD);
    each_vector(words, sample.target.V_WD.v);
    each_vector(words, sample.target.V_WD.w);
    each_wrench(words, sample.F_WB);
    each_vector(words, sample.joint.q);
    each_vector(words, sample.joint.q_dot);
  }
  for (auto& body : r.bodies) {
    each_pose(words, body.X_WB);
    each_vector(words, body.V_WB.v);
    each_vector(words, body.V_WB.w);
    for (auto* wrench : {&body.coupling_B, &body.feedback_D, &body.joint_C, &body.contact_W})
      each_wrench(words, *wrench);
  }
}

std::string head_payload(const InputLogHead& head) {
  std::string out;
  for (const std::string* text : {&head.version, &head.scene_file, &head.scene, &head.composition})
    put_text(out, *text);
  put(out, head.snapshot_bytes);
  put(out, head.log_origin_ns);
  const InputLogSizes& n = head.sizes;
  for (const std::uint32_t size : {n.bodies, n.targets, n.device_q, n.drives, n.joint_q}) put(out, size);
  put(out, static_cast<std::uint32_t>(head.files.size()));
  for (const InputLogFile& file : head.files) {
    put_text(out, file.name);
    put_text(out, file.bytes);
  }
  put_text(out, head.revision);
  put(out, static_cast<std::uint32_t>(head.device_start.size()));
  for (const double q : head.device_start) put(out, std::bit_cast<std::uint64_t>(q));
  return out;
}

}  // namespace

InputLogSizes sizes_of(const CycleRecord& record) {
  const auto size = [](const auto& vector) { return static_cast<std::uint32_t>(vector.size()); };
  return {.bodies = size(record.bodies),
          .targets = size(record.targets),
          .device_q = size(record.device_q),
          .drives = size(record.drive_torque),
          .joint_q = size(record.joint_q)};
}

CycleRecord record_of(const InputLogSizes& sizes) {
  CycleRecord record;
  record.bodies.resize(sizes.bodies);
  record.samples.resize(sizes.bodies);
  record.targets.resize(sizes.targets);
  record.device_q.resize(sizes.device_q);
  record.drive_torque.resize(sizes.drives);
  record.drive_energy.resize(sizes.drives);
  record.joint_q.resize(sizes.joint_q);
  return record;
}

std::size_t first_output_word(const InputLogSizes& n) noexcept {
  return scalar_words + std::size_t{n.device_q} + std::size_t{2} * n.drives + n.joint_q +
         input_words * n.bodies;
}

std::size_t num_words(const InputLogSizes& n) noexcept {
  return first_output_word(n) + output_names.size() * n.bodies;
}

std::string output_name(const InputLogSizes& n, std::span<const std::string> bodies, std::size_t word) {
  const std::size_t output = word - first_output_word(n);
  return bodies[output / output_names.size()] + "." + output_names[output % output_names.size()];
}

void to_words(const CycleRecord& record, std::span<std::uint64_t> words) noexcept {
  words.front() = record.held ? *record.held + 1 : 0;
  ToWords to{words.data() + 1};
  each_word(to, record);
}

bool from_words(std::span<const std::uint64_t> words, CycleRecord& record) noexcept {
  record.held.reset();
  if (words.front() > record.bodies.size()) return false;
  if (words.front() > 0) record.held = words.front() - 1;
  FromWords from{words.data() + 1};
  each_word(from, record);
  return true;
}

// ---- writing ---------------------------------------------------------------------------------------

namespace {

void put_chunk(std::string& out, InputLogKind kind, std::string_view payload) {
  out += input_log_marker;
  const std::size_t begin = out.size();
  put(out, static_cast<std::uint32_t>(kind));
  put_text(out, payload);
  put(out, crc32(std::string_view(out).substr(begin)));
}

}  // namespace

InputLogWriter::InputLogWriter(InputLogHead head, const CycleRecord& start, Sink sink)
    : sink_(std::move(sink)) {
  head.sizes = sizes_of(start);
  row_.resize(num_words(head.sizes));
  before_.resize(row_.size());
  payload_ = head_payload(head);
  write(InputLogKind::head, 0, false);
  add(start);
  flush();
}

void InputLogWriter::add(const CycleRecord& record) {
  to_words(record, row_);
  put_row(rows_, row_, before_);
  std::swap(row_, before_);
  t_ = record.t;
  if (++num_rows_ == input_log_chunk_rows || t_ - t_flushed_ >= input_log_chunk_s) flush();
}

void InputLogWriter::add(const EngineState& state) {
  flush();
  payload_.clear();
  put(payload_, state.cycle);
  put(payload_, state.hash);
  std::vector<std::uint64_t> words(state.bytes.size() / sizeof(std::uint64_t));
  std::ranges::copy(std::span(state.bytes).first(words.size() * sizeof(std::uint64_t)),
                    std::as_writable_bytes(std::span(words)).begin());
  put_row(payload_, words, std::vector<std::uint64_t>(words.size()));
  write(InputLogKind::state, 0, true);
}

void InputLogWriter::add(const LinkEvent& event) {
  constexpr std::size_t chunk_bytes = 1 << 16;
  put_link(links_, event, t_link_ns_);
  if (event.t_ns != 0) t_link_ns_ = event.t_ns;
  ++num_links_;
  if (links_.size() >= chunk_bytes) flush_links();
}

/// Writes the events that wait for a full chunk. Each chunk begins with a time in full.
void InputLogWriter::flush_links() {
  if (num_links_ == 0) return;
  payload_.clear();
  put(payload_, written_links_);
  put(payload_, static_cast<std::uint32_t>(num_links_));
  payload_ += links_;
  write(InputLogKind::links, 0, false);
  written_links_ += std::exchange(num_links_, 0);
  links_.clear();
  t_link_ns_ = 0;
}

void InputLogWriter::flush() {
  flush_links();
  if (num_rows_ == 0) return;
  payload_.clear();
  put(payload_, static_cast<std::uint32_t>(num_rows_));
  payload_ += rows_;
  write(InputLogKind::rows, num_rows_, false);
  rows_.clear();
  num_rows_ = 0;
  t_flushed_ = t_;
  std::ranges::fill(before_, 0);
}

std::string InputLogWriter::end_of(std::uint64_t lost) {
  std::string payload;
  put(payload, lost);
  std::string chunk;
  put_chunk(chunk, InputLogKind::end, payload);
  return chunk;
}

/// Passes a chunk with the payload on.
void InputLogWriter::write(InputLogKind kind, std::uint64_t rows, bool is_state) {
  chunk_.clear();
  if (kind == InputLogKind::head) chunk_ += input_log_magic;
  put_chunk(chunk_, kind, payload_);
  sink_({.bytes = chunk_, .num_rows = rows, .is_state = is_state});
}

LastChunks::LastChunks(const InputLogSizes& sizes, std::uint64_t snapshot_bytes, std::uint64_t rows,
                       std::uint64_t state_every)
    : num_states_((rows + state_every - 1) / state_every + 1) {
  const std::uint64_t word_bits = 65, chunk_bytes = 32;  // of a word with its bit, and around a payload
  const std::uint64_t link_bytes = sizes.device_q > 0 ? 1024 : 0;  // events of a rig in a cycle
  const std::uint64_t row_bytes = (num_words(sizes) * word_bits + 7) / 8 + chunk_bytes + link_bytes,
                      state_bytes = snapshot_bytes * word_bits / 64 + chunk_bytes;
  const std::uint64_t bytes = num_states_ * (state_every * row_bytes + state_bytes);
  memory_.resize(std::min<std::uint64_t>(bytes, max_bytes));
  groups_.reserve(num_states_ + 1);
}

void LastChunks::add(const InputLogWriter::Chunk& chunk) {
  if (chunk.bytes.size() > memory_.size()) {
    is_bounded_ = true;
    return groups_.clear();
  }
  if (chunk.is_state) groups_.push_back({.begin = end_});
  if (groups_.empty()) return;
  const auto too_old = [&](const Group& group) {
    return end_ + chunk.bytes.size() - group.begin > memory_.size();
  };
  while (!groups_.empty() && (too_old(groups_.front()) || groups_.size() > num_states_)) {
    is_bounded_ = is_bounded_ || groups_.size() <= num_states_;
    groups_.erase(groups_.begin());
  }
  if (groups_.empty()) return;
  groups_.back().rows += chunk.num_rows;
  for (const char byte : chunk.bytes) memory_[end_++ % memory_.size()] = byte;
}

void LastChunks::each(const std::function<void(std::string_view)>& use) const {
  if (groups_.empty()) return;
  const std::uint64_t size = memory_.size();
  for (std::uint64_t at = groups_.front().begin; at < end_;) {
    const std::uint64_t piece = std::min(end_ - at, size - at % size);
    use({memory_.data() + at % size, piece});
    at += piece;
  }
}

std::uint64_t LastChunks::num_rows() const noexcept {
  std::uint64_t rows = 0;
  for (const Group& group : groups_) rows += group.rows;
  return rows;
}

}  // namespace godobject
