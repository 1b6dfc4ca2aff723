#include "hal/tracker/openigtlink.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

namespace godobject::openigtlink {
namespace {

constexpr double mm = 1e-3;
constexpr double max_skew = 1e-2;                                 // of the products of a rotation's columns
constexpr std::uint64_t max_body_bytes = std::uint64_t{1} << 28;  // of a large volume
constexpr std::size_t extended_header_bytes = 12;

constexpr auto crc_table = [] {
  std::array<std::uint64_t, 256> table{};
  for (std::uint64_t byte = 0; byte < 256; ++byte) {
    std::uint64_t crc = byte << 56;
    for (int bit = 0; bit < 8; ++bit) crc = crc << 1 ^ (crc >> 63 != 0 ? 0x42F0E1EBA9EA3693u : 0u);
    table[byte] = crc;
  }
  return table;
}();

std::uint64_t number_at(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) noexcept {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes.subspan(at, size)) value = value << 8 | byte;
  return value;
}

double float_at(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
  return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(number_at(bytes, at, 4))));
}

/// Copies characters up to a zero. Returns false if one is not printable.
template <std::size_t size>
bool copy_text(std::span<const std::uint8_t> bytes, std::array<char, size>& text) noexcept {
  text.fill(0);
  for (std::size_t i = 0; i + 1 < size && bytes[i] != 0; ++i) {
    if (bytes[i] < ' ' || bytes[i] > '~') return false;
    text[i] = static_cast<char>(bytes[i]);
  }
  return true;
}

/// Returns the pose of 12 numbers: the columns of the rotation, then the position, mm.
std::optional<Pose> pose_of(std::span<const std::uint8_t> bytes) noexcept {
  Eigen::Matrix3d R;
  Vec3 p;
  for (int i = 0; i < 9; ++i) R(i % 3, i / 3) = float_at(bytes, static_cast<std::size_t>(4 * i));
  for (int i = 0; i < 3; ++i) p[i] = mm * float_at(bytes, static_cast<std::size_t>(36 + 4 * i));
  const double skew = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!R.allFinite() || !(skew <= max_skew) || !(R.determinant() > 0) || !(p.norm() <= max_distance))
    return std::nullopt;
  return Pose{.p = p, .q = Quat(R).normalized()};
}

}  // namespace

std::uint64_t crc64(std::span<const std::uint8_t> bytes, std::uint64_t before) noexcept {
  std::uint64_t crc = before;
  for (const std::uint8_t byte : bytes) crc = crc << 8 ^ crc_table[(crc >> 56 ^ byte) & 0xff];
  return crc;
}

// ---- receiving -------------------------------------------------------------------------------------

