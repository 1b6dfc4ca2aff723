// Commands to a running simulation, one a line; each is answered with one line of JSON.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "platform/cli/simulate/simulation.h"

namespace godobject {

/// "fault VERB key=value ...", "clear", "status", "quit". `quit` is set by the last of them. Allocates.
std::string answer(std::string_view command, Simulation& simulation, bool& quit);

/// Whole lines from a descriptor, without waiting for them: while it lives, reading there does not block.
class LineInput {
 public:
  explicit LineInput(int descriptor) noexcept;
  ~LineInput();
  LineInput(const LineInput&) = delete;
  LineInput& operator=(const LineInput&) = delete;

  static constexpr std::size_t max_line = 1001;  // bytes

  /// False: no line is complete yet. Of a longer line the first max_line bytes or some more, once.
  [[nodiscard]] bool try_line(std::string& line);
  /// -1 after its end.
  int descriptor() const noexcept { return ended_ ? -1 : descriptor_; }

 private:
  int descriptor_;
  int former_flags_;
  bool ended_ = false, skips_ = false;
  std::string text_;
};

}  // namespace godobject
