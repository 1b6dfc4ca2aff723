#include "hal/tracker/polhemus.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace godobject::polhemus {
namespace {

constexpr double inch = 0.0254;  // m
constexpr double max_distance_m = 20;
constexpr double unit_tolerance = 5e-3;  // tolerance of the squared length

void put_float(ByteWriter& out, double value) noexcept {
  out.put(std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

double get_float(ByteReader& in) noexcept {
  std::uint32_t bits = 0;
  in.get(bits);
  return static_cast<double>(std::bit_cast<float>(bits));
}

void put_pose(ByteWriter& out, const Pose& X) noexcept {
  for (const double p : {X.p.x(), X.p.y(), X.p.z()}) put_float(out, p / inch);
  for (const double q : {X.q.w(), X.q.x(), X.q.y(), X.q.z()}) put_float(out, q);
}

/// Reads a pose. Returns false if it is implausible.
bool get_pose(ByteReader& in, Pose& X) noexcept {
  for (Eigen::Index i = 0; i < 3; ++i) X.p[i] = inch * get_float(in);
  const double w = get_float(in), x = get_float(in), y = get_float(in), z = get_float(in);
  X.q = Quat(w, x, y, z);
  // per component, because a maximum may skip a NaN
  const bool plausible =
      (X.p.array().abs() < max_distance_m).all() && std::abs(X.q.coeffs().squaredNorm() - 1) < unit_tolerance;
  if (plausible) X.q.normalize();
  return plausible;
}

bool is_error_mark(std::uint8_t c) noexcept {
  return c == ' ' || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

/// True if the bytes match the beginning of `expected`; '?' matches any byte.
bool begins_like(std::span<const std::uint8_t> bytes, std::string_view expected) noexcept {
  for (std::size_t i = 0; i < std::min(bytes.size(), expected.size()); ++i) {
    if (expected[i] != '?' && bytes[i] != static_cast<std::uint8_t>(expected[i])) return false;
  }
  return true;
}

ParseResult parse_fastrak(std::span<const std::uint8_t> bytes, Record& out, std::size_t& size) noexcept {
  if (bytes.size() > 1 && (bytes[1] < '1' || bytes[1] > '4')) return ParseResult::other_message;
  if (bytes.size() > 2 && !is_error_mark(bytes[2])) return ParseResult::other_message;
  if (bytes.size() < fastrak_size) return ParseResult::too_short;
  Record record{.model = Model::fastrak,
                .station = static_cast<std::uint8_t>(bytes[1] - '0'),
                .error = static_cast<char>(bytes[2])};
  ByteReader in(bytes.subspan(3));
  const bool ends = bytes[fastrak_size - 1] == ' ';
  if (!get_pose(in, record.X_TH) || !ends) {
    size = ends ? fastrak_size : 0;
    return ParseResult::bad_value;
  }
  out = record;
  size = fastrak_size;
  return ParseResult::ok;
}

ParseResult parse_liberty(std::span<const std::uint8_t> bytes, Record& out, std::size_t& size) noexcept {
  if (bytes.size() > 2 && (bytes[2] < 1 || bytes[2] > max_stations)) return ParseResult::other_message;
  if (bytes.size() > 3 && bytes[3] != 'C' && bytes[3] != 'P') return ParseResult::other_message;
  if (bytes.size() < liberty_header) return ParseResult::too_short;
  std::uint16_t payload = 0;
  ByteReader(bytes.subspan(6, 2)).get(payload);
  if (payload != liberty_payload && payload != liberty_button_payload) return ParseResult::other_message;
  const std::size_t all = liberty_header + payload;
  if (bytes.size() < all) return ParseResult::too_short;
  Record record{.model = Model::liberty, .station = bytes[2], .error = static_cast<char>(bytes[4])};
  ByteReader in(bytes.subspan(liberty_header));
  const bool ends = bytes[all - 1] == ' ';
  if (!get_pose(in, record.X_TH) || !ends) {
    size = ends ? all : 0;
    return ParseResult::bad_value;
  }
  in.get(record.t_ms);
  out = record;
  size = all;
  return ParseResult::ok;
}

}  // namespace

std::span<const std::uint8_t> make_record(const Record& record, std::span<std::uint8_t> out) noexcept {
  ByteWriter writer(out);
  if (record.model == Model::fastrak) {
    writer.put('0').put(static_cast<char>('0' + record.station)).put(record.error);
    put_pose(writer, record.X_TH);
  } else {
    writer.put('L').put('Y').put(record.station).put('C').put(record.error).put('\0');
    writer.put(static_cast<std::uint16_t>(liberty_payload));
    put_pose(writer, record.X_TH);
    writer.put(record.t_ms);
  }
  writer.put(' ');
  return writer.ok() ? out.first(writer.size()) : std::span<std::uint8_t>{};
}

ParseResult parse_record(std::span<const std::uint8_t> bytes, Record& out, std::size_t& size) noexcept {
  if (bytes.empty()) return ParseResult::too_short;
  if (bytes[0] == '0') return parse_fastrak(bytes, out, size);
  const bool liberty = begins_like(bytes, "LY") || begins_like(bytes, "LU") || begins_like(bytes, "PA");
  return liberty ? parse_liberty(bytes, out, size) : ParseResult::other_message;
}

RecordReceiver::Event RecordReceiver::push(std::uint8_t byte) noexcept {
  data_[size_++] = byte;
  bool lost = false;
  while (size_ > 0) {
    std::size_t size = 0;
    const ParseResult result = parse_record({data_.data(), size_}, record_, size);
    if (result == ParseResult::too_short && size_ < data_.size()) break;
    if (result == ParseResult::ok) {
      drop(size);
      in_step_ = true;
      return Event::record;
    }
    // The record is complete, so the next byte begins a record.
    if (result == ParseResult::bad_value && size > 0 && in_step_) {
      drop(size);
      return Event::malformed;
    }
    lost = true;
    drop(1);
  }
  const bool first_loss = lost && in_step_;
  if (lost) in_step_ = false;
  return first_loss ? Event::malformed : Event::more;
}

void RecordReceiver::drop(std::size_t count) noexcept {
  std::copy(data_.begin() + static_cast<std::ptrdiff_t>(count),
            data_.begin() + static_cast<std::ptrdiff_t>(size_), data_.begin());
  size_ -= count;
}

std::optional<Command> init_command(Model model, std::size_t index, std::size_t num_stations) noexcept {
  const bool fastrak = model == Model::fastrak;
  const char* format = nullptr;
  if (index == 0) {
    format = fastrak ? "c" : "P";  // stops continuous records
  } else if (index == 1) {
    format = fastrak ? "U" : "U0\r";  // inches
  } else if (index < 2 + num_stations) {
    // 2 position, 11 or 7 quaternion, 8 time, 0 space
    format = fastrak ? "O%zu,2,11,0\r" : "O%zu,2,7,8,0\r";
  } else if (index == 2 + num_stations) {
    format = fastrak ? "f" : "F1\r";  // binary
  } else if (index == 3 + num_stations) {
    format = fastrak ? "C" : "C\r";  // continuous
  } else {
    return std::nullopt;
  }
  Command command;
  // cppcheck-suppress wrongPrintfScanfArgNum  ; the formats without a place for it leave it out
  const int size = std::snprintf(command.data.data(), command.data.size(), format, index - 1);
  command.size = static_cast<std::size_t>(size);
  return command;
}

std::optional<Command> frame_command(Model model, std::size_t index, std::size_t num_stations,
                                     const Vec3& hemisphere) noexcept {
  constexpr std::size_t num_kinds = 5;
  const bool fastrak = model == Model::fastrak;
  // a Fastrak sets its stations one by one
  const std::size_t num_commands =
      fastrak ? num_kinds * std::min(num_stations, max_fastrak_stations) : num_kinds;
  if (index >= num_commands) return std::nullopt;
  std::array<char, 3> station{'*', '\0'};
  if (fastrak) station[0] = static_cast<char>('1' + index / num_kinds);
  Command command;
  const auto print = [&](const char* format, auto... values) {
    const int size = std::snprintf(command.data.data(), command.data.size(), format, values...);
    command.size = static_cast<std::size_t>(size);
  };
  switch (index % num_kinds) {
    case 0: print(fastrak ? "R%s\r" : "\x12%s\r", station.data()); break;  // alignment; Liberty: ^R
    case 1: print(fastrak ? "b%s\r" : "\x02%s\r", station.data()); break;  // boresight; Liberty: ^B
    case 2: print("N%s,0,0,0\r", station.data()); break;                   // tip offset
    case 3:
      fastrak ? print("r%s,0,0,0\r", station.data()) : print("%s", "G0,0,0\r");
      break;  // frame of the source
    default: print("H%s,%.3f,%.3f,%.3f\r", station.data(), hemisphere.x(), hemisphere.y(), hemisphere.z());
  }
  return command;
}

}  // namespace godobject::polhemus
