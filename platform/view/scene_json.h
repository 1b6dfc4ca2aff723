// A scene as JSON for the page: names, shapes, and texts for the bits of faults and limits.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// Text for a bit of a frame's fault and limit words.
struct BitText {
  std::string name, text;  // text: meaning and remedy
};

struct BusLoadText {
  std::string name;
  double percent = 0;  // worst case
};

/// Data of a view besides its scene.
struct ViewAbout {
  std::string title;  // "run sim/scenes/lego.toml", or the file of a recording
  bool live = true;
  bool takes_pointer = false;
  std::string warning{};  // displayed on the page; empty: none
  std::vector<BitText> faults{}, rig_faults{}, limits{};
  std::vector<BusLoadText> buses{};
};

/// Returns the JSON text, with the keys of docs/view.md.
std::string scene_json(const SceneConfig& scene, const ViewAbout& about);

}  // namespace godobject
