// Content of a device profile file: the set-up of a CANopen node before it runs in a rig.
// platform/scene/toml.h reads it; Commissioning converts it to SDO transfers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/canopen/object.h"

namespace godobject {

/// A value and its line in the profile file, for error messages.
template <class T>
struct FromLine {
  T value{};
  unsigned line = 0;
};

/// An object whose value is checked or written.
struct ProfileObject {
  canopen::ObjectAddress address{};
  canopen::ObjectType type = canopen::ObjectType::u32;
  std::int64_t value = 0;
  unsigned line = 0;
};

/// One entry of a PDO's mapping.
struct MappedObject {
  canopen::ObjectAddress address{};
  std::uint8_t bits = 0;  // 8, 16 or 32
  unsigned line = 0;
};

enum class PdoDirection : std::uint8_t {
  receive,   // RPDO: host to node
  transmit,  // TPDO: node to host
};

/// Required configuration of a PDO. Its COB-ID is that of the predefined connection set (CiA 301 7.5.4).
struct PdoProfile {
  PdoDirection direction = PdoDirection::transmit;
  int number = 1;                         // 1..4
  FromLine<std::uint8_t> transmission{};  // xx:02; see of_scene
  bool of_scene = false;                  // transmission type is status_every_nth_sync of the scene
  std::optional<FromLine<std::uint16_t>> inhibit_100us{};  // xx:03, TPDO only
  // xx:05: event timer of a TPDO, deadline of an RPDO
  std::optional<FromLine<std::uint16_t>> timer_ms{};
  std::vector<MappedObject> map{};  // at most 8 objects of at most 64 bits in total
  unsigned line = 0;
};

struct NodeProfile {
  std::string file{};  // name used in messages
  std::string about{};
  double boot_timeout_s = 5;  // from reset communication to the boot-up message
  double sdo_timeout_s = 1;   // timeout of each answer
  // from writing 6060h to reading the same value in 6061h
  double mode_timeout_s = 1;
  std::vector<ProfileObject> identity{};                  // 1000h, 1018h: required values
  std::optional<FromLine<std::uint16_t>> heartbeat_ms{};  // 1017h
  std::optional<FromLine<std::uint16_t>>
      host_timeout_ms{};                                   // 1016h:01; the node consumes the host's heartbeat
  std::vector<ProfileObject> before_map{}, after_map{};    // written before and after the mapping
  std::vector<PdoProfile> pdos{};                          // TPDOs 1..4 that are not listed are switched off
  std::optional<FromLine<double>> torque_rated_unit_Nm{};  // unit of 6076h, which must agree with the scene
  std::optional<FromLine<bool>> interpolation_time{};      // writes the period of the scene to 60C2h
  std::optional<FromLine<std::int8_t>> mode{};             // written to 6060h; then waits for 6061h
  // Bits of the statusword, 0 to 15, or -1 for none. Default: Cia402Params.
  std::optional<FromLine<std::int8_t>> follows_bit{}, limit_bit{};
};

/// Profiles of the nodes of a rig, in the order of RigParams::encoders and ::drives. A node without a profile
/// is not set up.
struct RigProfiles {
  std::vector<std::optional<NodeProfile>> encoders, drives;
};

}  // namespace godobject
