// Runs the step of planted.cc, in a program that RealtimeSanitizer watches: it ends at the planted call.
#include <cstdio>
#include <memory>

#include "tests/nonblocking/planted.cc"

int main() {
  using Scene = godobject::PlantedScene;
  const auto par = std::make_unique<godobject::Params<Scene>>();
  const auto in = std::make_unique<godobject::Input<Scene>>();
  const auto x = std::make_unique<godobject::State<Scene>>();
  const auto w = std::make_unique<godobject::Scratch<Scene>>();
  const auto out = std::make_unique<godobject::Output<Scene>>();
  par->bodies[0].coupling = {.k = 500, .g = 5, .k_r = 0.5, .g_r = 0.005};
  par->bodies[0].feedback.gains = par->bodies[0].coupling;
  in->devices[0].engaged = true;
  in->devices[0].target.X_WD.p.x() = 0.01;
  for (int n = 0; n < 1000; ++n) godobject::run(*par, *in, *x, *w, *out);
  std::printf("took its steps, at %g m\n", x->bodies[0].x.X_WB.p.x());
}
