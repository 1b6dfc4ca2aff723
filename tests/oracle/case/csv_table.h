// Numbers in named columns, as the motion and reference files hold them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace godobject::oracle {

class CsvTable {
 public:
  /// Reads a file of one header line and rows of numbers. Throws std::runtime_error with file and line.
  /// Reasons: it cannot be read, a field is not a number, or a row differs in length from the header.
  explicit CsvTable(const std::filesystem::path& file);

  std::size_t num_rows() const { return rows_.size(); }

  /// Throws std::runtime_error if there is no such column.
  std::vector<double> column(const std::string& name) const;

 private:
  std::filesystem::path file_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> rows_;
};

}  // namespace godobject::oracle
