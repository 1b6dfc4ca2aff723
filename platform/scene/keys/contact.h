// All keys of contacts: spheres and shapes of bodies, obstacles, pairs of materials. Visitors:
// platform/scene/text/key.h.
#pragma once

#include <cmath>
#include <set>

#include "core/contact/contact.h"
#include "platform/scene/checks.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/joint/joints.h"
#include "platform/scene/mesh/file.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

inline constexpr double default_contact_damping_ratio = 1.4;

/// Names of ShapeKind in scene files, in its order.
inline constexpr std::array shape_kind_names{"plane", "box", "sphere", "capsule", "height-field", "mesh"};
/// Names of the shapes that bodies may carry.
inline constexpr std::array body_shape_kind_names{"box", "sphere", "capsule"};

template <class V>
void visit_material(V& v, std::string& material) {
  v.value(Key{"material", "", "see [[contact]]"}, material);
  v.check(is_plain_name(material), "material", "must be one or more letters, digits, '_' or '-'");
}

template <class V>
void visit_sphere(V& v, SphereConfig& s) {
  v.value(Key{"position", "m", "centre"}, s.p_B);
  v.value(Key{"radius", "m", "", positive, true}, s.radius);
  visit_material(v, s.material);
  v.value(Key{"count", "", "number of spheres in the row", {1, 1e4}}, s.count);
  v.value(Key{"spacing", "m", "from one centre to the next"}, s.spacing);
  v.check(s.count == 1 || s.spacing.norm() > 0, "spacing", "must not be zero if count is above 1");
}

/// Visits a dimension that only some kinds have.
template <class V, class T>
void visit_dimension(V& v, bool needed, const Key& key, std::optional<T>& x) {
  v.value(key, x);
  v.check(!needed || x, key.name, "is missing: this kind of shape requires it");
  v.check(needed || !x, key.name, "has no meaning for this kind of shape: remove it");
}

template <class V>
void visit_dimensions(V& v, ShapeConfig& s) {
  const bool round = s.kind == ShapeKind::sphere || s.kind == ShapeKind::capsule;
  visit_dimension(v, s.kind == ShapeKind::box,
                  Key{"half_extents", "m", "box: half edges along x, y, z", positive}, s.half_extents);
  visit_dimension(v, round, Key{"radius", "m", "of a sphere or capsule", positive}, s.radius);
  visit_dimension(v, s.kind == ShapeKind::capsule,
                  Key{"half_length", "m", "capsule: half the distance of its centres", not_negative},
                  s.half_length);
}

template <class V>
void visit_body_shape(V& v, ShapeConfig& s) {
  std::size_t kind = static_cast<std::size_t>(s.kind) - 1;
  v.one_of(Key{"kind", "", "capsule: along z"}, {body_shape_kind_names.begin(), body_shape_kind_names.end()},
           kind);
  s.kind = static_cast<ShapeKind>(kind + 1);
  visit_pose(v, "position", "orientation_wxyz", "the shape's frame", s.X);
  visit_dimensions(v, s);
  visit_material(v, s.material);
}

template <class V>
void visit_spheres_and_shapes(V& v, BodyConfig& b) {
  // Without a table in the file the list of the body named by `like` is kept.
  std::vector<SphereConfig> spheres = b.spheres;
  v.tables(TableKey{"sphere", "A sphere of the body, or a row of equal ones."}, spheres,
           [&](auto& t, SphereConfig& s) { visit_sphere(t, s); });
  if (!spheres.empty()) b.spheres = spheres;
  std::vector<ShapeConfig> shapes = b.shapes;
  v.tables(TableKey{"shape", "A solid of the body, which touches others."}, shapes,
           [&](auto& t, ShapeConfig& s) { visit_body_shape(t, s); });
  if (!shapes.empty()) b.shapes = shapes;
}

