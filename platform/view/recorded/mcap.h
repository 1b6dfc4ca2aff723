// Recordings as MCAP files (mcap.dev/spec): messages with times, on channels with schemas, in chunks with an
// index and CRCs. Chunks are not compressed. Numbers are little-endian:
//   magic, header, data, summary, summary offsets, footer, magic
//   record    opcode (u8), bytes of the content (u64), the content
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "hal/base/crc32.h"
#include "hal/can/frame.h"
#include "platform/trace/trace.h"
#include "platform/view/server/server.h"

namespace godobject {

/// Content of a record, one member after the other.
class McapContent {
 public:
  template <class Int>
  McapContent& put(Int value) {
    for (std::size_t i = 0; i < sizeof(Int); ++i) bytes_ += static_cast<char>(value >> (8 * i));
    return *this;
  }
  template <class Int>
  McapContent& text(std::string_view text) {
    return put(static_cast<Int>(text.size())).raw(text);
  }
  McapContent& text(std::string_view value) { return text<std::uint32_t>(value); }
  McapContent& raw(std::string_view bytes) {
    bytes_ += bytes;
    return *this;
  }
  const std::string& bytes() const noexcept { return bytes_; }

 private:
  std::string bytes_;
};

/// Writer of an MCAP file. Not for the real-time thread.
class McapWriter {
 public:
  /// Receives bytes; returns false if some were not written.
  using Sink = std::function<bool(std::string_view)>;

  /// library: name and version of the program.
  McapWriter(Sink sink, std::string_view library) : sink_(std::move(sink)) {
    write(magic);
    write(record(Op::header, McapContent().text("").text(library)));
  }

  /// Adds a channel of messages in JSON, and returns its number, from 0.
  /// schema: JSON Schema of a message.
  std::size_t add_channel(std::string_view topic, std::string_view schema_name, std::string_view schema) {
    const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
    const std::string schema_record =
        record(Op::schema, McapContent().put(id).text(schema_name).text("jsonschema").text(schema));
    const std::string channel_record =
        record(Op::channel, McapContent().put(id).put(id).text(topic).text("json").text(""));
    write(schema_record);
    write(channel_record);
    schema_records_ += schema_record;
    channel_records_ += channel_record;
    channels_.emplace_back();
    return channels_.size() - 1;
  }
  static constexpr std::size_t max_channels = 65534;

  void add_message(std::size_t channel, Nanoseconds t, std::string_view json) {
    Channel& to = channels_[channel];
    const auto time = static_cast<std::uint64_t>(t);
    to.index.put(time).put(static_cast<std::uint64_t>(chunk_.size()));
    chunk_ += record(Op::message, McapContent()
                                      .put(static_cast<std::uint16_t>(channel + 1))
                                      .put(static_cast<std::uint32_t>(to.num_messages++))
                                      .put(time)
                                      .put(time)
                                      .raw(json));
    span_.include(time);
    if (chunk_.size() >= chunk_bytes) write_chunk();
  }

  /// Writes the rest. Returns false if anything was not written.
  [[nodiscard]] bool close() {
    write_chunk();
    write(record(Op::data_end, McapContent().put(crc_)));
    crc_ = 0;  // from here on of the summary
    const std::uint64_t summary = position_;
    std::string records, offsets;
    const auto add_group = [&](Op op, const std::string& group) {
      if (group.empty()) return;
      offsets += record(Op::summary_offset, McapContent()
                                                .put(static_cast<std::uint8_t>(op))
                                                .put(summary + records.size())
                                                .put(static_cast<std::uint64_t>(group.size())));
      records += group;
    };
    add_group(Op::schema, schema_records_);
    add_group(Op::channel, channel_records_);
    add_group(Op::statistics, statistics());
    add_group(Op::chunk_index, chunk_indices_);
    write(records);
    const std::uint64_t summary_offsets = position_;
    write(offsets);
    constexpr std::uint64_t footer_bytes = 20;
    const McapContent footer = McapContent().put(summary).put(summary_offsets);
    write(McapContent()
              .put(static_cast<std::uint8_t>(Op::footer))
              .put(footer_bytes)
              .raw(footer.bytes())
              .bytes());
    write(McapContent().put(crc_).bytes());
    write(magic);
    return all_taken_;
  }

 private:
  static constexpr std::string_view magic = "\x89MCAP0\r\n";
  static constexpr std::size_t chunk_bytes = std::size_t{1} << 20;

