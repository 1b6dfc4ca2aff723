// Writes rows of a result file: text and numbers; a missing number is an empty field.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <optional>
#include <stdexcept>
#include <string>

namespace godobject::study {

class CsvWriter {
 public:
  /// Throws std::runtime_error if the file cannot be written.
  CsvWriter(const std::filesystem::path& file, const std::string& header) : stream_(file) {
    if (!stream_) throw std::runtime_error(file.string() + ": cannot be written");
    stream_ << std::setprecision(9) << header << '\n';
  }

  template <class... Fields>
  void row(const Fields&... fields) {
    const char* separator = "";
    ((stream_ << separator, field(fields), separator = ","), ...);
    stream_ << '\n';
  }

 private:
  template <class T>
  void field(const T& value) {
    stream_ << value;
  }
  void field(double value) {
    if (std::isfinite(value)) stream_ << value;
  }
  void field(const std::optional<double>& value) {
    if (value) field(*value);
  }

  std::ofstream stream_;
};

}  // namespace godobject::study
