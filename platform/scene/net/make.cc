#include "platform/scene/net/make.h"

#include <cmath>

#include "platform/scene/mesh/file.h"
#include "platform/scene/net/edges.h"
#include "platform/scene/net/surface.h"
#include "platform/scene/text/key.h"

namespace godobject {
namespace {

/// Rounds up to three digits.
double rounded_up(double x) {
  const double digit = std::pow(10, std::floor(std::log10(x)) - 2);
  if (!(digit > 0)) return x;
  return std::ceil(x / digit) * digit;
}

std::string too_many(double vertices, std::size_t room, const NetConfig& net) {
  std::string text = "has " + (vertices < 1e6 ? std::to_string(std::lround(vertices)) : "over a million") +
                     " nodes, above the capacity of " + std::to_string(room) + " of " +
                     std::to_string(max_net_nodes) + ": ";
  if (net.kind == NetKind::mesh) return text + "simplify the mesh with a mesh editor";
  constexpr double rounding = 1.05;  // tolerance for the numbers of rows, and of vertices in each
  if (room < 16) return text + "make the other nets coarser";
  return text + "a spacing of " +
         shortest(rounded_up(rounding * *net.spacing * std::sqrt(vertices / static_cast<double>(room)))) +
         " m or above fits";
}

}  // namespace

std::string make_surface(const std::string& path, std::size_t room, NetConfig& net) {
  if (net.kind == NetKind::mesh) {
    if (std::string why_not = read_mesh(path, net.scale.value_or(1), net.surface); !why_not.empty())
      return why_not;
  } else {
    constexpr double safe = 2;  // error bound of expected_vertices()
    if (const double n = expected_vertices(net); !(n <= safe * static_cast<double>(max_net_nodes)))
      return too_many(n, room, net);
    net.surface = generated_surface(net);
  }
  std::string why_not;
  if (const std::size_t n = net.surface.vertices.size(); n > room)
    why_not = too_many(static_cast<double>(n), room, net);
  else why_not = why_no_net(net.surface);
  net.surface = why_not.empty() ? ordered_along(net.surface) : MeshData{};
  return why_not;
}

}  // namespace godobject
