// A device on its buses: boots the nodes, reads the handles' poses from the joint sensors, sends joint
// torques to the drives. Each cycle, in this order: sync(now); receive(now) until complete() or the caller's
// deadline; read(now); command(F, now). No function waits, throws, reads a clock or allocates after
// construction. The caller owns the buses. A bus has one protocol, that of its drives (hal/drive/link.h).
// CANopen buses, also those without a drive, have SYNC, NMT and heartbeats. On other buses each drive
// receives a request and is supervised by its answers.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/body/target.h"
#include "core/nonblocking.h"
#include "hal/can/bus.h"
#include "hal/drive/drive.h"
#include "hal/joint/answer_delay.h"
#include "hal/joint/encoder.h"
#include "hal/joint/kinematic_tree.h"
#include "hal/joint/rest_watch.h"
#include "hal/joint/sync_attribution.h"
#include "hal/joint/transmission.h"
#include "hal/rig/fault.h"
#include "hal/rig/inertia_compensation.h"
#include "hal/rig/node.h"
#include "hal/rig/passivity_controller.h"
#include "hal/rig/supervisor.h"
#include "hal/rig/validate.h"

namespace godobject {

/// Pressed buttons; false without such a button.
struct DeviceButtons {
  bool hold = false;
  bool clutch = false;
};

/// State of the device by its joint sensors.
struct DeviceSample {
  // The first num_handles() are used; stale joints count as at rest.
  std::array<Target, max_handles> handles{};
  JointVector q, q_dot;  // one number per joint
  DeviceButtons buttons;
  // Every joint's sample is good and every drive was received; otherwise the last good values are held.
  bool valid = false;
  bool fresh = false;    // every joint has a new sample since the previous read(), as far as one was due
  Nanoseconds t_ns = 0;  // time of the oldest joint sample
  Nanoseconds age = 0;   // age of the oldest joint sample at read()
  RigFault faults = RigFault::none;
};

/// Result of command(); bit i refers to RigParams::drives[i].
struct CommandReport {
  std::uint32_t torque_limited = 0;  // limited to torque_max_Nm
  std::uint32_t rate_limited = 0;    // limited by torque_rate_Nm_per_s
  std::uint32_t drive_limited = 0;   // the drive reports an internal limit
  std::uint32_t not_sent = 0;        // the bus refused the frame; the drive keeps its last target
};

/// Presses of the home button that were refused, because a joint was not at rest.
struct RefusedPresses {
  std::uint64_t count = 0;
  std::size_t joint = 0;  // one that moved or had no good sample
};

struct RigCounters {
  std::uint64_t syncs = 0;             // queued on at least one bus
  std::uint64_t incomplete_syncs = 0;  // not every expected answer arrived before the next SYNC
  std::uint64_t frames = 0;
  std::uint64_t malformed = 0;          // wrong size or an undefined value
  std::uint64_t repeated = 0;           // repeated answers of a joint sensor to the same SYNC: not used
  std::uint64_t foreign = 0;            // frames from no node of this rig
  std::uint64_t receive_truncated = 0;  // receive() stopped at max_frames_per_receive on a bus
};

/// Returns the request to the user while homing: coordinates of the joints, and the button. Allocates.
std::string homing_request(const RigParams& rig);

class Rig {
 public:
  /// Per bus: bounds the work of a cycle on a flooded bus.
  static constexpr int max_frames_per_receive = 512;
  /// Cycles at zero torque in which every drive must report that it follows its command, before ready.
  static constexpr int settle_cycles = 10;

  /// params: constant and outliving the rig; validate(params, cycle_s) must be empty. cycle_s: period of
  /// sync(), s. buses: one per params.buses, open, outliving the rig. Allocates, as fault_text() and
  /// place_text() do; no other function does.
  Rig(const RigParams& params, double cycle_s, std::span<CanBus* const> buses);
  Rig(const RigParams&&, double, std::span<CanBus* const>) = delete;  // a temporary would not outlive it
  Rig(Rig&&) noexcept = default;

  /// Gives each drive a passivity controller, which acts before its limits. controllers: one per drive.
  void control_passivity(std::span<const PassivityParams> controllers) noexcept;

