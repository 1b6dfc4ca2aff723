// Reads the words of a text one by one, with their lines. Safe for untrusted files.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace godobject {

class TextScanner {
 public:
  explicit TextScanner(std::string_view text) : rest_(text) {}

  /// Returns the next word, on this line or a later one; empty at the end of the text.
  std::string_view word() {
    while (!rest_.empty() && is_space(rest_.front())) {
      line_ += rest_.front() == '\n';
      rest_.remove_prefix(1);
    }
    return take(rest_, word_length(rest_));
  }
  /// Returns the rest of this line without its end.
  std::string_view rest_of_line() {
    const std::string_view line = take(rest_, std::min(rest_.find('\n'), rest_.size()));
    if (rest_.empty()) return line;
    rest_.remove_prefix(1);
    ++line_;
    return line;
  }
  /// As rest_of_line(), joined with the next line after a backslash at its end.
  std::string_view rest_of_joined_line() {
    std::string_view line = rest_of_line();
    while (!rest_.empty() && (line.ends_with('\\') || line.ends_with("\\\r"))) {
      const char* const begin = line.data();
      const std::string_view next = rest_of_line();
      line = {begin, static_cast<std::size_t>(next.data() + next.size() - begin)};
    }
    return line;
  }
  std::string_view rest() const { return rest_; }
  /// Returns the line of the latest word, counted from 1.
  std::size_t line() const { return line_; }

  /// Returns the first word of a line, and removes it from the line.
  static std::string_view first_word(std::string_view& line) {
    line.remove_prefix(static_cast<std::size_t>(std::ranges::find_if_not(line, is_space) - line.begin()));
    return take(line, word_length(line));
  }

 private:
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  static std::size_t word_length(std::string_view text) {
    return static_cast<std::size_t>(std::ranges::find_if(text, is_space) - text.begin());
  }
  static std::string_view take(std::string_view& text, std::size_t length) {
    const std::string_view taken = text.substr(0, length);
    text.remove_prefix(length);
    return taken;
  }

  std::string_view rest_;
  std::size_t line_ = 1;
};

/// Parses the whole word as a number.
template <class T>
std::optional<T> number_of(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  T value{};
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (problem != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace godobject
