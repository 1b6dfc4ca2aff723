// What leaves the loop for those who look on: a copy of the record of a period, when it was asked for.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "platform/session/session.h"
#include "platform/view/server/latest.h"

namespace godobject {

/// One period of a run, as a view shows it.
struct ViewSample {
  CycleRecord record;
  RunPhase phase = RunPhase::off;
  bool missed_deadlines = false;  // for good
  RigCounters counters;
  Nanoseconds wake_ns = 0;            // the longest since the sample before
  std::vector<ContactView> touching;  // with room for all; the first num_touching are
  std::size_t num_touching = 0;
  std::vector<Vec3> net_nodes{};  // all of them
};

/// The loop's end is real-time: a load where nothing is asked for, else a copy without allocation.
class ViewTap {
 public:
  explicit ViewTap(const Session& session) : latest_(like(session)) {}

  /// The loop, after each period. record: of the last step so far.
  void offer(const Session& session, const CycleRecord& record) noexcept {
    if (!latest_.wanted()) return;
    ViewSample& sample = latest_.slot();
    sample.record = record;
    sample.phase = session.phase();
    sample.missed_deadlines = session.missed_deadlines();
    sample.counters = session.rig_counters();
    sample.wake_ns = std::exchange(wake_ns_, 0);
    sample.num_touching = session.engine().contacts(sample.touching);
    session.engine().net_nodes(sample.net_nodes);
    latest_.give();
  }
  /// The loop, before each period.
  void woke(Nanoseconds latency) noexcept { wake_ns_ = std::max(wake_ns_, latency); }

  /// The view's end.
  void ask() noexcept { latest_.ask(); }
  const ViewSample* get() const noexcept { return latest_.get(); }

 private:
  static ViewSample like(const Session& session) {
    ViewSample sample{.record = session.at_start(), .counters = {}, .touching = {}};
    sample.touching.resize(session.engine().composition().all_contacts());
    sample.net_nodes.resize(session.engine().nets().nodes.size());
    return sample;
  }

  Latest<ViewSample> latest_;
  Nanoseconds wake_ns_ = 0;
};

}  // namespace godobject
