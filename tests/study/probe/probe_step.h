// Step of one composition in its own object file, for measurement by size and callgrind.
#pragma once

#include "core/scene.h"
#include "core/stage.h"

namespace godobject::study {

/// godobject::step of scene S, compiled in probe_step.cc.
template <Scene S>
void probe_step(const Params<S>& par, const Input<S>& in, State<S>& x, Scratch<S>& w,
                Output<S>& out) noexcept;

}  // namespace godobject::study
