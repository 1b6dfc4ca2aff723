#include "tests/bench/contact_quality.h"

#include <algorithm>
#include <cmath>

#include "tests/bench/peer/peer.h"
#include "tests/support/box_overlap.h"

namespace godobject::bench {
namespace {

constexpr std::size_t num_instants = 200;
constexpr double settled = 3;  // s, start of the evaluation of S2

/// Depths of the first body's spheres in the plane z = 0.
struct Depths {
  double deepest = 0, average = 0;
};

Depths depths_of(const ContactScene& scene, const oracle::RigidState& x) {
  Depths depths;
  for (const Vec3& c : scene.centres) {
    const double depth = scene.radius - (x.p + x.q * c).z();
    depths.deepest = std::max(depths.deepest, depth);
    depths.average += depth / static_cast<double>(scene.centres.size());
  }
  return depths;
}

double worst_overlap(const ContactScene& scene, const std::vector<oracle::RigidState>& bodies) {
  double worst = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      worst = std::max(worst, box_overlap(*scene.half_extents, bodies[i], bodies[j]));
  return worst;
}

/// all: depths of every step, of a run longer than the start of the evaluation.
ContactQuality::Depth summary(const std::vector<Depths>& all, double Depths::*depth) {
  const auto first = static_cast<std::size_t>(std::lround(settled / h));
  const auto num = static_cast<double>(all.size() - first);
  ContactQuality::Depth sum;
  for (std::size_t n = first; n < all.size(); ++n) {
    const double change = all[n].*depth - all[n - 1].*depth;
    sum.mean += all[n].*depth / num;
    sum.jitter += change * change / num;
  }
  sum.jitter = std::sqrt(sum.jitter);
  return sum;
}

}  // namespace

double box_overlap(const Vec3& half_extents, const oracle::RigidState& a, const oracle::RigidState& b) {
  if ((b.p - a.p).norm() > 2 * half_extents.norm()) return 0;
  const auto box = [&](const oracle::RigidState& x) -> godobject::box_overlap::PosedBox {
    return {.p = x.p, .h = half_extents, .R = x.q.toRotationMatrix()};
  };
  return std::max(godobject::box_overlap::overlap(box(a), box(b)), 0.0);
}

ContactQuality quality_of(const ContactScene& scene, std::size_t steps,
                          const std::function<Snapshot(std::size_t n)>& step) {
  ContactQuality quality;
  std::vector<Depths> depths;    // S2, of every step
  std::vector<double> overlaps;  // S4, of every instant
  const std::size_t every = std::max<std::size_t>(steps / num_instants, 1);
  for (std::size_t n = 0; n < steps; ++n) {
    const Snapshot now = step(n);
    quality.contacts += static_cast<double>(now.num_contacts) / static_cast<double>(steps);
    for (std::size_t i = 1; i < now.bodies.size(); ++i)
      quality.speed = std::max(quality.speed, now.bodies[i].v.norm());
    if (!scene.half_extents) depths.push_back(depths_of(scene, now.bodies.front()));
    else if ((n + 1) % every == 0) overlaps.push_back(worst_overlap(scene, now.bodies));
  }
  if (!scene.half_extents) {
    quality.deepest = summary(depths, &Depths::deepest);
    quality.average = summary(depths, &Depths::average);
  } else {
    std::sort(overlaps.begin(), overlaps.end());
    quality.overlap_median = overlaps[overlaps.size() / 2];
    quality.overlap = overlaps.back();
  }
  return quality;
}

}  // namespace godobject::bench
