// All keys of a [[net]]. Visitors: platform/scene/text/key.h.
#pragma once

#include <set>

#include "platform/scene/checks.h"
#include "platform/scene/keys/contact.h"
#include "platform/scene/keys/joint.h"
#include "platform/scene/net/params.h"

namespace godobject {

/// Advised lower bound of a node's inertia, anchor and damping in a step, relative to its springs. Below it a
/// stage takes more than 12 iterations of conjugate gradients to 1 %; at 0.1 and above it takes 4 to 8.
inline constexpr double advised_hold = 0.02;

template <class V>
void visit_net_carrier(V& v, const std::vector<std::string>& bodies, NetConfig& n) {
  v.value(Key{"body", "", "carrier: a body, or \"world\""}, n.body);
  check_body_name(v, "body", bodies, true, n.body);
  visit_pose(v, "position", "orientation_wxyz", "the net's frame on its body, or in the world", n.X_BF);
}

/// True if the dimensions of a generated surface are given.
inline bool has_dimensions(const NetConfig& n) {
  const bool sheet = n.kind == NetKind::sheet, sphere = n.kind == NetKind::sphere;
  return n.spacing && (sheet ? n.length && n.width : n.radius && (sphere || n.half_length));
}

template <class V>
void visit_net_dimensions(V& v, NetConfig& n) {
  const bool sheet = n.kind == NetKind::sheet, mesh = n.kind == NetKind::mesh;
  const bool with_length = n.kind == NetKind::tube || n.kind == NetKind::capsule;
  visit_dimension(
      v, !mesh,
      Key{"spacing", "m", "distance of nodes, except for meshes; edges are 0.8 to 1.4 of it", positive},
      n.spacing);
  visit_dimension(v, with_length || n.kind == NetKind::sphere,
                  Key{"radius", "m", "of a tube, capsule or sphere, to its nodes", positive}, n.radius);
  visit_dimension(
      v, with_length,
      Key{"half_length", "m", "tube: half its length; capsule: half the distance of its centres", positive},
      n.half_length);
  visit_dimension(v, sheet, Key{"length", "m", "of a sheet, along x", positive}, n.length);
  visit_dimension(v, sheet, Key{"width", "m", "of a sheet, along y", positive}, n.width);
  constexpr double coarsest = 1.5;  // relative to the radius: four nodes around it
  const double most =
      std::min({coarsest * n.radius.value_or(1e300), n.length.value_or(1e300), n.width.value_or(1e300)});
  v.check(mesh || n.spacing.value_or(0) <= most, "spacing",
          "must be at most 1.5 times the radius of the net, or the length or width of a sheet");
}

/// Visits the surface.
/// room: largest number of nodes.
template <class V>
void visit_net_surface(V& v, std::size_t room, NetConfig& n) {
  choose(v,
         Key{"kind", "",
             "tube: about z, open; capsule: along z; sheet: in z = 0 about its middle; mesh: nodes are the "
             "corners of a file's triangles"},
         net_kind_names, n.kind);
  visit_net_dimensions(v, n);
  const bool mesh = n.kind == NetKind::mesh;
  const std::string path =
      v.path(Key{"file", "", "mesh: STL, OBJ or PLY in the scene file's folder or below"}, n.file);
  v.check(!mesh || !n.file.empty(), "file", "is missing: a mesh is read from one");
  v.check(mesh || n.file.empty(), "file", "has no meaning for this kind of net: remove it");
  v.value(Key{"scale", "m", "mesh: unit of its file, default 1", positive}, n.scale);
  v.check(mesh || !n.scale, "scale", "has no meaning for this kind of net: remove it");
  if (!n.surface.vertices.empty() || (mesh ? path.empty() : !has_dimensions(n))) return;
  const std::string why_not = make_surface(path, room, n);
  v.check(why_not.empty(), mesh ? "file" : "spacing", why_not);
}

template <class V>
void visit_net_springs(V& v, NetConfig& n) {
  v.value(Key{"membrane_stiffness", "N/m",
              "E t, Young's modulus times thickness: a force F stretches a strip of width w by F / (w E t)",
              positive, true},
          n.membrane_stiffness);
  v.value(Key{"bending",
              "",
              "springs across inner edges, which resist folding, relative to those along them; 0: none, and "
              "half as many springs",
              {0, 10}},
          n.bending);
  const double k = lattice_stiffness(n.membrane_stiffness);
  const double unit = k > 0 ? std::sqrt(mean_node_mass(n) / 2 / k) : 0;
  v.either(Key{"relaxation_time", "s", "tau: damping g = tau k of each spring", not_negative},
           Key{"damping_ratio", "", "g / sqrt(k m / 2) between mean nodes, default 1.4", {0, 1e6}}, unit,
           default_net_damping_ratio * unit, n.relaxation_time);
}

template <class V>
void visit_net_anchors(V& v, NetConfig& n) {
  const double sigma = n.surface_density;
  v.value(Key{"settling_time", "s",
              "time T in which a vibration decays to 2 %: damping of 8 sigma / T per area relative to body "
              "or world, of a net neither anchored nor held to its own motion as a whole",
              positive, true},
          n.settling_time);
  if (!n.anchor_stiffness && n.settling_time > 0 && sigma > 0)
    n.anchor_stiffness = n.body == world_name ? 0 : anchor_stiffness_for(sigma, n.settling_time);
  v.value(Key{.name = "anchor_stiffness",
              .unit = "N/m^3",
              .meaning =
                  "kappa of the anchors, force per area and displacement; dents reach sqrt(E t / kappa) far",
              .range = not_negative,
              .otherwise = "on a body 32.7 sigma / T^2, damping ratio 1.4; in the world 0"},
          n.anchor_stiffness);
  const double kappa = n.anchor_stiffness.value_or(0),
               d = n.settling_time > 0 ? drag(sigma, n.settling_time) : 0;
  const double slow = d / std::max(kappa, 1e-300);
  v.advise(kappa == 0 || d <= 2 * std::sqrt(kappa * sigma), "anchor_stiffness",
           "is too soft for this settling time: the net creeps back, with a time constant of " +
               rounded(slow) + " s");
}

/// h: time step, s.
template <class V>
void advise_on_iterations(V& v, double h, const NetConfig& n) {
  const double m = mean_node_mass(n), k = lattice_stiffness(n.membrane_stiffness);
  if (!(m > 0 && n.surface_density > 0 && k > 0 && n.settling_time > 0)) return;
  const double area = m / n.surface_density;
  const double held =
      m / (h * h) + area * (drag(n.surface_density, n.settling_time) / h + n.anchor_stiffness.value_or(0));
  v.advise(held >= advised_hold * k, "membrane_stiffness",
           "is too high for so light a net: a node's inertia and anchor are " + rounded(held / k) +
               " of a spring in a step, and below 0.02 a stage takes more than 12 iterations; make the net "
               "heavier or softer, or shorten its settling_time or the step");
}

template <class V>
void visit_net_touch(V& v, NetConfig& n) {
  const double spacing = mean_edge_of(n.surface);
  if (!n.thickness && spacing > 0) n.thickness = spacing;
  v.value(Key{.name = "thickness",
              .unit = "m",
              .meaning = "twice the radius of the nodes' spheres; 0: no contacts",
              .range = not_negative,
              .otherwise = "the mean edge"},
          n.thickness);
  visit_material(v, n.material);
  const double t = n.thickness.value_or(0);
  v.value(Key{"touches_itself", "", "its nodes touch its own surface as those of other nets do"},
          n.touches_itself);
  v.check(!n.touches_itself || t > 0, "touches_itself", "needs a thickness above 0 m");
  constexpr double rounding = 1e-9;
  v.advise(
      t == 0 || t >= (1 - rounding) * spacing, "thickness",
      "is below the mean edge of " + rounded(spacing) + " m: solids thinner than " +
          rounded(2 * spacing / std::sqrt(3.0) - t) +
          " m pass between the nodes, and edges of other nets may; raise the thickness or lower the spacing");
}

template <class V>
void visit_net_held(V& v, NetConfig& n) {
  const std::vector<bool> on_rim = rim_of(n.surface);
  const bool open = std::ranges::find(on_rim, true) != on_rim.end();
  v.value(Key{"rim", "", "nodes on the edge of an open surface are held"}, n.rim);
  v.check(!n.rim || open || n.surface.vertices.empty(), "rim", "has no meaning here: the surface is closed");
  if (!n.held_stiffness && n.membrane_stiffness > 0)
    n.held_stiffness = held_stiffness_for(n.membrane_stiffness);
  v.value(Key{.name = "held_stiffness",
              .unit = "N/m",
              .meaning = "of each held node",
              .range = positive,
              .otherwise = "8.66 E t: ten springs"},
          n.held_stiffness);
  v.tables(TableKey{"held", "A ball whose nodes are held in place."}, n.held, [&](auto& t, HeldConfig& h) {
    t.value(Key{"position", "m", "centre in the net's frame"}, h.p_F);
    t.value(Key{"radius", "m", "", positive, true}, h.radius);
    const bool holds = std::ranges::any_of(n.surface.vertices,
                                           [&](const Vec3& p_F) { return (p_F - h.p_F).norm() <= h.radius; });
    t.check(holds || n.surface.vertices.empty(), "radius", "is too small: no node is inside the ball");
  });
}

/// Visits the name of the other body, which must not be the carrier, since all nodes are anchored to it.
template <class V>
void visit_attached_body(V& v, const std::vector<std::string>& bodies, const NetConfig& n,
                         AttachedConfig& a) {
  v.value(Key{.name = "body",
              .unit = "",
              .meaning = "another body than the net's, or \"world\"",
              .required = true},
          a.body);
  check_body_name(v, "body", bodies, true, a.body);
  v.check(!v.understood("body") || a.body != n.body, "body",
          "is the net's own: hold nodes there by [[net.held]]");
}

template <class V>
void visit_net_attached(V& v, const std::vector<std::string>& bodies, NetConfig& n) {
  v.tables(TableKey{"attached",
                    "A ball whose nodes are attached to another body, each at its place at the start, by a "
                    "spring of length zero."},
           n.attached, [&](auto& t, AttachedConfig& a) {
             visit_attached_body(t, bodies, n, a);
             t.value(Key{"position", "m", "centre in the net's frame"}, a.p_F);
             t.value(Key{"radius", "m", "", positive, true}, a.radius);
             t.check(n.surface.vertices.empty() || a.radius <= 0 || num_within(n, a) > 0, "radius",
                     "is too small: no node is inside the ball");
             if (!a.stiffness && n.membrane_stiffness > 0)
               a.stiffness = held_stiffness_for(n.membrane_stiffness);
             t.value(Key{.name = "stiffness",
                         .unit = "N/m",
                         .meaning = "of each node",
                         .range = positive,
                         .otherwise = "8.66 E t: ten springs"},
                     a.stiffness);
             const double k = a.stiffness.value_or(0), m = mean_node_mass(n);
             const double unit = k > 0 ? std::sqrt(m / k) : 0;
             t.either(Key{"relaxation_time", "s",
                          "tau: damping g = tau k; a stretched spring creeps back with it", not_negative},
                      Key{"damping_ratio", "", "g / sqrt(k m) of a mean node, default 1.4", {0, 1e6}}, unit,
                      default_net_damping_ratio * unit, a.relaxation_time);
           });
  v.advise(
      n.anchor_stiffness.value_or(1) > 0 || n.rim || !n.held.empty() || !n.attached.empty(), "",
      "net '" + n.name + "' is not held: give it anchor_stiffness, rim, [[net.held]] or [[net.attached]]");
}

template <class V>
void visit_net(V& v, const SceneConfig& scene, const std::vector<std::string>& bodies, std::size_t room,
               NetConfig& n) {
  visit_name(v, "", n.name);
  visit_net_carrier(v, bodies, n);
  visit_net_surface(v, room, n);
  const double area = area_of(n.surface);
  v.either(Key{"surface_density", "kg/m^2", "mass per area sigma; tissue: 1000 kg/m^3 times thickness",
               positive, true},
           Key{"mass", "kg", "of the whole net", positive}, area > 0 ? 1 / area : 0, std::nullopt,
           n.surface_density);
  visit_net_springs(v, n);
  visit_net_anchors(v, n);
  advise_on_iterations(v, scene.step, n);
  visit_net_touch(v, n);
  const std::string of_density = doubt_of_density(n.surface_density, n.thickness.value_or(0)),
                    of_size = doubt_of_size(n.surface, "net '" + n.name + "'");
  v.advise(of_density.empty(), v.has("mass") ? "mass" : "surface_density", of_density);
  v.advise(of_size.empty(), "", of_size);
  visit_net_held(v, n);
  visit_net_attached(v, bodies, n);
}

/// Visits the nets, after bodies and joints.
template <class V>
void visit_nets(V& v, SceneConfig& s) {
  std::vector<std::string> bodies;
  for (const BodyConfig& body : s.bodies) bodies.push_back(body.name);
  std::set<std::string> names;
  std::size_t nodes = 0, springs = 0, attachments = 0;
  v.tables(TableKey{"net", "A deformable surface; see Nets above."}, s.nets, [&](auto& t, NetConfig& n) {
    visit_net(t, s, bodies, max_net_nodes - nodes, n);
    t.check(names.insert(n.name).second, "name", "is the name of an earlier net");
    t.check(std::ranges::find(bodies, n.name) == bodies.end(), "name", "is the name of a body");
    nodes += n.surface.vertices.size();
    springs += num_springs(n);
    t.check(springs <= max_net_springs, "",
            "nets have " + std::to_string(springs) + " springs, above the capacity of " +
                std::to_string(max_net_springs) + ": use a larger spacing, or bending = 0");
    attachments += num_attachments(n);
    t.check(attachments <= max_net_attachments, "attached",
            "makes " + std::to_string(attachments) + " attachments, above the capacity of " +
                std::to_string(max_net_attachments) + ": use smaller balls, or a larger spacing");
  });
}

}  // namespace godobject
