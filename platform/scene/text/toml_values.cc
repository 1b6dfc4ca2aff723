// Values of TOML tables: numbers, vectors, attitudes, inertias, names.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/setup.h"
#include "platform/scene/text/toml_reader.h"

namespace godobject {
namespace {

// tolerance of unit length, for a quaternion or axis written in decimals
constexpr double unit_tolerance = 1e-6;
constexpr double rounding = 1e-15;          // within this already unit, and kept bit for bit
constexpr double inertia_tolerance = 1e-9;  // relative, for symmetry and triangle inequality
constexpr std::size_t max_strings = 1000;   // limit of strings in an array

std::string quoted_list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
  return text.empty() ? "nothing (none is defined)" : text;
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

}  // namespace godobject
