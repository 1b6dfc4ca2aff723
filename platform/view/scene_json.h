// A scene as the page gets it: names, what can be drawn, what the bits of faults and limits mean.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// What a bit of a frame's words stands for.
struct BitText {
  std::string name, text;  // text: what it means, and what to do
};

struct BusLoadText {
  std::string name;
  double percent = 0;  // at worst
};

/// What a view says of a run beside its scene.
struct ViewAbout {
  std::string title;  // "run sim/scenes/lego.toml", the file of a recording
  bool live = true;
  bool takes_pointer = false;
  std::string warning{};  // shown on the page; empty: none
  std::vector<BitText> faults{}, rig_faults{}, limits{};
  std::vector<BusLoadText> buses{};
};

/// docs/view.md has the keys.
std::string scene_json(const SceneConfig& scene, const ViewAbout& about);

}  // namespace godobject
