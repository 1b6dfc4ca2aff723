#include "platform/trace/csv_rows.h"

#include <array>
#include <charconv>
#include <fstream>
#include <memory>
#include <utility>

namespace godobject {

inline constexpr std::size_t buffer_size = 1 << 16;  // bytes

namespace {

CsvRows::Sink file_sink(const std::string& path) {
  return [file = std::make_shared<std::ofstream>(path, std::ios::binary)](std::string_view text) {
    file->write(text.data(), static_cast<std::streamsize>(text.size()));
    return !file->flush().fail();
  };
}

}  // namespace

CsvRows::CsvRows(const std::string& path) : CsvRows(file_sink(path)) { gathered_ = buffer_size; }

CsvRows::CsvRows(Sink sink) : sink_(std::move(sink)) { buffer_.reserve(2 * buffer_size); }

void CsvRows::header(std::span<const std::string> columns) {
  for (const std::string& column : columns) text(column);
  end_row();
}

void CsvRows::header(std::initializer_list<std::string_view> columns) {
  for (const std::string_view column : columns) text(column);
  end_row();
}

void CsvRows::number(double x) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
  buffer_.append(text.data(), end);
  buffer_ += ',';
}

void CsvRows::vector(const Vec3& a) {
  for (int i = 0; i < 3; ++i) number(a[i]);
}

void CsvRows::text(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    buffer_.append(text);
  } else {
    buffer_ += '"';
    for (const char c : text) buffer_.append(c == '"' ? 2 : 1, c);
    buffer_ += '"';
  }
  buffer_ += ',';
}

void CsvRows::end_row() {
  buffer_.back() = '\n';
  if (buffer_.size() > gathered_) flush();
}

bool CsvRows::close() {
  flush();
  return all_taken_;
}

void CsvRows::flush() {
  if (!buffer_.empty()) all_taken_ = sink_(buffer_) && all_taken_;
  buffer_.clear();
}

}  // namespace godobject
