#include "platform/scene/toml.h"

#include "platform/scene/contact/pairs.h"
#include "platform/scene/keys/scene.h"
#include "platform/scene/text/key_reference.h"
#include "platform/scene/text/toml_reader.h"
#include "platform/scene/text/toml_writer.h"

namespace godobject {
namespace {

/// Returns TR-BDF2 where it is of second order. Among bodies that touch each other nearly every step is of
/// first order, because a contact becomes active or inactive (docs/decisions/046-default-integrator.md).
std::string default_integrator(const SceneConfig& scene) {
  return contact_scope(scene) == ContactScope::bodies ? "implicit-euler" : "tr-bdf2";
}

}  // namespace

LoadResult parse_scene(std::string_view toml, const std::string& file, const FaultChecks& checks) {
  Diagnostics log(file);
  const std::optional<toml::table> parsed = parse_toml(toml, log);
  if (!parsed) return {std::nullopt, log.errors(), {}};
  SceneConfig scene;
  scene.integrator.clear();  // set once the scene's contacts are known
  TomlReader reader(*parsed, "", "the file", log);
  visit_scene(reader, scene, checks);
  reader.finish();
  if (!log.ok()) return {std::nullopt, log.errors(), log.warnings()};
  if (scene.integrator.empty()) scene.integrator = default_integrator(scene);
  return {std::move(scene), {}, log.warnings()};
}

LoadResult load_scene(const std::string& path, const FaultChecks& checks) {
  const FileText file = read_file(path, max_toml_bytes);
  if (!file.text) return {std::nullopt, {printable(path) + ": " + file.why_not}, {}};
  return parse_scene(*file.text, path, checks);
}

std::string effective_config_toml(const SceneConfig& scene) {
  std::string out;
  TomlWriter writer(out);
  SceneConfig copy = scene;
  visit_scene(writer, copy, {});
  return out;
}

std::string scene_reference_markdown() {
  std::string out;
  KeyReference reference(out);
  SceneConfig defaults;
  visit_scene(reference, defaults, {});
  return out;
}

}  // namespace godobject
