// Table of compositions: its row type, and the functions that add rows.
#pragma once

#include "core/setup.h"
#include "platform/engine/engine.h"

namespace godobject {

/// One row of the table of compositions.
struct CompositionRow {
  Composition composition;
  // make_engine_of() in of.h
  std::unique_ptr<Engine> (*make)(const SceneConfig&, std::span<const BodySample>, const Composition&,
                                  Validity&);
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
