#include "platform/cli/option_checks.h"

#include <charconv>
#include <string>

#include "platform/scene/text/key.h"

namespace godobject {
namespace {

CLI::Validator number(const Range& range) {
  const auto check = [range](const std::string& text) -> std::string {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool complete = error == std::errc() && end == text.data() + text.size();
    return complete && range.contains(value) ? "" : "'" + text + "' is not a number " + to_string(range);
  };
  return {check, to_string(range), "number"};
}

}  // namespace

CLI::Validator number_in(double min, double max) { return number({.min = min, .max = max}); }
CLI::Validator number_above(double min, double max) {
  return number({.min = min, .max = max, .min_open = true});
}

CLI::Validator port_number() {
  constexpr unsigned highest = 65535;
  const auto check = [](const std::string& text) -> std::string {
    unsigned port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    const bool complete =
        error == std::errc() && end == text.data() + text.size() && port >= 1 && port <= highest;
    return text.empty() || complete
               ? ""
               : "'" + text + "' is not a port number, 1 to 65535; write SCENE before --view";
  };
  return {check, "", "port"};
}

}  // namespace godobject