template <class V>
void visit_obstacle_file(V& v, ObstacleConfig& o) {
  const ShapeKind kind = o.shape.kind;
  const bool mesh = kind == ShapeKind::mesh, heights = kind == ShapeKind::height_field;
  const std::string path =
      v.path(Key{"file", "",
                 "mesh: closed STL, OBJ or PLY; height field: rows of heights (m) between commas; sphere: "
                 "centres of many, CSV with columns x, y, z (m). In the scene file's folder or below"},
             o.file);
  v.check(!(mesh || heights) || !o.file.empty(), "file",
          "is missing: a mesh or height field is read from one");
  v.value(Key{"scale", "m", "mesh: unit of its file, default 1", positive}, o.scale);
  v.check(mesh || !o.scale, "scale", "has no meaning for this kind of obstacle: remove it");
  visit_dimension(v, heights, Key{"spacing", "m", "height field: distance of grid points", positive},
                  o.spacing);
  if (path.empty()) return;
  const std::string why_not = load_file(path, o);
  v.check(why_not.empty(), "file", why_not);
  const std::string doubt = doubt_of_size(o.mesh, "obstacle '" + o.name + "'");
  v.advise(doubt.empty(), "", doubt);
}

template <class V>
void visit_obstacle(V& v, ObstacleConfig& o) {
  visit_name(v, "name in messages", o.name);
  choose(v,
         Key{"kind", "",
             "plane: solid below z = 0; capsule: along z; height-field: solid below, from its corner along x "
             "and y; mesh: solid inside"},
         shape_kind_names, o.shape.kind);
  visit_pose(v, "position", "orientation_wxyz", "its frame in the world", o.shape.X);
  if constexpr (requires { v.keys_of("", "", ""); })
    v.keys_of("[[body.shape]]", "half_extents", "half_length");
  else visit_dimensions(v, o.shape);
  visit_obstacle_file(v, o);
  visit_material(v, o.shape.material);
}

/// Returns the damping c / sqrt(m k) of the law (22) for a restitution. A ball of mass m rebounds from an
/// obstacle with this share of its speed, without gravity. (Schwager, Poschel, Granular Matter 9, 2007.)
/// restitution: in (0, 1].
inline double damping_ratio_of(double restitution) {
  // x'' + 2 z x' + x = 0 until the force ends; |x'| is then exp(-z t) of that at the start
  const auto restitution_at = [](double z) {
    const double root = std::sqrt(std::abs(1 - z * z));
    if (root < 1e-6) return std::exp(-2.0);
    if (z < 1) return std::exp(-z / root * std::atan2(2 * z * root, 2 * z * z - 1));
    return std::exp(-z / root * std::log((z + root) / (z - root)));
  };
  double low = 0, high = 1e6;  // the restitution falls with z
  for (int i = 0; i < 200; ++i) {
    const double z = (low + high) / 2;
    (restitution_at(z) > restitution ? low : high) = z;
  }
  return 2 * high;
}

/// Visits a damping as N s/m or as a ratio, of which at most one is given. is_new: it has no value yet.
template <class V>
void visit_damping(V& v, const Key& damping, const Key& damping_ratio, bool is_new, double& c,
                   double& ratio) {
  std::optional<double> given, given_ratio;
  if (!is_new) (ratio > 0 ? given_ratio : given) = ratio > 0 ? ratio : c;
  v.value(damping, given);
  v.value(damping_ratio, given_ratio);
  v.check(!given || !given_ratio, damping_ratio.name,
          "and '" + std::string(damping.name) + "' give the same quantity: remove one of them");
  if (!given && !given_ratio) return;
  c = given.value_or(0);
  ratio = given_ratio.value_or(0);
}

