// godobject encoder: prints the state of one CiA 406 encoder, and sets its position.
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "hal/canopen/cia406.h"
#include "platform/cli/bus/dialogue.h"

namespace godobject {
namespace {

using canopen::ObjectType;

constexpr TypedObject device_type{{0x1000, 0}, ObjectType::u32},
    parameters{{cia406::operating_parameters, 0}, ObjectType::u16},
    scaled_range{{cia406::total_range, 0}, ObjectType::u32},
    preset{{cia406::preset_value, 0}, ObjectType::u32},
    position{{cia406::position_value, 0}, ObjectType::u32}, speed{{cia406::speed_value, 1}, ObjectType::i16},
    turn_counts{{cia406::single_turn_counts, 0}, ObjectType::u32},
    turns{{cia406::number_of_revolutions, 0}, ObjectType::u16}, alarms{{cia406::alarms, 0}, ObjectType::u16},
    warnings{{cia406::warnings, 0}, ObjectType::u16};

struct EncoderOptions {
  NodeOptions node;
  std::uint32_t counts = 0;
  bool despite_host = false;
};

ExitCode open(NodeDialogue& node) {
  if (const ExitCode code = node.open(); code != ExitCode::ok) return code;
  const std::optional<std::int64_t> type = node.read(device_type);
  if (!type) return node.report();
  constexpr unsigned profile = 406;
  const auto found = static_cast<unsigned>(*type & 0xFFFF);
  if (found == profile) return ExitCode::ok;
  std::fprintf(stderr, "node %d: is not a CiA 406 encoder: its profile (1000h) is %u\n", node.node(), found);
  return ExitCode::fault;
}

/// Returns the texts of the set bits.
std::string bits_text(std::int64_t bits, std::span<const cia406::BitText> texts) {
  if (bits == 0) return "none";
  std::string text;
  const auto append = [&text](const std::string& more) { text += (text.empty() ? "" : ", ") + more; };
  for (const cia406::BitText& known : texts) {
    if ((bits & known.bit) != 0) append(std::string(known.meaning));
    bits &= ~std::int64_t{known.bit};
  }
  for (int bit = 0; bit < 16; ++bit)
    if ((bits >> bit & 1) != 0)
      append("bit " + std::to_string(bit) + (bit < 12 ? " (reserved)" : " (the maker's)"));
  return text;
}

/// Prints lines of a status, with "-" for an object that the encoder does not have.
class StatusLines {
 public:
  explicit StatusLines(NodeDialogue& node) : node_(node) {}

  template <class Format>
  void print(const char* label, const TypedObject& object, const Format& format) {
    if (!complete_) return;
    const std::optional<std::int64_t> value = node_.read(object);
    print_text(label, value ? std::optional(format(*value)) : std::nullopt);
  }
  void print_name(const char* label, canopen::ObjectAddress address) {
    if (complete_) print_text(label, node_.read_text(address));
  }
  /// True if the node answered for all objects.
  bool complete() const { return complete_; }

 private:
  void print_text(const char* label, const std::optional<std::string>& text) {
    complete_ = text || node_.was_absent();
    if (complete_) std::printf("%-16s %s\n", label, text ? text->c_str() : "-");
    else static_cast<void>(node_.report());
  }
  NodeDialogue& node_;
  bool complete_ = true;
};

ExitCode print_status(const EncoderOptions& options) {
  NodeDialogue node(options.node);
  if (const ExitCode code = open(node); code != ExitCode::ok) return code;
  const auto number = [](std::int64_t value) { return std::to_string(value); };
  const auto hexadecimal = [](std::int64_t value) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "0x%08llX", static_cast<unsigned long long>(value));
    return std::string(text.data());
  };
  StatusLines lines(node);
  lines.print_name("name", {0x1008, 0});
  constexpr std::array identity{"vendor", "product", "revision", "serial"};
  for (std::size_t i = 0; i < identity.size(); ++i)
    lines.print(identity[i], {{0x1018, static_cast<std::uint8_t>(i + 1)}, ObjectType::u32}, hexadecimal);
  lines.print("position", position, [&](std::int64_t value) { return number(value) + " counts"; });
  lines.print("speed", speed,
              [&](std::int64_t value) { return number(value) + " (6030h: the maker's unit)"; });
  lines.print("counts of a turn", turn_counts, number);
  lines.print("turns", turns, number);
  lines.print("alarms", alarms, [](std::int64_t bits) { return bits_text(bits, cia406::alarm_texts); });
  lines.print("warnings", warnings, [](std::int64_t bits) { return bits_text(bits, cia406::warning_texts); });
  if (lines.complete() && !node.host_seen().empty())
    std::printf("%-16s %s\n", "host", node.host_seen().c_str());
  return lines.complete() ? ExitCode::ok : ExitCode::fault;
}

