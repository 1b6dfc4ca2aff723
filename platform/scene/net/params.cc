#include "platform/scene/net/params.h"

#include <cmath>
#include <map>
#include <utility>

#include "platform/scene/contact/pairs.h"
#include "platform/scene/net/edges.h"
#include "platform/scene/net/physics.h"

namespace godobject {
namespace {

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
    NetRange range{net.name, body.value_or(world), to_.nodes.size(), net.surface.vertices.size(), {}};
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

}  // namespace

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

}  // namespace godobject
