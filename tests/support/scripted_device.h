// A device of one encoder, one CiA 402 drive, an emergency stop and a home button, without a simulated bus.
#pragma once

#include <cmath>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "hal/can/bus.h"
#include "hal/canopen/cia401.h"
#include "hal/canopen/cia406.h"
#include "hal/drive/cia402.h"
#include "tests/support/may_allocate.h"
#include "tests/support/scripted_bus.h"
#include "tests/support/scripted_drive.h"

namespace godobject::test {

using canopen::NmtState;
using cia402::DriveState;

inline constexpr Nanoseconds ms = 1'000'000;
inline constexpr std::uint8_t encoder_id = 1, drive_id = 2, input_id = 3, idle_drive_id = 4;
inline constexpr int watchdog_cycles = 20;

/// The other end of the host's bus. A drive without CANopen is on a bus of its own.
class ScriptedDevice : public CanBus {
 public:
  explicit ScriptedDevice(DriveProtocol protocol = DriveProtocol::cia402) {
    if (protocol == DriveProtocol::odrive) other_drive_ = std::make_unique<ScriptedOdrive>(drive_id);
    if (protocol == DriveProtocol::moteus) other_drive_ = std::make_unique<ScriptedMoteus>(drive_id);
  }
  std::vector<CanBus*> buses() {
    return other_drive_ ? std::vector<CanBus*>{this, &drive_bus_} : std::vector<CanBus*>{this};
  }

  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame& frame) noexcept override {
    [[maybe_unused]] const MayAllocate here;
    if (is_full || is_off) return SendResult::full;
    receive_from_host(frame);
    return SendResult::queued;
  }
  bool try_receive(ReceivedFrame& out) noexcept override {
    [[maybe_unused]] const MayAllocate here;
    if (to_host_.empty()) return false;
    out = to_host_.front();
    to_host_.pop_front();
    return true;
  }
  BusState state() const noexcept override { return is_off ? BusState::bus_off : BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }
  bool is_live() const noexcept override { return live; }

  void send(const CanFrame& frame, Nanoseconds t) {
    if (!is_off) to_host_.push_back({frame, t});
  }

  /// Sends heartbeats, and the answers to SYNC if it was sent.
  void answer(Nanoseconds now) {
    if (other_drive_) answer_of_other_drive(now);
    if (sends_heartbeats && now % (10 * ms) == 0) {
      if (encoder_plugged) send(canopen::make_heartbeat(encoder_id, encoder_nmt), now);
      if (drive_powered && !other_drive_) send(canopen::make_heartbeat(drive_id, drive_nmt), now);
      if (has_idle_drive) send(canopen::make_heartbeat(idle_drive_id, NmtState::operational), now);
      send(canopen::make_heartbeat(input_id, NmtState::operational), now);
      send_inputs(now);
    }
    syncs_.push_back(std::exchange(synced_, false));
    const bool answers = syncs_.size() > delay_cycles && syncs_.front();
    while (syncs_.size() > delay_cycles) syncs_.pop_front();
    if (!answers || !answers_sync) return;
    if (encoder_answers && encoder_plugged && encoder_nmt == NmtState::operational)
      send(cia406::make_position(encoder_id, encoder_counts), now + ms / 4);
    if (has_idle_drive) send(cia402::make_status(idle_drive_id, {.statusword = 0x40}), now + ms / 4);
    if (!drive_answers || other_drive_ || !drive_powered || drive_nmt != NmtState::operational) return;
    if (++num_syncs_ % status_every_nth_sync != 0) return;
    const unsigned status = cia402::encode_state(drive) | cia402::status_follows_command;
    send(cia402::make_status(
             drive_id, {.statusword = static_cast<std::uint16_t>(status), .position_counts = drive_counts}),
         now + ms / 4);
  }
  void send_inputs(Nanoseconds now) {
    const unsigned inputs = (stop_pressed ? 1u : 0u) | (home_pressed ? 2u : 0u);
    send(cia401::make_inputs(input_id, static_cast<std::uint8_t>(inputs)), now);
  }
  /// Moves the joint by this number of counts of both sensors.
  void move(int counts) {
    encoder_counts += static_cast<std::uint32_t>(counts);
    drive_counts += counts;
  }
  /// Ends a cycle: the drive's watchdog.
  void end_cycle() {
    if (other_drive_) return end_cycle_of_other_drive();
    if (cycles_without_command++ > watchdog_cycles && drive == DriveState::operation_enabled)
      drive = DriveState::fault;
    if (drive != DriveState::operation_enabled) torque_per_mille = 0;
  }
  void power_drive(bool on, Nanoseconds now) {
    if (drive_powered == on) return;
    drive_powered = on;
    if (other_drive_) return other_drive_->power(on);
    drive = DriveState::switch_on_disabled;
    drive_nmt = NmtState::pre_operational;
    torque_per_mille = 0;
    if (on) send(canopen::make_heartbeat(drive_id, NmtState::boot_up), now);
  }
  void fail_drive(Nanoseconds now) {
    if (!drive_powered) return;
    if (other_drive_) return other_drive_->fail();
    drive = DriveState::fault;
    send(canopen::make_emergency({.node = drive_id, .error_code = 0x2310}), now);
  }
  void disable_drive() {
    if (drive == DriveState::fault) return;
    if (other_drive_) return other_drive_->disable();
    drive = DriveState::switch_on_disabled;
  }

