// Every kind of drive with random frames; moteus's sub-frames stay within the frame.
#include <cmath>
#include <cstdlib>

#include "hal/drive/link.h"
#include "hal/drive/moteus.h"
#include "tests/fuzz/decode.h"

namespace {

using namespace godobject;

void walk(const CanFrame& frame) {
  moteus::SubframeReader reader(frame.bytes());
  moteus::Subframe subframe;
  while (reader.next(subframe)) {
    const std::uint8_t* const end = frame.data.data() + frame.size;
    if (subframe.bytes.data() + subframe.bytes.size() > end) std::abort();
    if (subframe.kind == moteus::SubframeKind::read) continue;
    for (std::uint32_t i = 0; i < subframe.count && i < 64; ++i) static_cast<void>(subframe.value(i));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  DriveParams params;
  params.protocol = static_cast<DriveProtocol>(in.byte() % drive_protocol_names.size());
  params.node_id = 1;
  const std::unique_ptr<DriveLink> link = make_drive_link(params, 1e-3);
  if (const BusProtocol protocol = bus_protocol(params.protocol); protocol.describe)
    for (fuzz::Input frames = in; !frames.empty();)
      if (protocol.describe(fuzz::frame_of(frames)).node > canopen::max_node_id) std::abort();
  const fuzz::NoAllocation guard;
  DriveTelemetry telemetry;
  for (Nanoseconds now = 0; !in.empty(); now += 1'000'000) {
    CanFrame frame = fuzz::frame_of(in);
    walk(frame);
    static_cast<void>(link->decode(frame, telemetry));
    if (!std::isfinite(telemetry.torque_Nm) || !std::isfinite(telemetry.velocity_counts_per_s)) std::abort();
    const DriveOrder order{.goal = static_cast<DriveGoal>(in.byte() % 4), .torque_Nm = 0.01};
    static_cast<void>(link->request(order));
    const DriveFrame command = link->command(order, now);
    if (command.frame && !is_valid(*command.frame)) std::abort();
    link->sent(command, now);
  }
  return 0;
}
