// Term: joints that close loops. The joints of the tree are eliminated (33). A further joint between two of
// its bodies is a term, which holds the constrained directions as (18) does.
#pragma once

#include "core/joint/list.h"
#include "core/joint/stabilisation.h"
#include "core/joint/tree.h"
#include "core/term/pair.h"
#include "core/tuning.h"

namespace godobject {

/// Parameters of a closing joint. Its frames coincide at coordinates zero, as those of other joints.
struct LoopJointParams {
  JointKind kind{};
  std::uint32_t a = TermEnds::on_world, b = 0;  // bodies; a may be the world
  JointFrame P, C;                              // frames on a and b
};

template <class Scene>
bool is_valid(const LoopJointParams& par, const Scene& scene) noexcept {
  return par.kind != JointKind::free && (par.a == TermEnds::on_world || scene.exists(par.a)) &&
         scene.exists(par.b) && par.a != par.b && scene.is_frame(par.P) && scene.is_frame(par.C);
}

/// Closing joint in a stage.
struct LoopJointStage : PairStage {
  SpatialVector multiplier = SpatialVector::zero();  // h F_0 (62) along constrained directions, part of J
  Real K_w = 1, K_v = 1;                             // K_rigid of rotations and translations
};

/// Kind of term with a capacity for closing joints. The impulse on b at its anchor, for the twist V of b
/// against a there, is
///
///   (62)  h F_0 + K (beta - V),  K = K_rigid L^T L
///
/// with L the constrained directions, L beta the twist that undoes the violation (18), and F_0 the multiplier
/// of the previous solve (method of multipliers, Hestenes 1969). The violation is then that of the change of
/// F_0 alone, and K_rigid need not be so large that it costs digits. Redundant directions share the force.
template <std::size_t max_>
struct LoopJoints : PairTerm {
  static constexpr std::size_t max = max_;
  static constexpr bool is_joint = true;
  using Param = LoopJointParams;
  using Stage = LoopJointStage;

  /// Linearises a joint. F: its wrench on b in the previous solve.
  template <class OfStage>
  static void begin(const Param& par, const OfStage& stage, const Wrench& F, Stage& w) noexcept {
    const bool between = par.a != TermEnds::on_world;
    const TreePlace A = between ? stage.at[par.a] : TreePlace{}, &B = stage.at[par.b];
    const Vec3 r_b = B.R_WB * par.C.p, a_W = B.p_W + r_b;
    const JointAt now = joint_at(
        {.kind = par.kind, .parent = 0, .P = par.P, .C = par.C}, A,
        {.p_W = B.p_W, .R_WB = B.R_WB, .a_W = a_W, .V = {.w = B.V.w, .v = B.V.v + B.V.w.cross(a_W - B.a_W)}});
    const auto& of_b = stage.stages[par.b];
    Real M = of_b.M, I = mean_of(of_b.A_ww);
    if (between) {
      M = std::min(M, stage.stages[par.a].M);
      I = std::min(I, mean_of(stage.stages[par.a].A_ww));
    }
    w = {};
    w.a = par.a;
    w.b = par.b;
    w.r_a = Column(Vec3(a_W - A.p_W));
    w.r_b = Column(r_b);
    w.F_0 = Column(F.f);
    with_joint(par.kind, [&](auto kind) noexcept {
      const auto m = kind.motion(now.X);
      const Twist beta = across(m, AtPrediction::beta(m, now.V, par.C.p.squaredNorm(), stage.h));
      Mat3 turns = Mat3::Identity(), moves = Mat3::Identity();
      if constexpr (decltype(m)::num_turns == 3) turns.setZero();
      for (const Vec3& s : m.turn) turns -= s * s.transpose();
      for (const Vec3& s : m.slide) moves -= s * s.transpose();
      w.K_w = rigid_mass_ratio * I;
      w.K_v = rigid_mass_ratio * M;
      w.K = {.ww = block_of(w.K_w * turns), .wv = Block::zero(), .vv = block_of(w.K_v * moves)};
      w.multiplier = {.w = Column(Vec3(turns * (stage.h * F.tau))),
                      .v = Column(Vec3(moves * (stage.h * F.f)))};
      w.J = w.multiplier + SpatialVector{.w = Column(Vec3(turns * (w.K_w * beta.w))),
                                         .v = Column(Vec3(moves * (w.K_v * beta.v)))};
    });
  }
  /// Adds an impulse to the multiplier.
  static void add_to_multiplier(const SpatialVector& J, Stage& w) noexcept {
    w.multiplier += J;
    w.J += J;
  }
  /// Returns a . K_rigid^-1 b of two impulses.
  static Real weighted(const SpatialVector& a, const SpatialVector& b, const Stage& w) noexcept {
    return dot(a.w, b.w) / w.K_w + dot(a.v, b.v) / w.K_v;
  }
  /// Returns zero: a joint stores no energy.
  template <class At>
  static Real energy(const Param&, const At&) noexcept {
    return 0;
  }
};

}  // namespace godobject
