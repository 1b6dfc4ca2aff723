// godobject sdo: reads or writes one object of one CANopen node.
#include "platform/cli/bus/dialogue.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <memory>

#include "hal/canopen/sdo/client.h"
#include "hal/canopen/sdo/sequence.h"
#include "platform/cli/command_line.h"

namespace godobject {

using canopen::ObjectType;

namespace {

constexpr std::string_view hex_type = "hex";

std::optional<std::uint32_t> parse_hex(std::string_view text, std::uint32_t max) {
  if (text.starts_with("0x") || text.starts_with("0X")) text.remove_prefix(2);
  else if (text.ends_with("h") || text.ends_with("H")) text.remove_suffix(1);
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  const bool complete = error == std::errc() && end == text.data() + text.size();
  return complete && value <= max ? std::optional(value) : std::nullopt;
}

/// Parses a decimal number, or a hexadecimal one after "0x".
std::optional<std::int64_t> parse_number(std::string_view text) {
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (hexadecimal) text.remove_prefix(2);
  std::int64_t value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value, hexadecimal ? 16 : 10);
  const bool complete = error == std::errc() && end == text.data() + text.size();
  return complete && !(hexadecimal && text.starts_with("-")) ? std::optional(value) : std::nullopt;
}

std::optional<std::vector<std::uint8_t>> parse_bytes(std::string_view text) {
  std::string digits;
  std::ranges::copy_if(text, std::back_inserter(digits), [](char c) { return c != ' '; });
  if (digits.empty() || digits.size() % 2 != 0) return std::nullopt;
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2) {
    const auto is_digit = [](char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; };
    if (!is_digit(digits[i]) || !is_digit(digits[i + 1])) return std::nullopt;
    std::uint8_t byte = 0;
    std::from_chars(digits.data() + i, digits.data() + i + 2, byte, 16);
    bytes.push_back(byte);
  }
  return bytes;
}

std::string format_bytes(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    if (!text.empty()) text += ' ';
    text += digits[byte >> 4];
    text += digits[byte & 0x0F];
  }
  return text;
}

/// Returns printable characters as they are and others as '.', so that a device cannot send control codes to
/// the terminal.
std::string format_text(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes)
    if (byte != 0) text += std::isprint(byte) != 0 ? static_cast<char>(byte) : '.';
  return text;
}

std::string format_all(std::span<const std::uint8_t> bytes) {
  std::string text = "hex " + format_bytes(bytes);
  for (const char* const name : canopen::object_type_names) {
    const std::optional<ObjectType> type = number_type(name);
    if (!type || canopen::size_of(*type) != bytes.size()) continue;
    text += ", " + std::string(name) + " " +
            std::to_string(canopen::decode_number(bytes, canopen::is_signed(*type)));
  }
  const auto printable = [](std::uint8_t byte) { return std::isprint(byte) != 0; };
  if (!bytes.empty() && std::ranges::all_of(bytes, printable)) text += ", string " + format_text(bytes);
  return text;
}

struct SdoOptions {
  DialogueOptions dialogue;
  int node = 1;
  std::string object, value, type;
};

ExitCode transfer(const SdoOptions& options, sdo::Client& client, const std::string& what) {
  BusDialogue bus;
  const ExitCode opened = bus.open(options.dialogue, sdo::response_cob_id(client.node()));
  if (opened != ExitCode::ok) return opened;
  bus.run([&] { return client.busy(); }, [&](const CanFrame& frame) { client.on_frame(frame); },
          [&](Nanoseconds now, CanBus& to) { client.poll(now, to); });
  if (client.state() == sdo::TransferState::done) return ExitCode::ok;
  std::fprintf(stderr, "node %d, %s: %s%s\n", options.node, what.c_str(), client.failure_text().c_str(),
               bus.trouble().c_str());
  return ExitCode::fault;
}

std::optional<canopen::ObjectAddress> address_of(const SdoOptions& options) {
  const auto address = parse_object_address(options.object);
  if (!address)
    std::fprintf(
        stderr,
        "'%s' is not an object address: write INDEX or INDEX:SUB in hexadecimal, as 6077 or 1018:01\n",
        options.object.c_str());
  return address;
}

ExitCode read(const SdoOptions& options) {
  const auto address = address_of(options);
  if (!address) return ExitCode::usage;
  sdo::Client client(static_cast<std::uint8_t>(options.node), options.dialogue.timeout_ns());
  if (!client.read(*address)) return ExitCode::usage;
  const ExitCode code = transfer(options, client, to_string(*address) + " read");
  if (code != ExitCode::ok) return code;
  std::string error;
  const std::optional<canopen::ObjectType> number = number_type(options.type);
  const std::span<const std::uint8_t> data = number ? client.data(canopen::size_of(*number)) : client.data();
  const std::optional<std::string> text = format_value(data, options.type, error);
  if (text) std::printf("%s\n", text->c_str());
  else std::fprintf(stderr, "node %d, %s: %s\n", options.node, to_string(*address).c_str(), error.c_str());
  return text ? ExitCode::ok : ExitCode::fault;
}

