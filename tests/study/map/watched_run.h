// Runs a scene and records energy gain, divergence and distance.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/energy_balance.h"
#include "tests/study/map/sample.h"

namespace godobject::study {

/// Hand of the drawn scenes: moves all its targets as one rigid body, there and back, and rests in the second
/// half of the run.
struct Hand {
  Vec3 pivot = Vec3::Zero(), way = Vec3::Zero(), axis = Vec3::UnitZ();
  Real angle = 0, rate = 0;  // rad, rad/s

  /// Draws a hand with a peak speed of 0.01 to 5 m/s and a peak rate of 0.1 to 30 rad/s.
  static Hand drawn(Random& random, Real reach) {
    const Real speed = random.log_uniform(0.01, 5), length = reach * random.log_uniform(0.1, 1);
    const Real turn_rate = random.log_uniform(0.1, 30);
    return {.way = length * random.direction(),
            .axis = random.direction(),
            .angle = std::min(turn_rate * length / speed, pi / 2),
            .rate = speed / length};
  }
  /// Returns the target at time t that was X_WD at first. rests: the hand stays where it is at that time.
  Target at(const Pose& X_WD, Real t, bool rests) const {
    const Real s = 1 - std::cos(rate * t), s_dot = rests ? 0 : rate * std::sin(rate * t);
    const Quat turn = exp_so3(Vec3(angle * s * axis));
    const Vec3 r = turn * (X_WD.p - pivot), w = angle * s_dot * axis;
    return {.X_WD = {.p = pivot + s * way + r, .q = (turn * X_WD.q).normalized()},
            .V_WD = {.w = w, .v = s_dot * way + w.cross(r)}};
  }
};

/// Moves the targets of all engaged devices by a hand.
template <Scene S>
class HandMotion {
 public:
  HandMotion(Running<S>& run, const Hand& hand, int steps) : run_(run), hand_(hand), steps_(steps) {
    for (const auto& device : run.in.devices) starts_.push_back(device.target.X_WD);
  }
  void operator()(int n) {
    const bool rests = n >= steps_ / 2;
    const Real t = (std::min(n, steps_ / 2) + 1) * run_.par.h;
    for (std::size_t i = 0; i < starts_.size(); ++i)
      if (run_.in.devices[i].engaged) run_.in.devices[i].target = hand_.at(starts_[i], t, rests);
    run_.step();
  }

 private:
  Running<S>& run_;
  Hand hand_;
  int steps_;
  std::vector<Pose> starts_;
};

/// Records the drawn quantities that parameters and state show.
template <Scene S>
void describe(const Running<S>& run, MapSample& sample) {
  const auto& par = run.par;
  sample.step = par.h;
  Real lightest = std::numeric_limits<Real>::infinity(), heaviest = 0;
  const auto weigh = [&](Real m) { lightest = std::min(lightest, m), heaviest = std::max(heaviest, m); };
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const Real m = par.bodies[i].body.m;
    weigh(m);
    sample.spin = std::max(sample.spin, run.x.bodies[i].x.w_B.norm());
    if constexpr (uses<typename S::Coupling>) {
      const SpringParams& spring = par.bodies[i].coupling;
      sample.coupling = std::max(sample.coupling, spring.k);
      if (spring.k > 0) sample.damping = std::max(sample.damping, spring.g / std::sqrt(m * spring.k));
    }
  }
  if constexpr (uses<NetOf<S>>)
    for (std::size_t n = 0; n < par.net.num_nodes; ++n) weigh(par.net.nodes[n].m);
  sample.mass_ratio = heaviest / lightest;
  if constexpr (uses<ContactsOf<S>>)
    if (par.contacts.num_surfaces > 0) sample.contact = par.contacts.laws[0][0].k;
}

/// Positions of bodies and nodes, m.
template <Scene S>
std::vector<Vec3> places(const Running<S>& run) {
  std::vector<Vec3> all;
  for (std::size_t i = 0; i < num_bodies(run.par); ++i) all.push_back(run.x.bodies[i].x.X_WB.p);
  if constexpr (uses<NetOf<S>>)
    for (std::size_t n = 0; n < run.par.net.num_nodes; ++n) all.push_back(run.x.net.nodes[n].p_W);
  return all;
}

/// Returns the potential energy of gravity, J.
template <Scene S>
Real gravity_of(const Running<S>& run, const std::vector<Vec3>& places) {
  Real sum = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t bodies = num_bodies(run.par);
    Real m = 0;
    if (i < bodies) m = run.par.bodies[i].body.m;
    else if constexpr (uses<NetOf<S>>) m = run.par.net.nodes[i - bodies].m;
    sum -= m * run.par.gravity_W.dot(places[i]);
  }
  return sum;
}

/// Returns a bound of the gain that the balance ignores, J: rounding, net springs, and contacts that are
/// pushed out (35).
template <Scene S>
Real ignored_gain(const Running<S>& run, Real energy) {
  Real floor = gain_floor + rounding_share * std::abs(energy);
  if constexpr (uses<ContactsOf<S>>) {
    Real m = 0;
    for (std::size_t i = 0; i < num_bodies(run.par); ++i) m = std::max(m, run.par.bodies[i].body.m);
    auto num = static_cast<Real>(run.out.contacts.num_contacts);
    if constexpr (uses<NetOf<S>>) {
      num += static_cast<Real>(run.out.net.num_contacts);
      floor += net_gain_floor * net_spring_energy(run.par, run.x);
    }
    floor += num * push_out_energy(run.par.contacts.laws[0][0], m);
  }
  return floor;
}

/// Runs a scene up to a fault. advance(n): sets the inputs of step n and makes it.
template <Scene S, class Advance>
void watch(Running<S>& run, int steps, Advance&& advance, MapSample& sample) {
  describe(run, sample);
  if (const Invalid rule = validate(run.par); rule != Invalid::nothing)
    throw std::runtime_error("sample " + std::to_string(sample.number) + ": " + text_of(rule));
  EnergyBalance<S> balance;
  balance.start(run.par, run.x);
  const std::vector<Vec3> start = places(run);
  const Real first_gravity = gravity_of(run, start), first = balance.energy() - first_gravity;
  Real kinetic = 0, given = 0, gained = 0, at_work = 0;
  for (int n = 0; n < steps; ++n) {
    advance(n);
    sample.steps = n + 1;
    for (const auto& device : run.in.devices)
      if (device.engaged) sample.speed = std::max(sample.speed, device.target.V_WD.v.norm());
    sample.fault = static_cast<std::uint32_t>(run.out.fault);
    if (sample.fault != 0) break;
    balance.observe(run.par, run.x, run.w, run.out);
    const GainWatch& watch = balance.watch();
    sample.is_reported = sample.is_reported || watch.gains();
    gained = std::max(gained, watch.gained() - ignored_gain(run, balance.energy()));
    at_work = std::max(at_work, watch.at_work());
    const std::vector<Vec3> now = places(run);
    kinetic = std::max(kinetic, EnergyBalance<S>::kinetic(run.par, run.x));
    given = std::max(given, balance.energy() - balance.balance() + first_gravity - gravity_of(run, now));
    for (std::size_t i = 0; i < now.size(); ++i)
      sample.distance = std::max(sample.distance, (now[i] - start[i]).norm());
  }
  sample.gain = gained / std::max(at_work, gain_floor);
  sample.divergence = kinetic / std::max(first + given, gain_floor);
}

}  // namespace godobject::study
