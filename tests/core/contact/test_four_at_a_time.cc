// Operations on four contacts at once, against the same for each by itself.
#include <gtest/gtest.h>

#include <cmath>

#include "core/solve/bodies.h"
#include "tests/core/one_body.h"

namespace godobject::test_four_at_a_time {
namespace {

using Contacts = BodyContacts<8, 8, 32>;

ContactPlacesOf<Real> drawn_places(Random& random) {
  return {.R_a = random.rotation().toRotationMatrix(),
          .R_b = random.rotation().toRotationMatrix(),
          .p_a = random.vector(),
          .p_b = random.vector()};
}
/// Draws the memory of a contact at c_W of normal n_W, or of another one.
ContactMemory drawn_memory(Random& random, const ContactPlacesOf<Real>& at, const Vec3& c_W,
                           const Vec3& n_W) {
  const Vec3 n =
      random.integer(0, 3) > 0 ? Vec3((n_W + 0.3 * random.vector()).normalized()) : random.direction();
  Vec3 xi = 1e-4 * random.vector();
  xi -= n * n.dot(xi);
  const AnchorsOf<Real> anchors = anchored<Real>(at, c_W, n, xi, 1e-4 * random.vector());
  const Vec3 slip_dot = 1e-1 * random.vector();
  return {.e = random.uniform(0, 1e-3),
          .pressed = random.integer(0, 2) * random.uniform(0, 1e-3),
          .F_n = random.uniform(-1, 10),
          .c_a = Column(anchors.c_a),
          .c_b = Column(anchors.c_b),
          .n_a = Column(anchors.n_a),
          .n_b = Column(anchors.n_b),
          .n_W = Column(n),
          .xi_a = Column(anchors.xi_a),
          .xi_b = Column(anchors.xi_b),
          .slip_dot_W = Column(slip_dot)};
}
ContactPastOf<Real> past(const ContactMemory& m) {
  return {.anchors = {.c_a = m.c_a.vec(),
                      .c_b = m.c_b.vec(),
                      .n_a = m.n_a.vec(),
                      .n_b = m.n_b.vec(),
                      .xi_a = m.xi_a.vec(),
                      .xi_b = m.xi_b.vec()},
          .n_W = m.n_W.vec(),
          .slip_dot_W = m.slip_dot_W.vec(),
          .e = m.e,
          .pressed = m.pressed,
          .F_n = m.F_n};
}
template <class F>
Vector3<Pack> four_vectors(F of) {
  return in_lanes(Column(of(0)), Column(of(1)), Column(of(2)), Column(of(3)));
}

ContactLaw drawn_law(Random& random) {
  const int kind = random.integer(0, 3);
  return {.k = kind == 0 ? 0 : random.log_uniform(1e2, 1e8),
          .c = random.log_uniform(1, 1e3),
          .mu = kind == 1 ? 0 : random.uniform(0, 1),
          .k_t = kind < 2 ? 0 : random.log_uniform(1e2, 1e8),
          .c_t = random.log_uniform(1e-3, 1e3),
          .push_out = random.uniform(0, 0.1)};
}
ContactStage drawn_stage(Random& random) {
  ContactStage stage{.relaxation_time = random.uniform(0, 1e-3)};
  if (random.integer(0, 1) > 0) stage.extrapolated = random.uniform(0, 1e-3);
  if (random.integer(0, 1) > 0) stage.slip_before = 0.5;
  return stage;
}

void expect_near(Real a, Real b, Real size) { EXPECT_NEAR(a, b, 1e-13 * (size + std::abs(b))); }
void expect_near(const Vec3& a, const Vec3& b, Real size) {
  EXPECT_LE((a - b).norm(), 1e-13 * (size + b.norm()));
}

/// Contacts, their memory and their laws; numbers of different magnitude.
struct Drawn {
  ContactPlacesOf<Real> at;
  ContactPlacesOf<Pack> at_4;
  std::array<ContactMemory, 4> before;
  std::array<NearContact, 4> near;
  std::array<StageLawOf<Real>, 4> laws;
  std::array<Vec3, 4> v_W;
  std::array<Real, 4> rho, d_0, approach;

