#include "tests/study/random_study.h"

#include <cmath>

#include "tests/core/one_body.h"
#include "tests/oracle/target.h"
#include "tests/study/compositions.h"
#include "tests/study/csv_writer.h"
#include "tests/study/joint/scene.h"
#include "tests/study/short_steps.h"

namespace godobject::study {
namespace {

// s, a multiple of the comparison step; longer runs of chains and tops diverge from equal starts
constexpr double duration = 0.252;

/// Returns a rod of 10 to 40 cm length and 4 to 40 mm diameter, coupled like an instrument.
oracle::Body rod(Random& random) {
  oracle::Body body;
  body.name = "tool";
  body.m = random.log_uniform(0.02, 1);
  const double length = random.uniform(0.1, 0.4), r = random.log_uniform(2e-3, 2e-2);
  const double I_t = body.m * (length * length / 12 + r * r / 4), I_a = body.m * r * r / 2;
  body.I_B = Vec3(I_t, I_t, I_a).asDiagonal();
  const double k = random.log_uniform(300, 5000), k_r = random.log_uniform(0.2, 5);
  body.coupling = {.k_t = k,
                   .g_t = random.uniform(1.4, 2) * std::sqrt(body.m * k),
                   .k_r = k_r,
                   .g_r = random.uniform(1.4, 2) * std::sqrt(I_t * k_r)};
  return body;
}

/// Returns a rod released towards a target up to 10 cm and 2.5 rad away.
oracle::Case released(Random& random) {
  oracle::Case problem;
  oracle::Body body = rod(random);
  oracle::RigidState target;
  target.p = random.uniform(0.02, 0.1) * random.direction();
  target.q = Eigen::AngleAxisd(random.uniform(0.5, 2.5), random.direction());
  body.coupling->target = std::make_shared<oracle::FunctionTarget>([target](double) { return target; });
  problem.bodies = {body};
  return problem;
}

/// Returns a rod with a target that oscillates in translation and rotation, up to 2 Hz.
oracle::Case led(Random& random) {
  oracle::Case problem;
  oracle::Body body = rod(random);
  const Vec3 way = random.log_uniform(0.01, 0.1) * random.direction(), axis = random.direction();
  const double rate = 2 * pi * random.uniform(0.5, 2), turn_rate = 2 * pi * random.uniform(0.5, 2),
               angle = random.uniform(0.2, 1.2);
  body.coupling->target = std::make_shared<oracle::FunctionTarget>([=](double t) {
    oracle::RigidState D;
    D.p = std::sin(rate * t) * way;
    D.v = rate * std::cos(rate * t) * way;
    D.q = Eigen::AngleAxisd(angle * std::sin(turn_rate * t), axis);
    D.w = angle * turn_rate * std::cos(turn_rate * t) * axis;
    return D;
  });
  body.start = body.coupling->target->at(0);
  problem.bodies = {body};
  return problem;
}

/// Rotates all bodies about the origin, the place of the first joint.
void turn(oracle::Case& problem, const oracle::Quaterniond& q) {
  for (oracle::Body& body : problem.bodies) {
    body.start.p = q * body.start.p;
    body.start.q = q * body.start.q;
  }
}

oracle::Case chain(Random& random) {
  oracle::Case problem = scene_s5(static_cast<std::size_t>(random.integer(2, 5)));
  turn(problem, oracle::Quaterniond(random.rotation()));
  const double ratio = random.log_uniform(1, 100);
  problem.bodies.back().m *= ratio;
  problem.bodies.back().I_B *= ratio;
  return problem;
}

oracle::Case top(Random& random) {
  oracle::Case problem = scene_s5(1);
  turn(problem, oracle::Quaterniond(random.rotation()));
  oracle::Body& body = problem.bodies.front();
  const double moment = random.log_uniform(2e-5, 5e-4);
  body.I_B = Vec3(moment, moment, random.uniform(0.3, 1.9) * moment).asDiagonal();
  body.start.w = random.log_uniform(10, 200) * (body.start.q * oracle::Vector3d::UnitZ());
  body.start.v = body.start.w.cross(body.start.p);
  return problem;
}

template <class I, class F>
auto with_kind(const std::string& kind, F f) {
  if (kind == "released" || kind == "led") return f.template operator()<Follower<I, 1>>();
  return f.template operator()<FreeJoints<I, 8>>();
}

template <class I>
Errors errors_at(const ReferenceScene& scene, const oracle::Solution& reference, double h) {
  return with_kind<I>(scene.name, [&]<Scene S>() {
    CaseRun<S> run(scene.problem, h);
    return compare(scene, reference, run, h);
  });
}

}  // namespace

std::vector<std::string> random_kinds() { return {"released", "led", "chain", "top"}; }

ReferenceScene random_scene(const std::string& kind, unsigned seed) {
  Random random(seed);
  ReferenceScene scene{.name = kind, .about = "drawn at random", .problem = {}, .duration = duration};
  scene.problem = kind == "released" ? released(random)
                  : kind == "led"    ? led(random)
                  : kind == "chain"  ? chain(random)
                                     : top(random);
  return scene;
}

std::vector<RandomRow> study_random(bool quick, const Progress& progress) {
  constexpr std::size_t steps_between = 256;  // steps per comparison interval: 1/64 ms
  const std::vector<double> times = oracle::uniform_times(duration, comparison_step);
  std::vector<RandomRow> rows;
  for (const std::string& kind : random_kinds()) {
    progress("error: drawn at random, " + kind);
    for (unsigned seed = 0; seed < (quick ? 3U : 100U); ++seed) {
      const ReferenceScene scene = random_scene(kind, seed);
      const oracle::Solution reference = with_kind<TrBdf2>(
          kind, [&]<Scene S>() { return by_short_steps<S>(scene.problem, times, steps_between, duration); });
      const Errors second = errors_at<TrBdf2>(scene, reference, 1e-3),
                   first = errors_at<ImplicitEuler>(scene, reference, 0.125e-3);
      rows.push_back({.scene = kind,
                      .seed = seed,
                      .position = second.position / first.position,
                      .rotation = second.rotation / first.rotation});
    }
  }
  return rows;
}

void write_csv(const std::filesystem::path& file, const std::vector<RandomRow>& rows) {
  CsvWriter csv(file, "scene,seed,position_error_ratio,rotation_error_ratio");
  for (const RandomRow& r : rows) csv.row(r.scene, r.seed, r.position, r.rotation);
}

}  // namespace godobject::study
