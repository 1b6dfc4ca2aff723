#include "hal/base/cobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace godobject::test_cobs {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Result = CobsDecoder::Result;

Bytes encoded(const Bytes& payload) {
  Bytes out(cobs_size(payload.size()), 0xEE);
  const std::optional<std::size_t> size = cobs_encode(payload, out);
  if (!size) return {};
  out.resize(*size);
  return out;
}

/// Results of all bytes that end a frame.
struct Decoded {
  std::vector<Bytes> frames;
  int cut_off = 0, too_large = 0;
};

Decoded decoded(const Bytes& wire) {
  CobsDecoder decoder;
  Decoded all;
  for (const std::uint8_t byte : wire) {
    switch (decoder.push(byte)) {
      case Result::more: break;
      case Result::frame: all.frames.emplace_back(decoder.payload().begin(), decoder.payload().end()); break;
      case Result::cut_off: ++all.cut_off; break;
      case Result::too_large: ++all.too_large; break;
    }
  }
  return all;
}

TEST(Cobs, GoldenVectors) {
  EXPECT_EQ(encoded({0x11, 0x00, 0x22, 0x00}), (Bytes{0x02, 0x11, 0x02, 0x22, 0x01, 0x00}));
  EXPECT_EQ(encoded({0x11, 0x22, 0x00, 0x33}), (Bytes{0x03, 0x11, 0x22, 0x02, 0x33, 0x00}));
  EXPECT_EQ(encoded({0x00}), (Bytes{0x01, 0x01, 0x00}));
  EXPECT_EQ(encoded({}), (Bytes{0x01, 0x00}));
}

TEST(Cobs, EverySizeComesBack) {
  std::mt19937 random(1);
  for (std::size_t size = 0; size <= CobsDecoder::max_payload; ++size) {
    for (const int zero_in : {1, 4, 300}) {
      Bytes payload(size);
      for (std::uint8_t& byte : payload)
        byte = static_cast<int>(random() % static_cast<unsigned>(zero_in)) == 0 && zero_in < 300
                   ? std::uint8_t{0}
                   : static_cast<std::uint8_t>(1 + random() % 255);
      const Bytes wire = encoded(payload);
      ASSERT_LE(wire.size(), cobs_size(size));
      EXPECT_EQ(std::ranges::count(wire, 0), 1);
      EXPECT_EQ(decoded(wire).frames, std::vector<Bytes>({payload})) << size;
    }
  }
}

TEST(Cobs, BothFormsAfterAFullBlockAreRead) {
  const Bytes payload(254, 0x55);
  Bytes without(255, 0x55);
  without[0] = 0xFF;
  Bytes with = without;
  with.push_back(0x01);
  without.push_back(0);
  with.push_back(0);
  EXPECT_EQ(decoded(without).frames, std::vector<Bytes>({payload}));
  EXPECT_EQ(decoded(with).frames, std::vector<Bytes>({payload}));
}

TEST(Cobs, ACutFrameCostsOneFrame) {
  const Bytes wire = encoded({1, 2, 3, 4, 5});
  for (std::size_t lost = 1; lost + 1 < wire.size(); ++lost) {
    Bytes broken = wire;
    broken.erase(broken.begin() + static_cast<std::ptrdiff_t>(lost));
    broken.insert(broken.end(), wire.begin(), wire.end());
    const Decoded all = decoded(broken);
    EXPECT_EQ(all.cut_off, 1);
    EXPECT_EQ(all.frames, std::vector<Bytes>({{1, 2, 3, 4, 5}}));
  }
}

TEST(Cobs, TooLargeIsReportedAndTheNextFrameRead) {
  Bytes wire;
  for (int block = 0; block < 2; ++block) {
    wire.push_back(0xFF);
    wire.insert(wire.end(), 254, 0x55);
  }
  wire.push_back(0);
  const Bytes next = encoded({7, 8});
  wire.insert(wire.end(), next.begin(), next.end());
  const Decoded all = decoded(wire);
  EXPECT_EQ(all.too_large, 1);
  EXPECT_EQ(all.frames, std::vector<Bytes>({{7, 8}}));
}

TEST(Cobs, ZerosBetweenFramesAreNothing) {
  const Decoded all = decoded({0, 0, 0x03, 0x07, 0x08, 0, 0, 0});
  EXPECT_EQ(all.frames, std::vector<Bytes>({{7, 8}}));
  EXPECT_EQ(all.cut_off + all.too_large, 0);
}

TEST(Cobs, AnyBytesAreSurvived) {
  std::mt19937 random(2);
  CobsDecoder decoder;
  for (int i = 0; i < 1'000'000; ++i) {
    static_cast<void>(decoder.push(static_cast<std::uint8_t>(random() % (i % 3 == 0 ? 3 : 256))));
    ASSERT_LE(decoder.payload().size(), CobsDecoder::max_payload);
  }
}

TEST(Cobs, EncoderRefusesASmallBuffer) {
  Bytes out(5);
  EXPECT_FALSE(cobs_encode(Bytes{1, 2, 3, 4}, out));
}

}  // namespace
}  // namespace godobject::test_cobs
