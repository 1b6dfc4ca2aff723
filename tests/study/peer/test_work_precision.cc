#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "tests/study/peer/section.h"
#include "tests/study/peer/work_precision.h"

namespace godobject::study::test_work_precision {
namespace {

using Kind = Reading::Kind;

void expect(const Reading& reading, Kind kind, double value) {
  EXPECT_EQ(reading.kind, kind);
  EXPECT_NEAR(reading.value, value, 1e-9 * value);
}

/// Errors of order 2 over times of 1, 2 and 4.
WorkCurve second_order() { return WorkCurve({{4, 1e-4}, {1, 16e-4}, {2, 4e-4}}); }

TEST(WorkCurve, InterpolatesBetweenLogarithms) {
  expect(second_order().error_at(2), Kind::exact, 4e-4);
  expect(second_order().error_at(std::sqrt(2)), Kind::exact, 8e-4);
  expect(second_order().error_at(1), Kind::exact, 16e-4);
  expect(second_order().time_to(4e-4), Kind::exact, 2);
  expect(second_order().time_to(2e-4), Kind::exact, 2 * std::sqrt(2));
}

TEST(WorkCurve, BeyondItsEndsIsABoundOrNothing) {
  EXPECT_EQ(second_order().error_at(0.9).kind, Kind::none);
  expect(second_order().error_at(4), Kind::exact, 1e-4);
  expect(second_order().error_at(5), Kind::at_most, 1e-4);
  expect(second_order().time_to(20e-4), Kind::at_most, 1);
  expect(second_order().time_to(0.5e-4), Kind::at_least, 4);
}

TEST(WorkCurve, LeavesOutFailuresAndPointsThatAnotherBeats) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const WorkCurve curve({{1, infinite}, {2, 1e-3}, {3, 2e-3}, {4, 1e-3}, {8, 5e-4}, {NAN, 1e-9}, {16, 0}});
  ASSERT_EQ(curve.points().size(), 2u);
  expect(curve.error_at(3), Kind::exact, 1e-3 * std::pow(0.5, std::log(1.5) / std::log(4)));
  EXPECT_EQ(curve.error_at(1).kind, Kind::none);
}

TEST(WorkCurve, WithoutPointsHasNoReadings) {
  EXPECT_EQ(WorkCurve({}).error_at(1).kind, Kind::none);
  EXPECT_EQ(WorkCurve({}).time_to(1).kind, Kind::none);
}

/// Adds rows at 2, 1 and 0.5 ms of an engine whose step takes us microseconds.
void add(PeerResults& results, const char* engine, double error_at_1_ms, double order, double us) {
  for (const double h : {2e-3, 1e-3, 0.5e-3}) {
    const double error = error_at_1_ms * std::pow(h / 1e-3, order);
    results.errors.push_back({"S1", engine, h, error, 10 * error, {}, us});
  }
}

const WorkComparison& of(const std::vector<WorkComparison>& all, const std::string& integrator) {
  for (const WorkComparison& c : all)
    if (c.integrator == integrator && c.quantity == std::string("position")) return c;
  throw std::runtime_error("no comparison of " + integrator);
}

/// A peer of equal order and error that takes 2 us where ours takes 1.
TEST(WorkComparison, ComparesInEqualTimeAndToAnEqualError) {
  PeerResults results;
  add(results, "tr-bdf2", 1e-6, 2, 1);
  add(results, "peer", 1e-6, 2, 2);
  results.errors.push_back({"S1", "in WASM", 1e-3, 1e-12, 1e-12, 0.1});
  const std::vector<WorkComparison> all = compare_work(results);
  ASSERT_EQ(all.size(), 2u);  // position and rotation
  const WorkComparison& c = of(all, "tr-bdf2");
  expect(c.error_in_our_time.value().ratio, Kind::exact, 4);
  expect(c.error_in_its_time.value().ratio, Kind::exact, 4);
  expect(c.time_to_our_error.value().ratio, Kind::exact, 2);
  expect(c.time_to_its_error.value().ratio, Kind::exact, 2);
  EXPECT_EQ(c.error_in_our_time->engine, "peer");
  EXPECT_EQ(peers_better_in_equal_time(results), "");
}

/// The curves share neither a time nor an error.
TEST(WorkComparison, OfCurvesThatDoNotOverlapHasBounds) {
  PeerResults results;
  add(results, "tr-bdf2", 1e-9, 2, 0.1);
  add(results, "slow", 1e-3, 1, 100);
  const WorkComparison c = of(compare_work(results), "tr-bdf2");
  EXPECT_FALSE(c.error_in_our_time) << "it has no step so fast";
  expect(c.error_in_its_time.value().ratio, Kind::at_least, 1e-3 / 0.25e-9);
  expect(c.time_to_our_error.value().ratio, Kind::at_least, 2000);
  expect(c.time_to_its_error.value().ratio, Kind::at_least, 2000);
}

/// A lower bound below 1 leaves open which is better.
TEST(WorkComparison, OfABoundNamesNoWinner) {
  PeerResults results;
  add(results, "tr-bdf2", 1e-6, 2, 1);
  add(results, "accurate", 1e-9, 2, 100);
  const WorkComparison c = of(compare_work(results), "tr-bdf2");
  expect(c.error_in_its_time.value().ratio, Kind::at_least, 1e-9 / 0.25e-6);
  EXPECT_EQ(peers_better_in_equal_time(results).find("ours in its time"), std::string::npos);
}

TEST(WorkComparison, KeepsThePeerThatIsBestInEach) {
  PeerResults results;
  add(results, "implicit-euler", 1e-5, 1, 1);
  add(results, "accurate", 1e-6, 1, 4);
  add(results, "worse", 1e-4, 1, 1);
  const WorkComparison c = of(compare_work(results), "implicit-euler");
  EXPECT_EQ(c.error_in_our_time.value().engine, "worse") << "the other is not so fast";
  expect(c.error_in_our_time->ratio, Kind::exact, 10);
  EXPECT_EQ(c.time_to_our_error.value().engine, "accurate");
}

TEST(WorkComparison, PrefersAPeerThatReachesOurErrorToAFasterOne) {
  PeerResults results;
  add(results, "tr-bdf2", 1e-6, 2, 1);
  add(results, "inaccurate", 1e-3, 1, 0.5);
  add(results, "accurate", 1e-6, 2, 50);
  add(results, "inaccurate too", 1e-3, 1, 0.4);
  const WorkComparison c = of(compare_work(results), "tr-bdf2");
  EXPECT_EQ(c.time_to_our_error.value().engine, "accurate");
  expect(c.time_to_our_error->ratio, Kind::exact, 50);
}

TEST(WorkComparison, OfAFailedPeerIsLeftOut) {
  PeerResults results;
  add(results, "tr-bdf2", 1e-6, 2, 1);
  add(results, "failed", std::numeric_limits<double>::infinity(), 1, 1);
  const WorkComparison c = of(compare_work(results), "tr-bdf2");
  EXPECT_FALSE(c.error_in_our_time || c.error_in_its_time || c.time_to_our_error || c.time_to_its_error);
}

TEST(WorkSection, HasTheTableAndNamesTheEnginesThatAreMissing) {
  PeerResults results;
  results.missing = "Simbody (libsimbody-dev)";
  results.why_not = "node is not installed";
  results.machine = "a processor";
  add(results, "tr-bdf2", 1e-6, 2, 1);
  add(results, "peer", 1e-7, 2, 2);
  std::ostringstream text;
  write_peers(text, results);
  const std::string section = text.str();
  for (const char* part : {"Native engines not found by the build: Simbody (libsimbody-dev).",
                           "Engines in WASM are left out: node is not installed.",
                           "| S1 | tr-bdf2 | 0.4 (peer) | 0.4 (peer) | < 1 (peer) | < 1 (peer) |",
                           "| peer | 1e-07 | 1e-06 |", "of one run in interleaved rounds on a processor",
                           "- in equal native time or to an equal error: S1 than tr-bdf2 (peer"})
    EXPECT_NE(section.find(part), std::string::npos) << part << "\n" << section;
}

}  // namespace
}  // namespace godobject::study::test_work_precision
