// MuJoCo 2.2: reduced coordinates, semi-implicit Euler. Its files nest bodies: a hundred links are too deep.
#include "tests/bench/peer/mujoco_model.h"
#include "tests/bench/peer/peer.h"

namespace godobject::bench {
namespace {

/// The chain as a model file. The links start on one line, turned alike.
std::string model_of(const oracle::Case& problem) {
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco><compiler inertiafromgeom='false' boundmass='0'/><option timestep='" << h << "' gravity='"
      << numbers(problem.gravity) << "' integrator='Euler'><flag constraint='disable'/></option>"
      << "<worldbody>";
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const oracle::Body& body = problem.bodies[i];
    const oracle::Joint& joint = problem.joints[i];
    if (joint.type != oracle::JointType::ball) throw std::invalid_argument("chains of ball joints only");
    const oracle::Quaterniond& q = body.start.q;
    xml << "<body pos='" << numbers(i == 0 ? body.start.p : joint.anchor_P - joint.anchor_C) << "'";
    if (i == 0) xml << " quat='" << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << "'";
    xml << "><joint type='ball' pos='" << numbers(joint.anchor_C) << "'/><inertial pos='0 0 0' mass='"
        << body.m << "' diaginertia='" << numbers(body.I_B.diagonal()) << "'/>";
  }
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) xml << "</body>";
  xml << "</worldbody></mujoco>";
  return xml.str();
}

class MujocoChain final : public Peer {
 public:
  explicit MujocoChain(const oracle::Case& problem)
      : model_(load(model_of(problem))), data_(mj_makeData(model_)) {}
  ~MujocoChain() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  MujocoChain(const MujocoChain&) = delete;
  MujocoChain& operator=(const MujocoChain&) = delete;

  void restart() override { mj_resetData(model_, data_); }
  void step(std::size_t) override { mj_step(model_, data_); }

  oracle::RigidState pose(std::size_t i) const override {
    if (i == 0) mj_kinematics(model_, data_);  // a step leaves the poses it started from
    const mjtNum* const p = data_->xpos + 3 * (i + 1);
    const mjtNum* const q = data_->xquat + 4 * (i + 1);
    oracle::RigidState x;
    x.p = {p[0], p[1], p[2]};
    x.q = {q[0], q[1], q[2], q[3]};
    return x;
  }

 private:
  mjModel* model_;
  mjData* data_;
};

}  // namespace

std::unique_ptr<Peer> make_mujoco(const oracle::Case& problem, const Targets&) {
  return std::make_unique<MujocoChain>(problem);
}

}  // namespace godobject::bench
