#include "hal/tracker/pose_track.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "tests/support/pose_recordings.h"

namespace godobject::test_pose_track {
namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr Nanoseconds start = 1'000'000'000;

/// Methods of making a target from late samples, for the table of docs/decisions/020-tracker-poses.md.
struct Way {
  virtual ~Way() = default;
  virtual void push(const Pose& X, Nanoseconds t, Nanoseconds now) = 0;
  virtual Target at(Nanoseconds now) = 0;
};

struct Hold : Way {
  void push(const Pose& X, Nanoseconds, Nanoseconds) override { held.X_WD = X; }
  Target at(Nanoseconds) override { return held; }
  Target held;
};

/// Extrapolates the last two samples, for at most 0.1 s.
struct Extrapolate : Way {
  void push(const Pose& X, Nanoseconds t, Nanoseconds) override {
    if (started) last.V_WD.v = (X.p - last.X_WD.p) / (1e-9 * static_cast<double>(t - t_last));
    last.X_WD = X;
    t_last = t;
    started = true;
  }
  Target at(Nanoseconds now) override {
    Target target = last;
    target.X_WD.p += std::min(1e-9 * static_cast<double>(now - t_last), 0.1) * last.V_WD.v;
    return target;
  }
  Target last;
  Nanoseconds t_last = 0;
  bool started = false;
};

/// As Extrapolate, but reaches each new prediction by a cubic over one period.
struct BlendedExtrapolation : Extrapolate {
  void push(const Pose& X, Nanoseconds t, Nanoseconds now) override {
    from = at(now);
    const bool first = !started;
    if (!first) period = t - t_last;
    Extrapolate::push(X, t, now);
    begin = now;
    to = Extrapolate::at(now + period);
    if (first) from = to;
  }
  Target at(Nanoseconds now) override {
    const double s = static_cast<double>(now - begin) / static_cast<double>(period);
    if (s > 1) return Extrapolate::at(now);
    return interpolated<Real>(from, to, s, 1e-9 * static_cast<double>(period));
  }
  Target from, to;
  Nanoseconds begin = 0, period = 10 * ms;
};

struct Playback : Way {
  void push(const Pose& X, Nanoseconds t, Nanoseconds now) override { track.push(X, t, now); }
  Target at(Nanoseconds now) override { return track.at(now).target; }
  PoseTrack track{500 * ms};
};

struct Quality {
  double range_N = 0;        // of the force along the true path
  double stair_percent = 0;  // largest change of the force in a step, as a share of that range
  double stair_99_N = 0;     // 99th percentile of the changes
  double true_stair_percent = 0;
  double error_mm = 0;  // rms, against the present pose of the hand
  double lag_ms = 0;    // the same, at the rms speed of the hand
};

/// Measures with the coupling of the demo's tool, which is fixed: 1000 N/m and 28 N s/m. Samples arrive 10 ms
/// after they were taken, +-2 ms.
Quality measure(const test::Recording& hand, Way& way) {
  const auto force = [](const Target& t) -> Vec3 { return 1000 * t.X_WD.p + 28 * t.V_WD.v; };
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(-0.002, 0.002);
  double t_sample = 0.5 / hand.rate_hz, t_known = t_sample + 0.01;
  Vec3 last = Vec3::Zero(), true_last = Vec3::Zero(), low = Vec3::Constant(1e9), high = -low;
  std::vector<double> stairs;
  double true_stair = 0, error_sq = 0, speed_sq = 0;
  for (double t = 0; t < hand.duration() - 0.01; t += 1e-3) {
    const Nanoseconds now = start + std::llround(1e9 * t);
    for (; t_known <= t; t_known = t_sample + 0.01 + jitter(random)) {
      way.push(hand.at(t_sample).X_WD, start + std::llround(1e9 * t_sample), now);
      t_sample += 1 / hand.rate_hz;
    }
    const Target played = way.at(now), truth = hand.at(t);
    const Vec3 f = force(played), true_f = force(truth);
    if (t > 1) {
      stairs.push_back((f - last).norm());
      true_stair = std::max(true_stair, (true_f - true_last).norm());
      error_sq += (played.X_WD.p - truth.X_WD.p).squaredNorm();
      speed_sq += truth.V_WD.v.squaredNorm();
      low = low.cwiseMin(true_f);
      high = high.cwiseMax(true_f);
    }
    last = f;
    true_last = true_f;
  }
  std::ranges::sort(stairs);
  const auto n = static_cast<double>(stairs.size());
  Quality q{.range_N = (high - low).norm()};
  q.stair_percent = 100 * stairs.back() / q.range_N;
  q.true_stair_percent = 100 * true_stair / q.range_N;
  q.stair_99_N = stairs[stairs.size() * 99 / 100];
  q.error_mm = 1e3 * std::sqrt(error_sq / n);
  q.lag_ms = 1e3 * std::sqrt(error_sq / speed_sq);
  return q;
}

/// Prints the table of the decision, row by row, and checks its conclusions.
TEST(PoseTrack, ForceWithoutStairsOnRecordedHands) {
  if (test::shared_file("data/plus_tracker").empty()) GTEST_SKIP() << "no recorded poses";
  for (const test::Recording& hand :
       {test::read_plus_stylus(), test::read_polaris(), test::read_fastrak(), test::read_desk()}) {
    ASSERT_GT(hand.poses.size(), 200u) << hand.name;
    Hold hold;
    Extrapolate extrapolate;
    BlendedExtrapolation blended;
    Playback playback;
    const std::array<std::pair<const char*, Way*>, 4> ways{
        {{"hold", &hold}, {"extrapolate", &extrapolate}, {"blended", &blended}, {"playback", &playback}}};
    std::array<Quality, 4> q;
    for (std::size_t i = 0; i < ways.size(); ++i) {
      q[i] = measure(hand, *ways[i].second);
      std::printf("| %s, %g Hz | %s | %.2f %% | %.3f | %.2f | %.0f |\n", hand.name.c_str(), hand.rate_hz,
                  ways[i].first, q[i].stair_percent, q[i].stair_99_N, q[i].error_mm, q[i].lag_ms);
    }
    for (std::size_t rival = 0; rival < 3; ++rival) {
      EXPECT_LT(q[3].stair_percent, q[rival].stair_percent / 2) << hand.name << " " << ways[rival].first;
      EXPECT_LT(q[3].stair_99_N, q[rival].stair_99_N) << hand.name << " " << ways[rival].first;
    }
    // About one and a half periods, plus the delay of the samples.
    EXPECT_LT(playback.track.delay(), start * 2 / static_cast<Nanoseconds>(hand.rate_hz) + 14 * ms)
        << hand.name;
    EXPECT_LT(q[3].stair_percent, 1) << hand.name;
  }
}

Pose turning(double t) {
  const double angle = 0.8 * std::sin(2 * t);
  return {.p = Vec3(0.1 * std::sin(3 * t), 0, 0.05 * t),
          .q = Quat(std::cos(angle / 2), 0, 0, std::sin(angle / 2))};
}

/// Samples at 60 Hz, delayed by `late`, up to `until`; played at 1 kHz.
struct Replay {
  explicit Replay(Nanoseconds stale_after = 100 * ms) : track(stale_after) {}

