// The table of compositions: what a row says, and the files that add theirs.
#pragma once

#include "core/setup.h"
#include "platform/engine/engine.h"

namespace godobject {

/// One row of the table of compositions.
struct CompositionRow {
  Composition composition;
  std::unique_ptr<Engine> (*make)(const SceneConfig&, std::span<const BodySample>, const Composition&);
  Validity (*check)(const SceneConfig&);  // of the core, on the scene's parameters
};

// One file each, and one line in engine.cc.
void add_rigid(std::vector<CompositionRow>& table);
void add_joints(std::vector<CompositionRow>& table);
void add_chains(std::vector<CompositionRow>& table);
void add_contacts(std::vector<CompositionRow>& table);
void add_joints_contacts(std::vector<CompositionRow>& table);
void add_touching(std::vector<CompositionRow>& table);
void add_touching_joints(std::vector<CompositionRow>& table);
void add_nets(std::vector<CompositionRow>& table);

}  // namespace godobject
