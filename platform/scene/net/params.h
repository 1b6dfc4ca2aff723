// Nets of a scene: their surfaces, and their conversion into nodes and springs of the core (decision 049).
// Nodes start on their anchors. A_i: a third of the area of a vertex's triangles; A_1, A_2: areas of the
// triangles at an edge.
//
//   m_i = sigma A_i,  k_ij = E t (A_1 + A_2) / l_ij^2,  g_ij = tau k_ij  (equilateral: k_ij = sqrt(3)/2 E t)
//   k_i = kappa A_i,  g_i = 8 sigma A_i / T  of anchors; T: settling time
//   k, tau k  of attachments
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/net/setup.h"
#include "platform/scene/geometry.h"
#include "platform/scene/scene.h"

namespace godobject {

// Surfaces: vertices and triangles with edges of nearly the requested length, and the lengths, areas and
// validity of their edges.

/// Returns the number of vertices that generated_surface() will make, within a factor of two.
double expected_vertices(const NetConfig& net);

/// Generates a surface by kind and dimensions, which must be set; not for meshes.
MeshData generated_surface(const NetConfig& net);

/// Returns the surface with its vertices sorted along its longest extent, z if tied. Springs then join near
/// numbers only, by which incomplete factors lose least.
MeshData ordered_along(const MeshData& surface);

/// An edge, i < j, and its one or two triangles.
struct SurfaceEdge {
  std::uint32_t i = 0, j = 0;
  double length = 0;                        // m
  double area = 0;                          // m^2, of its triangles
  int num_triangles = 0;                    // 1: on the rim
  std::array<std::uint32_t, 2> opposite{};  // third corner of each triangle
};

/// Returns the edges in the order of i, then j.
std::vector<SurfaceEdge> edges_of(const MeshData& surface);

double area_of(const MeshData& surface);       // m^2
double mean_edge_of(const MeshData& surface);  // m
/// Returns the area of each vertex, a third of its triangles', m^2.
std::vector<double> vertex_areas(const MeshData& surface);
/// Returns for each vertex true if it is on the edge of the surface.
std::vector<bool> rim_of(const MeshData& surface);

/// Returns why the surface is not valid for a net, with the remedy; empty if it is.
std::string why_no_net(const MeshData& surface);

// Nodes and springs.

/// Fills net.surface. Returns an error with its remedy; empty on success.
/// path: path of the mesh.
/// room: largest number of vertices.
std::string make_surface(const std::string& path, std::size_t room, NetConfig& net);

// Defaults of a net's physical numbers, derived in decision 049.

inline constexpr double default_net_damping_ratio =
    1.4;  // g / sqrt(k m) of anchors and springs, as of couplings (2)

/// Returns the stiffness k = sqrt(3)/2 E t of a spring, N/m, in an equilateral lattice equal to a membrane of
/// this E t in plane stress (Seung, Nelson 1988).
inline double lattice_stiffness(double membrane_stiffness) { return std::sqrt(3.0) / 2 * membrane_stiffness; }

/// Returns d = 8 sigma / T, N s/m^3, at which an oscillation a(t) = a_0 exp(-d t / (2 sigma)) decays within T
/// to exp(-4), 2 %.
inline double drag(double surface_density, double settling_time) {
  return 8 * surface_density / settling_time;
}

/// Returns kappa at which d / sqrt(kappa sigma) is the default ratio, N/m^3.
inline double anchor_stiffness_for(double surface_density, double settling_time) {
  const double d = drag(surface_density, settling_time) / default_net_damping_ratio;
  return d * d / surface_density;
}

/// Returns the stiffness that holds a node: ten springs of the lattice, so that the holder deforms by a tenth
/// of the net. N/m.
inline double held_stiffness_for(double membrane_stiffness) {
  return 10 * lattice_stiffness(membrane_stiffness);
}

/// Returns the factor of structural springs that compensates the bending springs. These stiffen the membrane
/// of an equilateral lattice by three times their ratio.
inline double structural_share(double bending) { return 1 / (1 + 3 * bending); }

/// Returns the mean mass of a node, kg; 0 without vertices.
inline double mean_node_mass(const NetConfig& net) {
  const std::size_t n = net.surface.vertices.size();
  return n == 0 ? 0 : net.surface_density * area_of(net.surface) / static_cast<double>(n);
}

// Nodes and springs.

/// A net as a range of the nodes of all nets.
struct NetRange {
  std::string name;
  std::size_t carrier = world;  // index of the body, or world
  std::size_t first_node = 0, num_nodes = 0;
  std::vector<TriangleIndices> triangles;        // corners: numbers of nodes among all nets
  bool touches = false, touches_itself = false;  // other nets, bodies and obstacles; its own surface
};

/// Nets in the order of their carriers, those of the world last; springs in the order of i, then j;
/// attachments in the order of the nets.
struct SceneNets {
  std::vector<NetNode> nodes;
  std::vector<NetSpring> springs;
  std::vector<NetAttachment> attachments;
  std::vector<NetRange> nets;
  int max_iterations = 0;  // largest number in a stage, for all nets

