#include "tests/oracle/case/csv_table.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace godobject::oracle {

namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

double parse(const std::string& field, const std::string& place) {
  double number = 0;
  const char* end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, number);
  if (error != std::errc() || stop != end)
    throw std::runtime_error(place + ": '" + field + "' is not a number");
  return number;
}

}  // namespace

CsvTable::CsvTable(const std::filesystem::path& file) : file_(file) {
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line)) throw std::runtime_error(file.string() + ": cannot be read, or is empty");
  names_ = split(line);
  for (std::size_t line_number = 2; std::getline(stream, line); ++line_number) {
    const std::string place = file.string() + ":" + std::to_string(line_number);
    const std::vector<std::string> fields = split(line);
    if (fields.size() != names_.size())
      throw std::runtime_error(place + ": not as many fields as the header");
    std::vector<double>& row = rows_.emplace_back();
    for (const std::string& field : fields) row.push_back(parse(field, place));
  }
}

std::vector<double> CsvTable::column(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) throw std::runtime_error(file_.string() + ": no column '" + name + "'");
  const auto index = static_cast<std::size_t>(found - names_.begin());
  std::vector<double> values;
  for (const std::vector<double>& row : rows_) values.push_back(row[index]);
  return values;
}

}  // namespace godobject::oracle
