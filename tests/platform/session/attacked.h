// Scenes that once failed (attacks/ of the shared folder), run as by `godobject run --fast --bus direct`, and
// data of a run for checks.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/core/one_body.h"
#include "tests/support/shared_data.h"

namespace godobject {

/// Reads a scene of the shared folder `attacks`; none if the folder is absent.
inline std::optional<SceneConfig> attack(const std::string& name) {
  const std::filesystem::path file = test::shared_file("attacks/" + name + ".toml");
  if (file.empty()) return std::nullopt;
  LoadResult loaded = load_scene(file.string());
  EXPECT_TRUE(loaded.scene) << name;
  return loaded.scene;
}

/// Runs for `seconds` and passes each record to `look`; returns the last one. A refused scene is a failure.
template <class Look>
CycleRecord attacked(const SceneConfig& scene, Motion motion, double seconds, Look look) {
  Session::Made made = make_session(scene, std::move(motion), BusChoice::direct);
  EXPECT_TRUE(made.session) << (made.errors.empty() ? "" : made.errors.front());
  if (!made.session) return {};
  CycleRecord record = made.session->at_start();
  while (record.t < seconds - scene.step / 2) {
    made.session->cycle(record);
    look(record);
  }
  return record;
}

inline double kinetic_energy(const SceneConfig& scene, const CycleRecord& r) {
  double T = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Vec3 w_B = r.bodies[i].X_WB.q.conjugate() * r.bodies[i].V_WB.w;
    T += 0.5 *
         (scene.bodies[i].mass * r.bodies[i].V_WB.v.squaredNorm() + w_B.dot(scene.bodies[i].inertia * w_B));
  }
  return T;
}

/// Returns the largest distance between the anchors of a joint, m; of joints that do not slide.
inline double joint_drift(const SceneConfig& scene, const CycleRecord& r) {
  double most = 0;
  const auto anchor = [&](const std::string& body, const Pose& X_BJ) -> Vec3 {
    if (body == world_name) return X_BJ.p;
    const Pose& X = r.bodies[*body_named(scene, body)].X_WB;
    return X.p + X.q * X_BJ.p;
  };
  for (const JointConfig& joint : scene.joints)
    most = std::max(most, (anchor(joint.parent, joint.X_BP) - anchor(joint.child, joint.X_BC)).norm());
  return most;
}

/// Returns the speed of the fastest point of any body at this lever arm, m/s. lever: m.
inline double fastest(const CycleRecord& r, double lever = 0.03) {
  double most = 0;
  for (const BodyView& body : r.bodies)
    most = std::max(most, body.V_WB.v.norm() + lever * body.V_WB.w.norm());
  return most;
}

/// Energy of a scene without a drive.
struct Course {
  double first = 0, gain = 0, moving = 0, drift = 0;  // J, J above the first, largest kinetic energy J, m
  bool energy_gained = false;
  Fault fault = Fault::none;
  double gained() const { return gain / std::max(moving, 1e-9); }
};

inline Course course_of(const SceneConfig& scene, double seconds) {
  Course c;
  bool begun = false;
  attacked(scene, Motion(scene), seconds, [&](const CycleRecord& r) {
    if (!begun) c.first = r.energy.total;
    begun = true;
    c.gain = std::max(c.gain, r.energy.total - c.first);
    c.moving = std::max(c.moving, kinetic_energy(scene, r));
    c.drift = std::max(c.drift, joint_drift(scene, r));
    c.energy_gained |= has(r.fault, Fault::energy_gained);
    c.fault |= r.fault;
  });
  return c;
}

/// Sets stiffness and damping. ratio: damping ratio, as in scene files.
inline void set_stiffness(BodyConfig& body, double k, double k_r, double ratio = 1.4) {
  const double I = principal_moments(body.inertia).z();
  body.coupling = SpringParams{
      .k = k, .g = ratio * std::sqrt(body.mass * k), .k_r = k_r, .g_r = ratio * std::sqrt(I * k_r)};
}

/// Sets the contact law. ratio: damping ratio, as in scene files.
inline void set_contact(SceneConfig& scene, double k, double ratio, double mu) {
  ContactLaw& law = scene.contacts.at(0).law;
  law.k = law.k_t = k;
  law.c = law.c_t = 0;
  law.ratio = law.ratio_t = ratio;
  law.mu = mu;
}

/// Rotates bodies and their fixed parents about the world's origin, not the obstacles.
inline void turn(SceneConfig& scene, const Quat& q) {
  for (BodyConfig& body : scene.bodies) {
    body.X_WB = {.p = q * body.X_WB.p, .q = (q * body.X_WB.q).normalized()};
    body.V_WB = {.w = q * body.V_WB.w, .v = q * body.V_WB.v};
  }
  for (JointConfig& joint : scene.joints)
    if (joint.parent == world_name)
      joint.X_BP = {.p = q * joint.X_BP.p, .q = (q * joint.X_BP.q).normalized()};
}

inline std::string any_integrator(Random& random) {
  return integrator_names[static_cast<std::size_t>(random.integer(0, 1))];
}

}  // namespace godobject
