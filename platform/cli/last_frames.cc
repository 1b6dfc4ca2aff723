#include "platform/cli/last_frames.h"

#include "hal/rig.h"

namespace godobject {
namespace {

/// Keeps what it is given.
class Notebook final : public CanBus {
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

}  // namespace

std::vector<LastWords> last_words(const RigParams& params, LinuxLink& link) {
  std::vector<Notebook> notes(link.num_buses());
  std::vector<CanBus*> buses;
  for (Notebook& note : notes) buses.push_back(&note);
  Rig rig(params, buses);
  rig.start(0);
  rig.stop();
  std::vector<LastWords> words;
  for (std::size_t i = 0; i < notes.size(); ++i) {
    words.push_back({.descriptor = link.bus(i).descriptor(), .writes = {}});
    for (const CanFrame& frame : notes[i].frames())
      words.back().writes.push_back(link.bus(i).as_written(frame));
  }
  return words;
}

}  // namespace godobject
