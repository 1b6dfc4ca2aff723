// Simulated CANopen slave: boot-up, network management, heartbeats, SYNC, SDO, PDOs, LSS. Base class of
// devices.
#pragma once

#include <deque>
#include <vector>

#include "hal/canopen/canopen.h"
#include "sim/node/canopen/lss.h"
#include "sim/node/canopen/pdo.h"
#include "sim/node/canopen/sdo_server.h"
#include "sim/node/node.h"

namespace godobject {

/// Settings of a simulated device after power-up.
enum class SimDefaults : std::uint8_t {
  rig,      // settings that the rig expects: works without commissioning
  factory,  // factory settings: other mapping, event-driven PDOs, no heartbeat
};

/// Sends its boot-up message at the first tick after power-up or a reset, then is pre-operational. Answers
/// SDO in all NMT states but stopped, exchanges PDOs in operational only. Written objects are effective at
/// once; resets restore them as CiA 301 specifies. A message refused by the bus is not repeated, the bus
/// counts it. Only the boot-up message waits until the bus accepts it.
class SimCanopenNode : public SimNode, private ObjectObserver {
 public:
  /// bus: opened by the caller, outlives the node. heartbeat_period_ns: ns; 0: no heartbeat. Allocates, as
  /// add_pdo, store and adding objects do; no other function does.
  SimCanopenNode(CanBus& bus, std::uint8_t node_id, Nanoseconds heartbeat_period_ns);
  SimCanopenNode(const SimCanopenNode&) = delete;
  SimCanopenNode& operator=(const SimCanopenNode&) = delete;

  void poll(Nanoseconds now) noexcept override;
  void on_frame(const CanFrame& frame, Nanoseconds now) noexcept;
  void tick(Nanoseconds now) noexcept;
  Nanoseconds next_timer() const noexcept override;
  /// Power-cycles the node: restores the power-up state except for stored LSS settings.
  void power_cycle(Nanoseconds now) noexcept override;

  /// Sends an EMCY with this code. Devices may add further reactions.
  void trip(std::uint16_t error_code) noexcept override {
    send(canopen::make_emergency({.node = node_id_, .error_code = error_code, .error_register = 0x01}));
  }
  void set_clock_error(double ppm, Nanoseconds now) noexcept override;

  /// Takes the identity in a profile's [identity]. Keeps the high word of 1000h. Set-up.
  void identify_as(std::span<const ProfileObject> identity) noexcept;
  /// Stores steps as if written and saved (1010h) before: effective after each power-up and reset. Skips
  /// reading steps and 1017h, so that no two simulated nodes send heartbeats in phase. Allocates.
  void store(std::vector<SdoStep> steps);

  std::uint8_t node_id() const noexcept override { return node_id_; }
  canopen::NmtState nmt_state() const noexcept { return nmt_state_; }
  ObjectDictionary& objects() noexcept { return objects_; }
  const ObjectDictionary& objects() const noexcept { return objects_; }
  const SimLss& lss() const noexcept { return lss_; }

 protected:
  void send(const CanFrame& frame) noexcept { static_cast<void>(bus_.try_send(frame)); }
  bool is_operational() const noexcept { return nmt_state_ == canopen::NmtState::operational; }
  /// Sets 1000h, 1008h and 1018h. For constructors of devices, as add_pdo.
  void identify(std::uint32_t device_type, std::string name, const lss::Identity& identity);
  void add_pdo(SimPdoDefault power_up);
  const SimPdo* find_pdo(PdoDirection direction, int number) const noexcept;

 private:
  virtual void on_pdo(const CanFrame&, Nanoseconds) noexcept {}  // a frame that is none of the node's PDOs
  virtual void on_rpdo_received(int /*number*/, Nanoseconds) noexcept {}
  // called when its values are in the dictionary and in effect
  virtual void on_rpdo(int /*number*/, Nanoseconds) noexcept {}
  virtual void on_nmt_state(Nanoseconds) noexcept {}  // called after a change of state
  // reset node: objects from 2000h on have power-up values
  virtual void on_reset() noexcept {}
  virtual void on_heartbeat_lost(Nanoseconds) noexcept {}  // heartbeat of the node in 1016h
  virtual void on_tick(Nanoseconds) noexcept {}
  virtual Nanoseconds device_timer() const noexcept { return never; }
  virtual void sample() noexcept {}  // updates objects that show present values
  // Checks an SDO write to an object of the device.
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
  Nanoseconds t_host_lost_ns_ = never;  // runs after the host's first heartbeat (CiA 301 7.2.8.2.2.2)
  Nanoseconds now_ns_ = 0;              // time of the present frame or tick
  // Clock of the node: it showed local_origin_ns_ at bus time origin_ns_ and runs at clock_rate_ since then.
  double clock_rate_ = 1;
  Nanoseconds origin_ns_ = 0, local_origin_ns_ = 0;
};

}  // namespace godobject
