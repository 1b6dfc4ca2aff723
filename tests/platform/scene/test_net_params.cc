// Nets in the core's terms: masses, springs and anchors have the physical values; a stretched sheet has the
// specified membrane stiffness.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <tuple>

#include "platform/scene/net/params.h"

namespace godobject::test_net_params {
namespace {

NetConfig made(NetConfig net) {
  EXPECT_EQ(make_surface("", max_net_nodes, net), "");
  return net;
}

NetConfig sheet(double length, double width, double spacing) {
  NetConfig net;
  net.name = "sheet";
  net.kind = NetKind::sheet;
  net.length = length;
  net.width = width;
  net.spacing = spacing;
  net.surface_density = 2;
  net.membrane_stiffness = 100;
  net.settling_time = 0.1;
  net.anchor_stiffness = 0;
  return made(net);
}

NetConfig capsule(double spacing) {
  NetConfig net;
  net.name = "bag";
  net.kind = NetKind::capsule;
  net.radius = 0.03;
  net.half_length = 0.05;
  net.spacing = spacing;
  net.surface_density = 1.5;
  net.membrane_stiffness = 200;
  net.settling_time = 0.05;
  net.anchor_stiffness = 3e4;
  net.relaxation_time = 2e-3;
  net.thickness = 0.004;
  return made(net);
}

SceneConfig scene_of(std::vector<NetConfig> nets) {
  SceneConfig scene;
  for (const char* name : {"a", "b"}) {
    BodyConfig body;
    body.name = name;
    body.X_WB.p = Vec3(0.1, -0.2, 0.3);
    body.X_WB.q = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
    scene.bodies.push_back(body);
  }
  scene.nets = std::move(nets);
  return scene;
}

TEST(NetParams, MassesAddUpToDensityTimesArea) {
  for (const double spacing : {0.02, 0.01, 0.006}) {
    const NetConfig net = capsule(spacing);
    const SceneNets nets = scene_nets(scene_of({net}));
    double m = 0, k = 0, g = 0;
    for (const NetNode& node : nets.nodes) {
      EXPECT_GT(node.m, 0);
      EXPECT_EQ(node.radius, 0.002);
      m += node.m;
      k += node.k;
      g += node.g;
    }
    const double area = area_of(net.surface);
    EXPECT_NEAR(m, 1.5 * area, 1e-12 * m);
    EXPECT_NEAR(k, 3e4 * area, 1e-12 * k);
    EXPECT_NEAR(g, 8 * 1.5 / 0.05 * area, 1e-12 * g);
  }
}

TEST(NetParams, SpringsAreTheEdgesInTheirOrder) {
  for (const double bending : {0.0, 0.2}) {
    NetConfig net = capsule(0.01);
    net.bending = bending;
    const SceneNets nets = scene_nets(scene_of({net}));
    const std::size_t edges = edges_of(net.surface).size();
    // Closed: every edge has a bending spring across it, unless that is an edge too.
    EXPECT_LE(nets.springs.size(), bending == 0 ? edges : 2 * edges);
    EXPECT_GE(nets.springs.size(), bending == 0 ? edges : 2 * edges - 12);
    EXPECT_EQ(nets.springs.size(), num_springs(net));
    for (std::size_t s = 0; s < nets.springs.size(); ++s) {
      const NetSpring& spring = nets.springs[s];
      EXPECT_LT(spring.i, spring.j);
      EXPECT_NEAR(spring.l_0, (nets.nodes[spring.j].p_B - nets.nodes[spring.i].p_B).norm(), 1e-15);
      EXPECT_NEAR(spring.g, 2e-3 * spring.k, 1e-15 * spring.k);
      if (s == 0) continue;
      const NetSpring& before = nets.springs[s - 1];
      EXPECT_LT(std::pair(before.i, before.j), std::pair(spring.i, spring.j));
    }
  }
}

TEST(NetParams, AnchorsAreTheVerticesOnTheirCarrier) {
  NetConfig net = capsule(0.01);
  net.body = "b";
  net.X_BF.p = Vec3(0.01, 0.02, 0.03);
  net.X_BF.q = Quat(Eigen::AngleAxisd(1.1, Vec3(3, -1, 2).normalized()));
  const SceneNets nets = scene_nets(scene_of({net}));
  for (std::size_t i = 0; i < nets.nodes.size(); ++i) {
    EXPECT_EQ(nets.nodes[i].body, 1U);
    EXPECT_LT((nets.nodes[i].p_B - net.X_BF.p - net.X_BF.q * net.surface.vertices[i]).norm(), 1e-15);
  }
}

TEST(NetParams, NodesOfACarrierAreInARow) {
  std::vector<NetConfig> list;
  for (const char* body : {"world", "b", "a", "world", "b"}) {
    NetConfig net = capsule(0.02);
    net.name = "net" + std::to_string(list.size());
    net.body = body;
    list.push_back(net);
  }
  const SceneNets nets = scene_nets(scene_of(list));
  std::vector<std::string> names;
  std::size_t next = 0;
  for (const NetRange& range : nets.nets) {
    names.push_back(range.name);
    EXPECT_EQ(range.first_node, next);
    next += range.num_nodes;
    for (std::size_t i = range.first_node; i < next; ++i) EXPECT_EQ(nets.nodes[i].body, range.carrier);
    for (const TriangleIndices& t : range.triangles)
      for (const std::uint32_t v : t) EXPECT_TRUE(v >= range.first_node && v < next);
  }
  EXPECT_THAT(names, testing::ElementsAre("net2", "net1", "net4", "net0", "net3"));
  EXPECT_EQ(next, nets.nodes.size());
  EXPECT_TRUE(
      std::ranges::is_sorted(nets.springs, {}, [](const NetSpring& s) { return std::pair(s.i, s.j); }));
}

TEST(NetParams, IterationsAreTheScenes) {
  SceneConfig scene = scene_of({sheet(0.1, 0.1, 0.02)});
  auto par = std::make_unique<godobject::NetParams<max_net_nodes, max_net_springs>>();
  set_net_params(scene_nets(scene), *par);
  EXPECT_EQ(par->max_iterations, 12);
  scene.net_iterations = 3;
  set_net_params(scene_nets(scene), *par);
  EXPECT_EQ(par->max_iterations, 3);
}

TEST(NetParams, RimAndBallsAreHeldByStifferAnchors) {
  NetConfig net = sheet(0.1, 0.08, 0.01);
  net.rim = true;
  net.held_stiffness = 500;
  net.held.push_back({.p_F = Vec3::Zero(), .radius = 0.012});
  const SceneNets nets = scene_nets(scene_of({net}));
  const std::vector<bool> rim = rim_of(net.surface);
  std::size_t num_held = 0;
  for (std::size_t i = 0; i < nets.nodes.size(); ++i) {
    const bool held = rim[i] || net.surface.vertices[i].norm() <= 0.012;
    EXPECT_EQ(nets.nodes[i].k, held ? 500 : 0);
    EXPECT_GT(nets.nodes[i].g, 0);
    num_held += held;
  }
  EXPECT_GT(num_held, static_cast<std::size_t>(std::ranges::count(rim, true)));
  EXPECT_LT(num_held, nets.nodes.size());
}

/// Stiffness E t and Poisson's ratio of a sheet's linearised springs, when its two ends along x are displaced
/// by a strain.
struct Elasticity {
  double E_t = 0, nu = 0;
};

Elasticity stretched(const NetConfig& net) {
  const SceneNets nets = scene_nets(scene_of({net}));
  const auto n = static_cast<Eigen::Index>(nets.nodes.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  for (const NetSpring& s : nets.springs) {
    const Eigen::Vector2d u = (nets.nodes[s.j].p_B - nets.nodes[s.i].p_B).head<2>() / s.l_0;
    const Eigen::Matrix2d k = s.k * u * u.transpose();
    const Eigen::Index i = 2 * Eigen::Index{s.i}, j = 2 * Eigen::Index{s.j};
    K.block<2, 2>(i, i) += k;
    K.block<2, 2>(j, j) += k;
    K.block<2, 2>(i, j) -= k;
    K.block<2, 2>(j, i) -= k;
  }
  // x of the nodes at both ends is prescribed, and y of one of them; the others are free.
  const double half = *net.length / 2 - 0.51 * *net.spacing, strain = 1e-3;
  std::vector<Eigen::Index> given, free;
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool end = std::abs(nets.nodes[static_cast<std::size_t>(i)].p_B.x()) > half;
    (end ? given : free).push_back(2 * i);
    (i == 0 ? given : free).push_back(2 * i + 1);
  }
  Eigen::VectorXd q = Eigen::VectorXd::Zero(2 * n);
  for (const Eigen::Index r : given)
    if (r % 2 == 0) q[r] = strain * nets.nodes[static_cast<std::size_t>(r / 2)].p_B.x();
  const Eigen::MatrixXd K_ff = K(free, free), K_fg = K(free, given);
  const Eigen::VectorXd q_g = q(given);
  const Eigen::VectorXd q_f = K_ff.ldlt().solve(-K_fg * q_g);
  q(free) = q_f;
  const Eigen::VectorXd F = K * q;
  double pull = 0, low = 0, high = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec3& p = nets.nodes[static_cast<std::size_t>(i)].p_B;
    if (p.x() > half) pull += F[2 * i];
    if (std::abs(p.x()) > half / 2) continue;  // away from the ends
    low = p.y() <= -*net.width / 2 * (1 - 1e-9) ? q[2 * i + 1] : low;
    high = p.y() >= *net.width / 2 * (1 - 1e-9) ? q[2 * i + 1] : high;
  }
  return {.E_t = pull / strain / *net.width, .nu = -(high - low) / *net.width / strain};
}

TEST(NetParams, AStretchedSheetHasTheMembraneStiffness) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> size(0.06, 0.15), stiffness(1, 1e4);
  for (int trial = 0; trial < 12; ++trial) {
    NetConfig net = sheet(1.5 * size(random), size(random), 0.008);
    net.membrane_stiffness = stiffness(random);
    net.bending = trial % 2 == 0 ? 0 : 0.1;
    const Elasticity e = stretched(net);
    EXPECT_NEAR(e.E_t / net.membrane_stiffness, 1, 0.05) << trial;
    EXPECT_NEAR(e.nu, 1.0 / 3, 0.05) << trial;
  }
}

