// Operations on four contacts at once, against the same for each by itself.
#include <gtest/gtest.h>

#include <cmath>

#include "core/contact/bodies.h"
#include "tests/core/one_body.h"

namespace godobject::test_four_at_a_time {
namespace {

using Contacts = BodyContacts<8, 8, 32>;

/// Draws the memory of a contact of normal n_W, or of another one.
ContactMemory drawn_memory(Random& random, const Vec3& n_W) {
  ContactMemory m;
  m.e = random.uniform(0, 1e-3);
  m.pressed = random.integer(0, 2) * random.uniform(0, 1e-3);
  m.xi_W = Column(Vec3(1e-4 * random.vector()));
  m.xi_dot_W = Column(Vec3(1e-1 * random.vector()));
  m.n_W = Column(random.integer(0, 3) > 0 ? Vec3((n_W + 0.3 * random.vector()).normalized())
                                          : random.direction());
  m.F_W = Column(Vec3(random.uniform(-1, 10) * m.n_W.vec() + random.vector()));
  return m;
}
ContactPastOf<Real> past(const ContactMemory& m) {
  return {.xi_W = m.xi_W.vec(),
          .xi_dot_W = m.xi_dot_W.vec(),
          .F_W = m.F_W.vec(),
          .n_W = m.n_W.vec(),
          .e = m.e,
          .pressed = m.pressed};
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
  if (random.integer(0, 1) > 0) stage.t_0 = random.uniform(0, 1e-3);
  if (random.integer(0, 1) > 0) {
    stage.continues_step = true;
    stage.t_1 = random.uniform(0, 1e-3);
    stage.follows = random.integer(0, 2) == 0;
    stage.is_euler = random.integer(0, 2) == 0;
  }
  return stage;
}

void expect_near(Real a, Real b, Real size) { EXPECT_NEAR(a, b, 1e-13 * (size + std::abs(b))); }
void expect_near(const Vec3& a, const Vec3& b, Real size) {
  EXPECT_LE((a - b).norm(), 1e-13 * (size + b.norm()));
}

/// Contacts, their memory of the step and the previous stage, and laws; numbers of different magnitude.
struct Drawn {
  std::array<ContactMemory, 4> of_step, of_stage;
  std::array<NearContact, 4> near;
  std::array<StageLawOf<Real>, 4> laws;
  std::array<Real, 4> d_0, approach;

