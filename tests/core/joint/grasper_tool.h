// A grasper on its device: a trocar that pitches and yaws about the world's origin, a tube that slides and
// turns in it, two jaws. The device's motion has a closed form.
#pragma once

#include <gtest/gtest.h>

#include "tests/core/one_body.h"
#include "tests/study/joint/tool.h"

namespace godobject {

/// One coordinate of the device: offset + amplitude sin(2 pi frequency t + phase), rad or m.
struct Swing {
  Real offset = 0, amplitude = 0, frequency = 0, phase = 0;

  Real at(Real t) const { return offset + amplitude * std::sin(2 * pi * frequency * t + phase); }
  Real rate(Real t) const {
    return 2 * pi * frequency * amplitude * std::cos(2 * pi * frequency * t + phase);
  }
};

inline constexpr Real degree = pi / 180;
inline constexpr Real jaw_hinge = -0.175, jaw_length = 0.01;  // along z of tube and jaw, m
enum GrasperBody : std::size_t { trocar, tube, left_jaw, right_jaw };

/// How the device moves; after 10 s it starts again.
struct GrasperMotion {
  Swing pitch{0, 30 * degree, 1.0, 0}, yaw{0, 30 * degree, 0.8, 0.9};
  Swing slide{0.025, 0.04, 0.5, 0.4}, roll{0, 60 * degree, 0.7, 1.3};
  Swing left{20 * degree, 20 * degree, 1.2, -pi / 2}, right{-20 * degree, -20 * degree, 1.2, -pi / 2};

  static constexpr Real period = 10;

  /// Every turn with this highest rate (rad/s), the slide with 5 cm/s for each rad/s.
  static GrasperMotion with_peak_rate(Real rate) {
    GrasperMotion m;
    for (Swing* s : {&m.pitch, &m.yaw, &m.roll, &m.left, &m.right})
      s->frequency = rate / (2 * pi * std::abs(s->amplitude));
    m.slide.frequency = 0.05 * rate / (2 * pi * m.slide.amplitude);
    return m;
  }
  static GrasperMotion at_rest() {
    GrasperMotion m;
    for (Swing* s : {&m.pitch, &m.yaw, &m.slide, &m.roll, &m.left, &m.right}) s->frequency = 0;
    return m;
  }

  /// All four bodies of the device, by the velocities of rigid bodies.
  std::array<Target, 4> at(Real t) const {
    const auto turn = [](Real angle, const Vec3& axis) { return exp_so3(Vec3(angle * axis)); };
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
    std::array<Target, 4> all;
    Target &trocar_D = all[trocar], &tube_D = all[tube];
    trocar_D.X_WD.q = turn(pitch.at(t), x) * turn(yaw.at(t), y);
    trocar_D.V_WD.w = pitch.rate(t) * x + yaw.rate(t) * (turn(pitch.at(t), x) * y);

    const Vec3 along = trocar_D.X_WD.q * z;
    tube_D.X_WD = {.p = slide.at(t) * along, .q = trocar_D.X_WD.q * turn(roll.at(t), z)};
    tube_D.V_WD = {.w = trocar_D.V_WD.w + roll.rate(t) * along,
                   .v = slide.rate(t) * along + trocar_D.V_WD.w.cross(tube_D.X_WD.p)};

    for (const std::size_t i : {left_jaw, right_jaw}) {
      const Swing& jaw = i == left_jaw ? left : right;
      const Vec3 to_hinge = jaw_hinge * along;
      all[i].X_WD.q = tube_D.X_WD.q * turn(jaw.at(t), x);
      all[i].V_WD.w = tube_D.V_WD.w + jaw.rate(t) * (tube_D.X_WD.q * x);
      const Vec3 to_centre = -jaw_length * (all[i].X_WD.q * z);
      all[i].X_WD.p = tube_D.X_WD.p + to_hinge + to_centre;
      all[i].V_WD.v = tube_D.V_WD.v + tube_D.V_WD.w.cross(to_hinge) + all[i].V_WD.w.cross(to_centre);
    }
    return all;
  }
};

struct GrasperParams {
  Real h = 1e-3;
  Real stiffness = 1000;  // of the tube's coupling, N/m; the others' are in proportion
  Real jaw_mass = 0.005;  // kg; its inertia is in proportion
  GrasperMotion motion = {};
};

template <Scene S>
void set_grasper_joints(Params<S>& par) {
  Mat3 z_along_x;  // the hinge's axis z is x of tube and jaw
  z_along_x << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const auto set = [&](std::size_t i, const JointParams& joint) {
    static_cast<JointParams&>(par.bodies[i].joint) = joint;
  };
  set(trocar, {.kind = JointKind::universal, .P = {}, .C = {}});
  set(tube, {.kind = JointKind::cylindrical, .parent = trocar, .P = {}, .C = {}});
  for (const std::size_t i : {left_jaw, right_jaw})
    set(i, {.kind = JointKind::hinge,
            .parent = tube,
            .P = {.p = Vec3(0, 0, jaw_hinge), .R = z_along_x},
            .C = {.p = Vec3(0, 0, jaw_length), .R = z_along_x}});
}

/// The grasper with its device at time t: starts on the device, moving with it.
template <class I, class J = TreeJoints<>>
class GrasperTool : public Running<Articulated<I, J>> {
 public:
  using S = Articulated<I, J>;

