#include "platform/scene/profile.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "hal/rig/profile_validate.h"
#include "platform/scene/keys/profile.h"
#include "platform/scene/text/key_reference.h"
#include "shipped_profiles.h"

namespace godobject {

namespace fs = std::filesystem;

namespace {

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
  return "profile \"" + name + "\" was found neither in '" + scene_folder +
         "' nor among the shipped profiles: " + known + "; the nearest is \"" + nearest(name, shipped) + "\"";
}

}  // namespace

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
  std::string out = KeyReference::table_head;
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

RigProfilesResult load_profiles(const RigParams& rig, const std::string& scene_folder,
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
  out.errors = validate(rig, out.profiles);
  return out;
}

std::vector<std::string> shipped_profiles() {
  std::vector<std::string> names;
  for (const ShippedProfile& profile : shipped_profile_files) names.emplace_back(profile.name);
  return names;
}

}  // namespace godobject
