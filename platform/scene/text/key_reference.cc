#include "platform/scene/text/key_reference.h"

namespace godobject {

void KeyReference::row(const Key& key, const std::string& type, const std::string& default_text) {
  out_ += "| `" + std::string(key.name) + "` | " + type + " | " + std::string(key.unit) + " | " +
          to_string(key.range) + " | " +
          (key.required            ? "required"
           : key.otherwise.empty() ? default_text
                                   : std::string(key.otherwise)) +
          " | " + std::string(key.meaning) + " |\n";
}

void KeyReference::value(const Key& key, const Vec3& x) {
  row(key, "3 numbers", "[" + shortest(x.x()) + ", " + shortest(x.y()) + ", " + shortest(x.z()) + "]");
}

void KeyReference::either(const Key& key, const Key& other, double, std::optional<double>, double) {
  row(key, "number", "");
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

KeyReference KeyReference::subtable(const TableKey& key, const char* open, const char* close) {
  const std::string path = path_.empty() ? std::string(key.name) : path_ + "." + std::string(key.name);
  out_ += (out_.empty() ? "### `" : "\n### `") + std::string(open) + path + close + "`\n\n" +
          std::string(key.meaning) + (key.required ? " Required.\n\n" : "\n\n") + table_head;
  return KeyReference(out_, path);
}

}  // namespace godobject
