#include "platform/scene/text/key_reference.h"

namespace godobject {

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
