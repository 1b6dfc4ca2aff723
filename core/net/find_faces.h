// Search for contacts of nodes of nets with faces of other nets, and of their own.
//
// Bound: for each node, a box test of each net with faces. Nodes in the box of another net walk through a
// tree of boxes over its faces. The tree is the order of the faces (faces.h): halves of a range.
//
// A node stays on that side of a face on which it started the stage. Once it was pressed through the middle
// of the thickness, its memory holds the side. So neither a thin nor a fast net passes another in a stage.
#pragma once

#include "core/contact/find/find.h"
#include "core/net/faces.h"
#include "core/net/scratch.h"

namespace godobject {

/// Numbers of touched elements of contacts: surfaces, spheres, then faces.
template <class Contacts>
inline constexpr std::uint32_t first_face_number =
    static_cast<std::uint32_t>(std::tuple_size_v<decltype(Contacts::Params::surfaces)> +
                               std::tuple_size_v<decltype(Contacts::Params::spheres)>);

/// Returns the key of a contact of node n with a face, the slot-th of the node.
template <class Contacts>
std::uint64_t face_key(std::uint32_t n, std::uint32_t slot) noexcept {
  return std::uint64_t(first_face_number<Contacts>) << 32 | (n * max_faces_of_node + slot);
}
template <class Contacts>
bool is_face_key(std::uint64_t key) noexcept {
  return key >> 32 == first_face_number<Contacts>;
}
inline std::uint32_t node_of_face_key(std::uint64_t key) noexcept {
  return static_cast<std::uint32_t>(key) / max_faces_of_node;
}

/// Returns the corners of a face, taken from a vector of the nodes.
template <class Vector>
Corners corners_of(const std::array<std::uint32_t, 3>& nodes, const Vector& p) noexcept {
  return {p[nodes[0]].vec(), p[nodes[1]].vec(), p[nodes[2]].vec()};
}

/// Search of one stage for contacts with faces. Its contacts follow all others in the order of the keys.
template <class Contacts, std::size_t N, class Net>
class FaceFinder {
 public:
  FaceFinder(const typename Net::Params& net, const ContactFinder<Contacts, N>& bodies,
             NetStage<Net, N>& w) noexcept
      : net_(net), since_(bodies.since()), h_(bodies.h), w_(w) {}

  void find() noexcept {
    const auto& faces = net_.faces;
    const auto may_be_touched = [&](const NetPatch& patch) noexcept {
      return patch.touches_own || patch.first_node > 0 || patch.end_node < w_.num_nodes;
    };
    const auto end = faces.patches.begin() + static_cast<std::ptrdiff_t>(faces.num_patches);
    if (std::none_of(faces.patches.begin(), end, may_be_touched)) return;
    recall_depths();
    for (std::size_t k = 0; k < faces.num_patches; ++k) {
      const NetPatch& patch = faces.patches[k];
      PatchBox& box = w_.faces.patch_boxes[k] = {};
      for (std::uint32_t n = patch.first_node; n < patch.end_node; ++n)
        cover(n, net_.nodes[n].radius, box.all);
    }
    for (std::uint32_t n = 0; n < w_.num_nodes; ++n) find_of_node(n);
  }

 private:
  /// Contact of the current node with a face, before selection.
  struct Candidate {
    std::uint32_t face = 0, slot = no_slot_yet;
    std::size_t patch = 0;
    Real d = 0, v_n = 0;
    Vec3 n_W = Vec3::UnitZ();
  };
  /// Memory of a contact of the current node: its slot and the normal off the remembered face.
  struct Remembered {
    std::uint32_t slot = 0, face = 0;
    Real depth = 0;
    Vec3 n_W = Vec3::UnitZ();
  };
  static constexpr std::uint32_t no_slot_yet = max_faces_of_node;
  static constexpr std::uint32_t first_key = first_face_number<Contacts>;

  static Real depth_of(const ContactMemory& memory) noexcept { return memory.e + memory.pressed; }

  void recall_depths() noexcept {
    std::fill_n(w_.faces.depth.begin(), w_.num_nodes, Real(0));
    const auto& before = w_.memories.before();
    for (std::size_t i = before.size; i-- > 0 && is_face_key<Contacts>(before.list[i].key);) {
      Real& depth = w_.faces.depth[node_of_face_key(before.list[i].key)];
      depth = std::max(depth, depth_of(before.list[i]));
    }
  }

  Vec3 start_of(std::uint32_t n) const noexcept { return w_.p[n].vec() - since_ * w_.v[n].vec(); }
  void cover(std::uint32_t n, Real around, FaceBox& box) const noexcept {
    box.cover(w_.p[n], around);
    box.cover(w_.p[n] - w_.v[n] * since_, around);
  }

