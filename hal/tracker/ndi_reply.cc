#include "hal/tracker/ndi_reply.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>

namespace godobject::ndi {
namespace {

/// Largest coordinate in a reply, m: beyond the range of any tracker; a missing value is -3.7e28.
constexpr double max_distance_m = 100;
/// Tolerance of the squared length of a quaternion: text replies have four digits.
constexpr double unit_tolerance = 5e-3;

bool is_plausible(const HandlePose& pose) noexcept {
  const Pose& X = pose.X_TH;
  // per component, because a maximum may skip a NaN
  return (X.p.array().abs() < max_distance_m).all() &&
         std::abs(X.q.coeffs().squaredNorm() - 1) < unit_tolerance && pose.error_m >= 0 &&
         pose.error_m < max_distance_m;
}

/// Parses fixed-width text; after an error all reads return 0.
class TextReader {
 public:
  explicit TextReader(std::span<const std::uint8_t> text) noexcept : text_(text) {}

  bool ok() const noexcept { return ok_; }
  bool at_end() const noexcept { return ok_ && text_.empty(); }

  unsigned hex(std::size_t digits) noexcept {
    unsigned value = 0;
    for (const std::uint8_t c : take(digits)) {
      if (c >= '0' && c <= '9') {
        value = value << 4 | static_cast<unsigned>(c - '0');
      } else if (c >= 'A' && c <= 'F') {
        value = value << 4 | static_cast<unsigned>(c - 'A' + 10);
      } else {
        ok_ = false;
      }
    }
    return ok_ ? value : 0;
  }

  /// Parses a sign and `digits` digits. unit: value of the last digit.
  double decimal(std::size_t digits, double unit) noexcept {
    const std::span<const std::uint8_t> all = take(1 + digits);
    if (!ok_) return 0;
    int value = 0;
    for (const std::uint8_t c : all.subspan(1)) {
      if (c < '0' || c > '9') ok_ = false;
      value = 10 * value + (c - '0');
    }
    if (all[0] != '+' && all[0] != '-') ok_ = false;
    return all[0] == '-' ? -value * unit : value * unit;
  }

  /// Skips `expected` and returns true if it comes next.
  bool word(std::string_view expected) noexcept {
    if (!ok_ || text_.size() < expected.size() || !std::ranges::equal(text_.first(expected.size()), expected))
      return false;
    text_ = text_.subspan(expected.size());
    return true;
  }
  void require(std::string_view expected) noexcept { ok_ = word(expected) && ok_; }
  void skip(std::size_t size) noexcept { static_cast<void>(take(size)); }

  std::span<const std::uint8_t> take(std::size_t size) noexcept {
    if (!ok_ || text_.size() < size) {
      ok_ = false;
      return {};
    }
    const std::span<const std::uint8_t> taken = text_.first(size);
    text_ = text_.subspan(size);
    return taken;
  }

