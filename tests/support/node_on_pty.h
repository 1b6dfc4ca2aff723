// A simulated node behind a pseudo-terminal, run on its own thread like another program.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "hal/canopen/canopen.h"
#include "platform/linux/bus/slcan.h"
#include "platform/rt/cyclic.h"
#include "tests/support/program.h"

namespace godobject::test {

template <class Node>
class NodeOnPty {
 public:
  explicit NodeOnPty(const std::function<std::unique_ptr<Node>(CanBus&)>& make) {
    EXPECT_TRUE(bus_.open());
    name_ = bus_.name();
    node_ = make(bus_);
  }
  ~NodeOnPty() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  const std::string& name() const { return name_; }

  /// Calls a function on the calling thread, while the node is paused.
  template <class Function>
  auto call(const Function& function) {
    const std::lock_guard lock(mutex_);
    return function(*node_);
  }
  /// Waits until the condition holds; returns false after ten seconds.
  bool wait_until(const std::function<bool(Node&)>& condition) {
    constexpr int attempts = 1000;
    for (int i = 0; i < attempts && !call(condition); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return call(condition);
  }
  void call_once_when(std::function<bool(Node&)> condition, std::function<void(Node&)> function) {
    const std::lock_guard lock(mutex_);
    condition_ = std::move(condition);
    function_ = std::move(function);
  }
  /// Sends SYNCs, as the host of the bus would.
  void send_syncs(bool on) { syncs_ = on; }
  /// Silences the node: from now on it neither receives nor sends.
  void silence() { silent_ = true; }

 protected:
  /// move: mechanics, called with the time since the last call, s, at most 1 ms.
  void start(std::function<void(Node&, double)> move) {
    thread_ = std::thread([this, move = std::move(move)] {
      for (Nanoseconds t_last_ns = MonotonicClock().now(); !stop_;) {
        const Nanoseconds now = MonotonicClock().now();
        step(now, 1e-9 * static_cast<double>(now - t_last_ns), move);
        t_last_ns = now;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
    // The node boots when its bus first accepts a frame; frames before that are lost to it.
    static_cast<void>(run_program("sdo --bus slcan:" + name_ + " --node 1 --timeout 0.1 read 1000"));
  }

 private:
  static constexpr double longest_step = 1e-3;  // s, of the mechanics, independent of delays of this thread

  void step(Nanoseconds now, double dt, const std::function<void(Node&, double)>& move) {
    const std::lock_guard lock(mutex_);
    if (silent_)
      for (ReceivedFrame lost; bus_.try_receive(lost);) continue;
    else node_->poll(now);
    for (; dt > 0; dt -= longest_step) move(*node_, std::min(dt, longest_step));
    if (syncs_) static_cast<void>(bus_.try_send(canopen::make_sync()));
    if (!condition_ || !condition_(*node_)) return;
    condition_ = nullptr;
    function_(*node_);
  }

  PtyBus bus_{BusSettings{}};
  std::unique_ptr<Node> node_;
  std::string name_;
  std::function<bool(Node&)> condition_;
  std::function<void(Node&)> function_;
  std::atomic<bool> stop_ = false, syncs_ = false, silent_ = false;
  std::mutex mutex_;
  std::thread thread_;
};

}  // namespace godobject::test
