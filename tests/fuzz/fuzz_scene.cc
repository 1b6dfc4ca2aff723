// Scene files. A scene that is read is written out, and reads as the same again.
#include <cstdio>
#include <cstdlib>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  const LoadResult result =
      parse_scene({reinterpret_cast<const char*>(data), size}, "fuzz.toml", simulated_faults());
  if (result.scene.has_value() == !result.errors.empty()) std::abort();
  if (!result.scene) return 0;
  const std::string text = effective_config_toml(*result.scene);
  const LoadResult again = parse_scene(text, "fuzz.toml");
  if (again.scene && effective_config_toml(*again.scene) == text) return 0;
  std::fprintf(stderr, "%s\n%s\n", text.c_str(), again.errors.empty() ? "" : again.errors.front().c_str());
  std::abort();
}
