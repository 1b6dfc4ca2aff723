// A simulated CANopen slave: boot-up, network management, heartbeats, SYNC, SDO, PDOs, LSS. Devices derive
// from it.
#pragma once

#include <deque>
#include <vector>

#include "hal/canopen/canopen.h"
#include "sim/node/canopen/lss.h"
#include "sim/node/canopen/pdo.h"
#include "sim/node/canopen/sdo_server.h"
#include "sim/node/node.h"

namespace godobject {

/// What a simulated device's settings are after power-up.
enum class SimDefaults : std::uint8_t {
  rig,      // those the rig expects: it works without being commissioned
  factory,  // those of a device out of its box: other mapping, event-driven PDOs, no heartbeat
};

/// Sends its boot-up message with the first tick after power-up or a reset and is then pre-operational.
/// SDO is answered in all NMT states but stopped, PDOs are exchanged in operational only. What is written to
/// the object dictionary is in effect at once, what CiA 301 says of resets undoes it. A message that the bus
/// refuses is not repeated, the bus counts it; only the boot-up message waits for a bus that takes it.
class SimCanopenNode : public SimNode, private ObjectObserver {
 public:
  /// bus: must outlive the node and be opened by the caller. heartbeat_period_ns 0: no heartbeat. Allocates,
  /// and so do add_pdo and what adds objects; nothing later does.
  SimCanopenNode(CanBus& bus, std::uint8_t node_id, Nanoseconds heartbeat_period_ns);
  SimCanopenNode(const SimCanopenNode&) = delete;
  SimCanopenNode& operator=(const SimCanopenNode&) = delete;

  void poll(Nanoseconds now) noexcept override;
  void on_frame(const CanFrame& frame, Nanoseconds now) noexcept;
  void tick(Nanoseconds now) noexcept;
  Nanoseconds next_timer() const noexcept override;
  /// Off and on again: everything is as after power-up, but the LSS settings that were stored.
  void power_cycle(Nanoseconds now) noexcept override;

  /// The device reports an error: EMCY with this code. What else it does is the device's.
  void trip(std::uint16_t error_code) noexcept override {
    send(canopen::make_emergency({.node = node_id_, .error_code = error_code, .error_register = 0x01}));
  }
  void set_clock_error(double ppm, Nanoseconds now) noexcept override;

  /// Becomes the device that a profile's [identity] is of. The high word of 1000h stays. Set-up.
  void identify_as(std::span<const ProfileObject> identity) noexcept;
  /// As if these had been written and stored (1010h) before: in effect from each power-up and reset on. What
  /// reads, and 1017h, is left out: no two simulated nodes send their heartbeats in step. Allocates.
  void store(std::vector<SdoStep> steps);

  std::uint8_t node_id() const noexcept override { return node_id_; }
  canopen::NmtState nmt_state() const noexcept { return nmt_state_; }
  ObjectDictionary& objects() noexcept { return objects_; }
  const ObjectDictionary& objects() const noexcept { return objects_; }
  const SimLss& lss() const noexcept { return lss_; }

 protected:
  void send(const CanFrame& frame) noexcept { static_cast<void>(bus_.try_send(frame)); }
  bool is_operational() const noexcept { return nmt_state_ == canopen::NmtState::operational; }
  /// 1000h, 1008h and 1018h. Of the device's constructor, as add_pdo.
  void identify(std::uint32_t device_type, std::string name, const lss::Identity& identity);
  void add_pdo(SimPdoDefault power_up);
  const SimPdo* find_pdo(PdoDirection direction, int number) const noexcept;

 private:
  virtual void on_pdo(const CanFrame&, Nanoseconds) noexcept {}  // a frame that is none of the node's PDOs
  virtual void on_rpdo_received(int /*number*/, Nanoseconds) noexcept {}
  virtual void on_rpdo(int /*number*/, Nanoseconds) noexcept {
  }                                                   // its values are in the dictionary, in effect
  virtual void on_nmt_state(Nanoseconds) noexcept {}  // the state has just changed
  virtual void on_reset() noexcept {}                 // reset node: objects from 2000h are as at power-up
  virtual void on_heartbeat_lost(Nanoseconds) noexcept {}  // of the node in 1016h
  virtual void on_tick(Nanoseconds) noexcept {}
  virtual Nanoseconds device_timer() const noexcept { return never; }
  virtual void sample() noexcept {}  // brings objects that show what happens now up to date
  // A write by SDO to an object of the device.
  virtual sdo::AbortCode may_write_object(canopen::ObjectAddress, std::int64_t) noexcept {
    return sdo::AbortCode::none;
  }
  virtual void on_object_written(canopen::ObjectAddress, std::int64_t) noexcept {}

  sdo::AbortCode may_write(canopen::ObjectAddress address, std::int64_t value) noexcept final;
  void on_written(canopen::ObjectAddress address, std::int64_t value) noexcept final;
  void before_read() noexcept final { sample(); }

  Nanoseconds local_time(Nanoseconds now) const noexcept;
  Nanoseconds bus_time(Nanoseconds local) const noexcept;
  void on_nmt(canopen::NmtCommand command, Nanoseconds now) noexcept;
  void enter(canopen::NmtState state, Nanoseconds now) noexcept;
  void boot(Nanoseconds now) noexcept;
  void reset_communication() noexcept;
  void write_stored(const SdoStep& step) noexcept;
  bool answer_service(const CanFrame& frame) noexcept;
  void consume_heartbeat(const CanFrame& frame, Nanoseconds now) noexcept;
  void exchange_synchronous(Nanoseconds now) noexcept;
  bool receive_pdo(const CanFrame& frame, Nanoseconds now) noexcept;
  void send_pdo(SimPdo& pdo) noexcept;
  void start_timer(SimPdo& pdo, Nanoseconds now) const noexcept;

  CanBus& bus_;
  std::uint8_t node_id_;
  Nanoseconds power_up_heartbeat_ns_;
  canopen::NmtState nmt_state_ = canopen::NmtState::boot_up;
  ObjectDictionary objects_;
  SdoServer sdo_server_;
  SimLss lss_;
  std::deque<SimPdo> pdos_;
  std::vector<SdoStep> stored_;
  Object* consumer_ = nullptr;  // 1016h:01
  Nanoseconds heartbeat_period_ns_ = 0;
  Nanoseconds t_heartbeat_ns_ = never;
  Nanoseconds t_host_lost_ns_ = never;  // once the host has been heard (CiA 301 7.2.8.2.2.2)
  Nanoseconds now_ns_ = 0;              // of the frame or tick at hand
  // The node's clock: it ran at the bus's time until it showed local_origin_ns_ at origin_ns_.
  double clock_rate_ = 1;
  Nanoseconds origin_ns_ = 0, local_origin_ns_ = 0;
};

}  // namespace godobject