  /// Computes the boxes of a range of faces, and returns that of all of it.
  FaceBox make_boxes(std::uint32_t first, std::uint32_t end) noexcept {
    FaceBox box;
    if (end - first == 1) {
      for (const std::uint32_t n : net_.faces.list[first].nodes) cover(n, net_.nodes[n].radius, box);
      return box;
    }
    const std::uint32_t middle = first + (end - first) / 2;
    box = make_boxes(first, middle);
    box.cover(make_boxes(middle, end));
    return w_.faces.boxes[middle] = box;
  }

  void find_of_node(std::uint32_t n) noexcept {
    const Real radius = net_.nodes[n].radius;
    if (!(radius > 0)) return;
    FaceBox box;
    cover(n, (1 + contact_reach) * radius + w_.faces.depth[n], box);
    num_candidates_ = num_remembered_ = 0;
    if (w_.faces.depth[n] > 0) recall_node(n);
    for (std::size_t k = 0; k < net_.faces.num_patches; ++k) {
      const NetPatch& patch = net_.faces.patches[k];
      PatchBox& of = w_.faces.patch_boxes[k];
      if ((!patch.touches_own && patch.holds(n)) || !box.meets(of.all)) continue;
      if (!of.has_tree) make_boxes(patch.first, patch.end);
      of.has_tree = true;
      walk(n, box, k);
    }
    select(n);
  }

  /// Collects the contacts of a node with a patch.
  void walk(std::uint32_t n, const FaceBox& box, std::size_t k) noexcept {
    const NetPatch& patch = net_.faces.patches[k];
    struct Range {
      std::uint32_t first, end;
    };
    std::array<Range, 64> open;  // halves of halves: fewer than the bits of a number
    std::size_t num_open = 0;
    open[num_open++] = {patch.first, patch.end};
    while (num_open > 0) {
      const auto [first, end] = open[--num_open];
      if (end - first == 1) {
        add_candidate(n, first, k);
        continue;
      }
      const std::uint32_t middle = first + (end - first) / 2;
      if (!box.meets(w_.faces.boxes[middle])) continue;
      open[num_open++] = {middle, end};
      open[num_open++] = {first, middle};
    }
  }

  /// Reads the memories of a node.
  void recall_node(std::uint32_t n) noexcept {
    const auto& before = w_.memories.before();
    const auto end = before.list.begin() + static_cast<std::ptrdiff_t>(before.size);
    auto at = std::lower_bound(
        before.list.begin(), end, face_key<Contacts>(n, 0),
        [](const ContactMemory& memory, std::uint64_t key) noexcept { return memory.key < key; });
    for (; at != end && is_face_key<Contacts>(at->key) && node_of_face_key(at->key) == n &&
           num_remembered_ < max_faces_of_node;
         ++at) {
      const std::uint32_t face = at->on - first_key;
      remembered_[num_remembered_++] = {
          .slot = static_cast<std::uint32_t>(at->key - face_key<Contacts>(n, 0)),
          .face = face,
          .depth = depth_of(*at),
          .n_W = axes_of_face(corners_of(net_.faces.list[face].nodes, w_.p)) * at->n_b.vec()};
    }
  }

  bool share_a_node(std::uint32_t f, std::uint32_t g) const noexcept {
    const auto &a = net_.faces.list[f].nodes, &b = net_.faces.list[g].nodes;
    return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
  }

  void add_candidate(std::uint32_t n, std::uint32_t f, std::size_t k) noexcept {
    const NetFace& face = net_.faces.list[f];
    const bool is_own = net_.faces.patches[k].holds(n);
    if (is_own && !face.touches_own) return;
    const Vec3 p = w_.p[n].vec();
    const Corners t = corners_of(face.nodes, w_.p);
    const FacePoint q = nearest_on_face(t, p);
    Real thickness = net_.nodes[n].radius, thinnest = thickness;
    for (std::size_t j = 0; j < 3; ++j) {
      const Real radius = net_.nodes[face.nodes[j]].radius;
      thickness += q.weights[static_cast<Eigen::Index>(j)] * radius;
      thinnest = std::min(thinnest, radius);
    }
    if (!(thinnest > 0)) return;  // without contacts
    const Vec3 apart = p - q.of(t), normal = axes_of_face(t).col(2);
    const Real distance = apart.norm();
    const bool is_inside = is_touching(t, p, distance);
    Vec3 u = is_inside ? normal : Vec3(apart / distance);
    const Remembered* const before = remembered_on(f, u);
    if (before != nullptr && before->depth > kept_side_depth * thickness) {
      if (u.dot(before->n_W) < 0) u = -u;
    } else {
      Corners t_0;
      for (std::size_t j = 0; j < 3; ++j) t_0[j] = start_of(face.nodes[j]);
      const Vec3 p_0 = start_of(n);
      if (is_inside ? axes_of_face(t_0).col(2).dot(p_0 - t_0[0]) < 0 : crosses_face(t_0, p_0, t, p)) u = -u;
    }
    const Real d = thickness - u.dot(apart);
    const Vec3 v = w_.v[n].vec() - q.of(corners_of(face.nodes, w_.v));
    const Real v_n = u.dot(v);
    if (!(std::max(d, d + h_ * v_n) > -contact_reach * net_.nodes[n].radius)) return;
    const std::size_t carrier = net_.nodes[n].body;
    const bool is_beside = carrier != world && carrier == net_.nodes[face.nodes[0]].body;
    if ((is_own || is_beside) && are_neighbours(net_, n, face, thickness)) return;
    if (num_candidates_ == max_face_candidates) {
      w_.near.is_short = true;
      return;
    }
    candidates_[num_candidates_++] = {.face = f,
                                      .slot = before != nullptr ? before->slot : no_slot_yet,
                                      .patch = k,
                                      .d = d,
                                      .v_n = v_n,
                                      .n_W = u};
  }

