// Compiled once per composition; tests/study/CMakeLists.txt defines its three choices.
#include "tests/study/probe/probe_step.h"

#include "tests/study/compositions.h"

namespace godobject::study {

template <Scene S>
void probe_step(const Params<S>& par, const Input<S>& in, State<S>& x, Scratch<S>& w,
                Output<S>& out) noexcept {
  step(par, in, x, w, out);
}

using Probed = PROBE_SCENE<PROBE_INTEGRATOR, PROBE_CAPACITY>;
template void probe_step(const Params<Probed>&, const Input<Probed>&, State<Probed>&, Scratch<Probed>&,
                         Output<Probed>&) noexcept;

}  // namespace godobject::study
