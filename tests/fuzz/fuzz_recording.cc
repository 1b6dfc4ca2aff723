// Traces and node files as read by `view`, with or without a header of the scene before the fuzzed rows. Each
// is refused with a reason, or has samples in the order of time.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "platform/scene/toml.h"
#include "platform/trace/trace.h"
#include "platform/view/recorded/recording.h"
#include "tests/fuzz/decode.h"

namespace {

using namespace godobject;

SceneConfig scene_of(const char* file) {
  return load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + file).scene.value();
}

std::string header_of(const std::vector<std::string>& names) {
  std::string line;
  for (const std::string& name : names) line += (line.empty() ? "" : ",") + name;
  return line + "\n";
}

/// Returns the path of a file in memory with these contents; the next call replaces them.
std::string file_of(const std::string& text) {
  static const int file = memfd_create("recording", 0);
  if (ftruncate(file, 0) != 0 ||
      pwrite(file, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()))
    std::abort();
  return "/proc/self/fd/" + std::to_string(file);
}

void read_as_trace(const std::string& text, const SceneConfig& scene) {
  const RecordingResult result = read_trace(file_of(text), scene);
  if (result.recording.has_value() == !result.errors.empty()) std::abort();
  if (!result.recording) return;
  if (result.recording->samples.empty()) std::abort();
  for (std::size_t i = 1; i < result.recording->samples.size(); ++i)
    if (!(result.recording->samples[i].record.t >= result.recording->samples[i - 1].record.t)) std::abort();
}

void read_as_nets(const std::string& text, const SceneConfig& scene) {
  const NetRecordingResult result = read_nets(file_of(text), scene);
  if (result.nets.has_value() == !result.errors.empty()) std::abort();
  if (!result.nets) return;
  for (const double t : {-1.0, result.nets->begin(), result.nets->end(), 1e9}) result.nets->at(t);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const SceneConfig scenes[] = {scene_of("wall.toml"), scene_of("net-small.toml")};
  fuzz::Input in(data, size);
  const std::uint8_t choice = in.byte();
  const SceneConfig& scene = scenes[choice & 1];
  const bool as_nets = (choice & 2) != 0, with_header = (choice & 4) != 0;
  const auto bytes = in.bytes(size);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (with_header)
    text = header_of(as_nets ? net_trace_columns(scene_nets(scene)) : trace_columns(scene)) + text;
  if (as_nets) read_as_nets(text, scene);
  else read_as_trace(text, scene);
  return 0;
}
