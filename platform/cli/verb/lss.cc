// godobject lss: sets node-ID and bit rate of a CANopen node without a usable node-ID.
#include <array>
#include <cstdio>
#include <memory>

#include "hal/canopen/lss.h"
#include "hal/canopen/sdo/sdo.h"
#include "platform/cli/bus/dialogue.h"
#include "platform/cli/command_line.h"
#include "platform/rt/cyclic.h"

namespace godobject {
namespace {

struct LssOptions {
  DialogueOptions dialogue;
  std::vector<std::uint32_t> identity;  // vendor, product, revision, serial; empty: the only node on the bus
  int node_id = 1;
  double new_bit_rate = 0;
  std::optional<int> activate_ms;
  bool alone = false;  // true: no other node is on the bus, and none is searched
};

/// Requests an object that every node has.
CanFrame device_type_request(std::uint8_t node) {
  return sdo::make_frame(sdo::request_cob_id(node),
                         sdo::make_plain(sdo::Request::initiate_upload, {0x1000, 0}));
}

/// Runs the services of one call in their order. The first failure ends the call.
class LssCall {
 public:
  explicit LssCall(const LssOptions& options) : options_(options), master_(options.dialogue.timeout_ns()) {}

  ExitCode open() {
    constexpr std::array answers{CanFilter{.id = lss::response_cob_id, .mask = 0x7FF},
                                 CanFilter{.id = sdo::response_cob_id(0), .mask = 0x780}};
    return bus_.open(options_.dialogue, answers);
  }

  /// Returns the node-IDs that answer an SDO request, once per answer. Their answers have identifiers of
  /// their own and cannot collide. Answers to LSS share one identifier, and several of them destroy each
  /// other.
  std::vector<std::uint32_t> present() {
    constexpr Nanoseconds sending_limit = 5'000'000'000;
    std::vector<std::uint32_t> ids;
    std::uint8_t next = 1;
    Nanoseconds end = MonotonicClock().now() + sending_limit;
    bus_.run([&] { return MonotonicClock().now() < end; },
             [&](const CanFrame& frame) {
               if (const std::uint32_t id = frame.id - sdo::response_cob_id(0);
                   !frame.extended && id >= 1 && id <= canopen::max_node_id)
                 ids.push_back(id);
             },
             [&](Nanoseconds now, CanBus& bus) {
               if (next > canopen::max_node_id) return;
               while (next <= canopen::max_node_id &&
                      bus.try_send(device_type_request(next)) == SendResult::queued)
                 ++next;
               if (next > canopen::max_node_id) end = now + options_.dialogue.timeout_ns();
             });
    return ids;
  }

  /// Switches the node with this identity, or all nodes, to configuration mode.
  bool select() {
    if (options_.identity.empty())
      return run(master_.switch_global(lss::Mode::configuration), lss::Command::switch_global);
    const lss::Identity identity{.vendor = options_.identity[0],
                                 .product = options_.identity[1],
                                 .revision = options_.identity[2],
                                 .serial = options_.identity[3]};
    return run(master_.select(identity), lss::Command::selected);
  }
  bool leave() { return run(master_.switch_global(lss::Mode::waiting), lss::Command::switch_global); }
  bool set_node_id(int id) {
    return run(master_.set_node_id(static_cast<std::uint8_t>(id)), lss::Command::set_node_id);
  }
  bool set_bit_timing(std::uint8_t index) {
    return run(master_.set_bit_timing(index), lss::Command::set_bit_timing);
  }
  bool store() { return run(master_.store(), lss::Command::store); }
  /// Returns one answer of each node in configuration mode; empty if none supports the inquiry.
  std::vector<std::uint32_t> inquire(lss::Command command) {
    if (!master_.inquire(command)) return {};
    run_bus();
    return {master_.answers().begin(), master_.answers().end()};
  }
  bool activate(int delay_ms) {
    return run(master_.activate_bit_timing(static_cast<std::uint16_t>(delay_ms)),
               lss::Command::activate_bit_timing);
  }

 private:
  bool run(bool begun, lss::Command command) {
    if (!begun) return false;
    run_bus();
    if (master_.outcome() == lss::Outcome::done) return true;
    std::fprintf(stderr, "lss: %s%s\n", failure_text(command).c_str(), bus_.trouble().c_str());
    return false;
  }

  void run_bus() {
    bus_.run([&] { return master_.outcome() == lss::Outcome::busy; },
             [&](const CanFrame& frame) { master_.on_frame(frame); },
             [&](Nanoseconds now, CanBus& to) { master_.poll(now, to); });
  }

  std::string failure_text(lss::Command command) const {
    switch (master_.outcome()) {
      case lss::Outcome::rejected:
        return "rejected: error " + std::to_string(master_.error_code()) + ", " +
               lss::text_of(command, master_.error_code());
      case lss::Outcome::not_sent:
        return "the bus did not take the request: check that another node acknowledges frames at this bit "
               "rate";
      default: break;
    }
    const std::string who = options_.identity.empty()
                                ? "check that exactly one node is on the bus"
                                : "check that a node has this identity (godobject sdo read 1018:01 to :04)";
    return "no answer within " + CLI::detail::to_string(options_.dialogue.timeout) + " s: " + who +
           ", that it is powered, that the bus has this bit rate, and that the node supports LSS";
  }