  Drawn(Random& random, Real h, Real relaxation_time)
      : at(drawn_places(random)),
        at_4{.R_a = at.R_a.cast<Pack>(),
             .R_b = at.R_b.cast<Pack>(),
             .p_a = at.p_a.cast<Pack>(),
             .p_b = at.p_b.cast<Pack>()} {
    for (std::size_t j = 0; j < 4; ++j) {
      near[j].n_W = random.direction();
      near[j].p_W = random.vector();
      if (random.integer(0, 3) > 0) before[j] = drawn_memory(random, at, near[j].p_W, near[j].n_W);
      laws[j] = stage_law<Contacts>(drawn_law(random), 1, random.log_uniform(1e-3, 10), h, relaxation_time,
                                    random.integer(0, 1) > 0);
      v_W[j] = 0.1 * random.vector();
      rho[j] = random.uniform(0, 0.1);
      d_0[j] = random.uniform(-1e-3, 2e-3);
      approach[j] = random.uniform(0, 1e-3);
    }
  }
  ContactStartOf<Real> start(std::size_t j) const {
    return {
        .at = at, .n_W = near[j].n_W, .v_W = v_W[j], .rho = rho[j], .d_0 = d_0[j], .approach = approach[j]};
  }
  ContactStartOf<Pack> start() const {
    const auto lanes = [](const auto& of) { return Pack(of[0], of[1], of[2], of[3]); };
    return {.at = at_4,
            .n_W = four_vectors([&](std::size_t j) { return near[j].n_W; }),
            .v_W = four_vectors([&](std::size_t j) { return v_W[j]; }),
            .rho = lanes(rho),
            .d_0 = lanes(d_0),
            .approach = lanes(approach)};
  }
};

TEST(FourAtATime, AreRecalledAndCarriedOverAsEachByItself) {
  Random random(1);
  int known = 0, pressed = 0;
  for (int n = 0; n < 20000; ++n) {
    const Real h = random.log_uniform(1e-4, 5e-3);
    const ContactStage stage = drawn_stage(random);
    const Drawn drawn(random, h, stage.relaxation_time);
    const auto four = [](const auto& of) { return gathered({&of[0], &of[1], &of[2], &of[3]}); };
    const StageLawOf<Pack> law = gathered(drawn.laws);
    const ContactStartOf<Pack> start = drawn.start();
    const InitialContactOf<Pack> initial = recalled<Pack>(law, stage, h, four(drawn.before), start);
    std::array<Vec3, 4> forces, slips;
    for (std::size_t j = 0; j < 4; ++j) {
      forces[j] = 5 * random.vector();
      slips[j] = 0.1 * random.vector();
    }
    const Pack d = random.uniform(-1e-3, 2e-3);
    const ContactPastOf<Pack> next =
        carried_over<Pack>({.contact = initial, .v_W = start.v_W, .sticking = sticking_of(law)}, stage, h,
                           {.at = start.at,
                            .c_W = four_vectors([&](std::size_t j) { return drawn.near[j].p_W; }),
                            .n_W = start.n_W,
                            .s_W = four_vectors([&](std::size_t j) { return slips[j]; }),
                            .F_W = four_vectors([&](std::size_t j) { return forces[j]; }),
                            .d = d});
    for (std::size_t j = 0; j < 4; ++j) {
      const StageLawOf<Real>& its = drawn.laws[j];
      const InitialContactOf<Real> one = recalled<Real>(its, stage, h, past(drawn.before[j]), drawn.start(j));
      expect_near(lane(initial.xi_W, j), one.xi_W, 10);  // positions of some metres
      expect_near(initial.e[j], one.e, 1e-2);
      expect_near(initial.F_n[j], one.F_n, 10);
      expect_near(initial.found[j], one.found, its.k * 1e-4);
      known += one.F_n >= 0;
      const ContactPastOf<Real> end =
          carried_over<Real>({.contact = one, .v_W = drawn.v_W[j], .sticking = sticking_of(its)}, stage, h,
                             {.at = drawn.at,
                              .c_W = drawn.near[j].p_W,
                              .n_W = drawn.near[j].n_W,
                              .s_W = slips[j],
                              .F_W = forces[j],
                              .d = d[j]});
      const Real size = 10 + 10 * its.given;
      expect_near(lane(next.anchors.xi_a, j), end.anchors.xi_a, size);
      expect_near(lane(next.anchors.xi_b, j), end.anchors.xi_b, size);
      expect_near(lane(next.anchors.c_a, j), end.anchors.c_a, 10);
      expect_near(lane(next.anchors.n_b, j), end.anchors.n_b, 1);
      expect_near(lane(next.slip_dot_W, j), end.slip_dot_W, size / h + 10 * its.v_per_xi);
      expect_near(next.pressed[j], end.pressed, 1e-2);
      pressed += end.anchors.xi_a.norm() > 0;
    }
  }
  EXPECT_GT(known, 30000);
  EXPECT_GT(pressed, 10000);
}

/// Returns four contacts of bodies whose axes are those of the world, at rest.
ContactStartOf<Pack> at_rest(const NearFour& near) {
  static const ContactPlacesOf<Pack> at;
  return {.at = at, .n_W = near.all(&NearContact::n_W), .v_W = Vector3<Pack>::Constant(Pack(0)), .rho = 0};
}

/// Lanes that are left bear nothing, whatever their neighbours do: the body feels a contact once.
TEST(FourAtATime, LanesThatAreLeftBearNothing) {
  Random random(2);
  for (std::uint32_t size = 1; size <= 4; ++size) {
    ContactMemories<32> memories{};
    std::array<NearContact, 4> list;
    const Vec3 n_W = random.direction();
    for (std::uint32_t j = 0; j < size; ++j) {
      list[j].key = memories.list[j].key = j + 1;
      list[j].d = memories.list[j].pressed = 1e-3;
      list[j].n_W = n_W;
      list[j].p_W = random.vector();
      memories.list[j].n_a = memories.list[j].n_b = memories.list[j].n_W = Column(n_W);
      memories.list[j].F_n = 1;
    }
    memories.size = size;
    constexpr Real h = 1e-3;
    const ContactLaw law{.k = 1e4, .c = 10, .mu = 0.5, .k_t = 1e4, .c_t = 10};
    const StageLawOf<Real> of_stage = stage_law<Contacts>(law, 1, 1, h, h, true);
    const NearFour near(list.data(), size);
    const auto law_in_stage = [&](const NearContact&) -> const ContactLaw& { return law; };
    const StageLawOf<Pack> laws =
        laws_of(near, law, of_stage, law_in_stage, [&](const ContactLaw&) { return of_stage; });
    Recall recall(memories);
    ContactPack pack;
    InitialMemoryPack initial;
    None none;
    const Vector3<Pack> p_W = near.all(&NearContact::p_W);
    const ContactStage stage{.relaxation_time = h};
    ContactStartOf<Pack> start = at_rest(near);
    begin_four(near, laws, near.sides(0), p_W, h, stage, start, recall, none, initial, pack);
    predict<false>(pack, SpatialVector::zero());
    ContactSums sums;
    add<false>(pack, h, sums);
    const SymmetricSpatialMatrix A = total(sums);
    EXPECT_NEAR(A.vv.col[0].x() + A.vv.col[1].y() + A.vv.col[2].z(),
                size * h * (of_stage.eta_n + 2 * pack.eta_t[0]), 1e-12);
    for (std::size_t j = 0; j < 4; ++j) {
      EXPECT_EQ(lane(pack.F, j).norm() > 0, j < size);
      EXPECT_EQ(pack.active[j], j < size ? 1 : 0);
    }
    ContactMemories<32> next{};
    move(pack, SpatialVector::zero());
    carry_over(near, near.sides(0), start.at, p_W, stage, h, initial, pack, next);
    EXPECT_EQ(next.size, size);
  }
}

/// A new contact in the second stage of a step, 1 mm deep at its start. If the stage starts by extrapolation,
/// its approach is measured; if it starts at the end of the first stage, it is not. The spring then drives
/// with at most the depenetration velocity (35).
TEST(FourAtATime, OfANewContactOnlyWhatAnExtrapolationMeasuredIsPressed) {
  constexpr Real h = 1e-3, depth = 1e-3, v_n = -3;
  const ContactLaw law{.k = 1e6, .c = 1, .push_out = 0.01};
  const StageLawOf<Real> of_stage = stage_law<Contacts>(law, 1e-5, 1e-5, h, h, false);
  std::array<NearContact, 4> list;
  for (std::uint32_t j = 0; j < 4; ++j) {
    list[j].key = j + 1;
    list[j].d = depth - h * v_n;  // where the stage is predicted to end
    list[j].v_n = v_n;
    list[j].n_W = Vec3::UnitZ();
  }
  const NearFour near(list.data(), 4);
  const auto begun_in = [&](const ContactStage& stage) {
    const ContactMemories<32> nothing{};
    Recall recall(nothing);
    ContactPack pack;
    InitialMemoryPack initial;
    None none;
    ContactStartOf<Pack> start = at_rest(near);
    const Pack found = begin_four(near, gathered({of_stage, of_stage, of_stage, of_stage}), near.sides(0),
                                  near.all(&NearContact::p_W), h, stage, start, recall, none, initial, pack);
    EXPECT_NEAR(found[0], law.push_out * law.push_out * 1e-5 / 2, 1e-15);
    return initial.contact.e[0];
  };
  const Real stored = of_stage.max_stored_penetration;
  ContactStage second{.relaxation_time = h, .extrapolated = h, .continues_step = true};
  EXPECT_EQ(begun_in(second), 0);
  second.extrapolated = 0;
  EXPECT_NEAR(begun_in(second), depth - stored, 1e-15);
}

}  // namespace
}  // namespace godobject::test_four_at_a_time
