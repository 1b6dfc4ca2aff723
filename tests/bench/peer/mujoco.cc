// MuJoCo 2.2: reduced coordinates; semi-implicit Euler with implicit joint dampers, `implicit` in all
// velocities, or RK4. The step's target is that of its start, of RK4 that of its middle.
#include <limits>

#include "tests/bench/peer/mujoco_tree.h"
#include "tests/bench/peer/peer.h"

namespace godobject::bench {
namespace {

using oracle::RigidState;
using oracle::Vector3d;

/// Returns the rates of a joint's coordinates at the start.
std::vector<double> joint_rates(const oracle::Case& problem, const oracle::Joint& joint) {
  const RigidState P = joint.parent ? problem.bodies[*joint.parent].start : RigidState{};
  const RigidState& C = problem.bodies[joint.child].start;
  const Vector3d w = C.w - P.w, axis = P.q * joint.axis_P;
  if (joint.type == oracle::JointType::ball) {
    const Vector3d w_C = C.q.conjugate() * w;
    return {w_C.x(), w_C.y(), w_C.z()};
  }
  if (joint.type == oracle::JointType::hinge) return {w.dot(axis)};
  if (joint.type == oracle::JointType::universal) return {w.dot(axis), w.dot(C.q * joint.axis_C)};
  const Vector3d r = C.q * joint.anchor_C;
  const Vector3d v = C.v + C.w.cross(r) - P.v - P.w.cross(C.p + r - P.p);
  return {v.dot(axis), w.dot(axis)};
}

class Mujoco final : public Peer {
 public:
  Mujoco(const oracle::Case& problem, const Targets& targets, double h, const char* integrator)
      : problem_(problem),
        targets_(targets),
        is_free_(problem.joints.empty()),
        model_(load(MujocoTree(problem, h, integrator).text())),
        data_(mj_makeData(model_)) {
    mju_user_warning = [](const char*) {};  // otherwise it writes a file; pose() reports a failure
    restart();
  }
  ~Mujoco() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  Mujoco(const Mujoco&) = delete;
  Mujoco& operator=(const Mujoco&) = delete;

  void restart() override {
    mj_resetData(model_, data_);
    if (is_free_) {
      const RigidState& x = problem_.bodies.front().start;
      write_pose(x, data_->qpos);
      const Vector3d w_B = x.q.conjugate() * x.w;
      std::copy_n(x.v.data(), 3, data_->qvel);
      std::copy_n(w_B.data(), 3, data_->qvel + 3);
    }
    mjtNum* rate = data_->qvel;
    for (const oracle::Joint& joint : problem_.joints)
      for (const double value : joint_rates(problem_, joint)) *rate++ = value;
  }

  void step(std::size_t n) override {
    if (!targets_.empty()) is_free_ ? pull(targets_[n].front()) : lead(targets_[n]);
    mj_step(model_, data_);
  }

  RigidState pose(std::size_t i) const override {
    RigidState x;
    for (const mjtWarning failure : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC})
      if (data_->warning[failure].number > 0)
        x.p = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    if (x.p.hasNaN()) return x;                // the engine has reset itself
    if (i == 0) mj_kinematics(model_, data_);  // a step leaves the poses it started from
    const mjtNum* const p = data_->xpos + 3 * (i + 1);
    const mjtNum* const q = data_->xquat + 4 * (i + 1);
    x.p = {p[0], p[1], p[2]};
    x.q = {q[0], q[1], q[2], q[3]};
    return x;
  }

 private:
  static void write_pose(const RigidState& x, mjtNum* q) {
    const mjtNum numbers[] = {x.p.x(), x.p.y(), x.p.z(), x.q.w(), x.q.x(), x.q.y(), x.q.z()};
    std::copy_n(numbers, 7, q);
  }

  /// Moves the reference of the springs; the target's velocity is a force.
  void pull(const RigidState& D) {
    const oracle::Coupling& c = *problem_.bodies.front().coupling;
    write_pose(D, model_->qpos_spring);
    const mjtNum* const q = data_->qpos + 3;
    const oracle::Quaterniond q_B(q[0], q[1], q[2], q[3]);
    const Vector3d f = c.g_t * D.v, t_B = c.g_r * (q_B.conjugate() * D.w);
    std::copy_n(f.data(), 3, data_->qfrc_applied);
    std::copy_n(t_B.data(), 3, data_->qfrc_applied + 3);
  }

  /// Moves the mocap bodies. Actuators measure in their axes; the target's velocity is a control.
  void lead(const std::vector<RigidState>& targets) {
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const RigidState& D = targets[i];
      const oracle::Coupling& c = *problem_.bodies[i].coupling;
      const mjtNum quaternion[] = {D.q.w(), D.q.x(), D.q.y(), D.q.z()};
      const Vector3d v = (c.g_t / c.k_t) * (D.q.conjugate() * D.v);
      const Vector3d w = (c.g_r / c.k_r) * (D.q.conjugate() * D.w);
      std::copy_n(D.p.data(), 3, data_->mocap_pos + 3 * i);
      std::copy_n(quaternion, 4, data_->mocap_quat + 4 * i);
      std::copy_n(v.data(), 3, data_->ctrl + 6 * i);
      std::copy_n(w.data(), 3, data_->ctrl + 6 * i + 3);
    }
  }

  const oracle::Case& problem_;
  const Targets& targets_;
  bool is_free_;
  mjModel* model_;
  mjData* data_;
};

template <const auto& integrator>
std::unique_ptr<Peer> make(const oracle::Case& problem, const Targets& targets, double h) {
  return std::make_unique<Mujoco>(problem, targets, h, integrator);
}

constexpr char euler[] = "Euler", implicit[] = "implicit", rk4[] = "RK4";
const bool added =
    add_peer(
        FreePeer{.engine = "MuJoCo 2.2 Euler", .aim = {.share = 0}, .can = is_short, .make = make<euler>}) &&
    add_peer(FreePeer{
        .engine = "MuJoCo 2.2 implicit", .aim = {.share = 0}, .can = is_short, .make = make<implicit>}) &&
    add_peer(FreePeer{.engine = "MuJoCo 2.2 RK4 (mid-step target)",
                      .aim = {.share = 0.5},
                      .can = is_short,
                      .make = make<rk4>});

}  // namespace
}  // namespace godobject::bench