  explicit GrasperTool(const GrasperParams& grasper = {}) : motion(grasper.motion) {
    this->par.h = grasper.h;
    this->par.num_bodies = 4;
    const auto body = [&](std::size_t i, Real m, const Vec3& moments, Real k, Real k_r) {
      const Real share = grasper.stiffness / 1000;
      BodyParams<S>& b = this->par.bodies[i];
      b.body = rigid_body(m, moments.asDiagonal());
      b.coupling = spring(b.body, k * share, k_r * share);
      b.device = {.rise = 0, .lost = 0.02};
    };
    const Real jaw = grasper.jaw_mass / 0.005;
    body(trocar, 0.05, Vec3(1e-5, 1e-5, 1e-5), 1000, 0.5);
    body(tube, 0.08, Vec3(8.1667e-4, 8.1667e-4, 1e-6), 1000, 1);
    for (const std::size_t i : {left_jaw, right_jaw})
      body(i, jaw * 0.005, jaw * Vec3(1.7e-7, 1.7e-7, 4e-8), 200, 0.02);
    set_grasper_joints(this->par);
    put_on_device(0);
  }

  void put_on_device(Real t) {
    const std::array<Target, 4> targets = motion.at(t);
    for (std::size_t i = 0; i < 4; ++i) {
      place<S>(this->x, i, {.X_WB = targets[i].X_WD, .V_WB = targets[i].V_WD});
      engage_at(this->x, i, targets[i]);
    }
    ticks_ = std::lround(t / this->par.h);
    feed(t);
  }

  /// The device's samples at time t, for the next step.
  void feed(Real t) {
    const std::array<Target, 4> targets = motion.at(t);
    for (std::size_t i = 0; i < 4; ++i) {
      this->in.devices[i].target = targets[i];
    }
  }

  /// A step along the device's motion.
  void follow() {
    feed(static_cast<Real>(++ticks_) * this->par.h);
    this->step();
  }

  Real time() const { return static_cast<Real>(ticks_) * this->par.h; }
  Drift drift() const { return godobject::drift(this->par, this->x); }
  Real energy() const { return godobject::energy(this->par, this->x); }
  /// Returns the energy of the tool if it moved with the device, J.
  Real device_energy(Real t) const {
    State<S> on_device = this->x;
    const std::array<Target, 4> targets = motion.at(t);
    for (std::size_t i = 0; i < 4; ++i)
      place<S>(on_device, i, {.X_WB = targets[i].X_WD, .V_WB = targets[i].V_WD});
    return kinetic_energy(this->par, on_device);
  }

  GrasperMotion motion;

 private:
  long ticks_ = 0;
};

using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;

}  // namespace godobject
