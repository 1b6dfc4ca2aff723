// The elimination along the tree against its plain twin: one dense matrix of all twists and all joint wrenches.
#include "core/tree_solve.h"

#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

namespace godobject {
namespace {

using Matrix6 = Eigen::Matrix<Real, 6, 6>;
using Vector6 = Eigen::Matrix<Real, 6, 1>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Node {
  std::size_t parent = world;
  int dof = 0;
  Matrix6 A;  // not symmetric, like that of a stage
  Vector6 b;
  EliminatedJoint joint;
};

Vector6 stacked(const Vec3& w, const Vec3& v) {
  Vector6 a;
  a << w, v;
  return a;
}

/// X of V_child = X V_parent for a rigid motion.
Matrix6 shift(const EliminatedJoint& joint) {
  Matrix6 X = Matrix6::Identity();
  X.bottomLeftCorner<3, 3>() = -skew(joint.d);
  return X;
}

class RandomTree {
 public:
  explicit RandomTree(unsigned seed) : engine_(seed) {
    for (std::size_t i = 0; i < num_bodies; ++i) {
      Node& n = nodes_[i];
      n.parent = i == 0 ? world : static_cast<std::size_t>(uniform(0, static_cast<Real>(i)));
      n.dof = static_cast<int>(uniform(0, 4));
      const Matrix6 M = Matrix6::NullaryExpr([&] { return uniform(-1, 1); });
      n.A = M * M.transpose() + Matrix6::Identity() + Real(0.5) * (M - M.transpose());
      n.b = Vector6::NullaryExpr([&] { return uniform(-1, 1); });
      EliminatedJoint& j = n.joint;
      for (Mat3* S : {&j.S_w, &j.S_v}) *S = Mat3::NullaryExpr([&] { return uniform(-1, 1); });
      for (Vec3* a : {&j.beta_w, &j.beta_v, &j.d}) *a = Vec3::NullaryExpr([&] { return uniform(-1, 1); });
    }
  }

  /// Twists of all bodies, then wrenches of all joints on their children, from the dense system.
  VectorXd dense() const {
    const auto n = static_cast<Eigen::Index>(6 * num_bodies);
    MatrixXd K = MatrixXd::Zero(2 * n, 2 * n);
    VectorXd r = VectorXd::Zero(2 * n);
    for (std::size_t k = 0; k < num_bodies; ++k) {
      const Node& node = nodes_[k];
      const auto i = static_cast<Eigen::Index>(6 * k), d = static_cast<Eigen::Index>(node.dof);
      const bool on_world = node.parent == world;
      const Eigen::Index p = on_world ? 0 : static_cast<Eigen::Index>(6 * node.parent);
      const Matrix6 X = shift(node.joint);
      // body: A V - F + sum of X^T F over its children = b
      K.block<6, 6>(i, i) = node.A;
      K.block<6, 6>(i, n + i) = -Matrix6::Identity();
      r.segment<6>(i) = node.b;
      if (!on_world) K.block<6, 6>(p, n + i) = X.transpose();
      // joint: no wrench along S, no motion across it
      MatrixXd S(6, d);
      S << node.joint.S_w.leftCols(d), node.joint.S_v.leftCols(d);
      const MatrixXd Q =
          MatrixXd(Eigen::HouseholderQR<MatrixXd>(S).householderQ() * MatrixXd::Identity(6, 6));
      const MatrixXd across = d == 0 ? MatrixXd(MatrixXd::Identity(6, 6)) : MatrixXd(Q.rightCols(6 - d));
      K.block(n + i, n + i, d, 6) = S.transpose();
      K.block(n + i + d, i, 6 - d, 6) = across.transpose();
      if (!on_world) K.block(n + i + d, p, 6 - d, 6) = -across.transpose() * X;
      r.segment(n + i + d, 6 - d) = across.transpose() * stacked(node.joint.beta_w, node.joint.beta_v);
    }
    return K.fullPivLu().solve(r);
  }

  /// The same by elimination.
  VectorXd eliminated() {
    std::array<ArticulatedBody, num_bodies> bodies;
    for (std::size_t k = 0; k < num_bodies; ++k) {
      const Node& n = nodes_[k];
      bodies[k] = {n.A.topLeftCorner<3, 3>(),
                   n.A.topRightCorner<3, 3>(),
                   n.A.bottomLeftCorner<3, 3>(),
                   n.A.bottomRightCorner<3, 3>(),
                   n.b.head<3>(),
                   n.b.tail<3>()};
    }
    for (std::size_t k = num_bodies; k-- > 0;) {
      Node& n = nodes_[k];
      with_dof(n.dof, [&](auto d) {
        eliminate<d>(bodies[k], n.joint, n.parent == world ? nullptr : &bodies[n.parent]);
      });
    }
    std::array<Twist, num_bodies> V;
    VectorXd all(12 * num_bodies);
    for (std::size_t k = 0; k < num_bodies; ++k) {
      const Node& n = nodes_[k];
      const Twist V_P = n.parent == world ? Twist{} : V[n.parent];
      with_dof(n.dof, [&](auto d) { V[k] = solved<d>(n.joint, V_P); });
      const ArticulatedBody& a = bodies[k];
      const auto i = static_cast<Eigen::Index>(6 * k);
      all.segment<6>(i) = stacked(V[k].w, V[k].v);
      all.segment<6>(static_cast<Eigen::Index>(6 * num_bodies) + i) =
          stacked(a.A_ww * V[k].w + a.A_wv * V[k].v - a.b_w, a.A_vw * V[k].w + a.A_vv * V[k].v - a.b_v);
    }
    return all;
  }

 private:
  static constexpr std::size_t num_bodies = 7;

  template <class F>
  static void with_dof(int dof, F&& f) {
    switch (dof) {
      case 0: return f(std::integral_constant<int, 0>{});
      case 1: return f(std::integral_constant<int, 1>{});
      case 2: return f(std::integral_constant<int, 2>{});
      default: return f(std::integral_constant<int, 3>{});
    }
  }
  Real uniform(Real a, Real b) { return std::uniform_real_distribution<Real>(a, b)(engine_); }

  std::mt19937 engine_;
  std::array<Node, num_bodies> nodes_;
};

TEST(TreeSolve, EqualsTheDenseSystem) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    RandomTree tree(seed);
    const VectorXd expected = tree.dense(), actual = tree.eliminated();
    EXPECT_LE((actual - expected).norm(), 1e-10 * (1 + expected.norm())) << "seed " << seed;
  }
}

TEST(TreeSolve, RootWithoutAJointIsSolvedByItself) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<Real> uniform(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const Matrix6 M = Matrix6::NullaryExpr([&] { return uniform(engine); });
    const Matrix6 A = M * M.transpose() + Matrix6::Identity() + Real(0.5) * (M - M.transpose());
    const Vector6 b = Vector6::NullaryExpr([&] { return uniform(engine); });
    const Twist V =
        solved(ArticulatedBody{A.topLeftCorner<3, 3>(), A.topRightCorner<3, 3>(), A.bottomLeftCorner<3, 3>(),
                               A.bottomRightCorner<3, 3>(), b.head<3>(), b.tail<3>()});
    EXPECT_LE((A * stacked(V.w, V.v) - b).norm(), 1e-12 * (1 + b.norm()) * A.norm());
  }
}

}  // namespace
}  // namespace godobject
