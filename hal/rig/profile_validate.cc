#include "hal/rig/profile_validate.h"

#include <algorithm>
#include <sstream>

#include "hal/canopen/commissioning_steps.h"

namespace godobject {

namespace {

/// Sizes in bits of the objects in a PDO that the rig decodes or encodes.
struct Layout {
  PdoDirection direction;
  int number;
  std::vector<std::uint8_t> bits;
};

/// Device type of a profile.
struct Kind {
  const char* name;
  std::int64_t device_profile;  // low word of 1000h
  std::vector<Layout> layouts;
};

const Kind& encoder_kind() {
  static const Kind kind{"encoder", 406, {{PdoDirection::transmit, 1, {32}}}};
  return kind;
}
const Kind& drive_kind() {
  static const Kind kind{"drive",
                         402,
                         {{PdoDirection::receive, 1, {16, 16}},
                          {PdoDirection::transmit, 1, {16, 32, 16}},
                          {PdoDirection::transmit, 2, {32, 8, 16}}}};
  return kind;
}

class Validation {
 public:
  Validation(const RigParams& rig, double cycle_s) : rig_(rig), cycle_s_(cycle_s) {}

  void check(const NodeProfile& profile, const Kind& kind, const std::string& joint) {
    if (!is_of_kind(profile, kind, joint)) return;
    check_heartbeats(profile);
    check_deadlines(profile);
    check_mode(profile);
    if (profile.interpolation_time && profile.interpolation_time->value && !interpolation_time(cycle_s_))
      error(
          profile, profile.interpolation_time->line,
          "60C2h cannot represent the scene's step: set a step of 1 to 255 times a power of ten, from 1 us");
    for (const PdoProfile& pdo : profile.pdos)
      for (const Layout& layout : kind.layouts)
        if (pdo.direction == layout.direction && pdo.number == layout.number) check_map(profile, pdo, layout);
  }

  std::vector<std::string> take() { return std::move(errors_); }

 private:
  /// Checks the device type. Further checks of an encoder's profile on a drive are meaningless.
  bool is_of_kind(const NodeProfile& profile, const Kind& kind, const std::string& joint) {
    const auto other = std::ranges::find_if(profile.identity, [&](const ProfileObject& object) {
      return object.address == canopen::ObjectAddress{0x1000, 0} && object.value != kind.device_profile;
    });
    if (other == profile.identity.end()) return true;
    error(profile, other->line,
          "device_profile is " + std::to_string(other->value) + ", but the " + kind.name + " of joint '" +
              joint + "' is a node of CiA " + std::to_string(kind.device_profile) +
              ": set a profile for such a node");
    return false;
  }

  void check_heartbeats(const NodeProfile& profile) {
    const auto& period_ms = profile.heartbeat_ms;
    if (period_ms && (period_ms->value == 0 || 2e-3 * period_ms->value > rig_.heartbeat_timeout_s))
      error(profile, period_ms->line,
            "the node's heartbeat period must be above 0 and at most half of the scene's heartbeat_timeout");
    const auto& timeout_ms = profile.host_timeout_ms;
    if (timeout_ms && 1e-3 * timeout_ms->value < 2 * rig_.heartbeat_period_s)
      error(profile, timeout_ms->line,
            "the node would stop between two heartbeats of the host: set at least twice the scene's "
            "heartbeat_period, or in the scene [device.supervision] heartbeat_period = " +
                number(0.25e-3 * timeout_ms->value));
  }

  void check_deadlines(const NodeProfile& profile) {
    for (const PdoProfile& pdo : profile.pdos)
      if (pdo.direction == PdoDirection::receive && pdo.timer_ms && pdo.timer_ms->value > 0 &&
          1e-3 * pdo.timer_ms->value < 2 * cycle_s_)
        error(profile, pdo.timer_ms->line,
              "the node would stop between two commands of the host: set at least twice the scene's step");
  }

  /// Checks the mode: the rig commands 6071h. Negative modes are vendor-specific.
  void check_mode(const NodeProfile& profile) {
    constexpr std::int8_t profile_torque = 4, cyclic_torque = 10;
    if (!profile.mode || profile.mode->value < 0) return;
    if (profile.mode->value == profile_torque || profile.mode->value == cyclic_torque) return;
    error(profile, profile.mode->line,
          "mode " + std::to_string(profile.mode->value) +
              " ignores the torque that the rig commands in 6071h: set 10 (CST) or 4 (profile torque)");
  }

  static std::string number(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
  }

  void check_map(const NodeProfile& profile, const PdoProfile& pdo, const Layout& layout) {
    const auto same_bits = [](const MappedObject& object, std::uint8_t bits) { return object.bits == bits; };
    if (std::ranges::equal(pdo.map, layout.bits, same_bits)) return;
    std::string expected;
    for (const std::uint8_t bits : layout.bits)
      expected += (expected.empty() ? "" : ", ") + std::to_string(bits);
    error(profile, pdo.map.empty() ? pdo.line : pdo.map.front().line,
          "the rig expects in this PDO objects of " + expected + " bits: see docs/canopen.md");
  }

  // Adds an error once, because nodes that share a profile share its errors.
  void error(const NodeProfile& profile, unsigned line, const std::string& what) {
    std::string text = profile.file + ":" + std::to_string(line) + ": " + what;
    if (std::ranges::find(errors_, text) == errors_.end()) errors_.push_back(std::move(text));
  }

  const RigParams& rig_;
  double cycle_s_;
  std::vector<std::string> errors_;
};

}  // namespace

void apply_profiles(const RigProfiles& profiles, RigParams& rig) noexcept {
  const auto mask = [](const FromLine<std::int8_t>& bit) {
    return bit.value < 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(1u << bit.value);
  };
  for (std::size_t i = 0; i < std::min(profiles.drives.size(), rig.drives.size()); ++i) {
    const std::optional<NodeProfile>& profile = profiles.drives[i];
    if (!profile) continue;
    Cia402Params& drive = rig.drives[i].cia402;
    if (profile->mode) drive.torque_mode = profile->mode->value;
    if (profile->follows_bit) drive.follows_mask = mask(*profile->follows_bit);
    if (profile->limit_bit) drive.limit_mask = mask(*profile->limit_bit);
  }
}

std::vector<std::string> validate(const RigParams& rig, double cycle_s, const RigProfiles& profiles) {
  Validation validation(rig, cycle_s);
  for (std::size_t i = 0; i < profiles.encoders.size(); ++i)
    if (profiles.encoders[i]) validation.check(*profiles.encoders[i], encoder_kind(), rig.encoders[i].joint);
  for (std::size_t i = 0; i < profiles.drives.size(); ++i)
    if (profiles.drives[i]) validation.check(*profiles.drives[i], drive_kind(), rig.drives[i].joint);
  return validation.take();
}

}  // namespace godobject
