// A rig on its buses as the device: encoders measure the handles' poses, drives display the force.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/rig/link.h"
#include "hal/rig/rig.h"
#include "hal/rig/swing_watch.h"
#include "platform/device/hand_device.h"
#include "platform/device/link_record.h"

namespace godobject {

/// Watches drive commands for oscillation between their bounds, as caused by feedback that the drives cannot
/// display in a stable way.
class DriveSwings {
 public:
  /// Allocates; the other functions do not. step: period, s.
  DriveSwings(std::span<const DriveParams> drives, double step) {
    for (const DriveParams& drive : drives)
      watches_.emplace_back(drive.torque_max_Nm, drive.torque_rate_Nm_per_s, step);
  }

  /// Updates with the commands that the rig sent in this step. Returns the oscillating drive, if any.
  std::optional<std::size_t> commands(const Rig& rig, const CommandReport& report) noexcept {
    std::optional<std::size_t> swings;
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      const bool bounded = ((report.torque_limited | report.rate_limited) >> i & 1u) != 0;
      if (watches_[i].update(rig.commanded_torque_Nm(i), bounded)) swings = i;
    }
    return swings;
  }
  void reset() noexcept {
    for (SwingWatch& watch : watches_) watch.reset();
  }

 private:
  std::vector<SwingWatch> watches_;
};

/// A bus whose frames are timed as the stages `send` and `receive` of a period. Forwards all calls.
class TimedBus final : public CanBus {
 public:
  explicit TimedBus(CanBus& bus) : bus_(bus) {}

  /// Sets the watch, which must outlive the next calls.
  void time_by(StageWatch& watch) noexcept { watch_ = &watch; }
  [[nodiscard]] bool open() noexcept override { return bus_.open(); }
  void close() noexcept override { bus_.close(); }
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override {
    const InStage stage(*watch_, Stage::send);
    return bus_.try_send(frame);
  }
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override {
    const InStage stage(*watch_, Stage::receive);
    return bus_.try_receive(out);
  }
  BusState state() const noexcept override { return bus_.state(); }
  BusCounters counters() const noexcept override { return bus_.counters(); }
  bool is_live() const noexcept override { return bus_.is_live(); }

 private:
  CanBus& bus_;
  StageWatch* watch_ = nullptr;
};

class RigDevice final : public HandDevice {
 public:
  /// Returns the errors of the scene's rig (which must exist); empty if it can be used.
  static std::vector<std::string> complaints(const SceneConfig& scene);

  /// Allocates; of the other functions only restart() does. complaints() must be empty.
  /// scene: constant and outliving the device. link: its buses may still be closed, but must be open before
  /// the first period.
  /// controllers: of the drives' passivity, see Rig::control_passivity().
  RigDevice(const SceneConfig& scene, std::unique_ptr<RigLink> link,
            std::vector<PassivityParams> controllers);

  /// Records the inputs of the rig from now on. Call it before the first period.
  void record(const LinkEventSink& sink) noexcept { link_.record(sink); }

  /// Returns more than the rig's own limit, which names the missing node.
  std::optional<double> boot_limit_s() const noexcept override { return params_.boot_timeout_s + 1; }
  void boot(Period& period) noexcept override;
  bool ready() const noexcept override { return rig_->state() == RigState::ready; }
  bool arm() noexcept override {
    note(RigCall::arm);
    return rig_->arm();
  }
  bool failed() const noexcept override { return rig_->state() == RigState::fault; }
  bool waits_for_user() const noexcept override { return rig_->state() == RigState::homing; }
  void read(Period& period, std::span<BodySample> samples) noexcept override;
  void command(Period& period, std::span<const Wrench> F_hand_W, Shown& shown) noexcept override;
  void tell(RunTrouble trouble) noexcept override;

  bool makes_torque() const noexcept override { return true; }
  void disarm() noexcept override {
    note(RigCall::disarm);
    rig_->disarm();
  }
  void quick_stop() noexcept override {
    note(RigCall::quick_stop);
    rig_->quick_stop();
  }
  bool run_down(Period& period) noexcept override;
  void stop(Period& period) noexcept override;
  void close(Period& period) noexcept override {
    note(RigCall::close);
    take_in(period);
  }
  void restart() override;

  bool has_hold_button() const noexcept override { return rig_->has_button(ButtonUse::hold); }
  bool hold_pressed() const noexcept override { return buttons_.hold && !buttons_before_.hold; }

  /// Coordinates of the device's joints in the last step; empty before the first.
  const JointVector& q() const noexcept { return q_; }
  const Rig& rig() const noexcept { return *rig_; }
  RigLink& link() noexcept { return link_; }
  std::span<CanBus* const> buses() const noexcept { return link_.ports(); }
  /// Returns sums over all rigs so far: see restart().
  RigCounters counters() const noexcept;

 private:
  void note(RigCall call, std::uint8_t argument = 0, std::uint32_t cycle = 0) noexcept {
    link_.call(call, rig_->state(), argument, cycle);
  }
  void begin(Period& period) noexcept;
  Nanoseconds wait(Period& period, Nanoseconds until) noexcept;
  DeviceSample exchange(Period& period, bool starting) noexcept;
  void make_rig();
  CommandReport send(Period& period, std::span<const Wrench> F_hand_W) noexcept;
  void take_in(Period& period) noexcept;
  bool commands_torque() const noexcept;

  const RigParams& params_;  // of the scene
  double cycle_s_;
  std::vector<std::size_t> bodies_;  // one per handle
  PrescribedSamples joints_;
  RecordedLink link_;
  std::vector<TimedBus> timed_;  // one per bus of the link
  std::vector<PassivityParams> controllers_;
  std::optional<Rig> rig_;
  RigCounters earlier_rigs_;
  DriveSwings swings_;
  DeviceButtons buttons_, buttons_before_;  // pressed in this step and in the one before
  Nanoseconds gather_ns_ = 0;
  JointVector q_;
};

/// Time to wait for the answers to a SYNC, ns. The rest of the period is for the step and the commands.
/// gather_polls: polls of a simulated bus within this time.
inline constexpr int gather_polls = 16;
Nanoseconds gather_time(double step) noexcept;

}  // namespace godobject
