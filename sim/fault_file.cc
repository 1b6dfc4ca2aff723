#include "sim/fault_file.h"

#include "sim/csv.h"
#include "sim/fault_keys.h"
#include "sim/toml_reader.h"

namespace godobject {

FaultsResult parse_faults(std::string_view toml, const std::string& file, const SceneConfig& scene) {
  Diagnostics log(file);
  const toml::parse_result parsed = toml::parse(toml, file);
  if (parsed.failed()) {
    const toml::source_position at = parsed.error().source().begin;
    log.error({at.line, at.column}, "not TOML: " + std::string(parsed.error().description()));
    return {.faults = {}, .errors = log.errors()};
  }
  const DeviceConfig* const device = scene.device ? &*scene.device : nullptr;
  FaultsResult result;
  TomlReader reader(parsed.table(), "", "the file", log);
  reader.tables(TableKey{"fault", "A fault that the simulated rig plays.", true}, result.faults,
                [&](auto& t, FaultConfig& f) { visit_fault(t, device, f); });
  reader.finish();
  result.errors = log.errors();
  return result;
}

FaultsResult load_faults(const std::string& path, const SceneConfig& scene) {
  const std::optional<std::string> text = read_text(path);
  if (!text) return {.faults = {}, .errors = {path + ": cannot be read: is the path right?"}};
  return parse_faults(*text, path, scene);
}

}  // namespace godobject
