#include "platform/view/picture/png.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace godobject {
namespace {

void put_u32(std::string& to, std::uint32_t value) {
  for (unsigned shift = 32; shift > 0; shift -= 8) to += static_cast<char>(value >> (shift - 8) & 0xFFu);
}

std::uint32_t crc32(std::string_view bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> rows{};
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
      std::uint32_t c = i;
      for (int k = 0; k < 8; ++k) c = (c & 1u) != 0 ? 0xEDB88320u ^ (c >> 1u) : c >> 1u;
      rows[i] = c;
    }
    return rows;
  }();
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const char byte : bytes) crc = table[(crc ^ static_cast<std::uint8_t>(byte)) & 0xFFu] ^ (crc >> 8u);
  return ~crc;
}

void put_chunk(std::string& to, std::string_view type, std::string_view data) {
  put_u32(to, static_cast<std::uint32_t>(data.size()));
  std::string body(type);
  body += data;
  to += body;
  put_u32(to, crc32(body));
}

/// Deflate with the fixed codes. Its only matches are runs of one byte, which occur in flat areas.
class Deflate {
 public:
  explicit Deflate(std::string& to) : to_(to) {
    put(1, 1);  // the last block
    put(1, 2);  // with fixed codes
  }
  void run(std::uint8_t byte, std::size_t length) {
    constexpr std::size_t longest = 258, shortest = 3;
    literal(byte);
    for (--length; length >= shortest;) {
      const std::size_t now = std::min(length, longest);
      match(static_cast<unsigned>(now));
      length -= now;
    }
    for (; length > 0; --length) literal(byte);
  }
  void end() {
    symbol(256);
    if (num_bits_ > 0) to_ += static_cast<char>(bits_);
  }

 private:
  /// Writes bits, least significant bit first.
  void put(std::uint32_t value, unsigned bits) {
    bits_ |= value << num_bits_;
    for (num_bits_ += bits; num_bits_ >= 8; num_bits_ -= 8, bits_ >>= 8u)
      to_ += static_cast<char>(bits_ & 0xFFu);
  }
  /// Writes a Huffman code, most significant bit first.
  void code(std::uint32_t value, unsigned bits) {
    std::uint32_t reversed = 0;
    for (unsigned i = 0; i < bits; ++i) reversed |= (value >> i & 1u) << (bits - 1 - i);
    put(reversed, bits);
  }
  void symbol(unsigned s) {
    if (s < 144) code(0x30 + s, 8);
    else if (s < 256) code(0x190 + s - 144, 9);
    else if (s < 280) code(s - 256, 7);
    else code(0xC0 + s - 280, 8);
  }
  void literal(std::uint8_t byte) { symbol(byte); }
  /// Writes `length` bytes, 3 to 258, equal to the previous byte.
  void match(unsigned length) {
    static constexpr std::array<unsigned, 29> base{3,  4,  5,  6,   7,   8,   9,   10,  11, 13,
                                                   15, 17, 19, 23,  27,  31,  35,  43,  51, 59,
                                                   67, 83, 99, 115, 131, 163, 195, 227, 258};
    static constexpr std::array<unsigned, 29> extra{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                                    2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
    std::size_t i = base.size() - 1;
    while (base[i] > length) --i;
    symbol(static_cast<unsigned>(257 + i));
    put(length - base[i], extra[i]);
    code(0, 5);  // a distance of 1
  }

  std::string& to_;
  std::uint32_t bits_ = 0;
  unsigned num_bits_ = 0;
};

std::string zlib_of(const std::vector<std::uint8_t>& bytes) {
  std::string to("\x78\x01", 2);
  Deflate deflate(to);
  std::uint32_t a = 1, b = 0;  // Adler-32
  for (std::size_t i = 0; i < bytes.size();) {
    std::size_t end = i + 1;
    while (end < bytes.size() && bytes[end] == bytes[i]) ++end;
    deflate.run(bytes[i], end - i);
    for (; i < end; ++i) {
      a = (a + bytes[i]) % 65521;
      b = (b + a) % 65521;
    }
  }
  deflate.end();
  put_u32(to, b << 16u | a);
  return to;
}

/// Encodes each row as its difference to the row above, which is zero in flat areas.
std::string rows_of(const Image& image) {
  constexpr std::uint8_t filter_up = 2;
  const std::size_t stride = std::size_t{3} * image.width;
  std::vector<std::uint8_t> rows;
  rows.reserve((stride + 1) * image.height);
  for (std::size_t y = 0; y < image.height; ++y) {
    rows.push_back(filter_up);
    for (std::size_t x = 0; x < stride; ++x) {
      const std::uint8_t above = y > 0 ? image.rgb[(y - 1) * stride + x] : std::uint8_t{0};
      rows.push_back(static_cast<std::uint8_t>(image.rgb[y * stride + x] - above));
    }
  }
  return zlib_of(rows);
}

std::string header_of(const Image& image) {
  std::string data;
  put_u32(data, image.width);
  put_u32(data, image.height);
  return data.append("\x08\x02\x00\x00\x00", 5);  // 8 bits, RGB
}

std::string frame_control(const Image& image, std::uint32_t number, double seconds) {
  std::string data;
  for (const std::uint32_t value : {number, image.width, image.height, 0u, 0u}) put_u32(data, value);
  const auto ms = static_cast<std::uint32_t>(std::lround(1000 * seconds));
  put_u32(data, (ms & 0xFFFFu) << 16u | 1000u);
  return data.append(2, '\0');  // stays, replaces
}

}  // namespace

std::string png_of(const std::vector<Image>& images, double seconds) {
  std::string to("\x89PNG\r\n\x1a\n", 8);
  put_chunk(to, "IHDR", header_of(images.front()));
  const bool moves = images.size() > 1;
  if (moves) {
    std::string control;
    put_u32(control, static_cast<std::uint32_t>(images.size()));
    put_u32(control, 0);  // repeats endlessly
    put_chunk(to, "acTL", control);
  }
  std::uint32_t number = 0;
  for (const Image& image : images) {
    if (moves) put_chunk(to, "fcTL", frame_control(image, number++, seconds));
    if (number <= 1) {
      put_chunk(to, "IDAT", rows_of(image));
      continue;
    }
    std::string data;
    put_u32(data, number++);
    put_chunk(to, "fdAT", data + rows_of(image));
  }
  put_chunk(to, "IEND", "");
  return to;
}

}  // namespace godobject