  bool has_idle_drive = false;  // a second drive, which stays off
  bool live = true, is_off = false, is_full = false, stop_pressed = false, home_pressed = false;
  bool encoder_plugged = true, drive_powered = true;
  int status_every_nth_sync = 1;
  bool sends_heartbeats = true, answers_sync = true, encoder_answers = true, drive_answers = true;
  std::size_t delay_cycles = 0;     // of the answers to SYNC
  bool encoder_stays_down = false;  // it ignores NMT start
  NmtState encoder_nmt = NmtState::pre_operational, drive_nmt = NmtState::pre_operational;
  DriveState drive = DriveState::switch_on_disabled;
  std::uint32_t encoder_counts = 0;
  std::int32_t drive_counts = 0;
  int torque_per_mille = 0;
  int nmt_starts_of_encoder = 0;
  int cycles_without_command = 0;

 private:
  /// The bus of a drive without CANopen. It fails with the other bus, as those of one adapter do.
  class DriveBus final : public ScriptedBus {
   public:
    explicit DriveBus(ScriptedDevice& device) : device_(device) {}
    SendResult try_send(const CanFrame& frame) noexcept override {
      full = device_.is_full || device_.is_off;
      const SendResult result = ScriptedBus::try_send(frame);
      if (result == SendResult::queued) device_.other_drive_->receive_from_host(frame);
      sent.clear();
      return result;
    }
    BusState state() const noexcept override { return device_.state(); }

   private:
    ScriptedDevice& device_;
  };

  void answer_of_other_drive(Nanoseconds now) {
    const SendFrame to_host = [&](const CanFrame& frame) {
      if (!is_off) drive_bus_.to_receive.push_back({frame, now + ms / 4});
    };
    if (sends_heartbeats && now % (10 * ms) == 0) other_drive_->send_heartbeat(to_host);
    if (drive_answers) other_drive_->answer(to_host);
  }
  void end_cycle_of_other_drive() {
    constexpr double torque_of_1000_per_mille_Nm = 0.1;
    other_drive_->end_cycle(watchdog_cycles);
    cycles_without_command = other_drive_->cycles_without_command;
    torque_per_mille =
        static_cast<int>(std::lround(1000 * other_drive_->torque_Nm / torque_of_1000_per_mille_Nm));
    drive = other_drive_->is_enabled()   ? DriveState::operation_enabled
            : other_drive_->has_failed() ? DriveState::fault
                                         : DriveState::switch_on_disabled;
  }

  void receive_from_host(const CanFrame& frame) {
    canopen::Nmt nmt;
    cia402::Command command;
    if (frame.id == canopen::sync_cob_id) synced_ = true;
    if (canopen::parse_nmt(frame, nmt) == ParseResult::ok) {
      const NmtState to =
          nmt.command == canopen::NmtCommand::start ? NmtState::operational : NmtState::pre_operational;
      if (nmt.node == encoder_id) encoder_nmt = encoder_stays_down ? NmtState::pre_operational : to;
      if (nmt.node == encoder_id && to == NmtState::operational) ++nmt_starts_of_encoder;
      if (nmt.node == drive_id && drive_powered) drive_nmt = to;
    }
    if (drive_powered && cia402::parse_command(frame, drive_id, command) == ParseResult::ok) follow(command);
  }
  void follow(const cia402::Command& command) {
    if (drive_nmt != NmtState::operational) return;
    cycles_without_command = 0;
    torque_per_mille = command.target_torque_per_mille;
    const bool is_fault = drive == DriveState::fault;
    if (is_fault && (command.controlword & cia402::fault_reset_bit) != 0)
      drive = DriveState::switch_on_disabled;
    if (is_fault) return;
    switch (command.controlword) {
      case cia402::shutdown: drive = DriveState::ready_to_switch_on; break;
      case cia402::switch_on:
        if (drive == DriveState::ready_to_switch_on) drive = DriveState::switched_on;
        break;
      case cia402::enable_operation:
        if (drive == DriveState::switched_on) drive = DriveState::operation_enabled;
        break;
      default: drive = DriveState::switch_on_disabled; break;
    }
  }

  std::unique_ptr<ScriptedDrive> other_drive_;  // not CANopen
  DriveBus drive_bus_{*this};
  std::deque<ReceivedFrame> to_host_;
  bool synced_ = false;
  int num_syncs_ = 0;
  std::deque<bool> syncs_;  // unanswered, the oldest first
};

}  // namespace godobject::test
