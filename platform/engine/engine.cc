#include "platform/engine/engine.h"

#include <algorithm>
#include <functional>

#include "platform/engine/wrapped.h"
#include "platform/scene/contact/params.h"

namespace godobject {
namespace {

/// Returns the compositions of the files in GODOBJECT_COMPOSITIONS, smallest first. To add one: a line in one
/// of these files.
std::vector<CompositionRow> table() {
  std::vector<CompositionRow> rows;
#ifdef GODOBJECT_HAS_COMPOSITIONS_free
  add_free(rows);
#endif
#ifdef GODOBJECT_HAS_COMPOSITIONS_contacts
  add_contacts(rows);
#endif
#ifdef GODOBJECT_HAS_COMPOSITIONS_many
  add_many(rows);
#endif
#ifdef GODOBJECT_HAS_COMPOSITIONS_terms
  add_terms(rows);
#endif
  std::stable_sort(rows.begin(), rows.end(), [](const CompositionRow& a, const CompositionRow& b) {
    return a.composition.bytes() < b.composition.bytes();
  });
  return rows;
}

/// Requirements of a scene on a composition. Couplings, feedback and devices are in every composition.
struct Needs {
  bool joints = false, nets = false;
  std::size_t terms = 0;  // largest number of one kind
  ContactScope contacts = ContactScope::none;
  ContactCounts counts;  // of these contacts
};

Needs needs_of(const SceneConfig& scene) {
  Needs needs{.joints = !scene.joints.empty(),
              .nets = !scene.nets.empty(),
              .terms = term_counts(scene).most(),
              .contacts = contact_scope(scene),
              .counts = {}};
  if (needs.contacts != ContactScope::none) needs.counts = contact_counts(scene);
  return needs;
}

/// True if contacts of the scope `has` include those of `needed`. A scene without contacts gets a composition
/// without; contacts between bodies include those with the world.
bool covers(ContactScope has, ContactScope needed) {
  return has == needed || (has == ContactScope::bodies && needed == ContactScope::obstacles);
}

bool has_room_for(const Composition& c, const Needs& needs, const SceneConfig& scene) {
  return scene.bodies.size() <= c.max_bodies && needs.counts.spheres <= c.max_spheres &&
         needs.counts.surfaces <= c.max_surfaces && needs.terms <= c.max_terms;
}

/// True if the composition has all parts of the scene, in any number. Compositions with nets or terms have
/// contacts too, needed or not.
bool has_parts_for(const Composition& c, const Needs& needs, const SceneConfig& scene) {
  return c.integrator == scene.integrator && c.has_nets() == needs.nets &&
         c.has_terms() == (needs.terms > 0) &&
         (needs.nets || needs.terms > 0 || covers(c.contacts, needs.contacts)) && (c.joints || !needs.joints);
}

/// Lists the scene's numbers that exceed every candidate, with the largest capacity.
std::string too_many(const std::vector<Composition>& candidates, const Needs& needs,
                     const SceneConfig& scene) {
  std::string text;
  const auto add = [&](std::size_t needed, const char* what, std::size_t Composition::*room) {
    const std::size_t most = std::invoke(room, *std::ranges::max_element(candidates, {}, room));
    if (needed > most)
      text += (text.empty() ? "" : ", ") + std::to_string(needed) + " " + what + "; the largest holds " +
              std::to_string(most);
  };
  add(scene.bodies.size(), "bodies", &Composition::max_bodies);
  add(needs.counts.spheres, "spheres", &Composition::max_spheres);
  add(needs.counts.surfaces, "surfaces of obstacles and shapes", &Composition::max_surfaces);
  add(needs.terms, "springs, forces, gears or closing joints of a kind", &Composition::max_terms);
  return text.empty() ? "all its bodies, spheres and surfaces at once" : text;
}

std::string why_none(const Needs& needs, const SceneConfig& scene) {
  std::vector<Composition> candidates;
  for (Composition& c : compositions())
    if (has_parts_for(c, needs, scene)) candidates.push_back(std::move(c));
  std::string parts;
  const auto add = [&](bool needed, const std::string& what) {
    if (needed) parts += (parts.empty() ? "" : ", ") + what;
  };
  add(needs.joints, "joints");
  add(needs.nets, "nets");
  add(needs.terms > 0, "springs, forces, gears or loops");
  add(needs.contacts == ContactScope::obstacles, "contacts with obstacles");
  add(needs.contacts == ContactScope::bodies, "contacts between bodies");
  const std::string what = "integrator '" + scene.integrator + "' and the parts of scene '" + scene.name +
                           "' (" + (parts.empty() ? "free bodies" : parts) + ")";
  if (candidates.empty())
    return "no compiled composition has " + what +
           ": change the integrator, compile all of GODOBJECT_COMPOSITIONS (./dev build), or add a "
           "composition";
  return "no compiled composition with " + what + " is large enough for " +
         too_many(candidates, needs, scene) + ": reduce them, or add a composition";
}

/// Returns the violated rule with the body's name. A rule that no scene file can violate is a defect of the
/// reader.
std::string complaint(const Validity& validity, const SceneConfig& scene) {
  const bool of_body = validity.index < scene.bodies.size() && validity.rule != Invalid::contact_sphere &&
                       validity.rule != Invalid::contact_surface;
  if (!of_body) return validity.text().data();
  return "body '" + scene.bodies[validity.index].name + "': " + std::string(text_of(validity.rule));
}

EngineWrapper wrapper = nullptr;  // of this program

}  // namespace

void wrap_engines(EngineWrapper wrap) noexcept { wrapper = wrap; }

std::vector<Composition> compositions() {
  std::vector<Composition> all;
  for (const CompositionRow& r : table()) all.push_back(r.composition);
  return all;
}

std::unique_ptr<Engine> make_engine(const SceneConfig& scene, std::span<const BodySample> at_start,
                                    std::string& why_not) {
  const Needs needs = needs_of(scene);
  for (const CompositionRow& r : table()) {
    if (!has_room_for(r.composition, needs, scene) || !has_parts_for(r.composition, needs, scene)) continue;
    Validity validity;
    std::unique_ptr<Engine> engine = r.make(scene, at_start, r.composition, validity);
    if (engine) return wrapper != nullptr ? wrapper(std::move(engine), scene) : std::move(engine);
    why_not = "the core rejects scene '" + scene.name + "': " + complaint(validity, scene);
    return nullptr;
  }
  why_not = why_none(needs, scene);
  return nullptr;
}

}  // namespace godobject