  PoseTrack::Played step() {
    now += ms;
    for (; t_sample + late <= now; t_sample += 16'666'667) {
      const double t = 1e-9 * static_cast<double>(t_sample);
      const Pose X = turning(t);
      // The sign of a tracker's quaternion has no meaning.
      const Quat q = ++count % 2 == 0 ? X.q : Quat(-X.q.w(), -X.q.x(), -X.q.y(), -X.q.z());
      if (t_sample < until) track.push({.p = X.p, .q = q}, t_sample, now);
    }
    return track.at(now);
  }

  PoseTrack track;
  Nanoseconds now = start, t_sample = start, late = 10 * ms, until = 1000 * start;
  int count = 0;
};

TEST(PoseTrack, PoseAndTwistAreThoseOfThePathSomewhatEarlier) {
  Replay run;
  for (int i = 0; i < 4000; ++i) {
    const PoseTrack::Played played = run.step();
    if (i < 500) continue;
    ASSERT_TRUE(played.valid);
    const double t = 1e-9 * static_cast<double>(run.now - run.track.delay());
    EXPECT_LT((played.target.X_WD.p - turning(t).p).norm(), 1e-4);
    EXPECT_LT(played.target.X_WD.q.angularDistance(turning(t).q), 1e-3);
    EXPECT_NEAR(played.target.V_WD.v.x(), 0.3 * std::cos(3 * t), 0.01);
    EXPECT_NEAR(played.target.V_WD.w.z(), 1.6 * std::cos(2 * t), 0.03);
  }
  EXPECT_LT(run.track.delay(), 40 * ms);
  EXPECT_EQ(run.track.late(), 0u);
}

TEST(PoseTrack, NeitherPoseNorTwistJumps) {
  Replay run;
  PoseTrack::Played last;
  std::uint64_t late = 0;
  for (int i = 0; i < 6000; ++i) {
    run.late = i > 3000 ? 24 * ms : 10 * ms;  // from now on later
    const PoseTrack::Played played = run.step();
    if (i == 4500) late = run.track.late();
    if (i > 500 && i < 2900) {
      EXPECT_LT((played.target.V_WD.v - last.target.V_WD.v).norm(), 4e-3);
      EXPECT_LT((played.target.V_WD.w - last.target.V_WD.w).norm(), 2e-2);
    }
    if (i > 500) {
      // While the track adapts to the longer delay the target stops and catches up; the speed is 0.3 m/s.
      EXPECT_LT((played.target.X_WD.p - last.target.X_WD.p).norm(), 2e-3);
      EXPECT_LT(played.target.X_WD.q.angularDistance(last.target.X_WD.q), 1e-2);
    }
    last = played;
  }
  EXPECT_EQ(run.track.late(), late) << "it has learnt";
}

TEST(PoseTrack, ComesToRestThenIsNotValid) {
  Replay run;
  run.until = start + 2000 * ms;
  PoseTrack::Played played, before;
  for (int i = 0; i < 2080; ++i) {
    before = played;
    played = run.step();
    if (i > 500) {
      EXPECT_LT((played.target.X_WD.p - before.target.X_WD.p).norm(), 1e-3);
    }
  }
  EXPECT_TRUE(played.valid);
  EXPECT_EQ(played.target.V_WD.v.norm(), 0) << "at rest before it is stale";
  for (int i = 0; i < 40; ++i) played = run.step();
  EXPECT_FALSE(played.valid);
  EXPECT_GT(played.age, 100 * ms);
  EXPECT_EQ(played.target.V_WD.v.norm(), 0);
}

TEST(PoseTrack, RestartsAfterAGap) {
  Replay run;
  run.until = start + 1000 * ms;
  for (int i = 0; i < 1500; ++i) static_cast<void>(run.step());
  run.until = 1000 * start;
  int steps = 0;
  while (!run.step().valid && steps < 500) ++steps;
  EXPECT_GT(steps, 45) << "four samples first";
  EXPECT_LT(steps, 80);
  const double t = 1e-9 * static_cast<double>(run.now - run.track.delay());
  EXPECT_LT((run.track.at(run.now).target.X_WD.p - turning(t).p).norm(), 1e-3);
}

TEST(PoseTrack, SamplesOutOfOrderAreIgnored) {
  PoseTrack track(100 * ms);
  EXPECT_FALSE(track.at(0).valid);
  for (int i = 0; i < 10; ++i) track.push(turning(0.01 * i), i * (10 * ms), i * (10 * ms));
  const Pose far{.p = Vec3(9, 9, 9), .q = Quat::Identity()};
  track.push(far, 50 * ms, 100 * ms);
  track.push(far, 90 * ms, 100 * ms);
  EXPECT_LT(track.at(101 * ms).target.X_WD.p.norm(), 0.2);
}

}  // namespace
}  // namespace godobject::test_pose_track