  /// Returns the memory on a face or a neighbour of it whose normal is nearest to the line along u.
  const Remembered* remembered_on(std::uint32_t f, const Vec3& u) const noexcept {
    const Remembered* best = nullptr;
    for (std::size_t i = 0; i < num_remembered_; ++i) {
      const Remembered& one = remembered_[i];
      if (std::abs(one.n_W.dot(u)) < same_contact || !share_a_node(f, one.face)) continue;
      if (best == nullptr || std::abs(best->n_W.dot(u)) < std::abs(one.n_W.dot(u))) best = &one;
    }
    return best;
  }

  /// Adds the deepest candidates of each patch whose normals differ.
  void select(std::uint32_t n) noexcept {
    const auto end = candidates_.begin() + static_cast<std::ptrdiff_t>(num_candidates_);
    std::sort(candidates_.begin(), end, [](const Candidate& a, const Candidate& b) noexcept {
      return a.d != b.d ? a.d > b.d : a.face < b.face;
    });
    std::array<const Candidate*, max_faces_of_node> of_slot{};
    std::array<bool, max_faces_of_node> is_kept{};  // slots of memories, in which other contacts begin last
    for (std::size_t i = 0; i < num_remembered_; ++i) is_kept[remembered_[i].slot] = true;
    for (auto one = candidates_.begin(); one != end; ++one) {
      const bool is_known = std::any_of(of_slot.begin(), of_slot.end(), [&](const Candidate* other) noexcept {
        return other != nullptr && other->patch == one->patch && other->n_W.dot(one->n_W) >= same_contact;
      });
      if (is_known) continue;
      const Candidate& chosen = first_of_ties(one, end, n);
      std::uint32_t slot = chosen.slot;
      if (slot == no_slot_yet || of_slot[slot] != nullptr)
        for (slot = 0; slot < no_slot_yet && (is_kept[slot] || of_slot[slot] != nullptr);) ++slot;
      if (slot == no_slot_yet)
        for (slot = 0; slot < no_slot_yet && of_slot[slot] != nullptr;) ++slot;
      if (slot < no_slot_yet) of_slot[slot] = &chosen;
      else w_.near.is_short = true;
    }
    for (std::uint32_t slot = 0; slot < max_faces_of_node; ++slot)
      if (of_slot[slot] != nullptr) add(n, slot, *of_slot[slot]);
  }

  /// Returns that candidate of those as deep as `one`, as at a common edge, whose nodes come first. Rounding
  /// does not decide.
  template <class Iterator>
  const Candidate& first_of_ties(Iterator one, Iterator end, std::uint32_t n) const noexcept {
    Iterator best = one;
    for (Iterator other = one + 1;
         other != end && one->d - other->d <= input_tolerance * net_.nodes[n].radius; ++other)
      if (other->patch == one->patch && other->n_W.dot(one->n_W) >= same_contact &&
          net_.faces.list[other->face].nodes < net_.faces.list[best->face].nodes)
        best = other;
    return *best;
  }

  void add(std::uint32_t n, std::uint32_t slot, const Candidate& one) noexcept {
    w_.near.add({.key = face_key<Contacts>(n, slot),
                 .of = n,
                 .on = first_key + one.face,
                 .a = n,
                 .b = NetContactTerm::on_net,
                 .d = one.d,
                 .v_n = one.v_n,
                 .p_W = w_.p[n].vec() - net_.nodes[n].radius * one.n_W,
                 .n_W = one.n_W});
  }

  const typename Net::Params& net_;
  Real since_, h_;
  NetStage<Net, N>& w_;
  std::array<Remembered, max_faces_of_node> remembered_;
  std::size_t num_remembered_ = 0;
  std::array<Candidate, max_face_candidates> candidates_;
  std::size_t num_candidates_ = 0;
};

}  // namespace godobject