/// Returns a sheet of squares with a diagonal, as meshes often are.
NetConfig squares(int columns, int rows, double side) {
  NetConfig net = sheet(columns * side, rows * side, side);
  net.surface = {};
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i)
      net.surface.vertices.emplace_back(side * i - *net.length / 2, side * j - *net.width / 2, 0);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const auto at = [&](int a, int b) { return static_cast<std::uint32_t>(b * (columns + 1) + a); };
      if ((i + j) % 2 == 0)
        net.surface.triangles.insert(
            net.surface.triangles.end(),
            {{at(i, j), at(i + 1, j), at(i + 1, j + 1)}, {at(i, j), at(i + 1, j + 1), at(i, j + 1)}});
      else
        net.surface.triangles.insert(
            net.surface.triangles.end(),
            {{at(i, j), at(i + 1, j), at(i, j + 1)}, {at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}});
    }
  return net;
}

TEST(NetParams, SoDoesAMeshOfSquaresWithDiagonals) {
  const NetConfig net = squares(20, 12, 0.01);
  const Elasticity e = stretched(net);
  EXPECT_NEAR(e.E_t / net.membrane_stiffness, 1, 0.35);
}

/// Returns the eigenvalues of M^-1 K of the linearised net, in three coordinates a node.
Eigen::VectorXd squared_frequencies(const SceneNets& nets) {
  const auto n = static_cast<Eigen::Index>(nets.nodes.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * n, 3 * n), M = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (const NetSpring& s : nets.springs) {
    const Vec3 u = (nets.nodes[s.j].p_B - nets.nodes[s.i].p_B) / s.l_0;
    const Mat3 k = s.k * u * u.transpose();
    const Eigen::Index i = 3 * Eigen::Index{s.i}, j = 3 * Eigen::Index{s.j};
    K.block<3, 3>(i, i) += k;
    K.block<3, 3>(j, j) += k;
    K.block<3, 3>(i, j) -= k;
    K.block<3, 3>(j, i) -= k;
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const NetNode& node = nets.nodes[static_cast<std::size_t>(i)];
    K.diagonal().segment<3>(3 * i).array() += node.k;
    M.diagonal().segment<3>(3 * i).setConstant(node.m);
  }
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(K, M).eigenvalues();
}

