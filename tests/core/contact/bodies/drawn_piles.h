// Random jointed tools among bodies: grippers that close, chains under bricks or hit by them, pendulums, and
// thrown trees of any joints.
#pragma once

#include "core/energy_balance.h"
#include "tests/core/contact/bodies/jointed_pile.h"

namespace godobject {

enum class DrawnKind { gripper, loaded_chain, hit_chain, pendulums, thrown_tree };
inline constexpr std::array drawn_kinds{DrawnKind::gripper, DrawnKind::loaded_chain, DrawnKind::hit_chain,
                                        DrawnKind::pendulums, DrawnKind::thrown_tree};

/// A scene of one seed. The hand moves its gripped body, if any.
template <class I>
class DrawnPile : public JointedPileOf<I> {
 public:
  using Base = JointedPileOf<I>;
  using Base::par, Base::x, Base::in, Base::add_brick, Base::join, Base::p;

  DrawnPile(DrawnKind kind, unsigned seed) : random_(seed) {
    par.h = random_.log_uniform(1e-4, 5e-3);
    const std::array dampings{0.0, 0.1, 1.0, 10.0};
    mass_ = random_.log_uniform(1e-3, 1);
    const Real zeta = dampings[static_cast<std::size_t>(random_.integer(0, 3))];
    set_law(par, law_of(random_.log_uniform(1e3, 1e8), zeta, random_.uniform(0, 1), mass_));
    speed_ = random_.log_uniform(0.05, 5);
    if (random_.integer(0, 3) > 0) this->add_floor();
    else par.gravity_W = Vec3(0, 0, -earth_gravity);
    switch (kind) {
      case DrawnKind::gripper: draw_gripper(); break;
      case DrawnKind::loaded_chain: draw_loaded_chain(); break;
      case DrawnKind::hit_chain: draw_hit_chain(); break;
      case DrawnKind::pendulums: draw_pendulums(); break;
      case DrawnKind::thrown_tree: draw_thrown_tree(); break;
    }
  }
  /// Makes one step; the hand moves on unless it rests.
  void go_on(bool rests = false) {
    if (held_ && rests) {
      in.devices[*held_].target.V_WD = {};
    } else if (held_) {
      const Real t = static_cast<Real>(x.tick + 1) * par.h;
      this->lead_to(*held_, from_ + way_ * (1 - std::cos(rate_ * t)));
    }
    this->step();
  }
  bool is_held() const { return held_.has_value(); }

