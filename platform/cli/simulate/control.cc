// Commands to a running simulation.
#include "platform/cli/simulate/simulation.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace godobject {
namespace {

using json = nlohmann::ordered_json;

json error(const std::string& what) { return {{"ok", false}, {"error", what}}; }

json play(std::string_view words, Simulation& simulation) {
  std::string what;
  const std::optional<FaultConfig> config = parse_fault(words, what);
  if (config) what = simulation.play(*config);
  if (!what.empty()) return error(what);
  return {{"ok", true}, {"t_s", 1e-9 * static_cast<double>(simulation.now())}};
}

}  // namespace

std::string answer(std::string_view command, Simulation& simulation, bool& quit) {
  if (command.size() >= LineInput::max_line)
    return error("longer than " + std::to_string(LineInput::max_line - 1) + " bytes: the line was ignored")
        .dump();
  const std::size_t space = command.find(' ');
  const std::string_view verb = command.substr(0, space);
  json reply{{"ok", true}};
  if (verb == "fault" && space != std::string_view::npos) {
    reply = play(command.substr(space + 1), simulation);
  } else if (verb == "clear") {
    simulation.clear_faults();
  } else if (verb == "status") {
    reply.update(simulation.to_json());
  } else if (verb == "quit") {
    quit = true;
  } else {
    reply = error(std::string(command) +
                  ": expected fault VERB [bus=NAME] [node=ID] [tracker=NAME] [value=X] [duration=S] [at=S], "
                  "clear, status or "
                  "quit");
  }
  return reply.dump(-1, ' ', false, json::error_handler_t::replace);  // replaces bytes that are not UTF-8
}

LineInput::LineInput(int descriptor) noexcept
    : descriptor_(descriptor), former_flags_(fcntl(descriptor, F_GETFL)) {
  fcntl(descriptor, F_SETFL, former_flags_ | O_NONBLOCK);
}

LineInput::~LineInput() { fcntl(descriptor_, F_SETFL, former_flags_); }

bool LineInput::try_line(std::string& line) {
  std::array<char, 256> buffer{};
  while (!ended_ && text_.find('\n') == std::string::npos && text_.size() < max_line) {
    const ssize_t size = ::read(descriptor_, buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) return false;
    if (size <= 0) ended_ = true;
    else text_.append(buffer.data(), static_cast<std::size_t>(size));
  }
  const std::size_t found = text_.find('\n'), end = std::min(found, text_.size());
  if (text_.empty()) return false;
  if (skips_) {  // skip the rest of a line whose beginning was answered
    text_.erase(0, end + 1);
    skips_ = found == std::string::npos && !ended_;
    return try_line(line);
  }
  line = text_.substr(0, end);
  text_.erase(0, end + 1);
  skips_ = found == std::string::npos && !ended_;
  return true;
}

}  // namespace godobject