  const LssOptions& options_;
  lss::Master master_;
  BusDialogue bus_;
};

ExitCode print_outcome(bool ok, const char* what) {
  if (ok) std::printf("%s\n", what);
  return ok ? ExitCode::ok : ExitCode::fault;
}

/// True if the ID would go to one node: that with the identity, or the only one on the bus.
bool is_only_one(LssCall& call, const LssOptions& options) {
  if (options.alone || !options.identity.empty()) return true;
  const std::vector<std::uint32_t> ids = call.present();
  if (ids.size() <= 1) return true;
  std::string list;
  for (const std::uint32_t id : ids) list += (list.empty() ? "" : ", ") + std::to_string(id);
  std::fprintf(stderr,
               "lss: %zu nodes are on the bus, and each would get the ID %d: %s. Address one by its identity "
               "with --select VENDOR PRODUCT REVISION SERIAL (godobject sdo --node ID read 1018:01 to :04), "
               "or take the others off the bus. Nothing was changed.\n",
               ids.size(), options.node_id, list.c_str());
  return false;
}

/// True if at most one node has no node-ID. Such nodes answer no SDO, but all answer the inquiry with equal
/// frames, at once or in turn.
bool is_only_one_without_id(LssCall& call, const LssOptions& options) {
  if (options.alone || !options.identity.empty()) return true;
  const std::size_t num_nodes = call.inquire(lss::Command::inquire_node_id).size();
  if (num_nodes > 1)
    std::fprintf(stderr,
                 "lss: %zu nodes would get the ID: take all but one off the bus, or address one with "
                 "--select. Nothing was changed.\n",
                 num_nodes);
  return num_nodes <= 1;
}

ExitCode set_node_id(const LssOptions& options) {
  LssCall call(options);
  if (const ExitCode code = call.open(); code != ExitCode::ok) return code;
  if (!is_only_one(call, options) || !call.select()) return ExitCode::fault;
  if (!is_only_one_without_id(call, options)) {
    static_cast<void>(call.leave());
    return ExitCode::fault;
  }
  const bool ok = call.set_node_id(options.node_id) && call.leave();
  return print_outcome(
      ok,
      "set; in effect after the node's communication is reset; to keep it without power: godobject "
      "lss store");
}

ExitCode set_bit_rate(const LssOptions& options) {
  const std::optional<std::uint8_t> index = lss::bit_timing_index(options.new_bit_rate);
  if (!index) {
    std::fprintf(stderr,
                 "bit rate %g bit/s is not one of CiA 305: 1000000, 800000, 500000, 250000, 125000, 50000, "
                 "20000, 10000\n",
                 options.new_bit_rate);
    return ExitCode::usage;
  }
  LssCall call(options);
  if (const ExitCode code = call.open(); code != ExitCode::ok) return code;
  bool ok = call.select() && call.set_bit_timing(*index);
  if (options.activate_ms) {
    // This side has the wrong rate from here on, so it cannot switch the node out of configuration mode.
    ok = ok && call.store() && call.activate(*options.activate_ms);
    return print_outcome(ok,
                         "stored and activated: set the interface to the new bit rate, and reset the node");
  }
  ok = ok && call.leave();
  return print_outcome(ok, "set; in effect once stored (godobject lss store) and the node's power was off");
}

ExitCode store(const LssOptions& options) {
  LssCall call(options);
  if (const ExitCode code = call.open(); code != ExitCode::ok) return code;
  return print_outcome(call.select() && call.store() && call.leave(), "stored");
}

}  // namespace

void add_lss(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("lss",
                                      "Set the node-ID or the bit rate of a CANopen node that is alone on "
                                      "the bus, or selected by its identity.");
  const auto options = std::make_shared<LssOptions>();
  add_dialogue_options(*verb, options->dialogue);
  verb->add_option("--select", options->identity,
                   "address the node with this identity 1018h: VENDOR PRODUCT REVISION SERIAL")
      ->expected(4);
  verb->require_subcommand(1);
  verb->fallthrough();

  CLI::App* node_id = verb->add_subcommand("node-id", "Set the node's ID.");
  node_id->add_option("ID", options->node_id, "set this node-ID")->required()->check(CLI::Range(1, 127));
  node_id->add_flag("--alone", options->alone, "skip the search for other nodes on the bus");
  node_id->callback([options, &code] { code = set_node_id(*options); });

  CLI::App* bit_rate = verb->add_subcommand("bit-rate", "Set the node's bit rate.");
  bit_rate->add_option("RATE", options->new_bit_rate, "set this bit rate, bit/s")->required();
  bit_rate
      ->add_option("--activate", options->activate_ms,
                   "store the rate and change to it now, with this silence before and after the change, ms")
      ->check(CLI::Range(1, 65535));
  bit_rate->callback([options, &code] { code = set_bit_rate(*options); });

  CLI::App* storing =
      verb->add_subcommand("store", "Store the node's settings, so that they survive a loss of power.");
  storing->callback([options, &code] { code = store(*options); });
}

}  // namespace godobject
