// The buses of a simulated rig, through the kernel. Each is a virtual CAN interface with the host at one
// socket and the rig's wire at another.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "hal/rig/link.h"
#include "platform/rig/buses.h"
#include "sim/rig/rig.h"
#include "tests/socketcan/can_test.h"

namespace godobject::test {

/// Bus time advances only after one end has received all frames that the other passed to the kernel. However
/// slow the machine is, a frame is late or lost only by the simulated wire.
class VcanBus final : public CanBus {
 public:
  /// Makes the interface; requires root. wire: the host's port on the simulated wire.
  VcanBus(std::string interface, SimCanPort& wire, const std::vector<CanFilter>& filters)
      : interface_(std::move(interface)),
        wire_(wire),
        filters_(filters),
        host_(interface_, {.filters = filters}),
        device_(interface_, {}) {
    plug_in();
  }
  ~VcanBus() override { unplug(); }

  // Host's end; its stamps are those of the simulated wire, because the kernel's are of wall time.
  [[nodiscard]] bool open() noexcept override { return host_.open(); }
  void close() noexcept override { host_.close(); }
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override {
    const SendResult result = host_.try_send(frame);
    if (result == SendResult::queued) ++to_device_;
    return result;
  }
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override {
    if (to_host_.empty()) return false;
    const Nanoseconds t_wire_ns = to_host_.front();
    to_host_.pop_front();
    const std::optional<ReceivedFrame> received = receive(host_);
    EXPECT_TRUE(received) << interface_ << ": a frame for the host did not arrive";
    if (!received) return false;
    out = {.frame = received->frame, .t_ns = t_wire_ns};
    return true;
  }
  BusState state() const noexcept override { return host_.state(); }
  BusCounters counters() const noexcept override { return host_.counters(); }

  /// Passes frames of the host to the wire.
  void carry_out() {
    for (; to_device_ > 0; --to_device_) {
      const std::optional<ReceivedFrame> received = receive(device_);
      EXPECT_TRUE(received) << interface_ << ": a frame for the device did not arrive";
      if (received) static_cast<void>(wire_.try_send(received->frame));
    }
  }
  /// Passes frames from the wire to the host; drops them if the interface is down or gone.
  void carry_in() {
    for (ReceivedFrame received; wire_.try_receive(received);) {
      const SendResult result = device_.try_send(received.frame);
      EXPECT_TRUE(result == SendResult::queued || result == SendResult::down) << device_.trouble();
      if (result == SendResult::queued && passes(filters_, received.frame)) to_host_.push_back(received.t_ns);
    }
  }
  /// Reads the host's own frames that the kernel returned, once it has read all others.
  void confirm() {
    if (!to_host_.empty()) return;
    ReceivedFrame unexpected;
    EXPECT_FALSE(host_.try_receive(unexpected)) << interface_;
  }

  void set(const std::string& what) { run("ip link set " + interface_ + " " + what); }
  void unplug() { run("ip link delete " + interface_); }
  void plug_in() {
    run("ip link add dev " + interface_ + " type vcan && ip link set " + interface_ + " up");
    for (SocketCanBus* bus : {&host_, &device_}) {
      bus->close();
      EXPECT_TRUE(bus->open()) << bus->trouble();
    }
  }

 private:
  std::string interface_;
  SimCanPort& wire_;
  std::vector<CanFilter> filters_;  // of the host: the kernel drops other frames
  SocketCanBus host_, device_;
  std::size_t to_device_ = 0;        // frames that the kernel holds for the device
  std::deque<Nanoseconds> to_host_;  // frames that the kernel holds for the host, by their time of completion
                                     // on the wire
};

/// A link with the time of a SimLink.
class VcanLink final : public RigLink {
 public:
  VcanLink(const SimRigConfig& config, double cycle_s, std::shared_ptr<const Hand> hand, Nanoseconds poll,
           const RigProfiles& profiles)
      : rig_(config, cycle_s, std::move(hand), profiles), period_ns_(to_ns(cycle_s)), poll_ns_(poll) {
    const std::vector<std::vector<CanFilter>> filters = rig_filters(config.rig);
    for (std::size_t i = 0; i < filters.size(); ++i) {
      vcans_.push_back(
          std::make_unique<VcanBus>("vcanlink" + std::to_string(i), rig_.host_port(i), filters[i]));
      buses_.push_back(vcans_.back().get());
    }
  }

  std::span<CanBus* const> buses() noexcept override { return buses_; }
  Nanoseconds begin_cycle(double motion_time) noexcept override {
    t_cycle_ns_ += period_ns_;
    run_wires(t_cycle_ns_ - 1);
    rig_.run_plant(t_cycle_ns_, motion_time);
    for (const auto& vcan : vcans_) vcan->confirm();
    return t_now_ns_ = t_cycle_ns_;
  }
  Nanoseconds wait(Nanoseconds until) noexcept override {
    t_now_ns_ = std::min(t_now_ns_ + poll_ns_, until);
    run_wires(t_now_ns_);
    return t_now_ns_;
  }
  void set_observer(const BusObserver& observer) noexcept override { rig_.set_observer(observer); }

  SimRig& rig() noexcept { return rig_; }
  VcanBus& vcan(std::size_t index) { return *vcans_[index]; }

 private:
  void run_wires(Nanoseconds t) {
    for (const auto& vcan : vcans_) vcan->carry_out();
    rig_.run_wires(t);
    for (const auto& vcan : vcans_) vcan->carry_in();
  }

  SimRig rig_;
  std::vector<std::unique_ptr<VcanBus>> vcans_;
  std::vector<CanBus*> buses_;
  Nanoseconds period_ns_;
  Nanoseconds poll_ns_;
  Nanoseconds t_cycle_ns_ = 0;
  Nanoseconds t_now_ns_ = 0;
};

}  // namespace godobject::test
