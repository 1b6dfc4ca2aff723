#include "platform/scene/net/report.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace godobject {
namespace {

/// Returns the time constant of a node on its anchor and attachments alone, s; infinite without a spring or a
/// damper.
double slow_time(const NetNode& node) {
  if (!(node.k > 0) || !(node.g > 0)) return std::numeric_limits<double>::infinity();
  const double d = node.g / node.m / 2, omega_sq = node.k / node.m;  // x'' + 2 d x' + omega^2 x = 0
  return d * d <= omega_sq ? 1 / d : (d + std::sqrt(d * d - omega_sq)) / omega_sq;
}

}  // namespace

NetTimes time_constants(const SceneNets& nets) {
  std::vector<double> k(nets.nodes.size());
  double slowest = 0;
  for (const NetSpring& s : nets.springs) {
    k[s.i] += 2 * s.k;
    k[s.j] += 2 * s.k;
    if (s.g > 0) slowest = std::max(slowest, s.g / s.k);
  }
  std::vector<NetNode> nodes = nets.nodes;
  for (const NetAttachment& one : nets.attachments) {
    nodes[one.node].k += one.k;
    nodes[one.node].g += one.g;
  }
  NetTimes times{.fastest = std::numeric_limits<double>::infinity(), .slowest = {}};
  for (std::size_t i = 0; i < k.size(); ++i) {
    const NetNode& node = nodes[i];
    times.fastest = std::min(times.fastest, std::sqrt(node.m / (k[i] + node.k)));
    slowest = std::max(slowest, slow_time(node));
  }
  if (std::isfinite(slowest)) times.slowest = slowest;
  return times;
}

}  // namespace godobject