  enum class Op : std::uint8_t {
    header = 1,
    footer = 2,
    schema = 3,
    channel = 4,
    message = 5,
    chunk = 6,
    message_index = 7,
    chunk_index = 8,
    statistics = 11,
    summary_offset = 14,
    data_end = 15,
  };
  struct Channel {
    McapContent index;  // time and place of each message in the present chunk
    std::uint64_t num_messages = 0;
  };
  /// First and last time of messages; zeros without any.
  struct Span {
    std::uint64_t first = 0, last = 0;
    bool is_empty = true;
    void include(std::uint64_t t) noexcept {
      first = is_empty ? t : std::min(first, t);
      last = is_empty ? t : std::max(last, t);
      is_empty = false;
    }
  };

  static std::string record(Op op, const McapContent& content) {
    return McapContent().put(static_cast<std::uint8_t>(op)).text<std::uint64_t>(content.bytes()).bytes();
  }

  void write(std::string_view bytes) {
    crc_ = crc32(bytes, crc_);
    position_ += bytes.size();
    all_taken_ = sink_(bytes) && all_taken_;
  }

  /// Writes the messages so far as a chunk, and the index of each channel in it.
  void write_chunk() {
    if (chunk_.empty()) return;
    const McapContent span = McapContent().put(span_.first).put(span_.last);
    const std::uint64_t size = chunk_.size(), begin = position_;
    write(record(
        Op::chunk,
        McapContent().raw(span.bytes()).put(size).put(crc32(chunk_)).text("").text<std::uint64_t>(chunk_)));
    const std::uint64_t end = position_;
    McapContent places;  // of each channel's index
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      Channel& channel = channels_[i];
      if (channel.index.bytes().empty()) continue;
      const auto id = static_cast<std::uint16_t>(i + 1);
      places.put(id).put(position_);
      write(record(Op::message_index, McapContent().put(id).text(channel.index.bytes())));
      channel.index = {};
    }
    chunk_indices_ += record(Op::chunk_index, McapContent()
                                                  .raw(span.bytes())
                                                  .put(begin)
                                                  .put(end - begin)
                                                  .text(places.bytes())
                                                  .put(position_ - end)
                                                  .text("")
                                                  .put(size)
                                                  .put(size));
    ++num_chunks_;
    all_.include(span_.first);
    all_.include(span_.last);
    span_ = {};
    chunk_.clear();
  }

  std::string statistics() const {
    McapContent counts;
    std::uint64_t num_messages = 0;
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      counts.put(static_cast<std::uint16_t>(i + 1)).put(channels_[i].num_messages);
      num_messages += channels_[i].num_messages;
    }
    return record(Op::statistics, McapContent()
                                      .put(num_messages)
                                      .put(static_cast<std::uint16_t>(channels_.size()))
                                      .put(static_cast<std::uint32_t>(channels_.size()))
                                      .put(std::uint32_t{0})  // attachments
                                      .put(std::uint32_t{0})  // metadata
                                      .put(num_chunks_)
                                      .put(all_.first)
                                      .put(all_.last)
                                      .text(counts.bytes()));
  }

  Sink sink_;
  bool all_taken_ = true;
  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;  // of the section so far
  std::vector<Channel> channels_;
  std::string schema_records_, channel_records_;  // again in the summary
  std::string chunk_, chunk_indices_;
  std::uint32_t num_chunks_ = 0;
  Span span_, all_;  // of the chunk, of all chunks
};