  /// off -> booting: sends NMT start to all nodes.
  void start(Nanoseconds now) noexcept GODOBJECT_NONBLOCKING;
  /// ready -> armed: command() reaches the motors from now on. Returns false in any other state.
  [[nodiscard]] bool arm() noexcept GODOBJECT_NONBLOCKING;
  /// armed -> ready: torque ramps down to 0 at the slew limit.
  void disarm() noexcept GODOBJECT_NONBLOCKING;
  /// fault -> booting: clears the sticky bits; armed again only after boot and an explicit arm().
  void clear_faults(Nanoseconds now) noexcept GODOBJECT_NONBLOCKING;
  /// any but off -> fault: the next command() stops every drive by its own fastest means. For CiA 402 these
  /// are a quick stop by option code 605Ah, for ODrive idle, for moteus stopped. clear_faults() recovers.
  void quick_stop() noexcept GODOBJECT_NONBLOCKING;
  /// any but off -> fault: the host missed too many deadlines.
  void deadlines_missed() noexcept GODOBJECT_NONBLOCKING;
  /// armed -> fault: the wrench passed to command() swings between its bounds. drive: the drive whose command
  /// swings, if known.
  void force_oscillates(std::optional<std::size_t> drive) noexcept GODOBJECT_NONBLOCKING;
  /// any but off -> fault: the displayed scene gained energy without external work.
  void energy_gained() noexcept GODOBJECT_NONBLOCKING;
  /// any -> off: drives disabled, nodes pre-operational.
  void stop() noexcept GODOBJECT_NONBLOCKING;

  /// Sends the first frames of the cycle: SYNC on every bus, or a request to each drive if its protocol has
  /// no SYNC. Positions are sampled at their end. now: in the clock of the buses' receive stamps, ns. A bus
  /// that refuses the frame has no SYNC in this cycle. SYNC is also left out on a bus whose
  /// answers may be late. The host's heartbeat replaces it, and the missing answer shows the delay
  /// (hal/joint/answer_delay.h).
  void sync(Nanoseconds now) noexcept GODOBJECT_NONBLOCKING;
  /// Decodes received frames, up to max_frames_per_receive per bus; the next call continues.
  void receive(Nanoseconds now) noexcept GODOBJECT_NONBLOCKING;
  /// True if every answer expected to the last SYNC of each bus has arrived.
  bool complete() const noexcept GODOBJECT_NONBLOCKING;
  /// Supervises, then returns the handles. State changes and faults happen here, after the answers are in,
  /// because a late host is no fault of the device.
  DeviceSample read(Nanoseconds now) noexcept GODOBJECT_NONBLOCKING;
  /// Sends one command to every drive: tau = M^T (sum of J^T F + compensation) at the pose of the last
  /// read(), zero unless armed. M: transmission.
  /// F_hand_W: wrench of the device on the hand for each handle, world axes, about the handle's origin, N m
  /// and N; missing ones are zero. Components on joints without a drive are not displayed. Call it in every
  /// cycle and state: it also carries the controlwords.
  CommandReport command(std::span<const Wrench> F_hand_W, Nanoseconds now) noexcept GODOBJECT_NONBLOCKING;

  /// Returns off, booting, homing, enabling, ready, armed or fault.
  RigState state() const noexcept { return supervisor_.state(); }
  TorqueOutput torque_output() const noexcept { return supervisor_.torque(); }
  bool ready() const noexcept { return state() == RigState::ready || state() == RigState::armed; }
  RigFault faults() const noexcept { return fault_log_.faults(); }
  const RigFaultLog& fault_log() const noexcept { return fault_log_; }
  /// Returns the text of the set faults, one line per place, in the order in which they were raised: name,
  /// bus, node, meaning, remedy. Not for the loop: allocates.
  std::string fault_text() const;
  /// Returns a place: "can0 node 4, drive of elbow". Thread-safe: depends on parameters only. Allocates.
  std::string place_text(const RigFaultRecord& record) const;
  const RigCounters& counters() const noexcept { return counters_; }
  const RefusedPresses& refused_presses() const noexcept { return refused_presses_; }

  std::size_t num_joints() const noexcept { return tree_.num_joints(); }
  std::size_t num_handles() const noexcept { return tree_.num_handles(); }
  std::size_t num_encoders() const noexcept { return encoders_.size(); }
  std::size_t num_drives() const noexcept { return drives_.size(); }
  bool has_button(ButtonUse use) const noexcept;
  /// True if a joint has an incremental sensor, so that each boot waits for the user.
  bool needs_homing() const noexcept { return !homed_joints_.empty(); }
  const Encoder& encoder(std::size_t index) const noexcept { return encoders_[index].encoder; }
  /// Returns position and torque as reported by the drive.
  DriveFeedback drive_feedback(std::size_t index, Nanoseconds now) const noexcept;
  double commanded_torque_Nm(std::size_t drive) const noexcept {
    return drives_[drive].drive.commanded_torque_Nm();
  }
  /// Returns the energy observed by the drive's passivity controller, J; 0 without one.
  double generated_energy_J(std::size_t drive) const noexcept { return drives_[drive].passivity.energy_J(); }