ExitCode write(const SdoOptions& options) {
  const auto address = address_of(options);
  if (!address) return ExitCode::usage;
  std::string error;
  const auto bytes = parse_value(options.value, options.type, error);
  sdo::Client client(static_cast<std::uint8_t>(options.node), options.dialogue.timeout_ns());
  if (!bytes || !client.write(*address, *bytes)) {
    if (error.empty()) error = "the value must have 1 to " + std::to_string(sdo::Client::capacity) + " bytes";
    std::fprintf(stderr, "%s\n", error.c_str());
    return ExitCode::usage;
  }
  return transfer(options, client, to_string(*address) + " <- " + options.value);
}

}  // namespace

std::optional<ObjectType> number_type(const std::string& name) {
  const auto found = std::ranges::find(canopen::object_type_names, name);
  const auto type = static_cast<ObjectType>(found - canopen::object_type_names.begin());
  if (found == canopen::object_type_names.end() || type == ObjectType::text) return std::nullopt;
  return type;
}

std::optional<canopen::ObjectAddress> parse_object_address(std::string_view text) {
  const std::size_t colon = text.find(':');
  const auto index = parse_hex(text.substr(0, colon), 0xFFFF);
  const auto sub =
      colon == std::string::npos ? std::optional<std::uint32_t>(0) : parse_hex(text.substr(colon + 1), 0xFF);
  if (!index || !sub) return std::nullopt;
  return canopen::ObjectAddress{static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*sub)};
}

std::vector<std::string> value_type_names() {
  std::vector<std::string> names(canopen::object_type_names.begin(), canopen::object_type_names.end());
  names.emplace_back(hex_type);
  return names;
}

std::optional<std::vector<std::uint8_t>> parse_value(std::string_view text, const std::string& type,
                                                     std::string& error) {
  if (type == hex_type) {
    std::optional<std::vector<std::uint8_t>> bytes = parse_bytes(text);
    if (!bytes)
      error = "'" + std::string(text) + "' is not a sequence of pairs of hexadecimal digits, as 0A00";
    return bytes;
  }
  const std::optional<ObjectType> number = number_type(type);
  if (!number) return std::vector<std::uint8_t>(text.begin(), text.end());
  const std::optional<std::int64_t> value = parse_number(text);
  if (!value || !canopen::in_range(*number, *value)) {
    error = "'" + std::string(text) + "' is not a " + type + ": " + std::to_string(canopen::lowest(*number)) +
            " to " + std::to_string(canopen::highest(*number)) + ", or hexadecimal with 0x";
    return std::nullopt;
  }
  std::vector<std::uint8_t> bytes(canopen::size_of(*number));
  canopen::encode_number(*value, bytes);
  return bytes;
}

std::optional<std::string> format_value(std::span<const std::uint8_t> bytes, const std::string& type,
                                        std::string& error) {
  if (type.empty()) return format_all(bytes);
  if (type == hex_type) return format_bytes(bytes);
  const std::optional<ObjectType> number = number_type(type);
  if (!number) return format_text(bytes);
  if (canopen::size_of(*number) != bytes.size()) {
    error = "it has " + std::to_string(bytes.size()) + " bytes, a " + type + " has " +
            std::to_string(canopen::size_of(*number)) + ": " + format_all(bytes);
    return std::nullopt;
  }
  return std::to_string(canopen::decode_number(bytes, canopen::is_signed(*number)));
}

void add_sdo(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("sdo", "Read or write one object of a CANopen node.");
  const auto options = std::make_shared<SdoOptions>();
  add_dialogue_options(*verb, options->dialogue);
  verb->add_option("--node", options->node, "address this node-ID")->required()->check(CLI::Range(1, 127));
  verb->require_subcommand(1);
  verb->fallthrough();
  constexpr const char* object_help =
      "address this object: INDEX or INDEX:SUB, hexadecimal, as 6077 or 1018:01";

  CLI::App* reading = verb->add_subcommand("read", "Print an object's value.");
  reading->add_option("OBJECT", options->object, object_help)->required();
  reading
      ->add_option("--type", options->type,
                   "print the value as this type; default: as every type of its size")
      ->check(CLI::IsMember(value_type_names()));
  reading->callback([options, &code] { code = read(*options); });

  CLI::App* writing = verb->add_subcommand("write", "Write a value to an object.");
  writing->add_option("OBJECT", options->object, object_help)->required();
  writing
      ->add_option("VALUE", options->value,
                   "write this value: decimal, or hexadecimal with 0x; with --type hex: bytes in their order")
      ->required();
  writing
      ->add_option("--type", options->type, "write the value as this type, which must have the object's size")
      ->required()
      ->check(CLI::IsMember(value_type_names()));
  writing->callback([options, &code] { code = write(*options); });
}

}  // namespace godobject
