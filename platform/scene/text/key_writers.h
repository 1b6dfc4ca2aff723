// Writers of keys: values as TOML from which the same values are read, and the reference of a format in
// Markdown.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/types.h"
#include "platform/scene/text/key.h"

namespace godobject {

/// Prints values as TOML. A visitor of platform/scene/keys/scene.h.
class TomlWriter {
 public:
  explicit TomlWriter(std::string& out, std::string path = "") : out_(out), path_(std::move(path)) {}

  /// Returns a string in quotes, with escapes.
  static std::string quoted(std::string_view text);

  void value(const Key& key, double x) { line(key, shortest(x)); }
  void value(const Key& key, const std::string& x) { line(key, quoted(x)); }
  void value(const Key& key, const Vec3& x) { line(key, array({x.x(), x.y(), x.z()})); }
  void value(const Key& key, bool x) { line(key, x ? "true" : "false"); }
  void value(const Key& key, const std::optional<double>& x) {
    if (x) value(key, *x);
  }
  void value(const Key& key, const std::optional<Vec3>& x) {
    if (x) value(key, *x);
  }
  void value(const Key& key, const std::vector<std::string>& x);
  void value(const Key& key, const std::vector<std::vector<double>>& x);
  template <std::integral T>
  void value(const Key& key, T x) {
    line(key, std::to_string(x));
  }
  std::string path(const Key& key, const std::string& x) {
    if (!x.empty()) value(key, x);
    return "";
  }
  template <class T>
  void shorthand(const Key&, const T&) {}
  void either(const Key& key, const Key&, double, std::optional<double>, double x) { value(key, x); }
  void unit_vector(const Key& key, const Vec3& x) { value(key, x); }
  void attitude(const Key& key, const Quat& q) { line(key, array({q.w(), q.x(), q.y(), q.z()})); }
  void inertia(const Key& key, const Mat3& I);
  void one_of(const Key& key, const std::vector<std::string>& names, std::size_t index) {
    value(key, names.at(index));
  }

  template <class F>
  void table(const TableKey& key, bool present, F visit) {
    if (!present) return;
    TomlWriter sub = subtable(key, "[", "]");
    visit(sub);
  }
  template <class T, class F>
  void tables(const TableKey& key, std::vector<T>& items, F visit) {
    for (T& item : items) {
      TomlWriter sub = subtable(key, "[[", "]]");
      visit(sub, item);
    }
  }

  bool has(std::string_view) const { return false; }
  bool understood(std::string_view) const { return true; }
  unsigned line_of(std::string_view) const { return 0; }
  void check(bool, std::string_view, const std::string&) {}
  void advise(bool, std::string_view, const std::string&) {}

 private:
  static std::string array(const std::vector<double>& values);
  void line(const Key& key, const std::string& text) { out_ += std::string(key.name) + " = " + text + "\n"; }
  TomlWriter subtable(const TableKey& key, const char* open, const char* close);

  std::string& out_;
  std::string path_;
};

/// Writes one Markdown list per TOML table, `key (type, unit, range; default): meaning`. A visitor of
/// platform/scene/keys/scene.h with default values.
class KeyReference {
 public:
  explicit KeyReference(std::string& out, std::string path = "") : out_(out), path_(std::move(path)) {}

  void value(const Key& key, double x) { row(key, "number", shortest(x)); }
  void value(const Key& key, const std::string& x) {
    row(key, "string", x.empty() ? "empty" : "`\"" + x + "\"`");
  }
  void value(const Key& key, const Vec3& x);
  void value(const Key& key, bool x) { row(key, "boolean", x ? "true" : "false"); }
  void value(const Key& key, const std::optional<double>&) { row(key, "number", ""); }
  /// Writes a key of type T without a default.
  template <class T>
  void absent(const Key& key) {
    // cppcheck-suppress assignBoolToPointer
    constexpr const char* type = std::same_as<T, bool> ? "boolean" : std::integral<T> ? "integer" : "number";
    row(key, type, "");
  }
  void value(const Key& key, const std::optional<Vec3>&) { row(key, "vector", ""); }
  void value(const Key& key, const std::vector<std::string>&) { row(key, "strings", ""); }
  void value(const Key& key, const std::vector<std::vector<double>>&) { row(key, "matrix", ""); }
  template <std::integral T>
  void value(const Key& key, T x) {
    row(key, "integer", std::to_string(x));
  }
  std::string path(const Key& key, const std::string&) {
    row(key, "path", "");
    return "";
  }
  void shorthand(const Key& key, double) { row(key, "number", ""); }
  void shorthand(const Key& key, const std::string&) { row(key, "string", ""); }
  void shorthand(const Key& key, const Vec3& x) { value(key, x); }
  void shorthand(const Key& key, const Quat& q) { attitude(key, q); }
  void either(const Key& key, const Key& other, double unit_of_other, std::optional<double> fallback,
              double x);
  void unit_vector(const Key& key, const Vec3& x) { value(key, x); }
  void attitude(const Key& key, const Quat&) { row(key, "quaternion", "identity"); }
  /// Writes one line for position and orientation.
  void pose(std::string_view position, std::string_view orientation, std::string_view of);
  void inertia(const Key& key, const Mat3&) { row(key, "3 moments or 3x3", ""); }
  void one_of(const Key& key, const std::vector<std::string>& names, std::size_t index);

  template <class F>
  void table(const TableKey& key, bool, F visit) {
    KeyReference sub = subtable(key, "[", "]");
    visit(sub);
  }
  template <class T, class F>
  void tables(const TableKey& key, std::vector<T>&, F visit) {
    KeyReference sub = subtable(key, "[[", "]]");
    T item{};
    visit(sub, item);
  }

  bool has(std::string_view) const { return false; }
  bool understood(std::string_view) const { return true; }
  unsigned line_of(std::string_view) const { return 0; }
  void check(bool, std::string_view, const std::string&) {}
  void advise(bool, std::string_view, const std::string&) {}
  /// Writes one line for the keys from `first` to `last`, which are those of another table.
  void keys_of(std::string_view table, std::string_view first, std::string_view last);

 private:
  void row(const Key& key, const std::string& type, const std::string& default_text);
  KeyReference subtable(const TableKey& key, const char* open, const char* close);

  std::string& out_;
  std::string path_;
};

}  // namespace godobject
