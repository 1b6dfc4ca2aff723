// Copies the record of a period out of the loop on request.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "platform/session/session.h"
#include "platform/view/server/latest.h"

namespace godobject {

/// One period of a run, for the view.
struct ViewSample {
  CycleRecord record;
  RunPhase phase = RunPhase::off;
  bool missed_deadlines = false;  // latched
  RigCounters counters;
  Nanoseconds wake_ns = 0;            // longest wake-up latency since the previous sample
  std::vector<ContactView> touching;  // storage for all contacts; the first num_touching are valid
  std::size_t num_touching = 0;
  std::vector<Vec3> net_nodes{};  // positions of the nodes of all nets
};

/// The loop's end is real-time: one atomic load without a request, else a copy without allocation.
class ViewTap {
 public:
  explicit ViewTap(const Session& session) : latest_(like(session)) {}

  /// For the loop, after each period. record: record of the last step so far.
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
  /// For the loop, before each period.
  void woke(Nanoseconds latency) noexcept { wake_ns_ = std::max(wake_ns_, latency); }

  /// For the view's thread.
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
