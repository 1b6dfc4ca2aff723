#include "platform/scene/toml.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "hal/rig/profile_validate.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/keys/profile.h"
#include "platform/scene/keys/scene.h"
#include "platform/scene/table.h"
#include "platform/scene/text/csv.h"
#include "platform/scene/text/key_writers.h"
#include "platform/scene/text/toml_reader.h"
#include "shipped_profiles.h"

namespace godobject {

namespace fs = std::filesystem;

namespace {

/// Returns TR-BDF2 where it is of second order. Among bodies that touch each other nearly every step is of
/// first order, because a contact becomes active or inactive (docs/decisions/046-default-integrator.md).
std::string default_integrator(const SceneConfig& scene) {
  return contact_scope(scene) == ContactScope::bodies ? "implicit-euler" : "tr-bdf2";
}

constexpr const char* extension = ".toml";

bool is_path(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(extension);
}

/// Finds the profile of a name or path in the scene's folder or among the shipped ones; none if there is
/// none.
std::optional<ProfileResult> find_profile(const std::string& name, const fs::path& scene_folder) {
  const std::string file = is_path(name) ? name : name + extension;
  if (const FilePath found = path_below(scene_folder.string(), file); !found.path.empty())
    return load_profile(found.path);
  const auto shipped = std::ranges::find(shipped_profile_files, name, &ShippedProfile::name);
  if (is_path(name) || shipped == shipped_profile_files.end()) return std::nullopt;
  return parse_profile(shipped->toml, "hal/profiles/" + name + extension);
}

std::string not_found(const std::string& name, const std::string& scene_folder) {
  if (is_path(name)) return "profile \"" + name + "\" " + path_below(scene_folder, name).why_not;
  const std::vector<std::string> shipped = shipped_profiles();
  std::string known;
  for (const std::string& other : shipped) known += (known.empty() ? "" : ", ") + other;
  return "profile \"" + name +
         "\" was found neither in the scene's folder nor among the shipped profiles: " + known +
         "; the nearest is \"" + nearest(name, shipped) + "\"";
}

}  // namespace

// ---- scenes ---------------------------------------------------------------------------------------

namespace {

LoadResult read(const toml::table& table, Diagnostics& log, const FaultChecks& checks) {
  SceneConfig scene;
  scene.integrator.clear();  // set once the scene's contacts are known
  TomlReader reader(table, "", "the file", log);
  visit_scene(reader, scene, checks);
  reader.finish();
  if (!log.ok()) return {std::nullopt, log.errors(), log.warnings(), log.placed_errors()};
  if (scene.integrator.empty()) scene.integrator = default_integrator(scene);
  return {std::move(scene), {}, log.warnings(), {}, log.placed_warnings()};
}

}  // namespace

LoadResult read_scene(const toml::table& table, const std::string& file, const FaultChecks& checks) {
  Diagnostics log(file);
  return read(table, log, checks);
}

LoadResult parse_scene(std::string_view toml, const std::string& file, const FaultChecks& checks) {
  Diagnostics log(file);
  const std::optional<toml::table> parsed = parse_toml(toml, log);
  if (!parsed) return {std::nullopt, log.errors(), {}, log.placed_errors()};
  return read(*parsed, log, checks);
}

LoadResult load_scene(const std::string& path, const FaultChecks& checks) {
  const FileText file = read_file(path, max_toml_bytes);
  if (!file.text)
    return {std::nullopt, {printable(path) + ": " + file.why_not}, {}, {{printable(path), {}, file.why_not}}};
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

// ---- faults ---------------------------------------------------------------------------------------

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

// ---- device profiles ------------------------------------------------------------------------------

ProfileResult parse_profile(std::string_view toml, const std::string& file) {
  Diagnostics log(file);
  const std::optional<toml::table> parsed = parse_toml(toml, log);
  if (!parsed) return {std::nullopt, log.errors()};
  NodeProfile profile{.file = file};
  TomlReader reader(*parsed, "", "the file", log);
  read_profile(reader, profile);
  reader.finish();
  if (!log.ok()) return {std::nullopt, log.errors()};
  return {profile, {}};
}

std::string profile_reference_markdown() {
  std::string out;
  KeyReference reference(out);
  NodeProfile defaults;
  read_profile(reference, defaults);
  return out;
}

ProfileResult load_profile(const std::string& path) {
  const FileText file = read_file(path, max_toml_bytes);
  if (!file.text) return {std::nullopt, {printable(path) + ": " + file.why_not}};
  return parse_profile(*file.text, path);
}

RigProfilesResult load_profiles(const RigParams& rig, double cycle_s, const std::string& scene_folder,
                                const std::string& scene_file) {
  RigProfilesResult out;
  std::set<std::string> reported;  // nodes that share a profile share its errors
  const auto load = [&](const char* kind, const auto& device) -> std::optional<NodeProfile> {
    if (device.profile.empty()) return std::nullopt;
    std::optional<ProfileResult> read = find_profile(device.profile, scene_folder);
    if (!read) {
      const std::string place =
          scene_file.empty() ? "" : scene_file + ":" + std::to_string(device.profile_line) + ": ";
      out.errors.push_back(place + kind + " of joint '" + device.joint +
                           "': " + not_found(device.profile, scene_folder));
      return std::nullopt;
    }
    for (std::string& error : read->errors)
      if (reported.insert(error).second) out.errors.push_back(std::move(error));
    return std::move(read->profile);
  };
  for (const EncoderParams& encoder : rig.encoders) out.profiles.encoders.push_back(load("encoder", encoder));
  for (const DriveParams& drive : rig.drives) out.profiles.drives.push_back(load("drive", drive));
  if (!out.errors.empty()) return out;
  out.errors = validate(rig, cycle_s, out.profiles);
  return out;
}

std::vector<std::string> shipped_profiles() {
  std::vector<std::string> names;
  for (const ShippedProfile& profile : shipped_profile_files) names.emplace_back(profile.name);
  return names;
}

}  // namespace godobject