 private:
  Real drawn_mass() { return mass_ * random_.log_uniform(0.03, 30); }
  JointKind drawn_joint() { return joint_kinds[static_cast<std::size_t>(random_.integer(0, 5))]; }
  /// One joint in three has stops, which bodies at rest do not touch.
  void draw_stops(std::size_t i) {
    if (random_.integer(0, 2) > 0) return;
    const Real k = random_.log_uniform(0.1, 1e3), end = random_.uniform(0.1, 1);
    par.bodies[i].joint.stop.stops[0] = {.lower = -end, .upper = end, .k = k, .g = 1e-2 * k, .width = 0.05};
  }
  Start thrown(const Vec3& p_W, Real speed) {
    return {.X_WB = {.p = p_W, .q = random_.rotation()},
            .V_WB = {.w = 10 * speed * random_.vector(), .v = speed * random_.direction()}};
  }
  void hold(std::size_t i, Real k, Real k_r) {
    this->hold_at(i, Base::at(i).X_WB, spring(par.bodies[i].body, k, k_r, random_.uniform(0.1, 2)));
    held_ = i;
    from_ = p(i);
    way_ = 0.03 * random_.vector();
    rate_ = speed_ / 0.03;
  }
  /// A chain of `links` from `start` on; from the world, by its first one, if it hangs.
  void add_chain(int links, const Start& start, bool hangs) {
    const JointKind kind = drawn_joint();
    const bool mixed = random_.integer(0, 1) == 0;
    const Vec3 end(brick_half.x() + 0.001, 0, 0);
    std::size_t before = world;
    for (int k = 0; k < links; ++k) {
      const std::size_t i = add_brick(start, drawn_mass());
      const Vec3 axis = random_.integer(0, 1) ? y_axis : random_.direction();
      const JointKind here = mixed ? drawn_joint() : kind;
      if (k > 0) {
        join(i, here, before, frame(end, axis), frame(-end, axis));
        draw_stops(i);
      } else if (hangs) {
        const Mat3 R = start.X_WB.q.toRotationMatrix();
        JointFrame pivot = frame(end, axis), own = frame(-end, axis);
        pivot.p = start.X_WB.p - R * end;
        pivot.R = R * own.R;
        join(i, here, world, pivot, own);
      }
      before = i;
    }
  }
  void draw_gripper() {
    const Real m = drawn_mass(), height = 0.0655 + (random_.integer(0, 1) ? 0.1 : 0);
    const JointKind kind = random_.integer(0, 2) ? JointKind::hinge : JointKind::slider;
    const Real width = kind == JointKind::hinge ? 0.0195 : 0.024;
    const std::size_t palm =
        add_brick({.X_WB = at(Vec3(0, 0, height)), .V_WB = {}}, drawn_mass(), Vec3(0.03, 0.01, 0.005));
    const Real jaw_mass = drawn_mass();
    hold(palm, random_.log_uniform(1e2, 1e5), random_.log_uniform(0.1, 10));
    for (const Real side : {-1.0, 1.0}) {
      const std::size_t jaw = add_brick({}, jaw_mass, Vec3(0.003, 0.008, 0.02));
      const Vec3 axis = kind == JointKind::hinge ? y_axis : Vec3(Vec3::UnitX());
      join(jaw, kind, palm, frame(Vec3(width * side, 0, -0.02), axis), frame(Vec3(0, 0, 0.018), axis));
      const Real k = random_.log_uniform(1, 1e4);
      this->hold_at(jaw, at(p(jaw) - Vec3(0.01 * side, 0, 0), Vec3(0, 0.15 * side, 0)),
                    spring(par.bodies[jaw].body, kind == JointKind::slider ? k : 0, 1e-4 * k));
      if (kind == JointKind::hinge) par.bodies[jaw].coupling.g = 0;
    }
    const Vec3 under = Vec3(0, 0, height - 0.05);
    add_brick({.X_WB = at(under), .V_WB = {}}, m);
    if (random_.integer(0, 1)) add_brick({.X_WB = at(under - Vec3(0, 0, 0.0101)), .V_WB = {}}, m);
    for (int n = random_.integer(0, 3); n > 0; --n)
      add_brick(thrown(Vec3(0.05 * n - 0.1, 0.03, 0.25), speed_), drawn_mass());
  }
  void draw_loaded_chain() {
    add_chain(random_.integer(2, 4), {.X_WB = at(Vec3(-0.05, 0, 0.0051)), .V_WB = {}}, random_.integer(0, 1));
    const bool flat = random_.integer(0, 1);
    for (int n = random_.integer(1, 4); n > 0; --n) {
      const Vec3 p_W(random_.uniform(-0.05, 0.05), 0.004 * random_.normal(), 0.005 + 0.012 * n);
      if (flat) add_brick({.X_WB = at(p_W), .V_WB = {}}, drawn_mass());
      else add_brick(thrown(p_W + Vec3(0, 0, 0.03 * n), speed_), drawn_mass());
    }
  }
  void draw_hit_chain() {
    const Vec3 middle(0, 0, 0.08);
    add_chain(random_.integer(2, 4), {.X_WB = at(middle - Vec3(0.05, 0, 0)), .V_WB = {}},
              random_.integer(0, 1));
    for (int n = random_.integer(2, 4); n > 0; --n) {
      const Vec3 way = (random_.direction() + Vec3(0, 0, 0.5)).normalized();
      const Vec3 p_W =
          Vec3(random_.uniform(-0.05, 0.05), 0, middle.z()) + (0.03 + 0.025 * n) * way.cwiseAbs();
      Start start = thrown(p_W, speed_);
      start.V_WB.v = -speed_ * way.cwiseAbs();
      add_brick(start, drawn_mass());
    }
    if (random_.integer(0, 2) == 0) hold(0, random_.log_uniform(1e2, 1e5), random_.log_uniform(0.01, 10));
  }
  void draw_pendulums() {
    const Vec3 end(brick_half.x() + 0.001, 0, 0);
    const Mat3 down = exp_so3(Vec3(0, pi / 2, 0)).toRotationMatrix();  // x of the links
    for (const Real side : {-1.0, 1.0}) {
      const JointFrame pivot{.p = Vec3(0.02 * side, 0, 0.1), .R = down * frame(Vec3::Zero(), y_axis).R};
      const std::size_t upper = add_brick({}, drawn_mass());
      const Real rate = speed_ / 0.05;
      join(upper, JointKind::hinge, world, pivot, frame(-end, y_axis),
           {.q = Vec3(-1.2 * side, 0, 0), .q_dot = Vec3(rate * side, 0, 0)});
      const std::size_t lower = add_brick({}, drawn_mass());
      join(lower, random_.integer(0, 1) ? JointKind::hinge : JointKind::universal, upper, frame(end, y_axis),
           frame(-end, y_axis));
    }
    for (int n = random_.integer(1, 3); n > 0; --n)
      add_brick(
          {.X_WB = at(Vec3(0, 0.001, 0.03 + 0.02 * n)), .V_WB = {.w = Vec3::Zero(), .v = Vec3(0, 0, 0.5)}},
          drawn_mass());
  }
  void draw_thrown_tree() {
    const int links = random_.integer(2, 5);
    const bool hangs = random_.integer(0, 1);
    for (int k = 0; k < links; ++k) {
      Start start = thrown(Vec3(0, 0, 0.1), speed_);
      if (k == 0 && hangs) start.V_WB = {};
      const std::size_t i = add_brick(start, drawn_mass());
      if (k == 0 && !hangs) continue;
      const std::size_t parent = k == 0 ? world : static_cast<std::size_t>(random_.integer(0, k - 1));
      JointFrame P = random_frame(random_, 0.02);
      if (k == 0) P.p.z() += 0.1;
      join(i, drawn_joint(), parent, P, random_frame(random_, 0.02),
           {.q = 0.02 * random_.vector(), .q_dot = speed_ * random_.vector()});
      draw_stops(i);
    }
    for (int n = random_.integer(1, 3); n > 0; --n)
      add_brick(thrown(Vec3(0, 0, 0.1) + 0.06 * random_.direction(), speed_), drawn_mass());
    if (random_.integer(0, 2) == 0) hold(0, random_.log_uniform(1e2, 1e5), random_.log_uniform(0.01, 10));
  }

  Random random_;
  Real mass_ = 0, speed_ = 0, rate_ = 0;
  std::optional<std::size_t> held_;
  Vec3 from_ = Vec3::Zero(), way_ = Vec3::Zero();
};

}  // namespace godobject
