// Numbers, texts and events of a rig as bytes of an input log.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "platform/device/link_record.h"

namespace godobject {

// ---- writing ---------------------------------------------------------------------------------------

/// Appends a number, low bytes first.
template <class Int>
void put(std::string& out, Int value) {
  std::array<char, sizeof value> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff);
  out.append(bytes.data(), bytes.size());
}

inline void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

/// Appends a number in 7 bits a byte, low ones first; the high bit is set in all bytes but the last.
inline void put_short(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out += static_cast<char>((value & 0x7f) | 0x80);
  out += static_cast<char>(value);
}

/// Appends a difference of times with its sign in the lowest bit.
inline void put_difference(std::string& out, Nanoseconds value) {
  put_short(out, static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63));
}

/// Appends an event: its kind, `results`, and the members of this kind. before: time of the event before, ns.
void put_link(std::string& out, const LinkEvent& event, Nanoseconds before);

// ---- reading ---------------------------------------------------------------------------------------

/// Reads numbers and texts from the front of bytes; zero and empty beyond their end.
class LogBytes {
 public:
  explicit LogBytes(std::string_view bytes) : rest_(bytes) {}

  template <class Int>
  Int number() {
    const std::string_view bytes = text(sizeof(Int));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      value |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
    return static_cast<Int>(value);
  }
  /// Reads a number of put_short().
  std::uint64_t short_number() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64 && complete_; shift += 7) {
      const auto byte = number<std::uint8_t>();
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if ((byte & 0x80) == 0) return value;
    }
    complete_ = false;
    return 0;
  }
  /// Reads a time, of which put_difference() wrote the difference from `before`.
  Nanoseconds after(Nanoseconds before) {
    const std::uint64_t value = short_number();
    return static_cast<Nanoseconds>(static_cast<std::uint64_t>(before) + (value >> 1 ^ (~(value & 1) + 1)));
  }
  /// Reads an enumerator, of which there are `count`.
  template <class Enum>
  Enum choice(std::uint8_t count) {
    const auto value = number<std::uint8_t>();
    complete_ = complete_ && value < count;
    return complete_ ? static_cast<Enum>(value) : Enum{};
  }
  std::string_view text(std::size_t size) {
    complete_ = complete_ && size <= rest_.size();
    const std::string_view taken = rest_.substr(0, complete_ ? size : 0);
    rest_.remove_prefix(taken.size());
    return taken;
  }
  std::string_view text() { return text(number<std::uint32_t>()); }
  std::string_view rest() const { return rest_; }
  bool is_complete() const { return complete_; }

 private:
  std::string_view rest_;
  bool complete_ = true;
};

/// Reads an event of put_link().
LinkEvent take_link(LogBytes& bytes, Nanoseconds before);

}  // namespace godobject
