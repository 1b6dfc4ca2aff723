#include "platform/scene/text/key_writers.h"

#include <array>
#include <cstdio>

namespace godobject {

// ---- TOML -----------------------------------------------------------------------------------------

std::string TomlWriter::array(const std::vector<double>& values) {
  std::string text;
  for (const double x : values) text += (text.empty() ? "" : ", ") + shortest(x);
  return "[" + text + "]";
}

std::string TomlWriter::quoted(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      std::array<char, 8> escaped{};
      std::snprintf(escaped.data(), escaped.size(), "\\u%04X", static_cast<unsigned>(c));
      result += escaped.data();
    } else {
      result += c;
    }
  }
  return result + "\"";
}

void TomlWriter::value(const Key& key, const std::vector<std::string>& x) {
  std::string text;
  for (const std::string& item : x) text += (text.empty() ? "" : ", ") + quoted(item);
  line(key, "[" + text + "]");
}

void TomlWriter::value(const Key& key, const std::vector<std::vector<double>>& x) {
  std::string text;
  for (const std::vector<double>& row : x) text += (text.empty() ? "" : ", ") + array(row);
  line(key, "[" + text + "]");
}

void TomlWriter::inertia(const Key& key, const Mat3& I) {
  if (I.isDiagonal(0)) {
    value(key, Vec3(I.diagonal()));
    return;
  }
  std::string rows;
  for (int i = 0; i < 3; ++i) rows += (i ? ", " : "") + array({I(i, 0), I(i, 1), I(i, 2)});
  line(key, "[" + rows + "]");
}

TomlWriter TomlWriter::subtable(const TableKey& key, const char* open, const char* close) {
  const std::string path = path_.empty() ? std::string(key.name) : path_ + "." + std::string(key.name);
  out_ += (out_.empty() ? "" : "\n") + std::string(open) + path + close + "\n";
  return TomlWriter(out_, path);
}

// ---- reference ------------------------------------------------------------------------------------

void KeyReference::row(const Key& key, const std::string& type, const std::string& default_text) {
  const std::string unit(key.unit), range = to_string(key.range);
  std::string kind = type == "number" && !(unit.empty() && range.empty()) ? "" : type;
  for (const std::string& part : {unit, range})
    if (!part.empty()) kind += (kind.empty() ? "" : ", ") + part;
  const std::string otherwise = key.required            ? "required"
                                : key.otherwise.empty() ? default_text
                                                        : std::string(key.otherwise);
  out_ += "- `" + std::string(key.name) + "` (" + kind + (otherwise.empty() ? "" : "; " + otherwise) + ")" +
          (key.meaning.empty() ? "" : ": " + std::string(key.meaning)) + "\n";
}

void KeyReference::value(const Key& key, const Vec3& x) {
  row(key, "vector",
      x.isZero(0)
          ? "0"
          : "[" + shortest_plain(x.x()) + "," + shortest_plain(x.y()) + "," + shortest_plain(x.z()) + "]");
}

void KeyReference::either(const Key& key, const Key& other, double, std::optional<double>, double) {
  const std::string or_other = (key.required ? "required, or `" : "or `") + std::string(other.name) + "`";
  Key first = key;
  first.required = false;
  first.otherwise = or_other;
  row(first, "number", "");
  row(other, "number", "");
}

void KeyReference::one_of(const Key& key, const std::vector<std::string>& names, std::size_t index) {
  if (key.required || !key.otherwise.empty()) {  // one of the names defined in the same file
    row(key, "string", "");
    return;
  }
  std::string type;
  for (const std::string& name : names) type += (type.empty() ? "`\"" : ", `\"") + name + "\"`";
  row(key, type, "`\"" + names.at(index) + "\"`");
}

void KeyReference::pose(std::string_view position, std::string_view orientation, std::string_view of) {
  out_ += "- `" + std::string(position) + "`, `" + std::string(orientation) +
          "` (m, quaternion; identity): " + std::string(of) + "\n";
}

void KeyReference::keys_of(std::string_view table, std::string_view first, std::string_view last) {
  out_ +=
      "- `" + std::string(first) + "` to `" + std::string(last) + "`: as in `" + std::string(table) + "`\n";
}

KeyReference KeyReference::subtable(const TableKey& key, const char* open, const char* close) {
  const std::string path = path_.empty() ? std::string(key.name) : path_ + "." + std::string(key.name);
  out_ += (out_.empty() ? "### `" : "\n### `") + std::string(open) + path + close + "`\n\n" +
          std::string(key.meaning) + (key.required ? " Required.\n\n" : "\n\n");
  return KeyReference(out_, path);
}

}  // namespace godobject
