// Working storage of nets in a step, undefined between steps.
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <type_traits>

#include "core/contact/candidates.h"
#include "core/contact/find/sphere_pack.h"
#include "core/contact/forces.h"
#include "core/contact/stage.h"
#include "core/math/symmetric.h"
#include "core/net/net.h"

namespace godobject {

/// Nodes [first, end) of one carrier, and their groups.
struct NetRun {
  std::size_t body = world;
  std::uint32_t first = 0, end = 0, first_group = 0, end_group = 0;

  bool holds(std::uint32_t n) const noexcept { return first <= n && n < end; }
};

/// Place of a face, as that of a body: its centre, and its axes as columns.
struct FacePlace {
  Vec3 p_W = Vec3::Zero();
  Mat3 R_W = Mat3::Identity();
};

/// Point of a face: the weighted sum of its nodes.
struct PointOfFace {
  std::array<std::uint32_t, 3> nodes{};
  Vec3 weights = Vec3::Zero();
  std::size_t carrier = world;  // of the nodes
};
/// Point of a face that a node touches.
struct FaceTouch : PointOfFace {
  std::uint32_t face = 0;
  // places at the predicted nodes: of the face, and of that in whose axes the memory has its anchor (51)
  FacePlace at_face, at_memory_face;
};

/// Contact or attachment of a node in the system: effective mass a 1 + b n n^T for the velocity of the node
/// relative to the body or face.
struct NetContactTerm {
  static constexpr std::uint32_t on_world = ~std::uint32_t(0), on_net = on_world - 1;
  std::uint32_t node = 0, body = on_world;
  std::size_t carrier = world;  // carrier of the node
  PointOfFace face;             // touched point if body is on_net
  Column n, r;                  // r: from the centre of mass of the touched body
  Real a = 0, b = 0;
  Column J;  // impulse on the node at zero relative velocity

  bool is_on_body() const noexcept { return body < on_net; }
  bool is_on_face() const noexcept { return body == on_net; }
  /// Returns the body that is touched, or the carrier of the touched face; world if neither exists.
  std::size_t touched() const noexcept {
    if (is_on_face()) return face.carrier;
    return is_on_body() ? body : world;
  }
};

/// Box of a range of faces, or of a node, over their way in a stage.
struct FaceBox {
  Column low = Column(Pack(std::numeric_limits<Real>::infinity()));
  Column high = Column(Pack(-std::numeric_limits<Real>::infinity()));

  void cover(const Column& p, Real around) noexcept {
    low.p = min(low.p, p.p - Pack(around));
    high.p = max(high.p, p.p + Pack(around));
  }
  void cover(const FaceBox& of) noexcept {
    low.p = min(low.p, of.low.p);
    high.p = max(high.p, of.high.p);
  }
  bool meets(const FaceBox& of) const noexcept { return !any(of.high.p < low.p) && !any(high.p < of.low.p); }
};

/// Box of a patch, and whether the boxes of its ranges have been computed.
struct PatchBox {
  FaceBox all;
  bool has_tree = false;
};

/// Numbers of the groups of rows: that of one of their rows.
template <std::size_t max>
struct RowGroups {
  std::array<std::uint32_t, max> of;

  void separate(std::size_t num_rows) noexcept {
    for (std::size_t k = 0; k < num_rows; ++k) of[k] = static_cast<std::uint32_t>(k);
  }
  void join(std::size_t a, std::size_t b, std::size_t num_rows) noexcept {
    if (of[a] == of[b]) return;
    const std::uint32_t from = of[a], to = of[b];
    std::replace(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(num_rows), from, to);
  }
};

/// Contacts between nets in a stage. Without faces: empty.
template <class Net, bool has_faces = (Net::max_faces > 0)>
struct FaceStage {
  // boxes of ranges of faces, by the middle of each range; nodes: largest depth in memory, m
  std::array<FaceBox, Net::max_faces> boxes;
  std::array<PatchBox, Net::max_nodes / 2 + 1> patch_boxes;
  std::array<Real, Net::max_nodes> depth;
  std::array<FaceTouch, Net::max_contacts> touching;  // by near contact
  // rows that touch each other or themselves and nothing else; group: by near contacts in the step so far
  RowGroups<Net::max_nodes / 2 + 1> group, active_group;
  std::array<bool, Net::max_nodes / 2 + 1> drifts, touches, is_held;  // touches, is_held: in the step so far
  bool has_touched = false;                        // a contact with a face in the step so far
  std::size_t num_drifting = 0;                    // rows
  std::array<Real, Net::max_nodes / 2 + 1> mass;   // by group, kg
  std::array<Column, Net::max_nodes / 2 + 1> sum;  // by group
  std::array<Column, Net::max_nodes> drift;  // by node: velocity of its group as a whole; otherwise zero
};
template <class Net>
struct FaceStage<Net, false> {};

/// Pair of a carrier and a body that its nodes touch.
struct NetPair {
  std::uint32_t carrier = 0, touched = 0, entry = 0;  // entry: index in the system of their island
};

/// Effective masses K = a 1 + b u u^T of the springs of a slot (41).
struct SlotMass {
  Vector3<Pack> u;
  Pack a, b;

