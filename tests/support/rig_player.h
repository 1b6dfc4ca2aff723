// Device end of the cables: a simulated rig in wall-clock time, on its own thread.
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

#include "platform/rt/cyclic.h"
#include "platform/simulated/session.h"
#include "sim/rig/rig.h"
#include "tests/support/cable.h"

namespace godobject::test {

/// Runs from the constructor to the destructor or stop(); read the logs after that.
class RigPlayer {
 public:
  /// on_sync: called on the player's thread with the number of SYNCs on bus 0 so far.
  RigPlayer(const SceneConfig& scene, const Motion& motion,
            std::function<void(RigPlayer&, std::uint64_t)> on_sync = {})
      : rig_(sim_rig_config(scene), scene.step, hand_of(motion)),
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
  /// Time scale: its time is slowed down, so that a stalling machine does not miss the drives' deadlines.
  static constexpr Nanoseconds slowness = 4;

  void run() {
    // real-time priority, if permitted: a device answers in time on a busy machine; drives have watchdogs
    const sched_param priority{.sched_priority = 70};
    static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority));
    const MonotonicClock clock;
    const Nanoseconds start = clock.now();
    while (!stop_) {
      const Nanoseconds now = (clock.now() - start) / slowness;
      // first, because a frame put on an idle wire begins at the time of the last run_wires()
      rig_.run_wires(now);
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
