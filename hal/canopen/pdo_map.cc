#include "hal/canopen/pdo_map.h"

#include <algorithm>
#include <charconv>

namespace godobject {

using canopen::ObjectType;

namespace {

constexpr std::array objects{
    NamedObject{"controlword", {0x6040, 0}, 16},     NamedObject{"statusword", {0x6041, 0}, 16},
    NamedObject{"error_code", {0x603F, 0}, 16},      NamedObject{"mode", {0x6060, 0}, 8},
    NamedObject{"mode_display", {0x6061, 0}, 8},     NamedObject{"position", {0x6064, 0}, 32},
    NamedObject{"velocity", {0x606C, 0}, 32},        NamedObject{"target_torque", {0x6071, 0}, 16},
    NamedObject{"torque", {0x6077, 0}, 16},          NamedObject{"target_position", {0x607A, 0}, 32},
    NamedObject{"target_velocity", {0x60FF, 0}, 32}, NamedObject{"torque_offset", {0x60B2, 0}, 16},
    NamedObject{"digital_inputs", {0x60FD, 0}, 32},  NamedObject{"encoder_position", {0x6004, 0}, 32},
    NamedObject{"encoder_speed", {0x6030, 1}, 16},
};

constexpr const char* no_deadline_hint =
    "if the drive has no deadline for RPDOs, remove deadline_ms and let it supervise the host's heartbeat: "
    "set host_timeout_ms = 20 and abort_connection_option = 1 in the profile, heartbeat_period = 0.005 in "
    "the scene";

/// Parses hexadecimal or decimal digits up to `end_mark`; removes both from `text`.
std::optional<unsigned> take_number(std::string_view& text, int base, std::string_view end_mark) noexcept {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.starts_with(end_mark)) return std::nullopt;
  text.remove_prefix(end_mark.size());
  return value;
}

SdoStep write_step(std::uint16_t index, std::uint8_t sub, ObjectType type, std::int64_t value,
                   unsigned line) {
  return {.action = SdoAction::write, .address = {index, sub}, .type = type, .low = value, .line = line};
}

SdoStep as(SdoAction action, SdoStep written) {
  written.action = action;
  written.high = written.low;
  return written;
}

/// Appends steps that compare the required values and perform `change` only if one differs. The count of a
/// mapping is compared before its entries.
void append_unless_same(std::vector<SdoStep> wanted, const std::vector<SdoStep>& change,
                        std::vector<SdoStep>& steps) {
  // The algorithm is not that of std::ranges, whose result clang 14 does not compile.
  std::stable_partition(wanted.begin(), wanted.end(),
                        [](const SdoStep& step) { return step.address.sub == 0; });
  for (const SdoStep& step : wanted) steps.push_back(as(SdoAction::compare, step));
  steps.push_back({.action = SdoAction::skip_if_same, .low = static_cast<std::int64_t>(change.size())});
  steps.insert(steps.end(), change.begin(), change.end());
}

SdoStep read_back(SdoStep written) {
  written = as(SdoAction::check, written);
  written.hint = "the node accepted the value but stores another one: see its manual on PDO mapping";
  return written;
}

}  // namespace

std::span<const NamedObject> named_objects() noexcept { return objects; }

std::optional<MappedObject> parse_mapped_object(std::string_view text) noexcept {
  const auto named = std::ranges::find(objects, text, &NamedObject::name);
  if (named != objects.end()) return MappedObject{.address = named->address, .bits = named->bits};
  const auto index = take_number(text, 16, "h:");
  if (!index || *index > 0xFFFF) return std::nullopt;
  const auto sub = take_number(text, 16, ":");
  if (!sub || *sub > 0xFF) return std::nullopt;
  const auto bits = take_number(text, 10, "");
  if (!bits || (*bits != 8 && *bits != 16 && *bits != 32) || !text.empty()) return std::nullopt;
  return MappedObject{.address = {static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*sub)},
                      .bits = static_cast<std::uint8_t>(*bits)};
}

