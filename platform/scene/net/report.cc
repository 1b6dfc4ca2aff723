#include "platform/scene/net/report.h"

#include <cmath>
#include <limits>

namespace godobject {
namespace {

double slow_time(const NetNode& node) {
  const double d = node.g / node.m / 2, omega_sq = node.k / node.m;  // x'' + 2 d x' + omega^2 x = 0
  if (omega_sq == 0) return 1 / (2 * d);
  return d * d <= omega_sq ? 1 / d : (d + std::sqrt(d * d - omega_sq)) / omega_sq;
}

}  // namespace

NetTimes time_constants(const SceneNets& nets) {
  std::vector<double> k(nets.nodes.size());
  for (const NetSpring& s : nets.springs) {
    k[s.i] += 2 * s.k;
    k[s.j] += 2 * s.k;
  }
  NetTimes times{.fastest = std::numeric_limits<double>::infinity(), .slowest = 0};
  for (std::size_t i = 0; i < k.size(); ++i) {
    const NetNode& node = nets.nodes[i];
    times.fastest = std::min(times.fastest, std::sqrt(node.m / (k[i] + node.k)));
    times.slowest = std::max(times.slowest, slow_time(node));
  }
  return times;
}

}  // namespace godobject
