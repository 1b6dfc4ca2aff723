// Rows of the table of compositions, and the functions that add them.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/validity.h"
#include "platform/engine/engine.h"

namespace godobject {

/// One row of the table of compositions.
struct CompositionRow {
  Composition composition;
  std::unique_ptr<Engine> (*make)(const SceneConfig&, std::span<const BodySample>, const Composition&,
                                  Validity&);
};

// One file each, and one line in engine.cc.
void add_free(std::vector<CompositionRow>& table);
void add_contacts(std::vector<CompositionRow>& table);
void add_many(std::vector<CompositionRow>& table);

}  // namespace godobject