 private:
  std::span<const std::uint8_t> text_;
  bool ok_ = true;
};

constexpr std::size_t point_digits = 21;  // x, y, z of a marker: a sign and six digits each

/// Skips the number of markers, one out-of-volume bit per marker, and their points.
void skip_markers(TextReader& in) noexcept {
  const std::size_t count = in.hex(2);
  in.skip((count + 3) / 4);
  in.skip(count * point_digits);
}

void read_pose(TextReader& in, HandlePose& pose) noexcept {
  const double w = in.decimal(5, 1e-4), x = in.decimal(5, 1e-4), y = in.decimal(5, 1e-4),
               z = in.decimal(5, 1e-4);
  pose.X_TH.q = Quat(w, x, y, z);
  for (Eigen::Index i = 0; i < 3; ++i) pose.X_TH.p[i] = in.decimal(6, 1e-5);  // 0.01 mm
  pose.error_m = in.decimal(5, 1e-7);                                         // 1e-4 mm
}

void read_handle(TextReader& in, std::uint16_t options, HandlePose& pose) noexcept {
  pose.handle = static_cast<std::uint8_t>(in.hex(2));
  pose.status = HandleStatus::valid;
  if (in.word("DISABLED") || in.word("UNOCCUPIED")) {
    pose.status = HandleStatus::disabled;
    return in.require("\n");
  }
  if ((options & option::transforms) != 0) {
    if (in.word("MISSING")) {
      pose.status = HandleStatus::missing;
    } else {
      read_pose(in, pose);
    }
    pose.port_bits = in.hex(8);
    pose.frame = in.hex(8);
  } else {
    pose.status = HandleStatus::missing;  // the command did not request poses
  }
  if ((options & option::tool_and_markers) != 0) in.skip(2 + 20);
  if ((options & option::stray_active_marker) != 0 && in.hex(2) == 0x01) in.skip(point_digits);
  if ((options & option::markers_on_tools) != 0) skip_markers(in);
  in.require("\n");
}

float get_float(ByteReader& in) noexcept {
  std::uint32_t bits = 0;
  in.get(bits);
  return std::bit_cast<float>(bits);
}

void skip(ByteReader& in, std::size_t size) noexcept {
  std::uint8_t byte = 0;
  while (size-- > 0 && in.ok()) in.get(byte);
}

void skip_markers(ByteReader& in) noexcept {
  std::uint8_t count = 0;
  in.get(count);
  skip(in, (count + 7u) / 8u + 12u * count);
}

void read_pose(ByteReader& in, HandlePose& pose) noexcept {
  const auto real = [&in] { return static_cast<double>(get_float(in)); };
  const double w = real(), x = real(), y = real(), z = real();
  pose.X_TH.q = Quat(w, x, y, z);
  for (Eigen::Index i = 0; i < 3; ++i) pose.X_TH.p[i] = 1e-3 * real();  // mm
  pose.error_m = 1e-3 * real();
}

/// Reads a handle. Returns false for an undefined status.
bool read_handle(ByteReader& in, std::uint16_t options, HandlePose& pose) noexcept {
  std::uint8_t status = 0;
  in.get(pose.handle).get(status);
  pose.status = static_cast<HandleStatus>(status);
  if (pose.status == HandleStatus::disabled) return true;
  if (pose.status != HandleStatus::valid && pose.status != HandleStatus::missing) return false;
  if ((options & option::transforms) != 0) {
    if (pose.status == HandleStatus::valid) read_pose(in, pose);
    in.get(pose.port_bits).get(pose.frame);
  } else {
    pose.status = HandleStatus::missing;  // the command did not request poses
  }
  if ((options & option::tool_and_markers) != 0) skip(in, 1 + 10);
  if ((options & option::stray_active_marker) != 0) {
    std::uint8_t stray = 0;
    in.get(stray);
    if (stray == 0x01) skip(in, 12);
  }
  if ((options & option::markers_on_tools) != 0) skip_markers(in);
  return true;
}

/// Normalises quaternions. Returns false if a pose is implausible and `implausible` is refuse_reply.
bool take_plausible(PoseReply& reply, ImplausiblePose implausible) noexcept {
  for (std::size_t i = 0; i < reply.num_handles; ++i) {
    HandlePose& pose = reply.handles[i];
    if (pose.status != HandleStatus::valid) continue;
    if (is_plausible(pose)) {
      pose.X_TH.q.normalize();
    } else if (implausible == ImplausiblePose::refuse_reply) {
      return false;
    } else {
      pose.status = HandleStatus::implausible;
      pose.X_TH = {};
    }
  }
  return true;
}

}  // namespace

ParseResult parse_tx(std::span<const std::uint8_t> text, std::uint16_t options, PoseReply& out,
                     ImplausiblePose implausible) noexcept {
  PoseReply reply;
  TextReader in(text);
  reply.num_handles = in.hex(2);
  if (reply.num_handles > max_handles) return ParseResult::too_long;
  for (std::size_t i = 0; i < reply.num_handles && in.ok(); ++i) read_handle(in, options, reply.handles[i]);
  if ((options & option::stray_passive_markers) != 0) skip_markers(in);
  reply.system_status = static_cast<std::uint16_t>(in.hex(4));
  if (!in.at_end() || !take_plausible(reply, implausible)) return ParseResult::bad_value;
  out = reply;
  return ParseResult::ok;
}

ParseResult parse_bx(std::span<const std::uint8_t> body, std::uint16_t options, PoseReply& out,
                     ImplausiblePose implausible) noexcept {
  PoseReply reply;
  ByteReader in(body);
  std::uint8_t count = 0;
  in.get(count);
  if (count > max_handles) return ParseResult::too_long;
  reply.num_handles = count;
  for (std::size_t i = 0; i < count && in.ok(); ++i) {
    if (!read_handle(in, options, reply.handles[i]) && in.ok()) return ParseResult::bad_value;
  }
  if ((options & option::stray_passive_markers) != 0) skip_markers(in);
  in.get(reply.system_status);
  if (!in.ok()) return ParseResult::too_short;
  std::uint8_t rest = 0;
  if (in.get(rest).ok()) return ParseResult::too_long;
  if (!take_plausible(reply, implausible)) return ParseResult::bad_value;
  out = reply;
  return ParseResult::ok;
}

// ---- BX2: components in components -----------------------------------------------------------------

namespace {

/// Components of BX2.
namespace component {
constexpr std::uint16_t frame = 0x0001, poses = 0x0002;
}
/// Status of a tool in BX2: a code in the low byte, and the bit that no pose follows.
namespace bx2_status {
constexpr std::uint16_t code_mask = 0x00FF, missing = 0x0100;
constexpr std::uint16_t partly_out_of_volume = 0x01, out_of_volume = 0x02, not_enabled = 0x20,
                        unplugged = 0x21;
}  // namespace bx2_status

/// Calls read(type, num_items, bytes) for each component of a list. Returns false if one is cut off.
template <class F>
bool each_component(ByteReader& in, F read) noexcept {
  std::uint16_t version = 0, count = 0;
  in.get(version).get(count);
  for (; count > 0 && in.ok(); --count) {
    std::uint16_t type = 0, format = 0;
    std::uint32_t size = 0, num_items = 0;
    in.get(type).get(size).get(format).get(num_items);
    constexpr std::uint32_t head = 12;
    if (!in.ok() || size < head || size - head > in.left()) return false;
    ByteReader items(in.take(size - head));
    if (!read(type, num_items, items)) return false;
  }
  return in.ok();
}

bool read_poses(std::uint32_t num_items, std::uint32_t frame, ByteReader& in, PoseReply& reply) noexcept {
  for (; num_items > 0; --num_items) {
    if (reply.num_handles == max_handles) return false;
    std::uint16_t handle = 0, status = 0;
    if (!in.get(handle).get(status).ok() || handle > 0xFF) return false;
    const std::uint16_t code = status & bx2_status::code_mask;
    HandlePose pose;
    pose.handle = static_cast<std::uint8_t>(handle);
    pose.status = HandleStatus::valid;
    pose.frame = frame;
    if (code == bx2_status::not_enabled || code == bx2_status::unplugged)
      pose.status = HandleStatus::disabled;
    else if ((status & bx2_status::missing) != 0) pose.status = HandleStatus::missing;
    if (code == bx2_status::out_of_volume) pose.port_bits = port_status::out_of_volume;
    if (code == bx2_status::partly_out_of_volume) pose.port_bits = port_status::partly_out_of_volume;
    if ((status & bx2_status::missing) == 0) read_pose(in, pose);
    reply.handles[reply.num_handles++] = pose;
  }
  return in.ok();
}

bool read_frames(std::uint32_t num_items, ByteReader& in, PoseReply& reply) noexcept {
  for (; num_items > 0; --num_items) {
    std::uint8_t type = 0, index = 0;
    std::uint16_t status = 0;
    std::uint32_t frame = 0, seconds = 0, nanoseconds = 0;
    in.get(type).get(index).get(status).get(frame).get(seconds).get(nanoseconds);
    if (!in.ok() || nanoseconds >= 1'000'000'000) return false;
    reply.t_ns = Nanoseconds{1'000'000'000} * seconds + nanoseconds;
    const auto read = [&](std::uint16_t kind, std::uint32_t count, ByteReader& items) noexcept {
      return kind != component::poses || read_poses(count, frame, items, reply);
    };
    if (!each_component(in, read)) return false;
  }
  return in.ok();
}

}  // namespace

ParseResult parse_bx2(std::span<const std::uint8_t> body, PoseReply& out,
                      ImplausiblePose implausible) noexcept {
  PoseReply reply;
  ByteReader in(body);
  const auto read = [&](std::uint16_t kind, std::uint32_t count, ByteReader& items) noexcept {
    return kind != component::frame || read_frames(count, items, reply);
  };
  if (!each_component(in, read)) return ParseResult::bad_value;
  if (in.left() > 0) return ParseResult::too_long;
  if (!take_plausible(reply, implausible)) return ParseResult::bad_value;
  out = reply;
  return ParseResult::ok;
}

const char* system_status_text(std::uint16_t status) noexcept {
  if ((status & 0x0010u) != 0)
    return "hardware failure: switch the tracker off and on; see its own diagnosis";
  if ((status & 0x0008u) != 0) return "recoverable exception: the tracker continues";
  if ((status & 0x0001u) != 0) return "communication synchronisation error in the tracker";
  if ((status & 0x0002u) != 0) return "too much environmental infrared: shield lamps and reflections";
  if ((status & 0x0004u) != 0) return "the tracker detected a CRC error on its own link";
  return nullptr;
}

ParseResult parse_phsr(std::span<const std::uint8_t> text, PortHandles& out) noexcept {
  PortHandles handles;
  TextReader in(text);
  handles.size = in.hex(2);
  if (handles.size > max_handles) return ParseResult::too_long;
  for (std::size_t i = 0; i < handles.size; ++i) {
    handles.handles[i].handle = static_cast<std::uint8_t>(in.hex(2));
    handles.handles[i].status = static_cast<std::uint16_t>(in.hex(3));
  }
  if (!in.at_end()) return ParseResult::bad_value;
  out = handles;
  return ParseResult::ok;
}

ParseResult parse_phinf(std::span<const std::uint8_t> text, ToolPlate& out) noexcept {
  ToolPlate plate;
  TextReader in(text);
  in.skip(8);  // type of the tool
  std::ranges::copy(in.take(plate.manufacturer.size() - 1), plate.manufacturer.begin());
  in.skip(3);  // revision
  std::ranges::copy(in.take(plate.serial.size() - 1), plate.serial.begin());
  plate.port_bits = static_cast<std::uint8_t>(in.hex(2));
  if (!in.ok()) return ParseResult::too_short;
  out = plate;
  return ParseResult::ok;
}

}  // namespace godobject::ndi
