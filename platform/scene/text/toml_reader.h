// Reads one TOML table strictly: every key must be known, of the right type and in range. A visitor of
// platform/scene/keys/scene.h. Errors go to Diagnostics with their place, and the member keeps its value.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "core/math/types.h"
#include "platform/scene/text/diagnostics.h"
#include "platform/scene/text/key.h"

namespace godobject {

/// Parses the tables of a text; none, and an error in the log, if it is not TOML.
std::optional<toml::table> parse_toml(std::string_view text, Diagnostics& log);

/// Returns "a table", "a number" or another type, for messages.
std::string article_and_type(const toml::node& node);

class TomlReader {
 public:
  /// title: name of the table in messages, as "[body.coupling]". The table and the log outlive the reader.
  TomlReader(const toml::table& table, std::string path, std::string title, Diagnostics& log);

  void value(const Key& key, double& x);
  void value(const Key& key, std::string& x);
  void value(const Key& key, Vec3& x);
  void value(const Key& key, bool& x);
  void value(const Key& key, std::optional<double>& x);
  void value(const Key& key, std::optional<Vec3>& x);
  void value(const Key& key, std::vector<std::string>& x);
  /// Reads rows of numbers, of one length.
  void value(const Key& key, std::vector<std::vector<double>>& x);
  template <std::integral T>
  void value(const Key& key, T& x) {
    if (const std::optional<std::int64_t> n = integer(key)) x = static_cast<T>(*n);
  }
  /// Returns the path of a file in the folder of the scene file, or below; empty if it may not be read.
  /// x: its name.
  std::string path(const Key& key, std::string& x);
  void shorthand(const Key& key, double& x) { value(key, x); }
  void shorthand(const Key& key, std::string& x) { value(key, x); }
  void shorthand(const Key& key, Vec3& x) { value(key, x); }
  void shorthand(const Key& key, Quat& q) { attitude(key, q); }
  /// Reads one of two spellings of one number; with neither the fallback, or an error if the key is required.
  void either(const Key& key, const Key& other, double unit_of_other, std::optional<double> fallback,
              double& x);

  /// Reads a vector of length 1 within 1e-6 and normalises it.
  void unit_vector(const Key& key, Vec3& x);
  void attitude(const Key& key, Quat& q);
  /// Reads three principal moments, or a 3x3 matrix, symmetric and positive definite. Warns if the triangle
  /// inequality fails.
  void inertia(const Key& key, Mat3& I);
  /// index: index of the string in `names`.
  void one_of(const Key& key, const std::vector<std::string>& names, std::size_t& index);

  template <class F>
  void table(const TableKey& key, bool& present, F visit) {
    const toml::node* node = subtable(key);
    present = node != nullptr;
    if (!present) return;
    TomlReader sub(*node->as_table(), path_of(key), "[" + path_of(key) + "]", log_);
    visit(sub);
    sub.finish();
  }
  template <class T, class F>
  void tables(const TableKey& key, std::vector<T>& items, F visit) {
    items.clear();
    for (const toml::table* element : subtables(key)) {
      TomlReader sub(*element, path_of(key), "[[" + path_of(key) + "]]", log_);
      visit(sub, items.emplace_back());
      sub.finish();
    }
  }

  bool has(std::string_view name) const { return table_.contains(name); }
  /// True if the key exists without an error so far, so that its member has its value.
  bool understood(std::string_view name) const;
  /// Returns the line of the key's value, or of the table if there is none.
  unsigned line_of(std::string_view name) const { return static_cast<unsigned>(place_of(name).line); }
  /// Checks a rule between keys. The text completes a sentence about the key, or is a sentence if name is "".
  void check(bool ok, std::string_view name, const std::string& what);
  void advise(bool ok, std::string_view name, const std::string& what);

  /// Reports every key that was not read, with the nearest known one.
  void finish();

 private:
  /// Returns the node; null, with an error if the key is required and missing.
  const toml::node* find(const Key& key);
  std::optional<double> number(const Key& key, const toml::node& node);
  std::optional<std::int64_t> integer(const Key& key);
  /// Returns exactly n numbers in range; empty after an error.
  std::vector<double> numbers(const Key& key, const toml::node& node, std::size_t n);
  std::optional<Mat3> matrix(const Key& key, const toml::node& node);
  const toml::node* subtable(const TableKey& key);
  std::vector<const toml::table*> subtables(const TableKey& key);

  std::string path_of(const TableKey& key) const;
  std::string sentence(std::string_view name, const std::string& what) const;
  TextPosition place_of(std::string_view name) const;
  void error(const toml::node& node, const std::string& what);

  const toml::table& table_;
  std::string path_, title_;
  Diagnostics& log_;
  std::vector<std::string> known_;
};

/// Returns the candidate with the smallest edit distance (insert, delete, replace, swap neighbours), at most
/// `most`. Returns an empty text if there is none, or if the word is too long.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates,
                    std::size_t most = std::string::npos);

}  // namespace godobject
