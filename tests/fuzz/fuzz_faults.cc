// Fault files, for a scene with two buses.
#include <cstdlib>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  static const SceneConfig scene = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml").scene.value();
  const FaultsResult result =
      parse_faults({reinterpret_cast<const char*>(data), size}, "fuzz.toml", scene, simulated_faults());
  for (const std::string& error : result.errors)
    if (!error.starts_with("fuzz.toml:")) std::abort();
  return 0;
}