std::string map_error(const PdoProfile& pdo) {
  if (pdo.map.empty()) return "maps no object: name at least one";
  if (pdo.map.size() > max_mapped_objects)
    return "maps " + std::to_string(pdo.map.size()) + " objects; a PDO carries at most " +
           std::to_string(max_mapped_objects);
  unsigned bits = 0;
  for (const MappedObject& object : pdo.map) bits += object.bits;
  if (bits <= max_pdo_bits) return "";
  return "maps " + std::to_string(bits) + " bits; a PDO carries at most " + std::to_string(max_pdo_bits);
}

void append_map_steps(const PdoProfile& pdo, std::uint8_t node, std::uint8_t transmission,
                      std::vector<SdoStep>& steps) {
  const std::uint16_t communication = communication_index(pdo.direction, pdo.number);
  const std::uint16_t mapping = mapping_index(pdo.direction, pdo.number);
  const auto count = static_cast<std::int64_t>(pdo.map.size());

  std::vector<SdoStep> kept;  // values to read back at the end
  std::uint8_t sub = 0;
  for (const MappedObject& object : pdo.map)
    kept.push_back(write_step(mapping, ++sub, ObjectType::u32, mapping_entry(object), object.line));
  kept.push_back(write_step(mapping, 0, ObjectType::u8, count, pdo.line));
  kept.push_back(write_step(communication, 2, ObjectType::u8, transmission, pdo.transmission.line));
  if (pdo.inhibit_100us)
    kept.push_back(
        write_step(communication, 3, ObjectType::u16, pdo.inhibit_100us->value, pdo.inhibit_100us->line));
  if (pdo.timer_ms) {
    kept.push_back(write_step(communication, 5, ObjectType::u16, pdo.timer_ms->value, pdo.timer_ms->line));
    if (pdo.direction == PdoDirection::receive) kept.back().hint = no_deadline_hint;
  }
  const SdoStep switch_on{.action = SdoAction::switch_on,
                          .address = {communication, 1},
                          .low = default_cob_id(pdo.direction, pdo.number, node),
                          .ignored_bits = SdoSequence::pdo_no_rtr,
                          .line = pdo.line};

  steps.push_back({.action = SdoAction::switch_off, .address = {communication, 1}, .line = pdo.line});
  steps.push_back(write_step(mapping, 0, ObjectType::u8, 0, pdo.line));
  steps.insert(steps.end(), kept.begin(), kept.end());
  steps.push_back(switch_on);
  for (const SdoStep& step : kept) steps.push_back(read_back(step));
  steps.push_back(read_back(switch_on));
}

void append_pdo_steps(const PdoProfile& pdo, std::uint8_t node, std::uint8_t transmission,
                      std::vector<SdoStep>& steps) {
  std::vector<SdoStep> all;
  append_map_steps(pdo, node, transmission, all);
  const auto is = [](SdoAction action) { return [action](const SdoStep& s) { return s.action == action; }; };
  const std::uint16_t mapping = mapping_index(pdo.direction, pdo.number);
  std::vector<SdoStep> map, map_wanted, wanted;
  for (const SdoStep& step : all) {
    const bool of_map = step.address.index == mapping;
    if (of_map && step.action == SdoAction::write) map.push_back(step);
    if (of_map && step.action == SdoAction::check) map_wanted.push_back(step);
    if (step.action == SdoAction::check) wanted.push_back(step);
  }
  std::vector<SdoStep> change(all.begin(), std::ranges::find_if(all, is(SdoAction::switch_off)) + 1);
  append_unless_same(map_wanted, map, change);
  for (const SdoStep& step : all)
    if (step.action == SdoAction::write && step.address.index != mapping)
      change.push_back(as(SdoAction::write_if_other, step));
  change.insert(change.end(), std::ranges::find_if(all, is(SdoAction::switch_on)), all.end());
  append_unless_same(wanted, change, steps);
}

void append_switch_off_steps(const std::vector<PdoProfile>& kept, std::vector<SdoStep>& steps) {
  for (int number = 1; number <= 4; ++number) {
    const bool is_kept = std::ranges::any_of(kept, [&](const PdoProfile& pdo) {
      return pdo.direction == PdoDirection::transmit && pdo.number == number;
    });
    if (is_kept) continue;
    steps.push_back({.action = SdoAction::switch_off_if_there,
                     .address = {communication_index(PdoDirection::transmit, number), 1},
                     .hint = "a TPDO that the profile does not map is switched off"});
  }
}

}  // namespace godobject
