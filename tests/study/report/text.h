// Formats numbers for the report.
#pragma once

#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>

namespace godobject::study {

inline std::string number(double value, int digits = 3) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}
inline std::string number(const std::optional<double>& value, int digits = 3) {
  return value ? number(*value, digits) : "not available";
}
/// True for a step of 1 ms, that of the tables; other steps are in the CSV files.
inline bool is_one_ms(double h) { return std::abs(h - 1e-3) < 1e-9; }
inline std::string whole(const std::optional<double>& value) {
  return value ? std::to_string(std::lround(*value)) : "not available";
}

}  // namespace godobject::study