  Vector3<Pack> operator*(const Vector3<Pack>& d) const noexcept {
    const Pack along = b * u.dot(d);
    return {d[0] * a + u[0] * along, d[1] * a + u[1] * along, d[2] * a + u[2] * along};
  }
};

/// Weighted sums of nodes about their centre, for their rigid motion.
struct RigidFit {
  Column c{Pack(0)};  // centre, m
  Real size = 0;      // sum of the weights
  Block J_inverse;    // inverse of J in (57), the moment of inertia about the centre
};

/// A row of nodes in a stage.
struct RowStage {
  bool floats = false;  // true if no anchor has stiffness and at least one has damping
  RigidFit dampers, masses;
  bool flies = false;        // nothing touches it
  bool is_free = false;      // true if it has no carrier and no anchor with stiffness
  bool stands = false;       // nothing but the world acts on it (standing.h)
  Block E, E_inverse;        // E of (44) of its translation, if it stands
  SpatialVector delta, c_1;  // corrections of (45), about the centre of the masses
};

/// Nets of a scene in a stage, undefined between steps. N: bodies.
template <class Net, std::size_t N>
struct NetStage {
  static constexpr std::size_t max_nodes = Net::max_nodes, max_packs = (Net::max_contacts + 3) / 4;
  static constexpr bool has_faces = Net::max_faces > 0;
  static constexpr std::size_t max_runs = N + 1, max_pairs = net_pairs_per_body * N;

  std::array<NetRun, max_runs> runs;
  std::size_t num_runs = 0, num_nodes = 0;
  static constexpr std::uint32_t no_body = ~std::uint32_t(0);
  std::uint32_t first_body = no_body;  // any body of its island

  // indexed by node, at the predicted end of the stage
  std::array<Column, max_nodes> p, v, r;  // r: from the carrier's centre of mass
  std::array<Column, max_nodes> v_free;   // velocities by gravity alone
  Column by_gravity;                      // velocity added in the stage, m/s
  bool begins_at_solution = false;        // V_0 is the last solution of the same stage (39)
  std::array<Real, max_nodes> m, kappa;   // mass; effective mass of the anchor
  std::array<Real, max_nodes> settling;   // h g of nodes in floating rows, otherwise 0
  std::array<RowStage, max_nodes / 2 + 1> rows;
  std::array<Column, max_nodes> J_anchor;
  std::array<Column, max_nodes> b;  // impulses except those of contacts

  const typename Net::Params* par = nullptr;
  // indexed by slot: effective masses of springs, and impulses with the ends at rest
  std::array<SlotMass, Net::max_springs> masses;
  std::array<Vector3<Pack>, Net::max_springs> J_springs;
  std::array<SymmetricSpatialMatrix, N>
      prestress;  // resistance of tensioned springs to rotation of their carrier

  // contacts, four to a pack, each of a node of its own
  std::array<SpherePack, (max_nodes + 3) / 4> spheres;
  NearContacts<Net::max_contacts> near;
  std::array<std::size_t, Net::max_contacts> carrier;
  std::array<ContactPack, max_packs> packs;  // r: on the body that is touched
  std::array<InitialMemoryPack, max_packs> initial;
  std::size_t num_packs = 0;
  // attachments, present in all modes, then the active contacts
  std::array<NetContactTerm, Net::max_attachments + Net::max_contacts> contacts;
  std::size_t num_contacts = 0;
  using NumAttachments =
      std::conditional_t<(Net::max_attachments > 0), std::size_t, std::integral_constant<std::size_t, 0>>;
  [[no_unique_address]] NumAttachments num_attachments{};
  std::array<NetPair, max_pairs> pairs;
  std::size_t num_pairs = 0;
  [[no_unique_address]] FaceStage<Net> faces;
  StageMemories<Net::max_contacts, 3> memories;
  ContactForces<Net::max_contacts> forces;  // contact forces of the stage

  // incomplete factor of the nodes: D without contacts, the contacts' part of D, and the inverse of both
  // together by group
  std::array<SymmetricBlock, max_nodes> D, of_contacts;
  std::array<SymmetricPack, max_nodes> D_inverse;
  Real factored_h = 0;  // length of the stage for which the factor was computed, s; 0: no factor to reuse
  std::array<Column, max_nodes> carrier_relative_v;  // node velocities, storage for a product A V
  using OfBodies = std::array<SpatialVector, N>;
  OfBodies delta, c_1;      // (45)
  OfBodies on_carriers;     // impulses of anchors on bodies, at the end
  OfBodies passed_on;       // residual impulses on bodies that contacts of their nodes, or attachments, carry
  bool is_solved = true;    // false if the iteration was cut off at its limit
  bool is_balanced = true;  // (45) holds for the velocities
  NetReport report;

  std::span<const NodeGroup> groups() const noexcept { return {par->groups.data(), par->num_groups}; }
  /// Returns the face that near contact i touches; null if it touches none.
  const FaceTouch* touched_face([[maybe_unused]] std::size_t i) const noexcept {
    if constexpr (has_faces)
      if (near.list[i].b == NetContactTerm::on_net) return &faces.touching[i];
    return nullptr;
  }
  std::span<const NetContactTerm> terms() const noexcept { return {contacts.data(), num_contacts}; }
  std::span<NetContactTerm> attached() noexcept { return {contacts.data(), num_attachments}; }
  std::span<const NetContactTerm> attached() const noexcept { return {contacts.data(), num_attachments}; }
};

}  // namespace godobject