Receiver::Event Receiver::push(std::span<const std::uint8_t>& bytes) noexcept {
  while (!bytes.empty()) {
    const std::uint64_t total = size_ < header_bytes ? header_bytes : header_bytes + header_.body_size;
    const std::size_t taken = static_cast<std::size_t>(std::min<std::uint64_t>(total - size_, bytes.size()));
    if (size_ < header_bytes || is_pose_message())
      std::copy_n(bytes.begin(), taken, bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += taken;
    bytes = bytes.subspan(taken);
    if (size_ == header_bytes && taken > 0 && total == header_bytes && !read_header()) {
      size_ = 0;
      return Event::no_header;
    }
    if (size_ >= header_bytes && size_ == header_bytes + header_.body_size) return finish();
  }
  return Event::more;
}

bool Receiver::read_header() noexcept {
  const std::span<const std::uint8_t> all(bytes_);
  header_.version = static_cast<std::uint16_t>(number_at(all, 0, 2));
  const bool has_texts = copy_text(all.subspan(2, 12), header_.type) &&
                         copy_text(all.subspan(14, max_name), header_.device) && header_.type[0] != 0;
  const std::uint64_t stamp = number_at(all, 34, 8);
  constexpr std::uint64_t second = 1'000'000'000;
  header_.t = static_cast<Nanoseconds>((stamp >> 32) * second + ((stamp & 0xffff'ffff) * second >> 32));
  header_.body_size = number_at(all, 42, 8);
  header_.crc = number_at(all, 50, 8);
  const bool has_size = header_.body_size <= (is_pose_message() ? capacity : max_body_bytes);
  return has_texts && has_size && header_.version >= 1 && header_.version <= 3;
}

bool Receiver::is_tdata() const noexcept { return std::string_view(header_.type.data()) == "TDATA"; }

/// True for messages whose body is read.
bool Receiver::is_pose_message() const noexcept {
  return is_tdata() || std::string_view(header_.type.data()) == "TRANSFORM";
}

Receiver::Event Receiver::finish() noexcept {
  size_ = 0;
  content_ = {};
  if (!is_pose_message()) return Event::passed;
  std::span<const std::uint8_t> body(bytes_.data() + header_bytes,
                                     static_cast<std::size_t>(header_.body_size));
  if (crc64(body) != header_.crc) return Event::bad_crc;
  if (header_.version > 1) {
    if (body.size() < extended_header_bytes) return Event::malformed;
    const std::uint64_t head = number_at(body, 0, 2), meta = number_at(body, 2, 2) + number_at(body, 4, 4);
    if (head < extended_header_bytes || head + meta > body.size()) return Event::malformed;
    body = body.subspan(static_cast<std::size_t>(head), static_cast<std::size_t>(body.size() - head - meta));
  }
  if (is_tdata() ? body.size() % tool_bytes != 0 : body.size() != transform_bytes) return Event::malformed;
  content_ = body;
  return Event::message;
}

std::size_t Receiver::num_poses() const noexcept {
  return content_.size() / (is_tdata() ? tool_bytes : transform_bytes);
}

ToolPose Receiver::pose(std::size_t index) const noexcept {
  if (!is_tdata()) return {.name = header_.device.data(), .X_TH = pose_of(content_)};
  const auto tool = content_.subspan(index * tool_bytes, tool_bytes);
  const auto* const name = reinterpret_cast<const char*>(tool.data());
  const auto length = static_cast<std::size_t>(std::find(name, name + max_name, '\0') - name);
  return {.name = std::string_view(name, length),
          .X_TH = pose_of(tool.subspan(tool_bytes - transform_bytes))};
}

// ---- sending ---------------------------------------------------------------------------------------

Message::Message(std::string_view type, std::string_view device, Nanoseconds t) noexcept {
  constexpr std::uint64_t second = 1'000'000'000;
  const auto ns = static_cast<std::uint64_t>(std::max<Nanoseconds>(t, 0));
  number(1, 2).text(type, 12).text(device, max_name);
  number(ns / second << 32 | ((ns % second << 32) / second), 8).number(0, 8).number(0, 8);
}

Message& Message::number(std::uint64_t value, std::size_t size) noexcept {
  for (std::size_t i = size; i-- > 0;)
    if (size_ < bytes_.size()) bytes_[size_++] = static_cast<std::uint8_t>(value >> (8 * i));
  return *this;
}

Message& Message::real(double value) noexcept { return number(std::bit_cast<std::uint64_t>(value), 8); }

Message& Message::text(std::string_view text, std::size_t size) noexcept {
  for (std::size_t i = 0; i < size; ++i) number(i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0u, 1);
  return *this;
}

Message& Message::pose(const Pose& X) noexcept {
  const Eigen::Matrix3d R = X.q.toRotationMatrix();
  const auto put = [this](double value) {
    number(std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
  };
  for (int i = 0; i < 9; ++i) put(R(i % 3, i / 3));
  for (int i = 0; i < 3; ++i) put(X.p[i] / mm);
  return *this;
}

std::span<const std::uint8_t> Message::finish() noexcept {
  const std::span<const std::uint8_t> all(bytes_.data(), size_);
  const std::size_t size = size_;
  size_ = 42;
  number(size - header_bytes, 8).number(crc64(all.subspan(header_bytes)), 8);
  size_ = size;
  return all;
}

}  // namespace godobject::openigtlink
