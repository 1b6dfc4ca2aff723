// Device profiles.
#include <cstdlib>

#include "platform/scene/toml.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  const ProfileResult result = parse_profile({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
  if (result.profile.has_value() == !result.errors.empty()) std::abort();
  return 0;
}
