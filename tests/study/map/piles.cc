// Families with contacts: piles, grips that turn, a tool in a valley.
#include <array>
#include <memory>

#include "tests/core/contact/bodies/drawn_piles.h"
#include "tests/core/contact/usual_scenes.h"
#include "tests/core/contact/valley.h"
#include "tests/study/map/watched_run.h"

namespace godobject::study {
namespace {

/// Steps of 0.6 s, at most `most`.
int steps_of(Real h, int most) { return std::min(static_cast<int>(0.6 / h), most); }

}  // namespace

template <class I>
void run_pile(unsigned seed, MapSample& sample) {
  constexpr std::array kinds{DrawnKind::loaded_chain, DrawnKind::hit_chain, DrawnKind::pendulums,
                             DrawnKind::thrown_tree};
  constexpr std::array names{"loaded-chain", "hit-chain", "pendulums", "thrown-tree"};
  sample.kind = names[seed % kinds.size()];
  const auto pile = std::make_unique<DrawnPile<I>>(kinds[seed % kinds.size()], seed);
  const int steps = steps_of(pile->par.h, 600);
  watch<Jointed<I>>(
      *pile, steps, [&](int n) { pile->go_on(n > steps / 2); }, sample);
}

template <class I>
void run_grip(unsigned seed, MapSample& sample) {
  const auto pile = std::make_unique<DrawnPile<I>>(DrawnKind::gripper, seed);
  sample.kind = "gripper";
  Random random(seed + 1);
  Hand hand = Hand::drawn(random, 0.05);
  hand.pivot = pile->p(0);
  const int steps = steps_of(pile->par.h, 600);
  watch<Jointed<I>>(*pile, steps, HandMotion<Jointed<I>>(*pile, hand, steps), sample);
}

template <class I>
void run_valley(Random& random, MapSample& sample) {
  using valley::radius;
  using S = OneTool<I>;
  const valley::Valley valley(random.log_uniform(2, 60) * pi / 180, random.log_uniform(2, 60) * pi / 180,
                              random);
  const auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  par.h = random.log_uniform(1e-4, 5e-3);
  par.gravity_W = Vec3(0, 0, random.integer(0, 1) * -9.81);
  const Real m = random.log_uniform(1e-3, 1), slender = random.log_uniform(1, 100);
  const Real moment = m * radius * radius;
  par.bodies[0].body = rigid_body(m, random.inertia(moment * Vec3(slender, slender, 1)));
  const int spheres = random.integer(1, 3);
  for (int k = 0; k < spheres; ++k) add_sphere(par, 0, Vec3(0, 0, 1.5 * k * radius), radius);
  const bool is_mesh = random.integer(0, 1) == 0;
  sample.kind = is_mesh ? "mesh" : "height-field";
  par.contacts.surfaces.at(par.contacts.num_surfaces++) = {.shape = is_mesh ? valley.mesh()
                                                                            : valley.height_field()};
  const Real zeta = random.integer(0, 3) == 0 ? 0 : random.log_uniform(0.01, 10);
  set_law(par, law_of(random.log_uniform(1e3, 1e8), zeta, random.uniform(0, 1), m));
  par.bodies[0].coupling =
      spring(par.bodies[0].body, random.log_uniform(10, 1e6), moment * random.log_uniform(1e2, 1e7),
             random.integer(0, 3) == 0 ? 0 : random.log_uniform(0.01, 10));
  par.bodies[0].device.rise = 0;
  const Real above = 2 * radius / std::cos(std::max(valley.left, valley.right));
  const Vec3 start(random.uniform(-1, 1) * radius, random.uniform(-1, 1) * radius, above + 1.5 * radius);
  place(run->x, 0,
        {.X_WB = at(start, pi * random.uniform(0, 1) * random.direction()),
         .V_WB = {.w = random.log_uniform(0.1, 300) * random.direction(), .v = Vec3::Zero()}});
  // the hand sways about a point below the lowest line
  const Vec3 target(random.uniform(-2, 2) * radius, random.uniform(-2, 2) * radius,
                    -radius * random.log_uniform(0.01, 4));
  hold_at(*run, at(target));
  Hand hand = Hand::drawn(random, 4 * radius);
  hand.pivot = target;
  const int steps = steps_of(par.h, 1000);
  watch(*run, steps, HandMotion<S>(*run, hand, steps), sample);
}

template void run_pile<ImplicitEuler>(unsigned, MapSample&);
template void run_pile<TrBdf2>(unsigned, MapSample&);
template void run_grip<ImplicitEuler>(unsigned, MapSample&);
template void run_grip<TrBdf2>(unsigned, MapSample&);
template void run_valley<ImplicitEuler>(Random&, MapSample&);
template void run_valley<TrBdf2>(Random&, MapSample&);

}  // namespace godobject::study
