#include "platform/rig/last_frames.h"

#include "hal/rig/rig.h"

namespace godobject {
std::vector<LastWords> last_words(const RigParams& params, double cycle_s, LinuxLink& link) {
  std::vector<FrameNotebook> notes(link.num_buses());
  std::vector<CanBus*> buses;
  for (FrameNotebook& note : notes) buses.push_back(&note);
  Rig rig(params, cycle_s, buses);
  rig.start(0);
  rig.stop();
  std::vector<LastWords> words;
  for (std::size_t i = 0; i < notes.size(); ++i) {
    words.push_back({.descriptor = link.bus(i).descriptor(), .writes = {}, .rest = link.bus(i).line_rest()});
    for (const CanFrame& frame : notes[i].frames())
      words.back().writes.push_back(link.bus(i).as_written(frame));
  }
  return words;
}

}  // namespace godobject
