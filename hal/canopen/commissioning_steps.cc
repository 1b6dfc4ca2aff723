#include "hal/canopen/commissioning_steps.h"

#include <cmath>
#include <sstream>

#include "hal/canopen/pdo_map.h"

namespace godobject {

using canopen::ObjectType;

namespace {

// Relative: devices round 6076h, and the product of two rounded numbers deviates by both errors.
constexpr double torque_tolerance = 0.02;

SdoStep write(canopen::ObjectAddress address, ObjectType type, std::int64_t value, unsigned line,
              std::string hint = {}) {
  return {.action = SdoAction::write,
          .address = address,
          .type = type,
          .low = value,
          .line = line,
          .hint = std::move(hint)};
}

void append(const std::vector<ProfileObject>& objects, std::vector<SdoStep>& steps) {
  for (const ProfileObject& o : objects) steps.push_back(write(o.address, o.type, o.value, o.line));
}

void append_identity(const NodeProfile& profile, std::vector<SdoStep>& steps) {
  for (const ProfileObject& o : profile.identity) {
    // The low word of the device type is the number of the device profile; the high word its variant.
    const bool device_type = o.address.index == 0x1000;
    steps.push_back({.action = SdoAction::check,
                     .address = o.address,
                     .type = o.type,
                     .low = o.value,
                     .high = o.value,
                     .ignored_bits = device_type ? 0xFFFF'0000u : 0u,
                     .line = o.line,
                     .hint = "the profile is for another device: check the node-ID, or set the profile of "
                             "this device in the scene"});
  }
}

void append_heartbeats(const NodeProfile& profile, const NodeSetup& setup, std::vector<SdoStep>& steps) {
  if (profile.heartbeat_ms)
    steps.push_back(
        write({0x1017, 0}, ObjectType::u16, profile.heartbeat_ms->value, profile.heartbeat_ms->line));
  if (!profile.host_timeout_ms) return;
  const std::uint32_t consumed = std::uint32_t{setup.host_node_id} << 16 | profile.host_timeout_ms->value;
  steps.push_back(write({0x1016, 1}, ObjectType::u32, consumed, profile.host_timeout_ms->line));
}

void append_pdos(const NodeProfile& profile, const NodeSetup& setup, std::vector<SdoStep>& steps) {
  if (profile.pdos.empty()) return;
  append_switch_off_steps(profile.pdos, steps);
  for (const PdoProfile& pdo : profile.pdos) {
    const std::uint8_t transmission = pdo.of_scene ? setup.status_every_nth_sync : pdo.transmission.value;
    append_pdo_steps(pdo, setup.node_id, transmission, steps);
  }
}

void append_interpolation(const NodeProfile& profile, double cycle_s, std::vector<SdoStep>& steps) {
  if (!profile.interpolation_time || !profile.interpolation_time->value) return;
  const InterpolationTime time = interpolation_time(cycle_s).value_or(InterpolationTime{});
  const unsigned line = profile.interpolation_time->line;
  steps.push_back(write({0x60C2, 1}, ObjectType::u8, time.value, line));
  steps.push_back(write({0x60C2, 2}, ObjectType::i8, time.exponent, line));
}

// Targets are sent in per mille of 6076h. If 6076h differs from the scene, every torque is wrong by that
// factor, and no other check detects it.
void append_torque_check(const NodeProfile& profile, const NodeSetup& setup, std::vector<SdoStep>& steps) {
  if (!profile.torque_rated_unit_Nm || !setup.torque_rated_Nm) return;
  const double expected = *setup.torque_rated_Nm / profile.torque_rated_unit_Nm->value;
  std::ostringstream hint;
  hint << "the unit is " << profile.torque_rated_unit_Nm->value
       << " N m and the scene has torque_rated_Nm = " << *setup.torque_rated_Nm
       << ": correct the scene or the drive, otherwise every torque is wrong by their ratio";
  steps.push_back({.action = SdoAction::check,
                   .address = {0x6076, 0},
                   .type = ObjectType::u32,
                   .low = std::llround(expected * (1 - torque_tolerance) - 0.5),
                   .high = std::llround(expected * (1 + torque_tolerance) + 0.5),
                   .line = profile.torque_rated_unit_Nm->line,
                   .hint = hint.str()});
}

void append_mode(const NodeProfile& profile, std::vector<SdoStep>& steps) {
  if (!profile.mode) return;
  const auto [mode, line] = *profile.mode;
  steps.push_back(write({0x6060, 0}, ObjectType::i8, mode, line, "6502h lists the modes of the drive"));
  steps.push_back(
      {.action = SdoAction::wait_for,
       .address = {0x6061, 0},
       .type = ObjectType::i8,
       .low = mode,
       .high = mode,
       .line = line,
       .hint = "the drive accepts the mode but does not enter it: see its manual for the conditions"});
}

}  // namespace

std::vector<SdoStep> commissioning_steps(const NodeProfile& profile, double cycle_s, const NodeSetup& setup) {
  std::vector<SdoStep> steps;
  append_identity(profile, steps);
  append_heartbeats(profile, setup, steps);
  append(profile.before_map, steps);
  append_pdos(profile, setup, steps);
  append_interpolation(profile, cycle_s, steps);
  append_torque_check(profile, setup, steps);
  append(profile.after_map, steps);
  append_mode(profile, steps);
  return steps;
}

std::optional<InterpolationTime> interpolation_time(double cycle_s) noexcept {
  for (int exponent = -3; exponent >= -6; --exponent) {
    const double value = cycle_s * std::pow(10.0, -exponent);
    const double rounded = std::round(value);
    if (rounded < 1 || rounded > 255 || std::abs(value - rounded) > 1e-6 * value) continue;
    return InterpolationTime{static_cast<std::uint8_t>(rounded), static_cast<std::int8_t>(exponent)};
  }
  return std::nullopt;
}

}  // namespace godobject
