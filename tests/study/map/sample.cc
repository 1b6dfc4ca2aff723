// Draws a sample: its family, scene and integrator; the family of nets.
#include "tests/study/map/sample.h"

#include <memory>

#include "tests/core/net/random_net.h"
#include "tests/core/net/usual_scene.h"
#include "tests/study/map/watched_run.h"

namespace godobject::study {
namespace {

/// Returns a number that differs for each index of a seed: a bijection of 32 bits (MurmurHash3's finaliser).
unsigned scene_seed(std::uint64_t seed, std::uint64_t index) {
  auto h = static_cast<std::uint32_t>(index + 0x9e3779b97f4a7c15u * (seed + 1));
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  return h ^ (h >> 16);
}

template <class I>
void run_family(std::size_t family, unsigned seed, MapSample& sample) {
  sample.integrator = I::name;
  Random random(seed);
  switch (family) {
    case 0: run_free<I>(random, sample); break;
    case 1: run_chain<I>(random, sample); break;
    case 2: run_pile<I>(seed, sample); break;
    case 3: run_grip<I>(seed, sample); break;
    case 4: run_valley<I>(random, sample); break;
    case 5: run_net<I>(seed, sample); break;
    case 6: run_loop<I>(random, sample); break;
    default: run_gear<I>(random, sample);
  }
}

}  // namespace

template <class I>
void run_net(unsigned seed, MapSample& sample) {
  const auto net = std::make_unique<RandomNet<I>>(seed);
  sample.kind = ordeal_names[static_cast<std::size_t>(net->of.ordeal)];
  const auto advance = [&](int) {
    net->lead();
    net->step();
  };
  watch<NetScene<I>>(*net, std::min(net->of.steps(), 1000), advance, sample);
}

template void run_net<ImplicitEuler>(unsigned, MapSample&);
template void run_net<TrBdf2>(unsigned, MapSample&);

MapSample map_sample(std::uint64_t seed, std::uint64_t number) {
  const std::size_t family = number % num_map_families;
  const std::uint64_t turn = number / num_map_families;
  MapSample sample;
  sample.number = number;
  sample.family = map_families[family];
  const unsigned scene = scene_seed(seed, num_map_families * (turn / 2) + family);
  if (turn % 2 == 0) run_family<ImplicitEuler>(family, scene, sample);
  else run_family<TrBdf2>(family, scene, sample);
  return sample;
}

}  // namespace godobject::study
