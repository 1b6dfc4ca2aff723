#include "platform/scene/net/params.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "platform/scene/contact/params.h"
#include "platform/scene/mesh/file.h"
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

using Ends = std::pair<std::uint32_t, std::uint32_t>;

/// Returns the stiffness of each spring by its ends: along the edges, then across the inner ones.
std::map<Ends, double> stiffnesses(const NetConfig& net) {
  const double in_plane = structural_share(net.bending) * net.membrane_stiffness;
  const std::vector<SurfaceEdge> edges = edges_of(net.surface);
  std::map<Ends, double> k;
  for (const SurfaceEdge& e : edges) k[{e.i, e.j}] = in_plane * e.area / (e.length * e.length);
  if (net.bending == 0) return k;
  for (const SurfaceEdge& e : edges)
    if (e.num_triangles == 2)
      k.try_emplace(std::minmax(e.opposite[0], e.opposite[1]), net.bending * k[{e.i, e.j}]);
  return k;
}

/// True if a point is in a ball of held or attached nodes, in the net's frame.
template <class Ball>
bool is_within(const Ball& ball, const Vec3& p_F) {
  return (p_F - ball.p_F).norm() <= ball.radius;
}
bool is_held(const NetConfig& net, const Vec3& p_F) {
  return std::ranges::any_of(net.held, [&](const HeldConfig& ball) { return is_within(ball, p_F); });
}

/// Builds the nets one by one.
class NetBuilder {
 public:
  explicit NetBuilder(const SceneConfig& scene) : scene_(scene) {
    for (const MaterialUse& use : materials_of(scene)) materials_.push_back(use.material);
    to_.max_iterations = scene.net_iterations;
  }

  void add(const NetConfig& net) {
    const std::optional<std::size_t> body = body_named(scene_, net.body);
    NetRange range{net.name, body.value_or(world),          to_.nodes.size(),  net.surface.vertices.size(),
                   {},       net.thickness.value_or(0) > 0, net.touches_itself};
    const auto first = static_cast<std::uint32_t>(range.first_node);
    for (const TriangleIndices& t : net.surface.triangles)
      range.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    add_nodes(net, range.carrier);
    add_springs(net, first);
    add_attachments(net, first);
    to_.nets.push_back(std::move(range));
  }
  SceneNets take() { return std::move(to_); }

 private:
  void add_nodes(const NetConfig& net, std::size_t carrier) {
    const std::vector<double> areas = vertex_areas(net.surface);
    const std::vector<bool> rim = rim_of(net.surface);
    const auto material =
        static_cast<MaterialId>(std::ranges::find(materials_, net.material) - materials_.begin());
    for (std::size_t i = 0; i < areas.size(); ++i) {
      const double m = net.surface_density * areas[i];
      NetNode node{.m = m,
                   .body = carrier,
                   .p_B = net.X_BF.p + net.X_BF.q * net.surface.vertices[i],
                   .k = net.anchor_stiffness.value_or(0) * areas[i],
                   .g = drag(net.surface_density, net.settling_time) * areas[i],
                   .radius = net.thickness.value_or(0) / 2,
                   .material = net.thickness.value_or(0) > 0 ? material : MaterialId{0}};
      if ((net.rim && rim[i]) || is_held(net, net.surface.vertices[i])) {
        const double k = net.held_stiffness.value_or(0);
        node.k += k;
        node.g += default_net_damping_ratio * std::sqrt(k * m);
      }
      to_.nodes.push_back(node);
    }
  }

  void add_springs(const NetConfig& net, std::uint32_t first) {
    for (const auto& [ends, k] : stiffnesses(net)) {
      const auto [i, j] = ends;
      to_.springs.push_back({.i = first + i,
                             .j = first + j,
                             .k = k,
                             .g = net.relaxation_time * k,
                             .l_0 = (net.surface.vertices[j] - net.surface.vertices[i]).norm()});
    }
  }

  /// Attaches each node to the point of the body at the node's place at the start.
  void add_attachments(const NetConfig& net, std::uint32_t first) {
    const auto at_start = [&](const std::optional<std::size_t>& body) {
      return body ? scene_.bodies[*body].X_WB : Pose{};
    };
    const Pose X_WC = at_start(body_named(scene_, net.body));
    for (const AttachedConfig& ball : net.attached) {
      const std::optional<std::size_t> body = body_named(scene_, ball.body);
      const Pose X_WB = at_start(body);
      const double k = ball.stiffness.value_or(0);
      for (std::uint32_t i = 0; i < net.surface.vertices.size(); ++i) {
        if (!is_within(ball, net.surface.vertices[i])) continue;
        const Vec3 p_W = X_WC.p + X_WC.q * to_.nodes[first + i].p_B;
        to_.attachments.push_back({.node = first + i,
                                   .body = body.value_or(world),
                                   .p_B = X_WB.q.conjugate() * (p_W - X_WB.p),
                                   .k = k,
                                   .g = ball.relaxation_time * k});
      }
    }
  }

  const SceneConfig& scene_;
  std::vector<std::string> materials_;
  SceneNets to_;
};

/// Returns the time constant of a node on its anchor and attachments alone, s; infinite without a spring or a
/// damper.
double slow_time(const NetNode& node) {
  if (!(node.k > 0) || !(node.g > 0)) return std::numeric_limits<double>::infinity();
  const double d = node.g / node.m / 2, omega_sq = node.k / node.m;  // x'' + 2 d x' + omega^2 x = 0
  return d * d <= omega_sq ? 1 / d : (d + std::sqrt(d * d - omega_sq)) / omega_sq;
}

}  // namespace

std::vector<NetFace> SceneNets::faces() const {
  std::vector<NetFace> all;
  const auto touching = std::ranges::count_if(nets, &NetRange::touches);
  for (const NetRange& net : nets) {
    if (!net.touches || (touching == 1 && !net.touches_itself)) continue;
    for (const TriangleIndices& t : net.triangles)
      all.push_back({.nodes = {t[0], t[1], t[2]}, .touches_own = net.touches_itself});
  }
  return all;
}

// ---- surface --------------------------------------------------------------------------------------

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

// ---- nodes and springs ----------------------------------------------------------------------------

std::size_t num_springs(const NetConfig& net) { return stiffnesses(net).size(); }

std::size_t num_within(const NetConfig& net, const AttachedConfig& ball) {
  return static_cast<std::size_t>(
      std::ranges::count_if(net.surface.vertices, [&](const Vec3& p_F) { return is_within(ball, p_F); }));
}
std::size_t num_attachments(const NetConfig& net) {
  std::size_t n = 0;
  for (const AttachedConfig& ball : net.attached) n += num_within(net, ball);
  return n;
}

SceneNets scene_nets(const SceneConfig& scene) {
  std::vector<const NetConfig*> nets;
  for (const NetConfig& net : scene.nets) nets.push_back(&net);
  std::ranges::stable_sort(
      nets, {}, [&](const NetConfig* net) { return body_named(scene, net->body).value_or(world); });
  NetBuilder builder(scene);
  for (const NetConfig* net : nets) builder.add(*net);
  return builder.take();
}

// ---- time constants -------------------------------------------------------------------------------

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