/// Visits a law; without its stiffness it is new, and a tangential gain that is not given is the normal one.
template <class V>
void visit_law(V& v, ContactLaw& law) {
  const bool is_new = law.k == 0;
  v.value(Key{"stiffness", "N/m", "normal stiffness k of each sphere; spheres that share a load add up",
              positive, true},
          law.k);
  if (is_new) law.ratio = default_contact_damping_ratio;
  visit_damping(v,
                Key{.name = "damping",
                    .unit = "N s/m",
                    .meaning = "normal damping c",
                    .range = not_negative,
                    .otherwise = "or `damping_ratio`"},
                Key{"damping_ratio",
                    "",
                    "c / sqrt(m k), default 1.4, m: mass of the lighter body, or node, of each contact",
                    {0, 1e6}},
                is_new, law.c, law.ratio);
  double restitution = 1;
  v.shorthand(Key{"restitution",
                  "",
                  "in place of `damping`: share of its speed with which a ball of mass m rebounds",
                  {.min = 0, .max = 1, .min_open = true}},
              restitution);
  if (v.has("restitution")) {
    v.check(!v.has("damping") && !v.has("damping_ratio"), "restitution",
            "sets the damping, as 'damping' and 'damping_ratio' do: remove all but one");
    law.ratio = damping_ratio_of(restitution);
  }
  v.value(Key{"friction", "", "coefficient of friction mu", {0, 100}}, law.mu);
  if (is_new) law.k_t = law.k;
  v.value(Key{.name = "tangential_stiffness",
              .unit = "N/m",
              .meaning = "k_t while sticking",
              .range = not_negative,
              .otherwise = "`stiffness`"},
          law.k_t);
  if (is_new) {
    law.c_t = law.c;
    law.ratio_t = law.ratio;
  }
  visit_damping(v,
                Key{.name = "tangential_damping",
                    .unit = "N s/m",
                    .meaning = "c_t while sticking, default `damping`",
                    .range = not_negative,
                    .otherwise = "or `tangential_damping_ratio`"},
                Key{"tangential_damping_ratio", "", "c_t / sqrt(m k), default `damping_ratio`", {0, 1e6}},
                is_new, law.c_t, law.ratio_t);
  v.check(law.mu == 0 || law.k_t > 0 || law.c_t > 0 || law.ratio_t > 0, "tangential_stiffness",
          "and 'tangential_damping' must not both be zero if friction is above 0");
  v.value(Key{"push_out_speed", "m/s", "of bodies that start inside each other", positive}, law.push_out);
}

/// Visits obstacles and contacts, after bodies and joints.
template <class V>
void visit_contacts(V& v, SceneConfig& s) {
  std::set<std::string> names;
  v.tables(TableKey{"obstacle", "A solid fixed in the world."}, s.obstacles, [&](auto& t, ObstacleConfig& o) {
    visit_obstacle(t, o);
    t.check(names.insert(o.name).second, "name", "is the name of an earlier obstacle");
  });
  const std::vector<MaterialUse> used = materials_of(s);
  const auto is_used = [&](const std::string& name) {
    return std::ranges::find(used, name, &MaterialUse::material) != used.end();
  };
  std::set<std::set<std::string>> pairs;
  v.tables(TableKey{"contact", "Contact of two materials."}, s.contacts, [&](auto& t, ContactConfig& c) {
    t.value(Key{.name = "materials",
                .unit = "",
                .meaning = "two names in any order, or one twice",
                .required = true},
            c.materials);
    t.check(c.materials.size() == 2, "materials", "must be two names: [\"a\", \"b\"]");
    for (const std::string& name : c.materials)
      t.advise(is_used(name), "materials", "has '" + name + "', which no sphere, shape, obstacle or net has");
    t.check(pairs.insert({c.materials.begin(), c.materials.end()}).second, "materials",
            "are those of an earlier [[contact]]");
    visit_law(t, c.law);
  });
  v.check(used.size() <= max_materials, "",
          "the scene has " + std::to_string(used.size()) + " materials; at most " +
              std::to_string(max_materials) + " are possible");
  if (used.size() > max_materials || !joints_have_bodies(s)) return;
  for (const MaterialPair& pair : pairs_that_meet(s))
    v.check(contact_of(s, pair.a.material, pair.b.material) != nullptr, "",
            "materials '" + pair.a.material + "' (" + pair.a.where + ") and '" + pair.b.material + "' (" +
                pair.b.where + ") can meet, but no [[contact]] has materials = [\"" + pair.a.material +
                "\", \"" + pair.b.material + "\"]: add it");
}

}  // namespace godobject
