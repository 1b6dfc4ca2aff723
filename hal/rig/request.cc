// Rig: start of a cycle, and plans of commands. Requests answers by SYNC or by a frame to each drive, and
// marks cycles whose answers measure the nodes' delay (hal/joint/answer_delay.h).
#include <algorithm>
#include <cassert>

#include "hal/rig/rig.h"

namespace godobject {

void Rig::sync(Nanoseconds now) noexcept {
  if (state() == RigState::off) return;
  now_ns_ = now;
  const bool last_was_complete = complete() || std::ranges::any_of(buses_, &Bus::marked);
  bool queued = false;
  for (std::size_t i = 0; i < buses_.size(); ++i) queued = begin_cycle(i, now) || queued;
  if (queued) ++counters_.syncs;
  if (queued && running() && !last_was_complete) ++counters_.incomplete_syncs;
  const bool due = now >= heartbeat_due_ns_;
  if (due) heartbeat_due_ns_ = now + to_ns(params_.heartbeat_period_s);
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    if (!buses_[i].protocol.canopen || (!due && !buses_[i].marked)) continue;
    send(i, canopen::make_heartbeat(params_.host_node_id, canopen::NmtState::operational));
  }
}

// Queues SYNC or the requests, or leaves them out as a mark in the answers. Returns true if any was queued.
bool Rig::begin_cycle(std::size_t bus, Nanoseconds now) noexcept {
  Bus& on = buses_[bus];
  on.marked = is_mark_due(bus);
  if (!on.marked) return request_answers(bus, now);
  on.syncs.sync_left_out(now);
  on.last_mark = on.syncs.num_syncs();
  for_each_delay(bus, [&](AnswerDelay& delay) { delay.left_out(on.last_mark, now); });
  return false;
}

// True if a delay on this bus is in doubt and the last mark is old enough. A mark is old once it was seen in
// the answers of all nodes, or after the longest measurement. Distances between marks grow. With equal
// distances, a delay longer than one would appear as a short delay each time.
bool Rig::is_mark_due(std::size_t bus) noexcept {
  const Bus& on = buses_[bus];
  const std::uint64_t last_sync = on.syncs.num_syncs();
  if (!on.bus->is_live() || !on.protocol.answers_only) return false;
  bool wanted = false, is_pending = false;
  std::uint64_t num_inconclusive = 1;  // the first one costs no further distance
  for_each_delay(bus, [&](const AnswerDelay& delay) {
    wanted = wanted || delay.needs_mark(last_sync);
    is_pending = is_pending || delay.is_pending();
    num_inconclusive = std::max(num_inconclusive, delay.num_inconclusive());
  });
  const std::uint64_t more = (num_inconclusive - 1) * on.longest_measurement;
  const std::uint64_t distance = is_pending ? on.mark_distance : AnswerDelay::min_distance;
  return wanted && (on.last_mark == 0 || last_sync - on.last_mark >= distance + more);
}

template <class Function>
void Rig::for_each_delay(std::size_t bus, Function&& function) noexcept {
  for (EncoderOnBus& encoder : encoders_)
    if (nodes_[encoder.node].bus == bus) function(encoder.delay);
  for (DriveOnBus& drive : drives_)
    if (nodes_[drive.node].bus == bus) function(drive.delay);
}

// Queues SYNC, or the requests. Returns true if any was queued.
bool Rig::request_answers(std::size_t bus, Nanoseconds now) noexcept {
  if (buses_[bus].protocol.canopen) {
    const bool queued = send(bus, canopen::make_sync());
    if (queued) buses_[bus].syncs.sync_queued(now);
    return queued;
  }
  bool queued = false;
  for (DriveOnBus& drive : drives_) {
    if (nodes_[drive.node].bus != bus) continue;
    const std::optional<CanFrame> request = drive.drive.request();
    if (!request) continue;
    drive.request_refused = !send(bus, *request);
    if (drive.request_refused) continue;
    drive.drive.request_sent();
    if (!queued) buses_[bus].syncs.sync_queued(now, *request);
    queued = true;
  }
  return queued;
}

/// Plans the command of a drive. Its passivity controller acts on the torques for the hand and the carried
/// inertia while torque follows command(). It restarts otherwise, because a torque that runs down is no
/// feedback.
DriveCommand Rig::plan(DriveOnBus& drive, double tau_shown, double tau_compensating,
                       Nanoseconds now) noexcept {
  const Measured& measured = measured_[static_cast<std::size_t>(drive.joint)];
  if (torque_output() != TorqueOutput::normal) {
    drive.passivity.reset();
    drive.inertia.reset();
  } else {
    const bool is_new = measured.valid && measured.reads_ago == 0;
    const double moving = drive.inertia.update(measured.q, is_new, measured.valid);
    tau_shown = drive.passivity.limit(tau_shown, measured.q, is_new, moving);
  }
  return drive.drive.plan(tau_shown + tau_compensating, goal(), now);
}

void Rig::control_passivity(std::span<const PassivityParams> controllers) noexcept {
  assert(controllers.size() == drives_.size());
  for (std::size_t i = 0; i < drives_.size(); ++i) drives_[i].passivity = PassivityController(controllers[i]);
}

}  // namespace godobject
