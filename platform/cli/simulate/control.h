// Commands to a running simulation, one per line, each answered by one line of JSON.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "platform/cli/simulate/simulation.h"

namespace godobject {

/// Executes "fault VERB key=value ...", "clear", "status" or "quit", and returns the answer. Allocates.
/// quit: set by the command of that name.
std::string answer(std::string_view command, Simulation& simulation, bool& quit);

/// Reads whole lines from a descriptor without blocking, which it sets for the descriptor during its life.
class LineInput {
 public:
  explicit LineInput(int descriptor) noexcept;
  ~LineInput();
  LineInput(const LineInput&) = delete;
  LineInput& operator=(const LineInput&) = delete;

  static constexpr std::size_t max_line = 1001;  // bytes

  /// Returns false if no line is complete yet. Of a longer line it returns the first max_line bytes or more,
  /// once.
  [[nodiscard]] bool try_line(std::string& line);
  /// Returns -1 after the end of input.
  int descriptor() const noexcept { return ended_ ? -1 : descriptor_; }

 private:
  int descriptor_;
  int former_flags_;
  bool ended_ = false, skips_ = false;
  std::string text_;
};

}  // namespace godobject