inline std::string mcap_json(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// Columns of a trace whose names differ in the last word: a channel of MCAP.
struct ColumnGroup {
  std::string name;  // "tool/coupling"
  std::size_t first = 0;
  std::vector<std::pair<std::size_t, std::string>> columns{};  // index and last word of each
  std::size_t channel = 0;
  bool is_pose = false;
};

/// Rows of a trace as messages of MCAP.
class McapRows {
  using Json = nlohmann::ordered_json;

 public:
  /// names: columns of the trace, t first. library: see McapWriter.
  McapRows(McapWriter::Sink sink, std::string_view library, const std::vector<std::string>& names)
      : writer_(std::move(sink), library) {
    for (std::size_t i = 1; i < names.size(); ++i) {
      if (names[i] == "t_bus") bus_time_ = i;
      add_column(i, names[i]);
    }
    for (ColumnGroup& group : groups_) add_channel(group);
    transforms_ = writer_.add_channel("/tf", "foxglove.FrameTransforms", foxglove_transforms_schema());
  }

  void add(std::span<const double> row) {
    const double t = bus_time_ && row[*bus_time_] > 0 ? row[*bus_time_] : row[0];
    const auto t_ns = static_cast<Nanoseconds>(std::llround(1e9 * t));
    Json transforms = Json::array();
    for (const ColumnGroup& group : groups_) {
      Json message = Json::object();
      for (const auto& [column, word] : group.columns)
        if (std::isfinite(row[column])) message[word] = row[column];
      writer_.add_message(group.channel, t_ns, mcap_json(message));
      const auto pose = row.subspan(group.first, group.is_pose ? pose_columns.size() : 0);
      if (group.is_pose && std::ranges::all_of(pose, [](double x) { return std::isfinite(x); }))
        transforms.push_back(transform(group, t_ns, &row[group.first]));
    }
    writer_.add_message(transforms_, t_ns, mcap_json({{"transforms", std::move(transforms)}}));
  }
  bool close() { return writer_.close(); }

 private:
  void add_column(std::size_t column, const std::string& name) {
    const std::size_t dot = name.rfind('.');
    std::string of = dot == std::string::npos ? "run" : name.substr(0, dot);
    std::ranges::replace(of, '.', '/');
    auto group = std::ranges::find(groups_, of, &ColumnGroup::name);
    if (group == groups_.end()) {
      groups_.push_back({.name = of, .first = column});
      group = groups_.end() - 1;
    }
    group->columns.emplace_back(column, name.substr(dot == std::string::npos ? 0 : dot + 1));
  }
  void add_channel(ColumnGroup& group) {
    Json properties = Json::object();
    for (const auto& [column, word] : group.columns) properties[word] = {{"type", "number"}};
    const Json schema{{"title", group.name}, {"type", "object"}, {"properties", properties}};
    group.channel = writer_.add_channel("/" + group.name, group.name, mcap_json(schema));
    group.is_pose = group.columns.size() >= pose_columns.size();
    for (std::size_t i = 0; group.is_pose && i < pose_columns.size(); ++i)
      group.is_pose = group.columns[i] == std::pair(group.first + i, std::string(pose_columns[i]));
  }
  static Json transform(const ColumnGroup& group, Nanoseconds t, const double* x) {
    return {{"timestamp", {{"sec", t / 1'000'000'000}, {"nsec", t % 1'000'000'000}}},
            {"parent_frame_id", "world"},
            {"child_frame_id", group.name},
            {"translation", {{"x", x[0]}, {"y", x[1]}, {"z", x[2]}}},
            {"rotation", {{"x", x[4]}, {"y", x[5]}, {"z", x[6]}, {"w", x[3]}}}};
  }

  McapWriter writer_;
  std::vector<ColumnGroup> groups_;
  std::optional<std::size_t> bus_time_{};
  std::size_t transforms_ = 0;
};

/// Returns bytes as two hexadecimal digits each.
inline std::string hex_of(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string hex;
  for (const std::uint8_t byte : bytes) (hex += digits[byte >> 4]) += digits[byte & 15];
  return hex;
}

/// Frames of buses as messages of MCAP, on a channel for each bus.
class McapFrames {
 public:
  McapFrames(McapWriter::Sink sink, std::string_view library) : writer_(std::move(sink), library) {}

  void add(const ReceivedFrame& received, std::string_view bus) {
    auto channel = std::ranges::find(buses_, bus);
    if (channel == buses_.end()) {
      constexpr std::string_view schema =
          R"({"title":"CAN frame","type":"object","properties":{"id":{"type":"integer"},)"
          R"("extended":{"type":"boolean"},"remote":{"type":"boolean"},"fd":{"type":"boolean"},)"
          R"("bit_rate_switch":{"type":"boolean"},"data":{"type":"string"}}})";
      writer_.add_channel("/" + std::string(bus), "godobject.can", schema);
      buses_.emplace_back(bus);
      channel = buses_.end() - 1;
    }
    const CanFrame& frame = received.frame;
    writer_.add_message(static_cast<std::size_t>(channel - buses_.begin()), received.t_ns,
                        mcap_json({{"id", frame.id},
                                   {"extended", frame.extended},
                                   {"remote", frame.remote},
                                   {"fd", frame.fd},
                                   {"bit_rate_switch", frame.bit_rate_switch},
                                   {"data", hex_of(frame.bytes())}}));
  }
  bool close() { return writer_.close(); }

 private:
  McapWriter writer_;
  std::vector<std::string> buses_;  // name of each channel
};

}  // namespace godobject