/// Returns the counts after which the position wraps; 0: unknown, 2^32 assumed. Returns none if there is no
/// answer.
std::optional<std::uint64_t> read_modulus(NodeDialogue& node) {
  const auto value_of = [&node](const TypedObject& object) -> std::optional<std::int64_t> {
    const std::optional<std::int64_t> value = node.read(object);
    return value || !node.was_absent() ? value : 0;
  };
  const std::optional<std::int64_t> bits = value_of(parameters);
  if (!bits) return std::nullopt;
  if ((*bits & cia406::parameter_scaling_on) != 0) {
    const std::optional<std::int64_t> range = value_of(scaled_range);
    return range ? std::optional(static_cast<std::uint64_t>(*range)) : std::nullopt;
  }
  const std::optional<std::int64_t> of_turn = value_of(turn_counts);
  const std::optional<std::int64_t> number_of = of_turn ? value_of(turns) : std::nullopt;
  return number_of ? std::optional(static_cast<std::uint64_t>(*of_turn * *number_of)) : std::nullopt;
}

bool may_preset(const EncoderOptions& options, const NodeDialogue& node, std::uint64_t modulus) {
  const bool hosted = !node.host_seen().empty() && !options.despite_host;
  switch (cia406::check_preset(options.counts, modulus, hosted)) {
    case cia406::PresetCheck::allowed: return true;
    case cia406::PresetCheck::armed:
      std::fprintf(stderr,
                   "node %d: a host runs this bus (%s) and would see the joint jump: stop the host first, or "
                   "give --despite-host if it has no motor armed\n",
                   node.node(), node.host_seen().c_str());
      break;
    case cia406::PresetCheck::out_of_range:
      std::fprintf(
          stderr,
          "node %d: the position %u is not below the encoder's range of %llu counts; give a smaller one\n",
          node.node(), options.counts, static_cast<unsigned long long>(modulus));
      break;
  }
  return false;
}

ExitCode set_preset(const EncoderOptions& options) {
  NodeDialogue node(options.node);
  if (const ExitCode code = open(node); code != ExitCode::ok) return code;
  const std::optional<std::uint64_t> modulus = read_modulus(node);
  if (!modulus) return node.report();
  if (!may_preset(options, node, *modulus)) return ExitCode::fault;
  const std::optional<std::int64_t> before = node.read(position);
  if (!before || !node.write(preset, options.counts)) return node.report();
  const std::optional<std::int64_t> after = node.read(position);
  if (!after) return node.report();
  std::printf("position %lld -> %lld counts; now check offset_counts and home of its joint in your scenes\n",
              static_cast<long long>(*before), static_cast<long long>(*after));
  return ExitCode::ok;
}

}  // namespace

void add_encoder(CLI::App& app, ExitCode& code) {
  CLI::App* verb =
      app.add_subcommand("encoder", "Print the state of one CiA 406 encoder, or set its position.");
  const auto options = std::make_shared<EncoderOptions>();
  add_node_options(*verb, options->node);
  verb->require_subcommand(1);
  verb->fallthrough();
  verb->add_subcommand("status", "Print identity, position, speed, resolution, alarms, warnings.")
      ->callback([options, &code] { code = print_status(*options); });
  CLI::App* setting = verb->add_subcommand("preset", "Set the present position to COUNTS (6003h).");
  setting->add_option("COUNTS", options->counts, "set this position, counts, below the encoder's range")
      ->required();
  setting->add_flag("--despite-host", options->despite_host,
                    "set it even while a host runs the bus, with no motor armed");
  setting->callback([options, &code] { code = set_preset(*options); });
}

}  // namespace godobject
