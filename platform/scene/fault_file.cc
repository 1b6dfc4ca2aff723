#include "platform/scene/fault_file.h"

#include "platform/scene/keys/fault.h"
#include "platform/scene/text/csv.h"
#include "platform/scene/text/toml_reader.h"

namespace godobject {

FaultsResult parse_faults(std::string_view toml, const std::string& file, const SceneConfig& scene,
                          const FaultChecks& checks) {
  Diagnostics log(file);
  const std::optional<toml::table> parsed = parse_toml(toml, log);
  if (!parsed) return {.faults = {}, .errors = log.errors()};
  const DeviceConfig* const device = scene.device ? &*scene.device : nullptr;
  FaultsResult result;
  TomlReader reader(*parsed, "", "the file", log);
  reader.tables(TableKey{"fault", "A fault played by the simulated rig.", true, 10'000}, result.faults,
                [&](auto& t, FaultConfig& f) { visit_fault(t, device, checks, f); });
  reader.finish();
  result.errors = log.errors();
  return result;
}

FaultsResult load_faults(const std::string& path, const SceneConfig& scene, const FaultChecks& checks) {
  const FileText text = read_file(path, max_toml_bytes);
  if (!text.text) return {.faults = {}, .errors = {printable(path) + ": " + text.why_not}};
  return parse_faults(*text.text, path, scene, checks);
}

}  // namespace godobject
