// MuJoCo 2.2: the hanging net of particles on three slides each, joined by spatial tendons. Its flex came
// with 3.0. The composite cloth of 2.2 is the same particles and tendons, made by its own rule.
//
// Tendons are springs with explicit forces, in stable substeps; or equalities of their lengths, which have no
// stiffness in N/m. The damping of the air is that of the slides, which is implicit.
#include "tests/bench/peer/mujoco_model.h"
#include "tests/bench/peer/native_peers.h"

namespace godobject::bench {
namespace {

struct MujocoHow {
  int substeps = 1, iterations = 20;
  bool is_spring = true;
};

void write_bodies(std::ostream& xml) {
  xml << "<body name='ball' mocap='true'><geom type='sphere' size='" << HangingNet::ball_radius
      << "' contype='0' conaffinity='1'/></body>";
  for (std::uint32_t n = 0; n < HangingNet::num_nodes; ++n) {
    xml << "<body pos='" << numbers(HangingNet::node(n)) << "'>";
    if (!HangingNet::is_held(n)) {
      for (const char* const axis : {"1 0 0", "0 1 0", "0 0 1"})
        xml << "<joint type='slide' axis='" << axis << "' damping='" << HangingNet::g_air << "'/>";
      xml << "<geom type='sphere' size='" << HangingNet::node_radius << "' mass='" << HangingNet::m
          << "' contype='1' conaffinity='0'/>";
    }
    xml << "<site name='n" << n << "'/></body>";
  }
}

void write_tendons(std::ostream& xml, const MujocoHow& how) {
  xml << "<tendon>";
  std::size_t num = 0;
  for (const auto& [i, j] : HangingNet::springs()) {
    xml << "<spatial name='t" << num++ << "'";
    if (how.is_spring)
      xml << " stiffness='" << HangingNet::k << "' damping='" << HangingNet::g() << "' springlength='"
          << HangingNet::spacing << "'";
    xml << "><site site='n" << i << "'/><site site='n" << j << "'/></spatial>";
  }
  xml << "</tendon>";
  if (how.is_spring) return;
  xml << "<equality>";
  for (std::size_t t = 0; t < num; ++t) xml << "<tendon tendon1='t" << t << "' solref='0.004 1'/>";
  xml << "</equality>";
}

std::string model_of(const MujocoHow& how) {
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco><compiler boundmass='0' boundinertia='0'/><size njmax='8000' nconmax='1500' "
         "nstack='40000000'/><option timestep='"
      << HangingNet::h / how.substeps << "' gravity='0 0 " << -HangingNet::gravity
      << "' integrator='Euler' solver='CG' jacobian='sparse' iterations='" << how.iterations
      << "' cone='pyramidal'/><default><geom friction='" << HangingNet::mu
      << " 0 0' solref='0.004 1'/></default><worldbody>";
  write_bodies(xml);
  xml << "</worldbody>";
  write_tendons(xml, how);
  xml << "</mujoco>";
  return xml.str();
}

class MujocoNet final : public NetPeer {
 public:
  explicit MujocoNet(const MujocoHow& how)
      : how_(how), model_(load(model_of(how))), data_(mj_makeData(model_)) {
    restart();
  }
  ~MujocoNet() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  MujocoNet(const MujocoNet&) = delete;
  MujocoNet& operator=(const MujocoNet&) = delete;

  void restart() override {
    mj_resetData(model_, data_);
    move_ball(0);
    mj_forward(model_, data_);
  }
  void step(std::size_t n) override {
    for (int s = 0; s < how_.substeps; ++s) {
      move_ball((static_cast<double>(n) + (s + 1.0) / how_.substeps) * HangingNet::h);
      mj_step(model_, data_);
    }
  }
  /// Returns the position at the end of the step; MuJoCo's own positions are those at the start of the last
  /// substep.
  Vec3 node(std::uint32_t n) const override {
    Vec3 p = HangingNet::node(n);
    if (HangingNet::is_held(n)) return p;
    const mjtNum* const q = data_->qpos + 3 * static_cast<std::size_t>(n - HangingNet::across);
    return p + Vec3(q[0], q[1], q[2]);
  }
  std::size_t num_contacts() const override { return static_cast<std::size_t>(data_->ncon); }

 private:
  void move_ball(double t) {
    const Vec3 p = HangingNet::ball(t)[0];
    std::copy_n(p.data(), 3, data_->mocap_pos);
  }

  MujocoHow how_;
  mjModel* model_;
  mjData* data_;
};

std::unique_ptr<NetPeer> make_net(const MujocoHow& how) { return std::make_unique<MujocoNet>(how); }

const bool added = add_peer(HangingPeer{.engine = "MuJoCo 2.2 springs 10 substeps",
                                        .is_slow = true,
                                        .make = [] { return make_net({.substeps = 10}); }}) &&
                   add_peer(HangingPeer{.engine = "MuJoCo 2.2 lengths CG 20 it", .is_slow = true, .make = [] {
                                          return make_net({.iterations = 20, .is_spring = false});
                                        }});

}  // namespace
}  // namespace godobject::bench
