// All keys of a device profile. V: TomlReader, or KeyReference with default values.
#pragma once

#include <set>

#include "hal/canopen/pdo_map.h"
#include "platform/scene/text/key.h"
#include "platform/scene/text/toml_reader.h"

namespace godobject {

/// Reads a value and its line; none if the file does not have the key.
template <class V, class T>
void read_optional(V& t, const Key& key, std::optional<FromLine<T>>& out) {
  if constexpr (requires { t.template absent<T>(key); }) return t.template absent<T>(key);
  FromLine<T> read;
  t.value(key, read.value);
  if (!t.has(key.name)) return;
  read.line = t.line_of(key.name);
  out = read;
}

/// Reads a key that sets an object of the dictionary.
template <class V>
void read_object(V& t, const Key& key, canopen::ObjectAddress address, canopen::ObjectType type,
                 std::vector<ProfileObject>& out) {
  std::optional<FromLine<std::int64_t>> read;
  read_optional(t, key, read);
  if (read) out.push_back({.address = address, .type = type, .value = read->value, .line = read->line});
}

inline constexpr Range unsigned_8{0, 255}, unsigned_16{0, 65535}, unsigned_32{0, 4294967295.0};

template <class V>
void read_identity(V& t, std::vector<ProfileObject>& out) {
  using canopen::ObjectType;
  read_object(t, Key{"device_profile", "", "low word of 1000h: 402 or 406", unsigned_16}, {0x1000, 0},
              ObjectType::u32, out);
  read_object(t, Key{"vendor", "", "1018h:01", unsigned_32}, {0x1018, 1}, ObjectType::u32, out);
  read_object(t, Key{"product", "", "1018h:02", unsigned_32}, {0x1018, 2}, ObjectType::u32, out);
  read_object(t, Key{"revision", "", "1018h:03", unsigned_32}, {0x1018, 3}, ObjectType::u32, out);
  read_object(t, Key{"serial", "", "1018h:04", unsigned_32}, {0x1018, 4}, ObjectType::u32, out);
}

template <class V>
void read_timeouts(V& t, NodeProfile& p) {
  t.value(Key{"boot",
              "s",
              "from reset communication to the boot-up message",
              {.min = 0, .max = 60, .min_open = true}},
          p.boot_timeout_s);
  t.value(Key{"sdo", "s", "of each answer", {.min = 0, .max = 60, .min_open = true}}, p.sdo_timeout_s);
  t.value(Key{"mode",
              "s",
              "from writing 6060h to the same value in 6061h",
              {.min = 0, .max = 60, .min_open = true}},
          p.mode_timeout_s);
}

template <class V>
void read_heartbeat(V& t, NodeProfile& p) {
  read_optional(
      t,
      Key{"period_ms", "ms", "of the node, 1017h; at most half the scene's `heartbeat_timeout`", unsigned_16},
      p.heartbeat_ms);
  read_optional(t,
                Key{"host_timeout_ms", "ms",
                    "of the host, 1016h:01; at least two of the scene's `heartbeat_period`", unsigned_16},
                p.host_timeout_ms);
}

template <class V>
void read_drive(V& t, NodeProfile& p) {
  using canopen::ObjectType;
  constexpr Range option{-32768, 32767};
  read_object(t, Key{"quick_stop_option", "", "605Ah", option}, {0x605A, 0}, ObjectType::i16, p.before_map);
  read_object(t, Key{"fault_reaction_option", "", "605Eh", option}, {0x605E, 0}, ObjectType::i16,
              p.before_map);
  read_object(t, Key{"abort_connection_option", "", "6007h", option}, {0x6007, 0}, ObjectType::i16,
              p.before_map);
  read_optional(
      t,
      Key{"torque_rated_unit_Nm", "N m", "of one count of 6076h; without it 6076h is not checked", positive},
      p.torque_rated_unit_Nm);
  read_optional(t, Key{"interpolation_time", "", "60C2h is set to the scene's step"}, p.interpolation_time);
  read_optional(t, Key{"mode", "", "6060h, checked in 6061h: 10 CST, 4 profile torque", {-128, 127}}, p.mode);
  constexpr Range bit{-1, 15};
  read_optional(
      t, Key{"follows_bit", "", "of 6041h, set while the drive follows 6071h; default 12; -1: none", bit},
      p.follows_bit);
  read_optional(
      t, Key{"limit_bit", "", "of 6041h, set while the drive limits the torque; default 11; -1: none", bit},
      p.limit_bit);
}

template <class V>
void read_map(V& t, PdoProfile& pdo) {
  const Key key{.name = "map",
                .unit = "",
                .meaning = "objects in order, by name or as \"6077h:00:16\"",
                .required = true};
  std::vector<std::string> names;
  t.value(key, names);
  for (const std::string& name : names) {
    std::optional<MappedObject> object = parse_mapped_object(name);
    std::vector<std::string> known;
    for (const NamedObject& named : named_objects()) known.emplace_back(named.name);
    t.check(object.has_value(), key.name,
            "names \"" + name + "\", which is not an object: the nearest is \"" + nearest(name, known) +
                "\"; write any other as \"6077h:00:16\": index, sub-index and bits");
    if (!object) continue;
    object->line = t.line_of(key.name);
    pdo.map.push_back(*object);
  }
  const std::string error = map_error(pdo);
  t.check(names.size() != pdo.map.size() || error.empty(), key.name, error);
}

template <class V>
void read_pdo(V& t, PdoProfile& pdo) {
  std::size_t which = 0;
  t.one_of(Key{.name = "pdo", .unit = "", .meaning = "rpdo1 to rpdo4, tpdo1 to tpdo4", .required = true},
           {"rpdo1", "rpdo2", "rpdo3", "rpdo4", "tpdo1", "tpdo2", "tpdo3", "tpdo4"}, which);
  pdo.direction = which < 4 ? PdoDirection::receive : PdoDirection::transmit;
  pdo.number = static_cast<int>(which % 4) + 1;
  pdo.line = t.line_of("pdo");
  const bool transmit = pdo.direction == PdoDirection::transmit;

  const Key transmission{"transmission", "",
                         "xx:02: 1 to 240 every n-th SYNC, 254 and 255 by event; default of TPDOs: the "
                         "scene's `status_every_nth_sync`",
                         unsigned_8};
  std::optional<FromLine<std::uint8_t>> type;
  read_optional(t, transmission, type);
  const bool event = type && type->value >= 254;
  t.check(!type || type->value <= 240 || event, "transmission", "is reserved: 0 to 240, 254 or 255");
  pdo.of_scene = !type && transmit;
  pdo.transmission = type.value_or(FromLine<std::uint8_t>{.value = 1, .line = pdo.line});

  std::optional<FromLine<std::uint16_t>> event_timer, deadline;
  read_optional(t, Key{"inhibit_100us", "100 us", "of a TPDO, xx:03", unsigned_16}, pdo.inhibit_100us);
  read_optional(t, Key{"event_timer_ms", "ms", "period of a TPDO, xx:05", unsigned_16}, event_timer);
  read_optional(
      t,
      Key{"deadline_ms", "ms", "of an RPDO, xx:05, after which a node that supports it reacts", unsigned_16},
      deadline);
  t.check(transmit || !pdo.inhibit_100us, "inhibit_100us", "is a key of TPDOs: remove it");
  t.check(transmit || !event_timer, "event_timer_ms", "is a key of TPDOs: use deadline_ms for an RPDO");
  t.check(!transmit || !deadline, "deadline_ms", "is a key of RPDOs: use event_timer_ms for a TPDO");
  pdo.timer_ms = transmit ? event_timer : deadline;
  t.check(!transmit || !event || (event_timer && event_timer->value > 0), "transmission",
          "is by event and may never be sent: add event_timer_ms");
  read_map(t, pdo);
}

/// Reads a write to an object without a key of its own.
template <class V>
void read_write(V& t, ProfileObject& object, bool& after_map) {
  constexpr Range any_write{-2147483648.0, 4294967295.0};
  t.value(Key{"index", "", "", {0x1000, 0xFFFF}, true}, object.address.index);
  t.value(Key{"sub", "", "", unsigned_8}, object.address.sub);
  std::size_t type = static_cast<std::size_t>(canopen::ObjectType::u32);
  t.one_of(Key{.name = "type", .unit = "", .meaning = "u8, u16, u32, i8, i16 or i32", .required = true},
           {canopen::object_type_names.begin(), canopen::object_type_names.end() - 1}, type);
  object.type = static_cast<canopen::ObjectType>(type);
  t.value(Key{"value", "", "", any_write, true}, object.value);
  t.check(canopen::in_range(object.type, object.value), "value",
          std::string("does not fit into ") + canopen::object_type_names[type]);
  t.value(Key{"after_map", "", "written after the PDO mapping, not before"}, after_map);
  object.line = t.line_of("value");
}

template <class V>
void read_profile(V& t, NodeProfile& p) {
  t.value(Key{"about", "", "purpose, and untested parts"}, p.about);
  const auto table = [&](const TableKey& key, auto read) {
    bool present = false;
    t.table(key, present, read);
  };
  table({"identity", "Required values; objects not given are not checked."},
        [&](auto& s) { read_identity(s, p.identity); });
  table({"timeout", "Time limits of the host."}, [&](auto& s) { read_timeouts(s, p); });
  table({"heartbeat", "Heartbeats."}, [&](auto& s) { read_heartbeat(s, p); });
  table({"drive", "CiA 402."}, [&](auto& s) { read_drive(s, p); });
  std::set<std::pair<PdoDirection, int>> pdos;
  t.tables(TableKey{"pdo", "A PDO to set up; TPDOs without a table are switched off."}, p.pdos,
           [&](auto& s, PdoProfile& pdo) {
             read_pdo(s, pdo);
             s.check(pdos.emplace(pdo.direction, pdo.number).second, "pdo",
                     "has an earlier [[pdo]] table: remove one");
           });
  std::vector<ProfileObject> writes;
  t.tables(TableKey{"write", "Another object to write, in the order of the file."}, writes,
           [&](auto& s, ProfileObject& object) {
             bool after_map = false;
             read_write(s, object, after_map);
             (after_map ? p.after_map : p.before_map).push_back(object);
           });
}

}  // namespace godobject
