// godobject sdo: reads or writes one object of one CANopen node.
#include <cstdio>
#include <memory>

#include "hal/canopen/sdo/client.h"
#include "hal/canopen/sdo/sequence.h"
#include "platform/cli/bus/dialogue.h"
#include "platform/cli/bus/object_text.h"
#include "platform/cli/option_checks.h"

namespace godobject {
namespace {

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