TEST(NetParams, TimeConstantsAreBoundsOfTheNetsOwn) {
  for (const double spacing : {0.02, 0.012}) {
    NetConfig net = capsule(spacing);
    net.anchor_stiffness = 5e3;
    const SceneNets nets = scene_nets(scene_of({net}));
    const NetTimes times = time_constants(nets);
    const Eigen::VectorXd omega_sq = squared_frequencies(nets);
    const double fastest = 1 / std::sqrt(omega_sq.maxCoeff());
    EXPECT_LE(times.fastest, fastest);
    EXPECT_GT(times.fastest, 0.5 * fastest);
    // All anchors are equal: the slowest modes are rigid motions, which do not stretch springs.
    const double d = 8 / net.settling_time / 2, slowest_sq = omega_sq.minCoeff();
    EXPECT_NEAR(slowest_sq, *net.anchor_stiffness / net.surface_density, 1e-6 * slowest_sq);
    ASSERT_LT(slowest_sq, d * d) << "overdamped";
    ASSERT_TRUE(times.slowest);
    EXPECT_NEAR(*times.slowest, 1 / (d - std::sqrt(d * d - slowest_sq)), 1e-6 * *times.slowest);
  }
  EXPECT_FALSE(time_constants(scene_nets(scene_of({sheet(0.1, 0.08, 0.02)}))).slowest)
      << "it never comes back to where it was";
}

