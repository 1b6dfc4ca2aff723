#include "sim/fault/promise.h"

#include <algorithm>
#include <cmath>

namespace godobject {
namespace {

using enum RigFault;
using enum FaultDelay;
using enum MotorsEnd;

constexpr PromisedFault lost_sample{sample_stale, lost}, lost_drive{drive_silent, lost},
    lost_heartbeat{heartbeat_lost, heartbeat}, jump{sample_implausible, votes},
    may_part{sensors_disagree, travel, false};

constexpr std::array promises{
    FaultPromise{"drop ENCODER value=0.005", {}, keep},
    FaultPromise{"drop ENCODER", {lost_sample, lost_heartbeat}, run_down},
    FaultPromise{"drop DRIVE", {lost_drive, lost_heartbeat}, watchdog},
    FaultPromise{"drop", {lost_sample, lost_drive, lost_heartbeat}, watchdog},
    FaultPromise{"duplicate", {}, keep},
    FaultPromise{"delay value=0.1*stale_after", {}, keep},
    FaultPromise{"delay value=3*stale_after", {lost_sample, lost_drive, may_part}, run_down},
    FaultPromise{"corrupt value=0.02", {}, keep},
    FaultPromise{"corrupt ENCODER value=1", {lost_sample, lost_heartbeat}, run_down},
    FaultPromise{"stuck ENCODER", {{{sensors_disagree, travel}}}, run_down},
    FaultPromise{"spike ENCODER", {}, keep},
    FaultPromise{"spike ENCODER duration=1", {jump, may_part}, run_down},
    FaultPromise{"wrap ENCODER", {jump, may_part}, run_down},
    FaultPromise{"nan ENCODER", {jump, lost_sample}, run_down},
    FaultPromise{"reboot-node ENCODER", {{{node_restarted, at_once}, {sample_stale, lost, false}}}, run_down},
    FaultPromise{"reboot-node ENCODER duration=0.2", {{lost_sample, {node_restarted, duration}}}, run_down},
    FaultPromise{"reboot-node DRIVE duration=0.2", {{lost_drive, {node_restarted, duration}}}, run_down},
    FaultPromise{"emcy ENCODER value=20480", {{{emergency, at_once}}}, run_down},
    FaultPromise{"emcy DRIVE", {{{emergency, at_once}, {drive_not_enabled, at_once}}}, run_down},
    FaultPromise{"bus-off ENCODER", {lost_sample, lost_heartbeat}, run_down},
    FaultPromise{"bus-off DRIVE", {lost_drive, lost_heartbeat}, watchdog},
    FaultPromise{"bus-off", {{{bus_down, at_once}, lost_sample, lost_drive, lost_heartbeat}}, watchdog},
    FaultPromise{"restart", {}, keep},
    FaultPromise{"unplug ENCODER", {lost_sample, lost_heartbeat}, run_down},
    FaultPromise{"unplug DRIVE", {lost_drive, lost_heartbeat}, watchdog},
    FaultPromise{
        "unplug", {{lost_sample, lost_drive, lost_heartbeat, {send_refused, lost, false}}}, watchdog},
    FaultPromise{"id-collision ENCODER",
                 {{{node_restarted, at_once},
                   lost_sample,
                   lost_heartbeat,
                   {sample_implausible, votes, false},
                   may_part}},
                 run_down},
    FaultPromise{"id-collision DRIVE", {{{node_restarted, at_once}, lost_drive, lost_heartbeat}}, watchdog},
    FaultPromise{"clock-drift ENCODER", {}, keep},
    FaultPromise{"clock-drift ENCODER value=-9e5", {{{heartbeat_lost, late_heartbeat}}}, run_down},
    FaultPromise{"swap-ids ENCODER value=OTHER",
                 {{{sensors_disagree, travel},
                   {sample_implausible, votes, false},
                   {joint_beyond_range, at_once, false}}},
                 run_down},
    FaultPromise{"second-host", {{{second_host, at_once}}}, run_down},
    FaultPromise{"flood", {}, keep},
    FaultPromise{"flood value=2e4",
                 {{lost_sample, lost_drive, lost_heartbeat, {send_refused, lost, false}}},
                 watchdog},
    FaultPromise{"press STOP", {{{quick_stop, at_once}}}, cut},
};

constexpr int cycles_more(FaultDelay delay) noexcept { return delay == votes ? 5 : 2; }

std::string text_of(FaultDelay delay) {
  std::string cycles = std::to_string(cycles_more(delay)) + " cycles";
  switch (delay) {
    case lost: return "`stale_after` + `lost_after` + " + cycles;
    case heartbeat: return "`heartbeat_timeout` + " + cycles;
    case late_heartbeat: return "2 `heartbeat_timeout` + " + cycles;
    case duration: return "`duration` + " + cycles;
    case travel: return "`max_slip` of travel";
    case at_once:
    case votes: break;
  }
  return cycles;
}

std::string_view text_of(MotorsEnd motors) {
  constexpr std::array<std::string_view, 4> texts{"torque stays", "run down", "watchdog", "off at once"};
  return texts[static_cast<std::size_t>(motors)];
}

/// Returns the delay of a fault bit in most rows of the table.
FaultDelay usual(RigFault fault) {
  switch (fault) {
    case sample_stale:
    case drive_silent: return lost;
    case heartbeat_lost: return heartbeat;
    case sample_implausible: return votes;
    case sensors_disagree: return travel;
    default: return at_once;
  }
}

std::string list(const FaultPromise& promise, bool always) {
  std::string out;
  for (const PromisedFault& promised : promise.faults) {
    if (promised.fault == RigFault::none || promised.always != always) continue;
    out += (out.empty() ? "`" : ", `") + std::string(godobject::text_of(promised.fault).name) + "`" +
           (always && promised.within != usual(promised.fault) ? " within " + text_of(promised.within) : "");
  }
  return out;
}

}  // namespace

std::span<const FaultPromise> fault_promises() noexcept { return promises; }

std::optional<Nanoseconds> bound(FaultDelay delay, const RigParams& rig, double cycle_s,
                                 Nanoseconds duration_ns) noexcept {
  const auto ns = [](double s) { return std::llround(1e9 * s); };
  const Nanoseconds more_ns = ns(cycles_more(delay) * cycle_s);
  switch (delay) {
    case lost: return ns(rig.stale_after_s + std::max(rig.lost_after_s, rig.stale_after_s)) + more_ns;
    case heartbeat: return ns(rig.heartbeat_timeout_s) + more_ns;
    case late_heartbeat: return 2 * ns(rig.heartbeat_timeout_s) + more_ns;
    case duration: return duration_ns + more_ns;
    case travel: return std::nullopt;
    case at_once:
    case votes: break;
  }
  return more_ns;
}

std::string fault_promises_markdown() {
  std::string out;
  for (const RigFault fault :
       {sample_stale, drive_silent, heartbeat_lost, sample_implausible, sensors_disagree})
    out += "- `" + std::string(godobject::text_of(fault).name) + "` within " + text_of(usual(fault)) + "\n";
  out += "- others within " + text_of(at_once) + "\n\n";
  for (const FaultPromise& promise : promises) {
    const std::string always = list(promise, true), possible = list(promise, false);
    out += "- `" + std::string(promise.words) + "`: " + (always.empty() ? "nothing" : always) +
           (possible.empty() ? "" : " (possibly " + possible + ")") + "; " +
           std::string(text_of(promise.motors)) + "\n";
  }
  return out;
}

}  // namespace godobject
