// Keys of scene files: name, unit, admissible range and meaning, and the common part of the lists of keys
// (../keys/). A visitor V walks the lists: toml_reader.h fills a SceneConfig from a file, key_writers.h
// prints one or writes the reference of the format. V offers
//   value, unit_vector, attitude, inertia, one_of   a key and its member
//   path         a file in the folder of the file being read, or below; returns its path
//   either       two spellings of one number: value, or other * unit_of_other; else the fallback
//   shorthand    a value that only sets defaults of other members, never written
//   pose, keys_of   only in the reference: one line for both keys of a pose, or for keys of another table
//   table, tables, has, check, advise               structure, and rules beyond a single range
// Within a table values come before sub-tables, as TOML requires.
#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/types.h"
#include "hal/base/format.h"

namespace godobject {

/// Admissible numbers; both ends are included, except min if min_open.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;

  bool contains(double x) const { return (min_open ? x > min : x >= min) && x <= max; }
};

inline constexpr Range any_number{};
inline constexpr Range not_negative{0};
inline constexpr Range positive{.min = 0, .min_open = true};
inline constexpr Range probability{0, 1};
inline constexpr Range mass_of_body{1e-12, 1e9};  // kg

struct Key {
  std::string_view name;
  std::string_view unit;  // empty: none
  std::string_view meaning;
  Range range = any_number;
  bool required = false;
  std::string_view otherwise = {};  // text of the default if it depends on other keys
};

/// Returns " (m)"; empty without a unit.
inline std::string with_unit(const Key& key) {
  return key.unit.empty() ? "" : " (" + std::string(key.unit) + ")";
}

struct TableKey {
  std::string_view name;
  std::string_view meaning;
  bool required = false;
  // largest number of tables in an array, since rules between them may take quadratic time
  std::size_t max = 1000;
};

/// Returns ">= 0", "> 0" or "0 to 1"; empty for any number.
inline std::string to_string(const Range& range) {
  const bool has_min = std::isfinite(range.min), has_max = std::isfinite(range.max);
  if (has_min && has_max) {
    return range.min_open ? "> " + shortest_plain(range.min) + " and <= " + shortest_plain(range.max)
                          : shortest_plain(range.min) + " to " + shortest_plain(range.max);
  }
  if (has_min) return (range.min_open ? "> " : ">= ") + shortest_plain(range.min);
  return has_max ? "<= " + shortest_plain(range.max) : "";
}

template <class V, class T, class F>
void optional_table(V& v, const TableKey& key, std::optional<T>& value, F visit) {
  bool present = value.has_value();
  T inner = value.value_or(T{});
  v.table(key, present, [&](auto& t) { visit(t, inner); });
  if (present) value = inner;
}

template <class V, class F>
void plain_table(V& v, const TableKey& key, F visit) {
  bool present = true;
  v.table(key, present, visit);
}

template <class V>
void choose(V& v, const Key& key, const std::vector<std::string>& names, std::string& value) {
  std::size_t index = static_cast<std::size_t>(std::ranges::find(names, value) - names.begin());
  v.one_of(key, names, index);
  if (index < names.size()) value = names[index];
}

template <class V, class Enum, std::size_t N>
void choose(V& v, const Key& key, const std::array<const char*, N>& names, Enum& value) {
  std::size_t index = static_cast<std::size_t>(value);
  v.one_of(key, {names.begin(), names.end()}, index);
  value = static_cast<Enum>(index);
}

/// Limit of [[body]] and [[joint]] tables, four times the largest composition, since rules between them take
/// cubic time.
inline constexpr std::size_t max_tables_of_bodies = 256;

/// Names become columns of CSV files and words of messages, so they must be plain.
inline bool is_plain_name(const std::string& name) {
  return !name.empty() &&
         std::ranges::all_of(name, [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
}

template <class V>
void visit_name(V& v, std::string_view meaning, std::string& name) {
  if (name.empty()) name = "unnamed";  // so that a missing name gives one error
  v.value(Key{.name = "name", .unit = "", .meaning = meaning, .required = true}, name);
  v.check(is_plain_name(name), "name", "must be one or more letters, digits, '_' or '-'");
}

template <class V>
void visit_pose(V& v, std::string_view position, std::string_view orientation, std::string_view of, Pose& X) {
  if constexpr (requires { v.pose(position, orientation, of); })
    return v.pose(position, orientation, of);  // the reference has one line for both
  const std::string p_meaning = "position of " + std::string(of),
                    q_meaning = "attitude of " + std::string(of);
  v.value(Key{position, "m", p_meaning}, X.p);
  v.attitude(Key{orientation, "", q_meaning}, X.q);
}

template <class V>
void visit_sign(V& v, const Key& key, int& sign) {
  v.value(key, sign);
  v.check(sign != 0, key.name, "must be 1 or -1");
}

}  // namespace godobject
