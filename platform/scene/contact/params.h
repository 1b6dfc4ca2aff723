// A scene's contacts in the core's terms, and the storage of the meshes and height fields they refer to.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "core/contact/contact.h"
#include "platform/scene/mesh/solid.h"
#include "platform/scene/scene.h"

namespace godobject {

/// Laws of pairs of materials: [a][b] is [b][a]; zero where the two do not meet.
using LawTable = std::array<std::array<ContactLaw, max_materials>, max_materials>;

/// Spheres in the order of their bodies; surfaces of the world, in the order of obstacles, then
/// of bodies if these can touch each other.
struct SceneContacts {
  std::vector<BodySphere> spheres;
  std::vector<Surface> surfaces;
  std::vector<std::string> surface_names;  // of each surface, for messages: "obstacle 'board'"
  std::vector<std::string> materials;      // by MaterialId
  LawTable laws;
  // What surfaces point to: stays where it is when this is moved.
  std::vector<std::unique_ptr<MeshSolid>> meshes;
  std::deque<std::vector<Real>> heights;
  std::deque<HeightField> height_fields;
};

/// The contacts of a scene that was read without errors: it has at most max_materials, and its meshes are solids.
SceneContacts scene_contacts(const SceneConfig& scene);

/// Surfaces that an obstacle makes: one, or as many as it has centres.
std::size_t num_solids(const ObstacleConfig& obstacle);

/// What a scene needs room for, without any geometry being made.
struct ContactCounts {
  std::size_t spheres = 0, surfaces = 0;
};
ContactCounts contact_counts(const SceneConfig& scene);

/// For a composition with room for them; `contacts` outlives the parameters.
template <class Params>
void set_contact_params(const SceneContacts& contacts, Params& par) noexcept {
  par.num_spheres = contacts.spheres.size();
  std::ranges::copy(contacts.spheres, par.spheres.begin());
  par.num_surfaces = contacts.surfaces.size();
  std::ranges::copy(contacts.surfaces, par.surfaces.begin());
  par.laws = contacts.laws;
}

}  // namespace godobject
