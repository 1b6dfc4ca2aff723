#include "hal/rig/watchdog.h"

#include <algorithm>

#include "hal/drive/link.h"

namespace godobject {
namespace {

constexpr canopen::ObjectAddress fault_reaction{0x605E, 0}, abort_connection{0x6007, 0};

std::optional<std::int64_t> written(const NodeProfile& profile, canopen::ObjectAddress object) {
  std::optional<std::int64_t> value;
  for (const std::vector<ProfileObject>* objects : {&profile.before_map, &profile.after_map})
    for (const ProfileObject& o : *objects)
      if (o.address == object) value = o.value;
  return value;
}

/// Returns the deadline of RPDO1, s; nullopt if there is none.
std::optional<double> command_deadline(const NodeProfile& profile) {
  for (const PdoProfile& pdo : profile.pdos)
    if (pdo.direction == PdoDirection::receive && pdo.number == 1 && pdo.timer_ms && pdo.timer_ms->value > 0)
      return 1e-3 * pdo.timer_ms->value;
  return std::nullopt;
}

/// Returns the heartbeat timeout of the host, s; nullopt without a reaction in 6007h. The drive's own
/// defaults are unknown.
std::optional<double> host_timeout(const NodeProfile& profile) {
  const bool reacts = written(profile, abort_connection).value_or(0) != 0;
  if (!reacts || !profile.host_timeout_ms || profile.host_timeout_ms->value == 0) return std::nullopt;
  return 1e-3 * profile.host_timeout_ms->value;
}

TimeToZero of_profile(const NodeProfile& profile) {
  const std::optional<double> deadline = command_deadline(profile), timeout = host_timeout(profile);
  if (!deadline && !timeout)
    return {.mechanism = "its profile " + profile.file +
                         " configures none: set deadline_ms = 20 of its RPDO1, or host_timeout_ms in "
                         "[heartbeat] and abort_connection_option = 1 in [drive]"};
  TimeToZero out;
  if (deadline && (!timeout || *deadline <= *timeout))
    out = {.s = deadline, .mechanism = "RPDO1 deadline, 1400h:05"};
  else out = {.s = timeout, .mechanism = "host's heartbeat, 1016h:01"};
  const std::optional<std::int64_t> reaction = written(profile, fault_reaction);
  if (!reaction) out.mechanism += ", then the drive's own 605Eh";
  else if (*reaction != 0) out.mechanism += ", then the ramp of 605Eh";
  return out;
}

TimeToZero of_cia402(const DriveParams& drive, const std::optional<NodeProfile>& profile) {
  if (profile) return of_profile(*profile);
  return {.mechanism = drive.profile.empty()
                           ? "it has no profile that configures one: set profile = \"generic-402\""
                           : "its profile is missing"};
}

TimeToZero of_host(const DriveParams& drive, double cycle_s, const std::optional<NodeProfile>& profile) {
  const ProtocolWatchdog* const watchdog = bus_protocol(drive.protocol).watchdog;
  if (watchdog == nullptr) return of_cia402(drive, profile);
  TimeToZero out{.mechanism = watchdog->mechanism};
  if (watchdog->time_s != nullptr) out.s = watchdog->time_s(cycle_s);
  return out;
}

}  // namespace

TimeToZero time_to_zero(const RigParams& rig, double cycle_s, std::size_t drive,
                        const RigProfiles& profiles) {
  const DriveParams& params = rig.drives[drive];
  switch (params.watchdog) {
    case DriveWatchdog::host: break;
    case DriveWatchdog::drive:
      return {.s = 1e-3 * params.watchdog_ms,
              .mechanism = "the drive's own configuration, according to the scene"};
    case DriveWatchdog::none: return {.mechanism = "accepted by watchdog = \"none\""};
  }
  const bool has_profile = drive < profiles.drives.size();
  return of_host(params, cycle_s, has_profile ? profiles.drives[drive] : std::nullopt);
}

std::vector<std::string> missing_watchdogs(const RigParams& rig, double cycle_s,
                                           const RigProfiles& profiles) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < rig.drives.size(); ++i) {
    const DriveParams& drive = rig.drives[i];
    const TimeToZero time = time_to_zero(rig, cycle_s, i, profiles);
    if (time.s || drive.watchdog == DriveWatchdog::none) continue;
    lines.push_back("drive of joint '" + drive.joint + "' (" + rig.buses[drive.bus].name + " node " +
                    std::to_string(drive.node_id) +
                    ") has no watchdog, so its motor would keep its torque if this program died: " +
                    time.mechanism + "; or accept it with watchdog = \"none\" in its [[device.drive]]");
  }
  return lines;
}

}  // namespace godobject
