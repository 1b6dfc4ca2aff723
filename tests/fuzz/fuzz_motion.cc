// Motion files, for a scene with a device and for one with a device that grips bodies. A motion that is read
// can be evaluated at every time.
#include <cmath>
#include <cstdlib>

#include "platform/motion/motion.h"
#include "platform/scene/toml.h"
#include "tests/fuzz/decode.h"

namespace {

using namespace godobject;

SceneConfig scene_of(const char* file) {
  return load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + file).scene.value();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const SceneConfig scenes[] = {scene_of("rigid.toml"), scene_of("lego.toml")};
  fuzz::Input in(data, size);
  const SceneConfig& scene = scenes[in.byte() % 2];
  const auto bytes = in.bytes(size);
  const MotionResult result =
      Motion::parse({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "fuzz.csv", scene);
  if (result.motion.has_value() == !result.errors.empty()) std::abort();
  if (!result.motion) return 0;
  for (const double t : {0.0, 1e-3, 1.0, 1e9}) {
    const Target sample = result.motion->target(0, t);
    if (!sample.X_WD.p.allFinite()) std::abort();
  }
  return 0;
}
