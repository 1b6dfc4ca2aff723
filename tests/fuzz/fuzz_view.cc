// Messages of a page: random bytes as a pointer message, and random text as the head of a request.
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

#include "platform/view/frame.h"
#include "platform/view/server/server.h"
#include "tests/fuzz/decode.h"

using namespace godobject;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  {
    const fuzz::NoAllocation guard;
    PointerMessage message;
    if (decode(std::span(data, size), message) == ParseResult::ok) {
      if (!(message.dp_W.norm() <= max_pointer_shift) || !(message.dphi_W.norm() <= max_pointer_turn))
        std::abort();
      PointerMessage again;
      if (decode(encode(message), again) != ParseResult::ok || again.dp_W != message.dp_W ||
          again.holds != message.holds)
        std::abort();
    }
    JointsMessage joints;
    if (decode(std::span(data, size), joints) == ParseResult::ok) {
      for (const double dq : joints.dq)
        if (!(std::abs(dq) <= max_joint_shift)) std::abort();
      JointsMessage again;
      if (decode(encode(joints), again) != ParseResult::ok || again.dq != joints.dq ||
          again.num_joints != joints.num_joints || again.holds != joints.holds)
        std::abort();
    }
    ResetMessage reset;
    if (decode(std::span(data, size), reset) == ParseResult::ok && size != reset_bytes) std::abort();
    PaceMessage pace;
    if (decode(std::span(data, size), pace) == ParseResult::ok)
      if (pace.steps > max_pace_steps ||
          !((pace.speed >= 0 && pace.speed <= max_pace_speed) || pace.speed == ViewPace::unlimited))
        std::abort();
  }
  fuzz::Input in(data, size);
  const auto text = [&] {
    const auto bytes = in.bytes(in.byte());
    return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  static const Door door("127.0.0.1", 7780, "0123456789abcdef0123456789abcdef");
  KnockHead head{.method = "GET", .target = text(), .host = in.byte() % 2 == 0 ? "127.0.0.1:7780" : text()};
  if (in.byte() % 2 == 0) head.origin = text();
  head.upgrade = in.byte() % 2 == 0;
  head.protocols = text();
  const Verdict verdict = door.judge(head);
  const bool is_open = verdict.route != Route::refused && verdict.route != Route::file;
  if (is_open && head.target.find("0123456789abcdef0123456789abcdef") == std::string_view::npos) std::abort();
  return 0;
}