  /// Returns the triangles that nodes touch. Of a net alone that does not touch itself: none.
  std::vector<NetFace> faces() const;
};

/// Converts the nets of a scene that was read without errors.
SceneNets scene_nets(const SceneConfig& scene);

/// Sets the parameters of a composition that has room for the nets.
template <class Params>
void set_net_params(const SceneNets& nets, Params& par) {
  par.num_nodes = nets.nodes.size();
  std::ranges::copy(nets.nodes, par.nodes.begin());
  par.num_springs = nets.springs.size();
  std::ranges::copy(nets.springs, par.springs.begin());
  if constexpr (requires { par.attachments.list; }) {
    par.attachments.size = nets.attachments.size();
    std::ranges::copy(nets.attachments, par.attachments.list.begin());
  }
  if constexpr (requires { par.faces.list; }) {
    const std::vector<NetFace> faces = nets.faces();
    par.faces.size = faces.size();
    std::ranges::copy(faces, par.faces.list.begin());
  }
  par.max_iterations = nets.max_iterations;
  put_in_order(par);
}

/// Returns the number of springs of a net with this surface and these settings.
std::size_t num_springs(const NetConfig& net);

/// Returns the number of attached nodes, by one ball or by all of them.
std::size_t num_within(const NetConfig& net, const AttachedConfig& ball);
std::size_t num_attachments(const NetConfig& net);

// Time constants, and cost per step, for `check`.

/// Bounds of the time constants of small motions of nets about their rest, s, with carriers and attached
/// bodies held. k_i and g_i are those of a node's anchor and attachments together.
///
/// Fastest: 1 / omega, omega^2 <= max_i (2 sum_j k_ij + k_i) / m_i by Gershgorin's theorem on M^-1 K.
///
/// Slowest: an eigenvector of M x'' + G x' + K x = 0 has the polynomial p(s) = m s^2 - g s + k of its decay
/// rate s. p is a sum of terms, each times a square: p_i(s) = m_i s^2 - g_i s + k_i of each node on its
/// anchor, and k_s - g_s s of each spring. An oscillating mode has s = g / 2m >= min_i g_i / 2 m_i. A
/// creeping mode has p(s) = 0. Below the slower real roots of all p_i and below k_s / g_s of all springs no
/// term is negative, and some p_i(s) > 0. So
///
///   1 / s <= max(time constant of the slowest node on its anchor alone, largest g_s / k_s of all springs)
///
/// None if an anchor has no spring or no damper, because the motion of such a node depends on the whole net.
struct NetTimes {
  double fastest = 0;
  std::optional<double> slowest;
};

NetTimes time_constants(const SceneNets& nets);

/// Returns the floating-point operations of an iteration of conjugate gradients. A spring takes 24 in the
/// product and 18 in each pass through the incomplete factor; a node takes 75, vector operations included.
inline double flops_of_an_iteration(const SceneNets& nets) {
  return 60.0 * static_cast<double>(nets.springs.size()) + 75.0 * static_cast<double>(nets.nodes.size());
}

}  // namespace godobject
