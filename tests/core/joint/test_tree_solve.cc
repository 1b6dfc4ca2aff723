// Elimination along the tree against a plain solution: one dense matrix of all twists and all joint wrenches.
#include "core/joint/tree_solve.h"

#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

namespace godobject::test_tree_solve {
namespace {

using Matrix6 = Eigen::Matrix<Real, 6, 6>;
using Vector6 = Eigen::Matrix<Real, 6, 1>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Node {
  std::size_t parent = world;
  int turns = 0, slides = 0;  // three turns: a ball
  Matrix6 A;                  // not symmetric, like that of a stage
  Vector6 b;
  std::array<Vec3, 2> axes;
  std::array<AxisTerms, 2> along;
  Twist beta;  // (5)
  Vec3 d;      // from the parent's anchor to the body's
  std::array<EliminatedAxis, 2> eliminated;

  Eigen::Index dof() const { return turns + slides; }
  MatrixXd S() const {
    MatrixXd all = MatrixXd::Zero(6, dof());
    if (turns == 3) all.topRows<3>().setIdentity();
    for (int c = 0; turns < 3 && c < turns + slides; ++c)
      all.block<3, 1>(c < turns ? 0 : 3, c) = axes[static_cast<std::size_t>(c)];
    return all;
  }
};

Vector6 stacked(const Vec3& w, const Vec3& v) {
  Vector6 a;
  a << w, v;
  return a;
}

/// X of V_child = X V_parent for a rigid motion.
Matrix6 shift(const Vec3& d) {
  Matrix6 X = Matrix6::Identity();
  X.bottomLeftCorner<3, 3>() = -skew(d);
  return X;
}

ArticulatedBody body_of(const Matrix6& A, const Vector6& b) {
  const auto block = [&](Eigen::Index row, Eigen::Index column) {
    const Mat3 m = A.block<3, 3>(row, column);
    return Block{{Column(m.col(0)), Column(m.col(1)), Column(m.col(2))}};
  };
  return {.A = {.ww = block(0, 0), .wv = block(0, 3), .vw = block(3, 0), .vv = block(3, 3)},
          .b = {.w = Column(b.head<3>()), .v = Column(b.tail<3>())}};
}

class RandomTree {
 public:
  explicit RandomTree(unsigned seed) : engine_(seed) {
    for (std::size_t i = 0; i < num_bodies; ++i) {
      Node& n = nodes_[i];
      n.parent = i == 0 ? world : static_cast<std::size_t>(uniform(0, static_cast<Real>(i)));
      n.turns = static_cast<int>(uniform(0, 4));
      n.slides = n.turns == 3 ? 0 : static_cast<int>(uniform(0, static_cast<Real>(3 - n.turns)));
      const Matrix6 M = Matrix6::NullaryExpr([&] { return uniform(-1, 1); });
      n.A = M * M.transpose() + Matrix6::Identity() + Real(0.5) * (M - M.transpose());
      n.b = Vector6::NullaryExpr([&] { return uniform(-1, 1); });
      for (Vec3* a : {&n.beta.w, &n.beta.v, &n.d}) *a = random_vector();
      for (Vec3& a : n.axes) a = random_vector().normalized();
      if (n.turns < 3)
        for (AxisTerms& t : n.along) t = {.D = uniform(0, 2), .tau = uniform(-1, 1)};
    }
  }

