// How a CANopen node is set up before it works in a rig: what a device profile file says. The reader is
// platform/scene/profile.h; Commissioning turns it into SDO transfers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/canopen/object.h"

namespace godobject {

/// A value and the line of the profile file that states it, which messages about it name.
template <class T>
struct FromLine {
  T value{};
  unsigned line = 0;
};

/// An object that must have this value, or gets it.
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

/// A PDO as it shall be. Its COB-ID is that of the predefined connection set (CiA 301 7.5.4).
struct PdoProfile {
  PdoDirection direction = PdoDirection::transmit;
  int number = 1;                         // 1..4
  FromLine<std::uint8_t> transmission{};  // xx:02; see of_scene
  bool of_scene = false;                  // the transmission type is status_every_nth_sync of the scene
  std::optional<FromLine<std::uint16_t>> inhibit_100us{};  // xx:03, TPDO only
  std::optional<FromLine<std::uint16_t>> timer_ms{};       // xx:05: a TPDO's event timer, an RPDO's deadline
  std::vector<MappedObject> map{};                         // at most 8, 64 bits in all
  unsigned line = 0;
};

struct NodeProfile {
  std::string file{};  // as messages call it
  std::string about{};
  double boot_timeout_s = 5;                              // from reset communication to the boot-up message
  double sdo_timeout_s = 1;                               // for each answer
  double mode_timeout_s = 1;                              // from 6060h to the same in 6061h
  std::vector<ProfileObject> identity{};                  // 1000h, 1018h: each must be what it says
  std::optional<FromLine<std::uint16_t>> heartbeat_ms{};  // 1017h
  std::optional<FromLine<std::uint16_t>>
      host_timeout_ms{};                                 // 1016h:01; the node consumes the host's heartbeat
  std::vector<ProfileObject> before_map{}, after_map{};  // written in this order around the mapping
  std::vector<PdoProfile> pdos{};  // TPDOs 1..4 that are not among them are switched off
  std::optional<FromLine<double>> torque_rated_unit_Nm{};  // of 6076h, which must agree with the scene
  std::optional<FromLine<bool>> interpolation_time{};      // 60C2h gets the period of the scene
  std::optional<FromLine<std::int8_t>> mode{};             // 6060h, then waits for 6061h
  // Bits of the statusword, 0 to 15, or -1 for none; as Cia402Params without these.
  std::optional<FromLine<std::int8_t>> follows_bit{}, limit_bit{};
};

/// Profiles of the nodes of a rig, in the order of RigParams::encoders and ::drives. None: the node is left
/// alone.
struct RigProfiles {
  std::vector<std::optional<NodeProfile>> encoders, drives;
};

}  // namespace godobject
