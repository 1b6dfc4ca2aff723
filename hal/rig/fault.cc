#include "hal/rig/fault.h"

#include <algorithm>
#include <bit>

namespace godobject {

namespace {

std::size_t index_of(RigFault fault) noexcept {
  return static_cast<std::size_t>(std::countr_zero(static_cast<std::uint32_t>(fault)));
}

constexpr std::array<RigFaultText, num_rig_faults> texts{{
    {RigFault::boot_timeout, "boot_timeout",
     "a node did not become operational, or a drive not enabled, within boot_timeout",
     "check power, cable, node id, bit rate; raise boot_timeout for a slow device"},
    {RigFault::heartbeat_lost, "heartbeat_lost", "no heartbeat of a node arrived for heartbeat_timeout",
     "check power and cable; set the node's 1017h well below heartbeat_timeout"},
    {RigFault::node_restarted, "node_restarted",
     "a node re-booted or left Operational while the rig was running",
     "check its supply voltage; then clear the faults and arm again"},
    {RigFault::emergency, "emergency", "a node sent an emergency message (EMCY)",
     "look the code up in the device's manual, remove the cause, clear the faults"},
    {RigFault::sample_stale, "sample_stale", "a joint had no valid sample for longer than lost_after",
     "check the encoder's cable and that its position PDO answers every SYNC; check the bus load"},
    {RigFault::sample_implausible, "sample_implausible",
     "a joint sensor jumped faster than its max_speed allows",
     "check shielding, counts_per_unit and modulus_counts; raise max_speed if the motion was real"},
    {RigFault::drive_silent, "drive_silent", "no status of a drive arrived for longer than lost_after",
     "check the drive's cable, its TPDO1 and status_every_nth_sync; check the bus load"},
    {RigFault::drive_not_enabled, "drive_not_enabled",
     "a drive left Operation Enabled (moteus: mode 10, ODrive: closed loop), or does not follow its command",
     "read its error code (CiA 402: 603Fh), remove the cause, clear the faults and arm again"},
    {RigFault::bus_down, "bus_down", "a bus is closed, bus-off or gone",
     "check adapter, cable, termination and bit rate; wait for the bus to recover, clear the faults"},
    {RigFault::send_refused, "send_refused", "the transmit queue of a bus refused three consecutive frames",
     "lower the bus load; check that another node acknowledges the frames"},
    {RigFault::command_not_finite, "command_not_finite", "the commanded wrench was not a finite number",
     "read the faults of the simulation; without any it is a defect of the caller"},
    {RigFault::drive_error, "drive_error", "a drive reported an error without an emergency message",
     "look the code up in the drive's manual, remove the cause, clear the faults"},
    {RigFault::quick_stop, "quick_stop", "the motors were stopped on request",
     "release every emergency stop, clear the faults and arm again when it is safe"},
    {RigFault::sensors_disagree, "sensors_disagree",
     "the position of a drive and the encoder on its joint differ by more than max_slip for longer than "
     "stale_after",
     "check for a stuck encoder, its coupling, a slipping belt or cable, and counts per unit of both"},
    {RigFault::second_host, "second_host",
     "another host sends frames that only this one may send: SYNC, NMT, the host's heartbeat or a drive's "
     "commands",
     "end the other program or disconnect the other master; check that no node sends SYNC (1005h), starts "
     "others (1F80h) or has the host's node id"},
    {RigFault::deadlines_missed, "deadlines_missed",
     "the host missed 20 consecutive deadlines, or so many for 2 s that the pose was held",
     "end other programs on this machine and check the real-time set-up; then clear the faults and arm "
     "again"},
    {RigFault::force_oscillates, "force_oscillates",
     "the displayed force, or a motor's command, oscillated between its bounds for 0.5 s",
     "the feedback is unstable on this device: lower the gains that godobject check names with the margin of "
     "each axis"},
    {RigFault::energy_gained, "energy_gained",
     "the scene's total energy rose by more than 1 % within 1 s without external work; its forces are not "
     "valid from then on",
     "shorten the step; soften couplings, contacts or stops; lower the ratio of masses in an articulated "
     "tool"},
    {RigFault::joint_beyond_range, "joint_beyond_range",
     "a joint is beyond lower or upper by more than a tenth of its range for longer than stale_after",
     "check zero, sign and counts_per_unit of its sensor; home an incremental sensor again; correct lower "
     "and upper of the joint"},
}};

}  // namespace

std::span<const RigFaultText, num_rig_faults> rig_fault_texts() noexcept { return texts; }

const RigFaultText& text_of(RigFault fault) noexcept { return texts[index_of(fault)]; }

bool RigFaultLog::raise(const RigFaultPlace& place, Nanoseconds now, std::uint32_t identifier,
                        const NodeEvidence& evidence) noexcept {
  const std::span<const RigFaultRecord> known = records();
  if (std::ranges::find(known, place, &RigFaultRecord::place) != known.end()) return false;
  if (!any(faults_ & place.fault)) ++counts_[index_of(place.fault)];
  faults_ = faults_ | place.fault;
  if (num_records_ < capacity)
    records_[num_records_++] = {.place = place, .t_ns = now, .identifier = identifier, .evidence = evidence};
  else ++left_out_;
  return true;
}

void RigFaultLog::clear() noexcept {
  faults_ = RigFault::none;
  num_records_ = 0;
  left_out_ = 0;
}

RigFaultRecord RigFaultLog::first(RigFault fault) const noexcept {
  for (const RigFaultRecord& record : records())
    if (record.place.fault == fault) return record;
  return {};
}

std::uint64_t RigFaultLog::count(RigFault fault) const noexcept { return counts_[index_of(fault)]; }

}  // namespace godobject
