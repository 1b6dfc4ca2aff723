#include "platform/scene/text/toml_reader.h"

#include <algorithm>

namespace godobject {
namespace {

constexpr std::size_t max_word = 100;   // bytes; longer than any key or name, so none is near
constexpr std::size_t max_dots = 1000;  // depth of a.b.c, counted without a comma, '=' or line end

TextPosition place(const toml::source_region& source) {
  return {std::max(source.begin.line, 1u), std::max(source.begin.column, 1u)};
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