  /// Twists of all bodies, then wrenches of all joints on their children, from the dense system.
  VectorXd dense() const {
    const auto n = static_cast<Eigen::Index>(6 * num_bodies);
    MatrixXd K = MatrixXd::Zero(2 * n, 2 * n);
    VectorXd r = VectorXd::Zero(2 * n);
    for (std::size_t k = 0; k < num_bodies; ++k) {
      const Node& node = nodes_[k];
      const Eigen::Index i = 6 * static_cast<Eigen::Index>(k), d = node.dof();
      const bool on_world = node.parent == world;
      const Eigen::Index p = on_world ? 0 : static_cast<Eigen::Index>(6 * node.parent);
      const Matrix6 X = shift(node.d);
      // body: A V - F + sum of X^T F over its children = b
      K.block<6, 6>(i, i) = node.A;
      K.block<6, 6>(i, n + i) = -Matrix6::Identity();
      r.segment<6>(i) = node.b;
      if (!on_world) K.block<6, 6>(p, n + i) = X.transpose();
      // joint, V = X V_parent + S q' + beta: no motion across S; along it F is the force on the coordinate
      const MatrixXd S = node.S();
      const MatrixXd Q =
          MatrixXd(Eigen::HouseholderQR<MatrixXd>(S).householderQ() * MatrixXd::Identity(6, 6));
      const MatrixXd across = d == 0 ? MatrixXd(MatrixXd::Identity(6, 6)) : MatrixXd(Q.rightCols(6 - d));
      K.block(n + i + d, i, 6 - d, 6) = across.transpose();
      if (!on_world) K.block(n + i + d, p, 6 - d, 6) = -across.transpose() * X;
      const Vector6 beta = stacked(node.beta.w, node.beta.v);
      r.segment(n + i + d, 6 - d) = across.transpose() * beta;
      if (d == 0) continue;
      // q' = (S^T S)^-1 S^T (V - X V_parent - beta):  S^T F = tau - D q'
      const MatrixXd pick = (S.transpose() * S).inverse() * S.transpose();
      MatrixXd D = MatrixXd::Zero(d, d);
      VectorXd tau = VectorXd::Zero(d);
      for (Eigen::Index c = 0; node.turns < 3 && c < d; ++c) {
        D(c, c) = node.along[static_cast<std::size_t>(c)].D;
        tau[c] = node.along[static_cast<std::size_t>(c)].tau;
      }
      K.block(n + i, n + i, d, 6) = S.transpose();
      K.block(n + i, i, d, 6) += D * pick;
      if (!on_world) K.block(n + i, p, d, 6) -= D * pick * X;
      r.segment(n + i, d) = tau + D * pick * beta;
    }
    return K.fullPivLu().solve(r);
  }

  /// Returns the solution by elimination.
  VectorXd eliminated() {
    std::array<ArticulatedBody, num_bodies> bodies;
    for (std::size_t k = 0; k < num_bodies; ++k) {
      const Node& n = nodes_[k];
      bodies[k] = body_of(n.A, n.b);
    }
    for (std::size_t k = num_bodies; k-- > 0;) {
      Node& n = nodes_[k];
      ArticulatedBody& a = bodies[k];
      const bool hangs = n.parent != world;
      add_bias(a, {.w = Column(n.beta.w), .v = Column(n.beta.v)});
      if (n.turns == 3) {
        eliminate_turns(a);
        if (hangs) add_mass_to_parent(a, Column(n.d), bodies[n.parent]);
        continue;
      }
      for (std::size_t c = 0; c < static_cast<std::size_t>(n.dof()); ++c) {
        const bool turn = c < static_cast<std::size_t>(n.turns);
        (turn ? eliminate_axis<true> : eliminate_axis<false>)(a, Column(n.axes[c]), n.along[c],
                                                              n.eliminated[c], true);
      }
      if (hangs) add_to_parent(a, Column(n.d), bodies[n.parent]);
    }
    std::array<SpatialVector, num_bodies> V;
    VectorXd all(12 * num_bodies);
    for (std::size_t k = 0; k < num_bodies; ++k) {
      const Node& n = nodes_[k];
      const ArticulatedBody& a = bodies[k];
      const SpatialVector V_P = n.parent == world ? SpatialVector{} : shifted(V[n.parent], Column(n.d));
      SpatialVector moved = V_P, F;
      if (n.turns == 3) {
        moved.w = a.b.w - a.A.wv * V_P.v;
        F.v = a.A.vv * V_P.v - a.b.v;
      } else {
        for (auto c = static_cast<std::size_t>(n.dof()); c-- > 0;)
          (c < static_cast<std::size_t>(n.turns) ? moved.w : moved.v) +=
              Column(n.axes[c]) * rate(n.eliminated[c], moved);
        F = a.A * V_P - a.b;
      }
      V[k] = {.w = moved.w + Column(n.beta.w), .v = moved.v + Column(n.beta.v)};
      const auto i = static_cast<Eigen::Index>(6 * k);
      all.segment<6>(i) = stacked(V[k].w.vec(), V[k].v.vec());
      all.segment<6>(static_cast<Eigen::Index>(6 * num_bodies) + i) = stacked(F.w.vec(), F.v.vec());
    }
    return all;
  }

 private:
  static constexpr std::size_t num_bodies = 7;

  Vec3 random_vector() {
    return Vec3::NullaryExpr([&] { return uniform(-1, 1); });
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
    const SpatialVector V = solved(body_of(A, b).A, body_of(A, b).b);
    EXPECT_LE((A * stacked(V.w.vec(), V.v.vec()) - b).norm(), 1e-12 * (1 + b.norm()) * A.norm());
  }
}

}  // namespace
}  // namespace godobject::test_tree_solve
