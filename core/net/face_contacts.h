// Geometry of contacts of nodes with faces of nets in a stage.
//
// In the memory of contacts (51) a face is a body: its centre, and the axes of its plane and first edge.
#pragma once

#include "core/joint/tree.h"
#include "core/net/contact_terms.h"
#include "core/net/drifting.h"
#include "core/net/find_faces.h"

namespace godobject {

/// Returns the place of a face at the predicted nodes.
template <class Net, std::size_t N>
FacePlace place_of_face(std::uint32_t face, const NetStage<Net, N>& w) noexcept {
  const Corners t = corners_of(w.par->faces.list[face].nodes, w.p);
  return {.p_W = (t[0] + t[1] + t[2]) / 3, .R_W = axes_of_face(t)};
}

/// Sets the touched points of the near contacts with faces, after these are in order.
template <class Contacts, class Net, std::size_t N>
void set_touched_points(NetStage<Net, N>& w) noexcept {
  Recall recall(w.memories.before());
  for (std::size_t i = 0; i < w.near.size; ++i) {
    const NearContact& near = w.near.list[i];
    if (near.b != NetContactTerm::on_net) continue;
    const ContactMemory* const memory = recall.find(near.key);
    FaceTouch& touch = w.faces.touching[i];
    touch.face = near.on - first_face_number<Contacts>;
    const std::uint32_t memory_face =
        memory == nullptr ? touch.face : memory->on - first_face_number<Contacts>;
    touch.nodes = w.par->faces.list[touch.face].nodes;
    touch.weights = nearest_on_face(corners_of(touch.nodes, w.p), w.p[near.a].vec()).weights;
    touch.carrier = w.par->nodes[touch.nodes[0]].body;
    touch.at_face = place_of_face(touch.face, w);
    touch.at_memory_face = place_of_face(memory_face, w);
  }
}

/// Finds the drifting nets. A row that touches a face no longer flies alone. Rows that touched in the
/// previous step or in earlier stages of this one count as touching, because their forces act in the step.
template <class Contacts, class Net, std::size_t N>
void find_drifting(bool continues_step, NetStage<Net, N>& w) noexcept {
  auto& faces = w.faces;
  const std::size_t num_rows = w.par->num_rows;
  // contacts with faces are the last ones
  const auto& before = w.memories.before();
  const bool has_faces = (w.near.size > 0 && w.near.list[w.near.size - 1].b == NetContactTerm::on_net) ||
                         (before.size > 0 && is_face_key<Contacts>(before.list[before.size - 1].key));
  if (!continues_step) faces.has_touched = false;
  if (!has_faces && !faces.has_touched) {
    faces.num_drifting = 0;
    return;
  }
  if (!faces.has_touched)
    for (std::size_t k = 0; k < num_rows; ++k) {
      faces.touches[k] = false;
      faces.is_held[k] = !w.rows[k].is_free;
    }
  if (!faces.has_touched) faces.group.separate(num_rows);
  faces.has_touched = true;
  const auto hold = [&](std::size_t row) noexcept {
    if (row < num_rows) faces.is_held[row] = true;
  };
  for (const NetContactTerm& one : w.attached()) hold(row_of_node(*w.par, one.node));
  const auto join = [&](std::uint32_t node, bool is_on_face, std::uint32_t face) noexcept {
    const std::size_t a = row_of_node(*w.par, node);
    if (!is_on_face) return hold(a);
    const std::size_t b = row_of_node(*w.par, w.par->faces.list[face].nodes[0]);
    for (const std::size_t row : {a, b})
      if (row < num_rows) faces.touches[row] = true;
    if (a == num_rows || b == num_rows) {
      hold(a);
      hold(b);
    } else {
      faces.group.join(a, b, num_rows);
    }
  };
  for (std::size_t i = 0; i < w.near.size; ++i)
    join(w.near.list[i].a, w.near.list[i].b == NetContactTerm::on_net, faces.touching[i].face);
  for (std::size_t i = 0; i < before.size; ++i) {
    const ContactMemory& one = before.list[i];
    const bool is_on_face = is_face_key<Contacts>(one.key);
    join(is_on_face ? node_of_face_key(one.key) : static_cast<std::uint32_t>(one.key), is_on_face,
         one.on - first_face_number<Contacts>);
  }
  for (std::size_t k = 0; k < num_rows; ++k)
    if (faces.is_held[k]) faces.is_held[faces.group.of[k]] = true;
  faces.num_drifting = 0;
  for (std::size_t k = 0; k < num_rows; ++k) {
    if (faces.touches[k]) w.rows[k].flies = false;
    faces.drifts[k] = faces.touches[k] && !faces.is_held[faces.group.of[k]];
    if (faces.drifts[k]) ++faces.num_drifting;
  }
}

}  // namespace godobject
