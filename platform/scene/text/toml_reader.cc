#include "platform/scene/text/toml_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/setup.h"

namespace godobject {

namespace {

// tolerance of unit length, for a quaternion or axis written in decimals
constexpr double unit_tolerance = 1e-6;
constexpr double rounding = 1e-15;          // within this already unit, and kept bit for bit
constexpr double inertia_tolerance = 1e-9;  // relative, for symmetry and triangle inequality
constexpr std::size_t max_strings = 1000;   // limit of strings in an array
constexpr std::size_t max_word = 100;       // bytes; longer than any key or name, so none is near
constexpr std::size_t max_dots = 1000;      // depth of a.b.c, counted without a comma, '=' or line end

TextPosition place(const toml::source_region& source) {
  return {std::max(source.begin.line, 1u), std::max(source.begin.column, 1u)};
}

std::string article_and_type(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table: return "a table";
    case toml::node_type::array: return "an array";
    case toml::node_type::string: return "a string";
    case toml::node_type::integer: return "an integer";
    case toml::node_type::floating_point: return "a number";
    case toml::node_type::boolean: return "a boolean";
    default: return "a date or time";
  }
}

std::string with_unit(const Key& key) { return key.unit.empty() ? "" : " (" + std::string(key.unit) + ")"; }

std::string quoted_list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
  return text.empty() ? "nothing (none is defined)" : text;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
      d[i][j] = std::min({replace, d[i - 1][j] + 1, d[i][j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

/// Returns the line on which tables nest deeper than the parser can follow; 0 if there is none.
std::uint32_t too_deep_line(std::string_view toml) {
  std::uint32_t line = 1;
  std::size_t dots = 0;
  for (const char c : toml) {
    if (c == '.' && ++dots > max_dots) return line;
    if (c == '\n' || c == '=' || c == ',') dots = 0;
    line += c == '\n';
  }
  return 0;
}

bool is_symmetric(const Mat3& I) {
  return (I - I.transpose()).cwiseAbs().maxCoeff() <= inertia_tolerance * I.cwiseAbs().maxCoeff();
}

std::string listed(const Vec3& moments) {
  std::ostringstream list;
  list << "its principal moments are " << moments.x() << ", " << moments.y() << ", " << moments.z()
       << " kg m^2";
  return list.str();
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& candidates, std::size_t most) {
  if (word.size() > max_word) return "";  // avoids quadratic time
  const auto distance = [&](const std::string& candidate) {
    return candidate.size() > max_word ? std::string::npos : edit_distance(word, candidate);
  };
  const auto best = std::ranges::min_element(candidates, {}, distance);
  if (best == candidates.end() || best->size() > max_word || distance(*best) > most) return "";
  return *best;
}

std::optional<toml::table> parse_toml(std::string_view text, Diagnostics& log) {
  if (const std::uint32_t line = too_deep_line(text)) {
    log.error({line, 1}, "more than " + std::to_string(max_dots) +
                             " dots in a row of names, deeper than any table of a scene");
    return std::nullopt;
  }
  toml::parse_result parsed = toml::parse(text, log.file());
  if (parsed.succeeded()) return std::move(parsed).table();
  const toml::source_position at = parsed.error().source().begin;
  log.error({at.line, at.column}, "not TOML: " + std::string(parsed.error().description()));
  return std::nullopt;
}

TomlReader::TomlReader(const toml::table& table, std::string path, std::string title, Diagnostics& log)
    : table_(table), path_(std::move(path)), title_(std::move(title)), log_(log) {}

// ---- values --------------------------------------------------------------------------------------

const toml::node* TomlReader::find(const Key& key) {
  known_.emplace_back(key.name);
  const toml::node* node = table_.get(key.name);
  if (!node && key.required) {
    log_.error(place(table_.source()), "required key '" + std::string(key.name) + "'" + with_unit(key) +
                                           " is missing in " + title_ +
                                           (key.meaning.empty() ? "" : ": " + std::string(key.meaning)));
  }
  return node;
}

std::optional<double> TomlReader::number(const Key& key, const toml::node& node) {
  double x = 0;
  if (const auto* real = node.as_floating_point()) {
    x = real->get();
  } else if (const auto* whole = node.as_integer()) {
    x = static_cast<double>(whole->get());
  } else {
    error(node, sentence(key.name, "must be a number" + with_unit(key) + ", not " + article_and_type(node)));
    return std::nullopt;
  }
  if (!std::isfinite(x)) {
    error(node, sentence(key.name, "must be finite"));
    return std::nullopt;
  }
  if (!key.range.contains(x)) {
    const std::string written = node.is_integer() ? std::to_string(node.as_integer()->get()) : shortest(x);
    error(node, sentence(key.name, "is " + written + ", out of range: admissible is " + to_string(key.range) +
                                       with_unit(key)));
    return std::nullopt;
  }
  return x;
}

void TomlReader::value(const Key& key, double& x) {
  const toml::node* node = find(key);
  if (!node) return;
  if (const std::optional<double> read = number(key, *node)) x = *read;
}

std::optional<std::int64_t> TomlReader::integer(const Key& key) {
  const toml::node* node = find(key);
  if (!node) return std::nullopt;
  if (!node->is_integer()) {
    error(*node, sentence(key.name, "must be an integer, not " + article_and_type(*node)));
    return std::nullopt;
  }
  if (!number(key, *node)) return std::nullopt;
  return node->as_integer()->get();
}

void TomlReader::value(const Key& key, std::string& x) {
  const toml::node* node = find(key);
  if (!node) return;
  if (const auto* text = node->as_string()) {
    x = text->get();
  } else {
    error(*node, sentence(key.name, "must be a string, not " + article_and_type(*node)));
  }
}

std::vector<double> TomlReader::numbers(const Key& key, const toml::node& node, std::size_t n) {
  const toml::array* array = node.as_array();
  if (!array || array->size() != n) {
    const std::string is = array ? std::to_string(array->size()) + " of them" : article_and_type(node);
    error(node, sentence(key.name, "must be an array of " + std::to_string(n) + " numbers" + with_unit(key) +
                                       ", not " + is));
    return {};
  }
  std::vector<double> values;
  for (const toml::node& element : *array) {
    if (const std::optional<double> x = number(key, element)) values.push_back(*x);
  }
  if (values.size() != n) values.clear();
  return values;
}

void TomlReader::value(const Key& key, Vec3& x) {
  const toml::node* node = find(key);
  if (!node) return;
  const std::vector<double> values = numbers(key, *node, 3);
  if (!values.empty()) x = Vec3(values[0], values[1], values[2]);
}

void TomlReader::value(const Key& key, bool& x) {
  const toml::node* node = find(key);
  if (!node) return;
  if (const auto* yes = node->as_boolean()) {
    x = yes->get();
  } else {
    error(*node, sentence(key.name, "must be true or false, not " + article_and_type(*node)));
  }
}

void TomlReader::value(const Key& key, std::optional<double>& x) {
  if (const toml::node* node = find(key)) x = number(key, *node);
}

void TomlReader::value(const Key& key, std::optional<Vec3>& x) {
  if (!has(key.name)) {
    find(key);  // marks the key as known
    return;
  }
  x = Vec3::Zero();
  value(key, *x);
}

std::string TomlReader::path(const Key& key, std::string& x) {
  value(key, x);
  if (x.empty()) return "";
  FilePath found = path_below(std::filesystem::path(log_.file()).parent_path().string(), x);
  check(found.why_not.empty(), key.name, found.why_not);
  return std::move(found.path);
}

void TomlReader::value(const Key& key, std::vector<std::string>& x) {
  const toml::node* node = find(key);
  if (!node) return;
  const toml::array* array = node->as_array();
  if (!array || !std::ranges::all_of(*array, [](const toml::node& n) { return n.is_string(); })) {
    error(*node, sentence(key.name, "must be an array of strings"));
    return;
  }
  if (array->size() > max_strings) {
    error(*node, sentence(key.name, "has " + std::to_string(array->size()) + " strings; at most " +
                                        std::to_string(max_strings) + " are possible"));
    return;
  }
  x.clear();
  for (const toml::node& element : *array) x.push_back(element.as_string()->get());
}

void TomlReader::either(const Key& key, const Key& other, double unit_of_other,
                        std::optional<double> fallback, double& x) {
  const bool has_other = has(other.name);
  if (has(key.name) && has_other) {
    check(false, other.name,
          "and '" + std::string(key.name) + "' give the same quantity: remove one of them");
  }
  Key required_unless_other = key;
  required_unless_other.required = key.required && !has_other;
  if (fallback) x = *fallback;
  if (has_other) {
    double in_units = 0;
    value(other, in_units);
    x = in_units * unit_of_other;
  } else {
    known_.emplace_back(other.name);
  }
  value(required_unless_other, x);
}

// ---- rotations, inertia, names -------------------------------------------------------------------

void TomlReader::unit_vector(const Key& key, Vec3& x) {
  const toml::node* node = find(key);
  if (!node) return;
  const std::vector<double> values = numbers(key, *node, 3);
  if (values.empty()) return;
  const Vec3 a(values[0], values[1], values[2]);
  if (std::abs(a.norm() - 1) > unit_tolerance) {
    error(*node, sentence(key.name, "must have length 1; its length is " + shortest(a.norm())));
    return;
  }
  x = std::abs(a.norm() - 1) > rounding ? a.normalized().eval() : a;
}

void TomlReader::attitude(const Key& key, Quat& q) {
  const toml::node* node = find(key);
  if (!node) return;
  const std::vector<double> wxyz = numbers(key, *node, 4);
  if (wxyz.empty()) return;
  const Quat read(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (std::abs(read.norm() - 1) > unit_tolerance) {
    error(*node,
          sentence(key.name, "must be a unit quaternion [w, x, y, z]; its norm is " + shortest(read.norm())));
    return;
  }
  q = std::abs(read.norm() - 1) > rounding ? Quat(read.normalized()) : read;
}

void TomlReader::value(const Key& key, std::vector<std::vector<double>>& x) {
  const toml::node* node = find(key);
  if (!node) return;
  const toml::array* rows = node->as_array();
  const toml::array* first = rows && !rows->empty() ? rows->get(0)->as_array() : nullptr;
  if (!first) {
    error(*node, sentence(key.name, "must be a matrix: an array of rows, as [[1, 0], [0, 1]]"));
    return;
  }
  std::vector<std::vector<double>> read;
  for (const toml::node& row : *rows) {
    std::vector<double> values = numbers(key, row, first->size());
    if (values.empty()) return;
    read.push_back(std::move(values));
  }
  x = std::move(read);
}

std::optional<Mat3> TomlReader::matrix(const Key& key, const toml::node& node) {
  const toml::array* rows = node.as_array();
  if (!rows || rows->size() != 3) {
    error(node, sentence(key.name, "must be 3 principal moments or a 3x3 matrix" + with_unit(key)));
    return std::nullopt;
  }
  if (!rows->get(0)->is_array()) {
    const std::vector<double> moments = numbers(key, node, 3);
    if (moments.empty()) return std::nullopt;
    return Mat3(Vec3(moments[0], moments[1], moments[2]).asDiagonal());
  }
  Mat3 I = Mat3::Zero();
  for (int i = 0; i < 3; ++i) {
    const std::vector<double> row = numbers(key, *rows->get(static_cast<std::size_t>(i)), 3);
    if (row.empty()) return std::nullopt;
    I.row(i) << row[0], row[1], row[2];
  }
  return I;
}

void TomlReader::inertia(const Key& key, Mat3& I) {
  const toml::node* node = find(key);
  if (!node) return;
  const std::optional<Mat3> read = matrix(key, *node);
  if (!read) return;
  if (!is_symmetric(*read)) {
    error(*node, sentence(key.name, "must be symmetric"));
    return;
  }
  const Vec3 moments = principal_moments(*read);
  if (!(moments.x() > 0)) {
    error(*node, sentence(key.name, "must be positive definite; " + listed(moments)));
    return;
  }
  I = 0.5 * (*read + read->transpose());
  // No solid has such an inertia, but textbook cases do, and the equations hold.
  const bool possible = moments.z() <= (moments.x() + moments.y()) * (1 + inertia_tolerance);
  advise(possible, key.name,
         "is not that of a solid: the largest moment is more than the sum of the others; " + listed(moments));
}

void TomlReader::one_of(const Key& key, const std::vector<std::string>& names, std::size_t& index) {
  if (!has(key.name)) {
    find(key);  // marks the key as known; an error if it is required
    return;
  }
  std::string text;
  value(key, text);
  const toml::node& node = *table_.get(key.name);
  if (!node.is_string()) return;
  const auto found = std::ranges::find(names, text);
  if (found == names.end()) {
    const std::string near = nearest(text, names);
    const std::string guess = near.empty() ? "" : "; the nearest is \"" + near + "\"";
    error(node,
          sentence(key.name, "is \"" + shortened(text) + "\"; admissible is " + quoted_list(names) + guess));
    return;
  }
  index = static_cast<std::size_t>(found - names.begin());
}

// ---- tables and rules ----------------------------------------------------------------------------

const toml::node* TomlReader::subtable(const TableKey& key) {
  const toml::node* node =
      find(Key{.name = key.name, .unit = "", .meaning = key.meaning, .required = key.required});
  if (!node || node->is_table()) return node;
  error(*node, sentence(key.name,
                        "must be a table, written [" + path_of(key) + "], not " + article_and_type(*node)));
  return nullptr;
}

std::vector<const toml::table*> TomlReader::subtables(const TableKey& key) {
  const toml::node* node =
      find(Key{.name = key.name, .unit = "", .meaning = key.meaning, .required = key.required});
  std::vector<const toml::table*> tables;
  if (!node) return tables;
  const toml::array* array = node->as_array();
  if (!array || !std::ranges::all_of(*array, [](const toml::node& n) { return n.is_table(); })) {
    error(*node, sentence(key.name, "must be an array of tables: write each as [[" + path_of(key) + "]]"));
    return tables;
  }
  if (array->size() > key.max) {
    error(*node, "there are " + std::to_string(array->size()) + " tables [[" + path_of(key) + "]]; at most " +
                     std::to_string(key.max) + " are possible");
    return tables;
  }
  for (const toml::node& element : *array) tables.push_back(element.as_table());
  return tables;
}

bool TomlReader::understood(std::string_view name) const {
  return has(name) && !log_.has_error(place_of(name));
}

void TomlReader::check(bool ok, std::string_view name, const std::string& what) {
  if (!ok) log_.error(place_of(name), sentence(name, what));
}

void TomlReader::advise(bool ok, std::string_view name, const std::string& what) {
  if (!ok) log_.warning(place_of(name), sentence(name, what));
}

void TomlReader::finish() {
  for (const auto& [key, node] : table_) {
    const std::string_view name = key.str();
    if (std::ranges::find(known_, name) != known_.end()) continue;
    // omitted after many errors, because it takes time
    const std::string guess = log_.full() ? "" : nearest(name, known_);
    log_.error(place(key.source()), "unknown key " + excerpt(name) + " in " + title_ +
                                        (guess.empty() ? "" : "; the nearest known key is '" + guess + "'"));
  }
}

std::string TomlReader::path_of(const TableKey& key) const {
  return path_.empty() ? std::string(key.name) : path_ + "." + std::string(key.name);
}

std::string TomlReader::sentence(std::string_view name, const std::string& what) const {
  return name.empty() ? what : "'" + std::string(name) + "' " + what;
}

TextPosition TomlReader::place_of(std::string_view name) const {
  const toml::node* node = name.empty() ? nullptr : table_.get(name);
  return place(node ? node->source() : table_.source());
}

void TomlReader::error(const toml::node& node, const std::string& what) {
  log_.error(place(node.source()), what);
}

}  // namespace godobject
