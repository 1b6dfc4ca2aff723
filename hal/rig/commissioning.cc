#include "hal/rig/commissioning.h"

#include <cmath>

#include "hal/canopen/commissioning_steps.h"

namespace godobject {

namespace {

constexpr int max_frames_per_poll = 512;  // per bus: bounds the work on a flooded bus

enum class Phase : std::uint8_t { resetting, booting, setting_up, done, failed };

enum class NodeFailure : std::uint8_t { none, reset_not_sent, no_boot_up, rebooted, sequence };

}  // namespace

/// Commissioning of one node.
class NodeCommissioning {
 public:
  NodeCommissioning(std::string name, std::size_t bus, double cycle_s, NodeProfile profile,
                    const NodeSetup& setup)
      : name_(std::move(name)),
        bus_(bus),
        node_id_(setup.node_id),
        profile_(std::move(profile)),
        sequence_(setup.node_id, commissioning_steps(profile_, cycle_s, setup), to_ns(profile_.sdo_timeout_s),
                  to_ns(profile_.mode_timeout_s)) {}

  std::size_t bus() const noexcept { return bus_; }
  Phase phase() const noexcept { return phase_; }
  bool finished() const noexcept { return phase_ == Phase::done || phase_ == Phase::failed; }

  void on_frame(const CanFrame& frame) noexcept {
    if (phase_ == Phase::failed) return;
    canopen::Heartbeat heartbeat;
    const bool boot_up = canopen::parse_heartbeat(frame, heartbeat) == ParseResult::ok &&
                         heartbeat.node == node_id_ && heartbeat.state == canopen::NmtState::boot_up;
    if (boot_up && phase_ != Phase::resetting) boot_up_ = true;
    else if (!boot_up_ && !finished()) static_cast<void>(sequence_.on_frame(frame));
  }

  void poll(Nanoseconds now, CanBus& bus) noexcept {
    if (!started_) deadline_ns_ = now + to_ns(profile_.boot_timeout_s);
    started_ = true;
    const bool late = now >= deadline_ns_;
    if (boot_up_) set_up_from_the_start(late);
    switch (phase_) {
      case Phase::resetting: {
        const CanFrame reset = canopen::make_nmt(canopen::NmtCommand::reset_communication, node_id_);
        if (bus.try_send(reset) == SendResult::queued) phase_ = Phase::booting;
        else if (late) fail(NodeFailure::reset_not_sent);
        break;
      }
      case Phase::booting:
        if (late) fail(NodeFailure::no_boot_up);
        break;
      case Phase::setting_up:
        // Some nodes start automatically (1F80h) and then refuse remapping.
        if (!halted_) halted_ = bus.try_send(halt()) == SendResult::queued;
        if (!halted_ && !late) break;
        sequence_.poll(now, bus);
        if (sequence_.failed()) fail(NodeFailure::sequence);
        else if (sequence_.done()) phase_ = Phase::done;
        break;
      case Phase::failed: sequence_.poll(now, bus); break;  // an abort may still have to be sent
      case Phase::done: break;
    }
  }

  /// Returns the device's name and its phase or failure.
  std::string text() const {
    const std::string seconds = std::to_string(std::llround(profile_.boot_timeout_s * 1e3)) + " ms";
    switch (failure_) {
      case NodeFailure::reset_not_sent:
        return name_ + ": the bus did not accept the reset within " + seconds +
               ": check that the interface is up and that another node on the bus acknowledges";
      case NodeFailure::no_boot_up:
        return name_ + ": no boot-up message within " + seconds +
               " of the reset: check its power supply and node-ID, and the bit rate and both terminations of "
               "the bus";
      case NodeFailure::rebooted:
        return name_ + ": booted " + std::to_string(1 + reboots_) + " times in more than " + seconds +
               " while it was set up: check its supply voltage, and for another master";
      case NodeFailure::sequence: return name_ + ": " + sequence_.error_text() + place();
      case NodeFailure::none: break;
    }
    if (phase_ == Phase::setting_up && sequence_.step() != nullptr)
      return name_ + ": at " + to_string(sequence_.step()->address) + place();
    return name_ + (phase_ == Phase::done ? ": set up" : ": waiting for its boot-up message");
  }