 private:
  struct Bus {
    CanBus* bus = nullptr;
    BusProtocol protocol;
    SyncAttribution syncs;
    int refused_in_a_row = 0;
    // longest measurement of a delay, periods
    std::uint64_t longest_measurement;
    // least distance of two left-out SYNCs, periods
    std::uint64_t mark_distance;
    std::uint64_t last_mark = 0;  // number of the last SYNC left out
    // true if the SYNC of this cycle was left out
    bool marked = false;
    std::array<std::uint8_t, canopen::max_node_id + 1> node_of_id{};  // index into nodes_ plus 1; 0: none
  };
  struct EncoderOnBus {
    Encoder encoder;
    std::size_t node;
    AnswerDelay delay;
    std::uint64_t answered_sync = 0;
    Nanoseconds t_good_ns = 0;  // time of its last valid sample
  };
  struct DriveOnBus {
    Drive drive;
    std::size_t node;
    Eigen::Index joint;
    std::uint64_t every_nth_sync;
    AnswerDelay delay;
    std::uint64_t answered_sync = 0;
    double motor_per_joint = 1;    // torque of the motor for a torque at the joint or actuator
    bool request_refused = false;  // true if the bus refused the request of this cycle
    double max_slip = 0;           // rad or m; 0: not compared with an encoder
    double apart = 0;              // the joint's encoder minus its position, as before ready; rad or m
    Nanoseconds t_agreed_ns = 0;   // time of the last difference within max_slip
    Nanoseconds t_good_ns = 0;     // time of its last valid status
    // While enabling:
    bool was_well = false;                     // the drive was out of fault
    bool was_powered = false;                  // its power stage was on
    std::uint32_t error_code_before = 0;       // error code at that time
    std::optional<Nanoseconds> t_failed_ns{};  // since then it has been in fault or without power
    PassivityController passivity{};
    InertiaCompensation inertia{};
  };
  struct ButtonOnBus {
    ButtonParams params;
    std::size_t node;
    bool heard = false;
    bool pressed = false;
  };

  /// A joint whose sensor is incremental.
  struct HomedJoint {
    std::size_t joint;
    std::size_t node;  // of the sensor
    RestWatch rest;
  };

  std::size_t add_node(std::size_t bus, std::uint8_t id, NodeKind kind, std::size_t device);
  void add_buttons();
  void add_homed_joints();
  Eigen::Index joint_named(const std::string& name) const;

  bool send(std::size_t bus, const CanFrame& frame) noexcept;
  bool send(DriveOnBus& drive, const DriveCommand& command, Nanoseconds now) noexcept;
  void raise(const RigFaultPlace& place, std::uint32_t identifier = 0) noexcept;
  void raise(RigFault fault, const RigNode& node) noexcept {
    raise({.fault = fault, .bus = node.bus, .node_id = node.id});
  }
  void raise_drive_error(const RigNode& node, std::uint32_t error_code) noexcept {
    raise({.fault = RigFault::drive_error, .bus = node.bus, .node_id = node.id, .drive_code = error_code});
  }
  const RigNode* node_at(const RigFaultPlace& place) const noexcept;
  NodeEvidence evidence_of(const RigNode& node) const noexcept;
  std::string evidence_text(const RigFaultRecord& record) const;

  // request.cc
  DriveCommand plan(DriveOnBus& drive, double tau_shown, double tau_compensating, Nanoseconds now) noexcept;
  bool begin_cycle(std::size_t bus, Nanoseconds now) noexcept;
  bool request_answers(std::size_t bus, Nanoseconds now) noexcept;
  bool is_mark_due(std::size_t bus) noexcept;
  template <class Function>
  void for_each_delay(std::size_t bus, Function&& function) noexcept;

