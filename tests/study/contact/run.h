// Scenes with contacts in the core: their types, and their contact parameters.
#pragma once

#include "core/solve/bodies.h"
#include "tests/study/case_run.h"
#include "tests/study/compositions.h"
#include "tests/study/contact/scene.h"

namespace godobject::study {

/// Sets the spheres of all bodies, the plane z = 0 and, if the scene has them, a box on each body.
template <Scene S>
void set_contacts(const bench::ContactScene& scene, Params<S>& par) {
  if constexpr (uses<ContactsOf<S>>) {
    auto& contacts = par.contacts;
    contacts.laws[0][0] = scene.law;
    contacts.num_spheres = 0;
    contacts.surfaces.at(0) = {};
    contacts.num_surfaces = 1;
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      for (const Vec3& p_B : scene.centres)
        contacts.spheres.at(contacts.num_spheres++) = {.body = i, .p_B = p_B, .radius = scene.radius};
      if (!scene.half_extents) continue;
      contacts.surfaces.at(contacts.num_surfaces++) = {
          .body = i, .shape = {.kind = ShapeKind::box, .half_extents = *scene.half_extents}};
    }
  }
}

inline oracle::RigidState oracle_state(const RigidBodyState& x) {
  return {.p = x.X_WB.p, .q = x.X_WB.q, .v = x.v_W, .w = to_world(x.X_WB.q, x.w_B)};
}

}  // namespace godobject::study