  Drawn(Random& random, Real h, Real relaxation_time) {
    for (std::size_t j = 0; j < 4; ++j) {
      near[j].n_W = random.direction();
      if (random.integer(0, 3) > 0) of_step[j] = drawn_memory(random, near[j].n_W);
      if (random.integer(0, 3) > 0) of_stage[j] = drawn_memory(random, near[j].n_W);
      laws[j] = stage_law<Contacts>(drawn_law(random), random.log_uniform(1e-3, 10), h, relaxation_time,
                                    random.integer(0, 1) > 0);
      d_0[j] = random.uniform(-1e-3, 2e-3);
      approach[j] = random.uniform(0, 1e-3);
    }
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
    const auto lanes = [](const auto& of) { return Pack(of[0], of[1], of[2], of[3]); };
    const StageLawOf<Pack> law = gathered(drawn.laws);
    const Vector3<Pack> n_W = in_lanes(Column(drawn.near[0].n_W), Column(drawn.near[1].n_W),
                                       Column(drawn.near[2].n_W), Column(drawn.near[3].n_W));
    const InitialContactOf<Pack> initial =
        recalled<Pack>(law, stage, four(drawn.of_step), four(drawn.of_stage),
                       {.n_W = n_W, .d_0 = lanes(drawn.d_0), .approach = lanes(drawn.approach)});
    const Vector3<Pack> F_W = in_lanes(Column(Vec3(5 * random.vector())), Column(Vec3(5 * random.vector())),
                                       Column(Vec3(5 * random.vector())), Column(Vec3(5 * random.vector())));
    const Pack d = random.uniform(-1e-3, 2e-3);
    const ContactPastOf<Pack> next = carried_over<Pack>(
        {.xi_W = initial.xi_W, .e = initial.e, .kept = law.kept, .given = law.given, .F_n = initial.F_n}, h,
        n_W, d, F_W);
    for (std::size_t j = 0; j < 4; ++j) {
      const InitialContactOf<Real> one =
          recalled<Real>(drawn.laws[j], stage, past(drawn.of_step[j]), past(drawn.of_stage[j]),
                         {.n_W = drawn.near[j].n_W, .d_0 = drawn.d_0[j], .approach = drawn.approach[j]});
      expect_near(lane(initial.xi_W, j), one.xi_W, 1e-3);
      expect_near(initial.e[j], one.e, 1e-2);
      expect_near(initial.F_n[j], one.F_n, 10);
      expect_near(initial.found[j], one.found, drawn.laws[j].k * 1e-4);
      known += one.F_n >= 0;
      const ContactPastOf<Real> end = carried_over<Real>({.xi_W = one.xi_W,
                                                          .e = one.e,
                                                          .kept = drawn.laws[j].kept,
                                                          .given = drawn.laws[j].given,
                                                          .F_n = one.F_n},
                                                         h, drawn.near[j].n_W, d[j], lane(F_W, j));
      expect_near(lane(next.xi_W, j), end.xi_W, 1e-3 + 10 * drawn.laws[j].given);
      expect_near(lane(next.xi_dot_W, j), end.xi_dot_W, (1e-3 + 10 * drawn.laws[j].given) / h);
      expect_near(next.pressed[j], end.pressed, 1e-2);
      pressed += end.xi_W.norm() > 0;
    }
  }
  EXPECT_GT(known, 30000);
  EXPECT_GT(pressed, 10000);
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
      memories.list[j].n_W = memories.list[j].F_W = Column(n_W);
    }
    memories.size = size;
    constexpr Real h = 1e-3;
    const ContactLaw law{.k = 1e4, .c = 10, .mu = 0.5, .k_t = 1e4, .c_t = 10};
    const StageLawOf<Real> of_stage = stage_law<Contacts>(law, 1, h, h, true);
    const NearFour near(list.data(), size);
    const auto law_in_stage = [&](const NearContact&) -> const ContactLaw& { return law; };
    const StageLawOf<Pack> laws =
        laws_of(near, law, of_stage, law_in_stage, [&](const ContactLaw&) { return of_stage; });
    Recall step(memories), stage_before(memories);
    ContactPack pack;
    InitialMemoryPack initial;
    None none;
    begin_four(near, laws, near.sides(0), near.all(&NearContact::p_W), h, {.relaxation_time = h}, step,
               stage_before, none, initial, pack);
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
    carry_over(near, near.sides(0), h, initial, pack, next);
    EXPECT_EQ(next.size, size);
  }
}

/// A new contact in the second stage of a step, 1 mm deep at its start. If the stage starts by extrapolation,
/// its approach is measured; if it starts at the end of the first stage, it is not. The spring then drives
/// with at most the depenetration velocity (35).
TEST(FourAtATime, OfANewContactOnlyWhatAnExtrapolationMeasuredIsPressed) {
  constexpr Real h = 1e-3, depth = 1e-3, v_n = -3;
  const ContactLaw law{.k = 1e6, .c = 1, .push_out = 0.01};
  const StageLawOf<Real> of_stage = stage_law<Contacts>(law, 1e-5, h, h, false);
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
    Recall step(nothing), stage_before(nothing);
    ContactPack pack;
    InitialMemoryPack initial;
    None none;
    const Pack found =
        begin_four(near, gathered({of_stage, of_stage, of_stage, of_stage}), near.sides(0),
                   near.all(&NearContact::p_W), h, stage, step, stage_before, none, initial, pack);
    EXPECT_NEAR(found[0], law.push_out * law.push_out * 1e-5 / 2, 1e-15);
    return initial.e[0];
  };
  const Real stored = of_stage.max_stored_penetration;
  const ContactStage second{.t_1 = h, .relaxation_time = h, .continues_step = true};
  EXPECT_EQ(begun_in(second), 0);
  ContactStage after_euler = second;
  after_euler.is_euler = true;
  EXPECT_NEAR(begun_in(after_euler), depth - stored, 1e-15);
  ContactStage part = after_euler;
  part.follows = true;
  EXPECT_NEAR(begun_in(part), depth - stored, 1e-15);
}

}  // namespace
}  // namespace godobject::test_four_at_a_time