  // receive.cc
  void decode(std::size_t bus, const ReceivedFrame& received, Nanoseconds now) noexcept;
  void note_malformed(RigNode& node, const CanFrame& frame, ParseResult why) noexcept;
  bool from_second_host(std::size_t bus, const CanFrame& frame) noexcept;
  void on_heartbeat(RigNode& node, const CanFrame& frame, Nanoseconds now) noexcept;
  void on_emergency(RigNode& node, const CanFrame& frame) noexcept;
  Nanoseconds sampled_at(const RigNode& node, const AnswerDelay& delay,
                         const SyncAttribution::Answer& answer) const noexcept;
  void on_position(RigNode& node, const CanFrame& frame, const SyncAttribution::Answer& answer) noexcept;
  void on_drive(RigNode& node, const CanFrame& frame, const SyncAttribution::Answer& answer,
                Nanoseconds now) noexcept;
  void on_inputs(RigNode& node, const CanFrame& frame) noexcept;

  // homing.cc
  void begin_boot(Nanoseconds now) noexcept;
  void drop_zeros(const RigFaultPlace& place) noexcept;
  void begin_homing(Nanoseconds now) noexcept;
  void home(Nanoseconds now) noexcept;
  bool is_pressed(ButtonUse use) const noexcept;

  // supervise.cc
  void supervise(Nanoseconds now) noexcept;
  void check_buses() noexcept;
  void check_stop_inputs() noexcept;
  void check_nodes(Nanoseconds now) noexcept;
  void check_samples(Nanoseconds now) noexcept;
  bool lost(const Encoder& encoder, const AnswerDelay& delay, Nanoseconds t_good,
            Nanoseconds now) const noexcept;
  bool measured_anew(std::size_t joint, const JointSample& sample) noexcept;
  void check_slip(DriveOnBus& drive, Nanoseconds now) noexcept;
  void check_ranges(const DeviceSample& sample, Nanoseconds now) noexcept;
  void check_drives() noexcept;
  void check_drive_error(const DriveOnBus& drive) noexcept;
  bool failed_on_the_way(DriveOnBus& drive, Nanoseconds now) noexcept;
  void boot(Nanoseconds now) noexcept;
  void wait_for_drives(Nanoseconds now) noexcept;
  bool boot_is_over(Nanoseconds now) const noexcept;
  bool booted(const RigNode& node, Nanoseconds now) const noexcept;
  bool is_known(const AnswerDelay& delay, const RigNode& node) const noexcept;
  bool silent(const RigNode& node, Nanoseconds now) const noexcept;
  bool running() const noexcept { return state() >= RigState::homing && state() <= RigState::armed; }
  // Devices that were up when the first fault was raised are still supervised.
  bool nodes_were_up() const noexcept { return supervisor_.reached() >= RigState::homing; }
  bool drives_were_up() const noexcept { return supervisor_.reached() >= RigState::ready; }

  DriveGoal goal() const noexcept;
  DeviceButtons buttons() const noexcept;

  const RigParams& params_;
  KinematicTree tree_;
  Transmission transmission_;
  std::vector<Bus> buses_;
  std::vector<RigNode> nodes_;
  std::vector<EncoderOnBus> encoders_;
  std::vector<DriveOnBus> drives_;
  std::vector<ButtonOnBus> buttons_;
  /// Sampling of the sensor of a joint, or of its actuator, and its state at the last read().
  struct Measured {
    std::uint64_t every_nth_sync = 1;
    Nanoseconds t_ns = 0;         // time of the sample
    std::uint64_t reads_ago = 0;  // number of reads since it was new
    double q = 0;                 // rad or m
    bool valid = false;
    std::size_t node = 0;         // of the sensor
    Nanoseconds t_within_ns = 0;  // last time at which the joint was not beyond its range
  };
  std::array<Encoder*, max_joints> sensors_{};  // by joint: its encoder, otherwise its drive
  std::array<Measured, max_joints> measured_{};
  std::vector<HomedJoint> homed_joints_;
  bool home_was_pressed_ = false;  // in the cycle before
  RefusedPresses refused_presses_;

  Supervisor supervisor_;
  Nanoseconds now_ns_ = 0;  // time of the present call
  Nanoseconds boot_started_ns_ = 0;
  Nanoseconds heartbeat_due_ns_ = 0;
  int settled_cycles_ = 0;
  TreeConfiguration configuration_;  // tree at the last read()
  JointVector q_dot_;                // rates of the joints at the last read()
  RigFaultLog fault_log_;
  RigCounters counters_;
};

}  // namespace godobject
