// NDI's replies, as bytes of the line and as contents with a right CRC: every accepted pose is valid.
#include <cmath>
#include <cstdlib>

#include "hal/tracker/ndi_tracker.h"
#include "tests/fuzz/decode.h"

namespace {

using namespace godobject;

void check(const Pose& X) {
  if (!X.p.allFinite() || !(std::abs(X.q.norm() - 1) < 1e-6)) std::abort();
}

void parse_all(std::span<const std::uint8_t> content, std::uint16_t options) {
  ndi::PoseReply reply;
  const auto check_poses = [&](ParseResult result) {
    if (result != ParseResult::ok) return;
    for (const ndi::HandlePose& pose : reply.all())
      if (pose.status == ndi::HandleStatus::valid) check(pose.X_TH);
  };
  check_poses(ndi::parse_tx(content, options, reply));
  check_poses(ndi::parse_bx(content, options, reply));
  check_poses(ndi::parse_bx2(content, reply));
  ndi::PortHandles handles;
  ndi::ToolPlate plate;
  static_cast<void>(ndi::parse_phsr(content, handles));
  static_cast<void>(ndi::parse_phinf(content, plate));
  static_cast<void>(ndi::classify(content));
}

TrackerParams one_tool() {
  TrackerParams params;
  params.name = "polaris";
  params.tools = {{.body = "tool", .tool = "0A"}};
  return params;
}

/// Discards its requests and answers with bytes, mostly whole replies with their CRC.
void talk(fuzz::Input& in, Tracker& tracker) {
  Nanoseconds now = 0;
  tracker.opened(now);
  while (!in.empty()) {
    now += Nanoseconds{1'000'000} * in.byte();
    static_cast<void>(tracker.next(now));
    const std::span<const std::uint8_t> text = in.bytes(in.byte() % 100);
    if (in.byte() % 4 == 0) {
      tracker.receive(text, now);
    } else {
      // a command's framing is that of a text reply: content, CRC, CR
      const std::string_view content(reinterpret_cast<const char*>(text.data()), text.size());
      const ndi::Command framed = ndi::make_command(content, "");
      tracker.receive(framed.bytes(), now);
    }
    tracker.expire(now);
    const ToolSample& sample = tracker.report().tools[0];
    if (sample.number > 0) check(sample.X_TH);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  std::vector<std::string> errors;
  const std::unique_ptr<Tracker> tracker = make_ndi_tracker(one_tool(), {{}}, errors);
  if (!tracker) std::abort();
  const std::uint8_t what = in.byte();
  const auto options = static_cast<std::uint16_t>(in.word());
  const fuzz::NoAllocation guard;
  if (what % 2 == 0) {
    parse_all(in.bytes(size), options);
  } else {
    talk(in, *tracker);
  }
  return 0;
}
