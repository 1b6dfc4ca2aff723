// The device's end of the cables: a simulated rig in wall time, on a thread of its own.
#pragma once

#include <pthread.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <thread>
#include <vector>

#include "platform/rt/clock.h"
#include "platform/simulated/session.h"
#include "sim/rig/rig.h"
#include "tests/support/cable.h"

namespace godobject::test {

/// Begins with the constructor, ends with the destructor or stop(); the logs are to be read after that.
class RigPlayer {
 public:
  /// on_sync: called on the player's thread with the number of SYNCs seen on bus 0 so far.
  RigPlayer(const SceneConfig& scene, const Motion& motion,
            std::function<void(RigPlayer&, std::uint64_t)> on_sync = {})
      : rig_(sim_rig_config(scene), hand_of(motion)),
        cables(rig_.host_buses().size()),
        on_sync_(std::move(on_sync)) {
    got.resize(cables.size());
    sent.resize(cables.size());
    thread_ = std::thread([this] { run(); });
  }
  ~RigPlayer() { stop(); }
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  SimRig rig_;

 public:
  std::vector<Cable> cables;                     // one per bus
  std::vector<std::vector<CanFrame>> got, sent;  // per bus, in order

 private:
  /// Its time passes slowly: the deadlines of its drives are not to be missed by a machine that stalls.
  static constexpr Nanoseconds slowness = 4;

  void run() {
    // A device answers in time however busy the machine is, where that may be asked for: drives have watchdogs.
    const sched_param priority{.sched_priority = 70};
    static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority));
    const MonotonicClock clock;
    const Nanoseconds start = clock.now();
    while (!stop_) {
      const Nanoseconds now = (clock.now() - start) / slowness;
      rig_.run_wires(now);  // first: a frame that is put on an idle wire begins when the wire was run last
      for (std::size_t i = 0; i < cables.size(); ++i) take(i);
      rig_.run_plant(now, 1e-9 * static_cast<double>(now));
      for (std::size_t i = 0; i < cables.size(); ++i) give(i, start);
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
  }
  void take(std::size_t i) {
    CanFrame frame;
    while (cables[i].far_fd() >= 0 && recv(cables[i].far_fd(), &frame, sizeof frame, 0) == sizeof frame) {
      static_cast<void>(rig_.host_buses()[i]->try_send(frame));
      got[i].push_back(frame);
      if (i == 0 && frame.id == 0x080 && on_sync_) on_sync_(*this, ++syncs_);
    }
  }
  void give(std::size_t i, Nanoseconds start) {
    for (ReceivedFrame received; rig_.host_buses()[i]->try_receive(received);) {
      received.t_ns = start + slowness * received.t_ns;
      const int fd = cables[i].far_fd();
      if (fd >= 0 && ::send(fd, &received, sizeof received, MSG_NOSIGNAL) == sizeof received)
        sent[i].push_back(received.frame);
    }
  }

  std::function<void(RigPlayer&, std::uint64_t)> on_sync_;
  std::uint64_t syncs_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace godobject::test