 private:
  /// Restarts the set-up, because a node that boots again loses the written values.
  void set_up_from_the_start(bool late) noexcept {
    boot_up_ = false;
    const bool again = phase_ != Phase::booting;
    if (again && late) return fail(NodeFailure::rebooted);
    if (again) ++reboots_;
    phase_ = Phase::setting_up;
    halted_ = false;
    sequence_.restart();
  }

  CanFrame halt() const noexcept {
    return canopen::make_nmt(canopen::NmtCommand::enter_pre_operational, node_id_);
  }

  void fail(NodeFailure failure) noexcept {
    failure_ = failure;
    phase_ = Phase::failed;
  }

  std::string place() const {
    const SdoStep* step = sequence_.step();
    if (step == nullptr) return "";
    const std::string line = step->line == 0 ? "" : ":" + std::to_string(step->line);
    return " (" + profile_.file + line + ")";
  }

  std::string name_;
  std::size_t bus_;
  std::uint8_t node_id_;
  NodeProfile profile_;
  SdoSequence sequence_;
  Phase phase_ = Phase::resetting;
  NodeFailure failure_ = NodeFailure::none;
  bool started_ = false;
  bool boot_up_ = false;  // received since the last poll
  int reboots_ = 0;
  bool halted_ = false;  // the NMT command to become pre-operational was sent
  Nanoseconds deadline_ns_ = 0;
};

Commissioning::Commissioning(const RigParams& params, double cycle_s, const RigProfiles& profiles,
                             std::span<CanBus* const> buses)
    : buses_(buses.begin(), buses.end()) {
  const auto add = [&](const char* kind, const auto& device, const std::optional<NodeProfile>& profile,
                       NodeSetup setup) {
    if (!profile) return;
    setup.node_id = device.node_id;
    setup.host_node_id = params.host_node_id;
    std::string name = std::string(kind) + " of joint '" + device.joint + "' (" +
                       params.buses[device.bus].name + " node " + std::to_string(device.node_id) + ")";
    nodes_.push_back(
        std::make_unique<NodeCommissioning>(std::move(name), device.bus, cycle_s, *profile, setup));
  };
  for (std::size_t i = 0; i < profiles.encoders.size(); ++i)
    add("encoder", params.encoders[i], profiles.encoders[i], {});
  for (std::size_t i = 0; i < profiles.drives.size(); ++i) {
    const DriveParams& drive = params.drives[i];
    add("drive", drive, profiles.drives[i],
        {.torque_rated_Nm = drive.torque_rated_Nm, .status_every_nth_sync = drive.status_every_nth_sync});
  }
}

Commissioning::~Commissioning() = default;

void Commissioning::poll(Nanoseconds now) noexcept {
  ReceivedFrame received;
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    for (int n = 0; n < max_frames_per_poll && buses_[i]->try_receive(received); ++n) {
      for (const auto& node : nodes_)
        if (node->bus() == i) node->on_frame(received.frame);
    }
  }
  for (const auto& node : nodes_) node->poll(now, *buses_[node->bus()]);
}

bool Commissioning::done() const noexcept {
  return std::ranges::all_of(nodes_, [](const auto& node) { return node->finished(); });
}

bool Commissioning::failed() const noexcept {
  return std::ranges::any_of(nodes_, [](const auto& node) { return node->phase() == Phase::failed; });
}

std::vector<std::string> Commissioning::errors() const {
  std::vector<std::string> lines;
  for (const auto& node : nodes_)
    if (node->phase() == Phase::failed) lines.push_back(node->text());
  return lines;
}

std::vector<std::string> Commissioning::pending() const {
  std::vector<std::string> lines;
  for (const auto& node : nodes_)
    if (!node->finished()) lines.push_back(node->text());
  return lines;
}

}  // namespace godobject
