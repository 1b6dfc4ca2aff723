// Streams of answers with a delay, as seen by receive stamps: the number of the last SYNC before each answer.
#include "hal/joint/answer_delay.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <set>

namespace godobject::test_answer_delay {
namespace {

constexpr std::uint64_t reach = 3;
constexpr std::uint64_t mark_distance = AnswerDelay::min_distance;

/// A host that leaves SYNCs out where it is wanted, and a node that answers every n-th of the others.
class Stream {
 public:
  explicit Stream(std::uint64_t n = 1) : Stream(n, n) {}
  /// declared: of which SYNCs the host expects an answer.
  Stream(std::uint64_t n, std::uint64_t declared) : every_nth(n), delay(declared, reach) {}

  /// late: of the answer to the SYNC of this cycle, periods. is_lost: the answer.
  void cycle(double late, bool is_lost = false) {
    ++sync;
    const std::uint64_t unsettled = std::max<std::uint64_t>(delay.num_inconclusive(), 1) - 1;
    const bool is_left_out =
        (last_mark == 0 || sync - 1 - last_mark >= mark_distance + unsettled * delay.longest()) &&
        delay.needs_mark(sync - 1);
    if (is_left_out) {
      ++marks;
      last_mark = sync;
      delay.left_out(sync, static_cast<Nanoseconds>(sync));
    } else if (++syncs_heard % every_nth == 0 && !is_lost) {
      const double arrives = static_cast<double>(sync) + late;
      arrivals.insert(std::max(arrives, last_arrival));  // in their order
      last_arrival = std::max(arrives, last_arrival);
    }
    while (!arrivals.empty() && *arrivals.begin() < static_cast<double>(sync + 1)) {
      const auto came = static_cast<std::uint64_t>(*arrivals.begin());
      arrivals.erase(arrivals.begin());
      if (came <= answered) delay.answered_again();
      else delay.answered(came, sync);
      answered = std::max(answered, came);
    }
  }
  void cycles(int count, double late) {
    for (int i = 0; i < count; ++i) cycle(late);
  }

  std::uint64_t every_nth;
  AnswerDelay delay;
  std::uint64_t sync = 0, syncs_heard = 0, answered = 0, last_mark = 0;
  int marks = 0;
  double last_arrival = 0;
  std::multiset<double> arrivals;
};

TEST(AnswerDelay, OneMarkIsEnoughWhereNothingIsLate) {
  Stream stream;
  stream.cycles(4, 0.3);
  EXPECT_FALSE(stream.delay.in_doubt());
  EXPECT_EQ(stream.delay.periods(), 0u);
  stream.cycles(10'000, 0.3);
  EXPECT_EQ(stream.marks, 1);
}

TEST(AnswerDelay, IsMeasuredInPeriods) {
  for (const std::uint64_t periods : {0u, 1u, 2u, 3u, 4u, 5u, 12u, 16u, 17u, 21u, 37u, 54u}) {
    Stream stream;
    stream.cycles(400, static_cast<double>(periods) + 0.4);
    EXPECT_EQ(stream.delay.periods(), std::min(periods, reach + 1));
    EXPECT_EQ(stream.delay.beyond_reach(), periods > reach);
    EXPECT_EQ(stream.delay.in_doubt(), periods > reach);
  }
}

TEST(AnswerDelay, GrowsAndShrinks) {
  Stream stream;
  for (const std::uint64_t periods : {0u, 2u, 1u, 3u, 9u, 0u, 17u, 0u}) {
    stream.cycles(400, static_cast<double>(periods) + 0.4);
    EXPECT_EQ(stream.delay.periods(), std::min(periods, reach + 1)) << periods;
  }
}

TEST(AnswerDelay, LostAnswersAreNoDelay) {
  for (const double share : {0.001, 0.01, 0.1, 0.3}) {
    std::mt19937 random(7);
    std::bernoulli_distribution lost(share);
    Stream stream;
    for (int i = 0; i < 100'000; ++i) {
      stream.cycle(0.3, lost(random));
      ASSERT_EQ(stream.delay.periods(), 0u) << share << ", cycle " << i;
    }
    EXPECT_LE(stream.marks, 1 + 100'000 / static_cast<int>(mark_distance));
  }
}

TEST(AnswerDelay, LostAnswersDoNotHideADelay) {
  std::mt19937 random(7);
  std::bernoulli_distribution lost(0.1);
  Stream stream;
  int beyond = 0;
  for (int i = 0; i < 20'000; ++i) {
    stream.cycle(9.3, lost(random));
    beyond += stream.delay.beyond_reach() ? 1 : 0;
  }
  EXPECT_GT(beyond, 10'000);
}

TEST(AnswerDelay, JitterBelowAPeriodIsSeldomTakenForMoreThanReach) {
  for (const double jitter : {0.5, 0.9}) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> late(0.2, 0.2 + jitter);
    Stream stream;
    int beyond = 0, longest = 0, in_a_row = 0;
    for (int i = 0; i < 100'000; ++i) {
      stream.cycle(late(random));
      in_a_row = stream.delay.beyond_reach() ? in_a_row + 1 : 0;
      longest = std::max(longest, in_a_row);
      beyond += stream.delay.beyond_reach() ? 1 : 0;
    }
    EXPECT_LT(beyond, 2'000) << jitter;
    EXPECT_LT(longest, 100) << jitter;
  }
}

TEST(AnswerDelay, OfNodesThatAnswerEveryNthSync) {
  for (const std::uint64_t n : {2u, 3u, 5u})
    for (const std::uint64_t periods : {0u, 1u, 3u, 12u}) {
      Stream stream(n);
      stream.cycles(400, static_cast<double>(periods) + 0.4);
      const std::uint64_t shown = stream.delay.periods();
      EXPECT_LE(shown, std::min(periods, reach + 1)) << n << ", " << periods;
      EXPECT_GE(shown + n - 1, std::min(periods, reach)) << n << ", " << periods;
      EXPECT_EQ(stream.delay.beyond_reach(), periods > reach + n) << n << ", " << periods;
      if (periods > 0) continue;
      EXPECT_EQ(stream.marks, 1) << n;
    }
}

TEST(AnswerDelay, OfNodesThatAnswerMoreSyncsThanDeclared) {
  for (const std::uint64_t periods : {0u, 1u, 3u, 12u}) {
    Stream stream(1, 3);
    stream.cycles(400, static_cast<double>(periods) + 0.4);
    EXPECT_EQ(stream.delay.beyond_reach(), periods > reach) << periods;
    EXPECT_EQ(stream.delay.in_doubt(), periods > reach) << periods;
    if (periods > 0) continue;
    EXPECT_EQ(stream.marks, 1);
  }
}

}  // namespace
}  // namespace godobject::test_answer_delay
