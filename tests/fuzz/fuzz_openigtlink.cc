// Messages of OpenIGTLink from random bytes: every accepted pose is valid, and no byte is left.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "hal/tracker/openigtlink.h"
#include "tests/fuzz/decode.h"

namespace {

void read(godobject::openigtlink::Receiver& receiver, std::span<const std::uint8_t> bytes) {
  using namespace godobject;
  while (!bytes.empty()) {
    const std::size_t before = bytes.size();
    const openigtlink::Receiver::Event event = receiver.push(bytes);
    if (bytes.size() >= before) std::abort();
    if (event != openigtlink::Receiver::Event::message) continue;
    for (std::size_t i = 0; i < receiver.num_poses(); ++i) {
      const openigtlink::ToolPose pose = receiver.pose(i);
      if (pose.name.size() > openigtlink::max_name) std::abort();
      if (pose.X_TH && (!(pose.X_TH->p.norm() <= openigtlink::max_distance) ||
                        !(std::abs(pose.X_TH->q.norm() - 1) < 1e-6)))
        std::abort();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  const fuzz::NoAllocation guard;
  openigtlink::Receiver receiver;
  // A body with its correct CRC, which random bytes do not have.
  openigtlink::Message whole((size & 1) != 0 ? "TDATA" : "TRANSFORM", "probe", 0);
  for (std::size_t i = 0; i < std::min<std::size_t>(size, 2000); ++i) whole.number(data[i], 1);
  read(receiver, whole.finish());
  read(receiver, {data, size});
  return 0;
}
