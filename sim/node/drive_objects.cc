#include "sim/node/drive_objects.h"

#include <cmath>

#include "hal/drive/cia402_homing.h"

namespace godobject {

using canopen::ObjectType;

void add_drive_objects(ObjectDictionary& objects, const DriveParams& params, SimDefaults defaults,
                       std::uint32_t supported_modes, double unit_Nm) {
  constexpr auto rw = ObjectAccess::read_write;
  constexpr auto ro = ObjectAccess::read_only;
  const bool ours = defaults == SimDefaults::rig;
  const std::int8_t mode = ours ? params.cia402.torque_mode : std::int8_t{0};

  objects.add_mappable(controlword_object, ObjectType::u16);
  objects.add_mappable(target_torque_object, ObjectType::i16);
  objects.add_mappable(mode_object, ObjectType::i8, rw, mode);
  objects.add_mappable(statusword_object, ObjectType::u16, ro);
  objects.add_mappable(error_code_object, ObjectType::u16, ro);
  objects.add_mappable(mode_display_object, ObjectType::i8, ro, mode);
  objects.add_mappable(position_object, ObjectType::i32, ro);
  objects.add_mappable(velocity_object, ObjectType::i32, ro);
  objects.add_mappable(torque_object, ObjectType::i16, ro);
  objects.add_mappable(target_position_object, ObjectType::i32);
  objects.add_mappable(target_velocity_object, ObjectType::i32);
  objects.add_mappable({0x60FD, 0}, ObjectType::u32, ro);  // digital inputs
  objects.add(home_offset_object, ObjectType::i32, rw);
  objects.add(homing_method_object, ObjectType::i8, rw, cia402::homing_at_current_position);
  objects.add({0x6099, 0}, ObjectType::u8, ro, 2);  // homing speeds: to the switch, to the index
  objects.add({0x6099, 1}, ObjectType::u32, rw);
  objects.add({0x6099, 2}, ObjectType::u32, rw);

  const std::int64_t torque_rated = std::llround(params.torque_rated_Nm / unit_Nm);
  objects.add({0x6076, 0}, ObjectType::u32, ro, torque_rated);
  objects.add(supported_modes_object, ObjectType::u32, ro, supported_modes);

  Object& abort_connection = objects.add(abort_connection_option, ObjectType::i16, rw, ours ? 1 : 0);
  abort_connection.low = static_cast<std::int64_t>(AbortConnection::no_action);
  abort_connection.high = static_cast<std::int64_t>(AbortConnection::quick_stop);
  Object& quick_stop = objects.add(quick_stop_option_object, ObjectType::i16, rw, 2);
  quick_stop.low = static_cast<std::int64_t>(cia402::QuickStopOption::disable);
  quick_stop.high = static_cast<std::int64_t>(cia402::QuickStopOption::current_limit_and_stay);
  Object& fault_reaction = objects.add({0x605E, 0}, ObjectType::i16, rw, ours ? 0 : 2);
  fault_reaction.low = 0;  // disable, ramps 1 and 2: each removes the torque at once here
  fault_reaction.high = 2;
  objects.add({0x60C2, 0}, ObjectType::u8, ro, 2);
  objects.add({0x60C2, 1}, ObjectType::u8, rw, 1).low = 1;
  Object& exponent = objects.add({0x60C2, 2}, ObjectType::i8, rw, -3);
  exponent.low = -6;
  exponent.high = 0;
}

std::vector<SimPdoDefault> drive_pdos(SimDefaults defaults, std::uint8_t status_every_nth_sync,
                                      std::uint16_t deadline_ms, std::uint16_t event_ms) {
  constexpr auto receive = PdoDirection::receive;
  constexpr auto transmit = PdoDirection::transmit;
  if (defaults == SimDefaults::rig) {
    return {
        {.direction = receive,
         .number = 1,
         .transmission = 1,
         .timer_ms = deadline_ms,
         .map = {controlword_object, target_torque_object}},
        {.direction = receive,
         .number = 2,
         .transmission = 1,
         .map = {controlword_object, target_position_object}},
        {.direction = receive,
         .number = 3,
         .transmission = 1,
         .map = {controlword_object, target_velocity_object}},
        {.direction = transmit,
         .number = 1,
         .transmission = status_every_nth_sync,
         .map = {statusword_object, position_object, torque_object}},
        {.direction = transmit,
         .number = 2,
         .transmission = event_driven,
         .timer_ms = event_ms,
         .map = {velocity_object, mode_display_object, error_code_object}},
        {.direction = transmit, .number = 3, .on = false, .map = {torque_object}},
    };
  }
  return {
      {.direction = receive, .number = 1, .transmission = event_driven, .map = {controlword_object}},
      {.direction = receive,
       .number = 2,
       .transmission = event_driven,
       .map = {controlword_object, mode_object}},
      {.direction = transmit, .number = 1, .transmission = event_driven, .map = {statusword_object}},
      {.direction = transmit,
       .number = 2,
       .transmission = event_driven,
       .map = {position_object, velocity_object}},
      {.direction = transmit, .number = 3, .transmission = 1, .map = {torque_object}},
  };
}

}  // namespace godobject
