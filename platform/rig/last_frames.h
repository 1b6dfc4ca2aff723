// Last frames of a rig, prepared for the death of the program.
#pragma once

#include "hal/rig/params.h"
#include "platform/linux/link.h"
#include "platform/rt/last_resort.h"

namespace godobject {

/// A bus that stores the frames sent to it.
class FrameNotebook final : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame& frame) noexcept override {
    frames_.push_back(frame);
    return SendResult::queued;
  }
  bool try_receive(ReceivedFrame&) noexcept override { return false; }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  const std::vector<CanFrame>& frames() const { return frames_; }

 private:
  std::vector<CanFrame> frames_;
};

/// Returns the frames that Rig::stop() would send on each bus, as bytes: drives off, nodes pre-operational.
/// Valid until a bus is closed.
std::vector<LastWords> last_words(const RigParams& params, double cycle_s, LinuxLink& link);

}  // namespace godobject
