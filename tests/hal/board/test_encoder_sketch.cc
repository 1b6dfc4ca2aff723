// The sketch of docs/encoder-board, compiled for the host: pins moved by a turning encoder, a clock, and the
// receiver.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "hal/board/encoder_board.h"

namespace godobject::test_encoder_sketch {
namespace sketch {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wparentheses"

// NOLINTBEGIN(readability-identifier-naming): Arduino's
constexpr int INPUT_PULLUP = 0, CHANGE = 0;
std::array<int, 8> pins{};
std::array<void (*)(), 8> interrupt_of{};
std::uint32_t clock_us = 0;
struct {
  void begin(std::uint32_t) {}
  void write(const std::uint8_t* data, std::size_t n) { sent.insert(sent.end(), data, data + n); }
  std::vector<std::uint8_t> sent;
} Serial;

int digitalRead(int pin) { return pins[static_cast<std::size_t>(pin)]; }
void pinMode(int, int) {}
int digitalPinToInterrupt(int pin) { return pin; }
void attachInterrupt(int pin, void (*handler)(), int) {
  interrupt_of[static_cast<std::size_t>(pin)] = handler;
}
std::uint32_t micros() { return clock_us; }
void noInterrupts() {}
void interrupts() {}
// NOLINTEND(readability-identifier-naming)

#include "docs/encoder-board/encoder_board.ino"

#pragma GCC diagnostic pop

void set_pin(std::size_t pin, int level) {
  if (pins[pin] == level) return;
  pins[pin] = level;
  interrupt_of[pin]();
}

}  // namespace sketch

namespace {

TEST(EncoderSketch, WhatItSendsIsWhatTheHostReads) {
  constexpr std::array<int, 4> a{0, 0, 1, 1}, b{0, 1, 1, 0};  // one turn of the Gray code
  sketch::setup();
  EncoderBoard host;
  std::int32_t place = 0;
  for (; sketch::clock_us < 3'000'000; sketch::clock_us += 100) {
    const auto t = sketch::clock_us;
    if (t < 2'000'000) place += t < 1'500'000 ? 1 : -1;
    sketch::set_pin(2, a[static_cast<unsigned>(place) & 3u]);
    sketch::set_pin(3, b[static_cast<unsigned>(place) & 3u]);
    sketch::loop();
    static_cast<void>(host.receive(sketch::Serial.sent, 1000 * Nanoseconds{t}));
    sketch::Serial.sent.clear();
  }
  EXPECT_EQ(host.counters().frames, 3000u);
  EXPECT_EQ(host.counters().lost + host.counters().bad_crc + host.counters().malformed, 0u);
  EXPECT_EQ(host.frame().num_counts, 2u);
  EXPECT_EQ(host.frame().counts[0], place);
  EXPECT_EQ(host.frame().counts[1], 0);
  EXPECT_EQ(host.frame().status, board_status::not_referenced);
}

}  // namespace
}  // namespace godobject::test_encoder_sketch
