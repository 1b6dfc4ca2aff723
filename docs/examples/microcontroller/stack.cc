// Measures the stack of a firmware, which is linked with --wrap=main: prints the bytes that main() used.
#include "line.h"

extern "C" {
int __real_main();

int __wrap_main() {
  board::paint_stack();
  const int status = __real_main();
  const std::uint32_t bytes = board::stack_bytes();
  static board::Line line;
  line << "# stack " << std::uint64_t{bytes} << " B";
  line.end();
  return status;
}
}