/// Returns a few nodes on anchors, all random, with springs between any two, at rest.
SceneNets drawn_net(std::mt19937_64& engine) {
  const auto log_uniform = [&](double a, double b) {
    return std::exp(std::uniform_real_distribution<double>(std::log(a), std::log(b))(engine));
  };
  SceneNets nets;
  const auto num = std::uniform_int_distribution<std::uint32_t>(2, 6)(engine);
  for (std::uint32_t j = 0; j < num; ++j) {
    NetNode node{.m = log_uniform(1e-4, 1e-1), .k = log_uniform(0.1, 1e3)};
    node.g = log_uniform(0.03, 30) * std::sqrt(node.k * node.m);
    for (int c = 0; c < 3; ++c) node.p_B[c] = std::normal_distribution<double>()(engine);
    for (std::uint32_t i = 0; i < j; ++i) {
      NetSpring spring{.i = i, .j = j, .k = log_uniform(0.1, 1e4)};
      spring.g = log_uniform(1e-4, 1) * spring.k;  // relaxation times of 0.1 ms to 1 s
      spring.l_0 = (node.p_B - nets.nodes[i].p_B).norm();
      nets.springs.push_back(spring);
    }
    nets.nodes.push_back(node);
  }
  return nets;
}

/// Returns 1 / the slowest decay of M x'' + G x' + K x = 0, by the eigenvalues of its companion matrix.
double slowest_of(const SceneNets& nets) {
  const auto n = 3 * static_cast<Eigen::Index>(nets.nodes.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);  // of (x, x')
  A.topRightCorner(n, n).setIdentity();
  const auto add = [&](Eigen::Index i, Eigen::Index j, const Mat3& k, const Mat3& g) {
    const double m = nets.nodes[static_cast<std::size_t>(i)].m;
    A.block<3, 3>(n + 3 * i, 3 * j) -= k / m;
    A.block<3, 3>(n + 3 * i, n + 3 * j) -= g / m;
  };
  for (std::size_t i = 0; i < nets.nodes.size(); ++i)
    add(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i), nets.nodes[i].k * Mat3::Identity(),
        nets.nodes[i].g * Mat3::Identity());
  for (const NetSpring& s : nets.springs) {
    const Vec3 u = (nets.nodes[s.j].p_B - nets.nodes[s.i].p_B) / s.l_0;
    const Mat3 uu = u * u.transpose();
    for (const auto& [a, b, sign] :
         {std::tuple{s.i, s.i, 1.}, {s.j, s.j, 1.}, {s.i, s.j, -1.}, {s.j, s.i, -1.}})
      add(a, b, sign * s.k * uu, sign * s.g * uu);
  }
  return -1 / A.eigenvalues().real().maxCoeff();
}

TEST(NetParams, NothingIsSlowerThanTheSlowestTimeConstant) {
  std::mt19937_64 engine(1);
  double closest = 0;
  int slower_than_anchors = 0;
  for (int k = 0; k < 300; ++k) {
    SceneNets nets = drawn_net(engine);
    const double bound = time_constants(nets).slowest.value(), slowest = slowest_of(nets);
    EXPECT_LE(slowest, bound * (1 + 1e-6)) << "net " << k;
    closest = std::max(closest, slowest / bound);
    for (NetSpring& s : nets.springs) s.g = 0;
    if (slowest > time_constants(nets).slowest.value() * (1 + 1e-6)) ++slower_than_anchors;
  }
  std::printf("up to %.4f of the bound; %d of 300 are slower than their anchors alone\n", closest,
              slower_than_anchors);
  EXPECT_GT(closest, 0.9);
  EXPECT_GT(slower_than_anchors, 10) << "springs that creep are to be among them";
}

TEST(NetParams, TimeConstantsTakeAttachmentsAsAnchors) {
  std::mt19937_64 engine(3);
  const SceneNets nets = drawn_net(engine);
  SceneNets attached = nets;
  for (std::uint32_t n = 0; n < nets.nodes.size(); ++n) {
    NetNode& node = attached.nodes[n];
    attached.attachments.push_back({.node = n, .body = 0, .k = 0.75 * node.k, .g = 0.25 * node.g});
    node.k *= 0.25;
    node.g *= 0.75;
  }
  EXPECT_NEAR(time_constants(attached).fastest, time_constants(nets).fastest, 1e-12);
  EXPECT_NEAR(time_constants(attached).slowest.value(), time_constants(nets).slowest.value(), 1e-12);
}

TEST(NetParams, ThereIsNoSlowestTimeConstantOfNodesWithoutAnchors) {
  std::mt19937_64 engine(2);
  for (double NetNode::*missing : {&NetNode::k, &NetNode::g}) {
    SceneNets nets = drawn_net(engine);
    nets.nodes[1].*missing = 0;
    EXPECT_FALSE(time_constants(nets).slowest);
  }
}

}  // namespace
}  // namespace godobject::test_net_params
