// Lines of text for the debugger or emulator. newlib's printf is not used, because it allocates for a number with
// a fraction.
#pragma once

#include <cmath>
#include <cstdint>

#include "board.h"

namespace board {

/// A line of up to 199 characters.
class Line {
 public:
  Line& operator<<(const char* text) {
    while (*text != 0) text_[size_++] = *text++;
    return *this;
  }
  Line& operator<<(std::uint64_t number) { return digits(number, 1); }
  /// Adds a number with 12 decimals, |x| < 1e6.
  Line& operator<<(double x) {
    if (x < 0) text_[size_++] = '-';
    const double size = std::abs(x);
    std::uint64_t whole = static_cast<std::uint64_t>(size);
    std::uint64_t rest = static_cast<std::uint64_t>((size - static_cast<double>(whole)) * 1e12 + 0.5);
    if (rest == decimals) rest = 0, ++whole;
    digits(whole, 1);
    text_[size_++] = '.';
    return digits(rest, 12);
  }
  /// Prints the line and begins the next one.
  void end() {
    text_[size_++] = '\n';
    text_[size_] = 0;
    board::write(text_);
    size_ = 0;
  }

 private:
  static constexpr std::uint64_t decimals = 1'000'000'000'000;

  Line& digits(std::uint64_t number, int least) {
    char reversed[20];
    int n = 0;
    for (; number > 0 || n < least; number /= 10) reversed[n++] = static_cast<char>('0' + number % 10);
    while (n > 0) text_[size_++] = reversed[--n];
    return *this;
  }

  char text_[200];
  int size_ = 0;
};

}  // namespace board
