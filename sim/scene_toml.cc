#include "sim/scene_toml.h"

#include "sim/key_reference.h"
#include "sim/scene_keys.h"
#include "sim/toml_reader.h"
#include "sim/toml_writer.h"

namespace godobject {

LoadResult parse_scene(std::string_view toml, const std::string& file) {
  Diagnostics log(file);
  const toml::parse_result parsed = toml::parse(toml, file);
  if (parsed.failed()) {
    const toml::source_position at = parsed.error().source().begin;
    log.error({at.line, at.column}, "not TOML: " + std::string(parsed.error().description()));
    return {std::nullopt, log.errors(), {}};
  }
  SceneConfig scene;
  TomlReader reader(parsed.table(), "", "the file", log);
  visit_scene(reader, scene);
  reader.finish();
  if (!log.ok()) return {std::nullopt, log.errors(), log.warnings()};
  return {scene, {}, log.warnings()};
}

LoadResult load_scene(const std::string& path) {
  const std::optional<std::string> text = read_text(path);
  if (!text) return {std::nullopt, {path + ": cannot be read: is the path right?"}, {}};
  return parse_scene(*text, path);
}

std::string effective_config_toml(const SceneConfig& scene) {
  std::string out;
  TomlWriter writer(out);
  SceneConfig copy = scene;
  visit_scene(writer, copy);
  return out;
}

std::string scene_reference_markdown() {
  std::string out;
  KeyReference reference(out);
  SceneConfig defaults;
  visit_scene(reference, defaults);
  return out;
}

}  // namespace godobject
