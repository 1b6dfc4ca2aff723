// Startup of a Cortex-M7: vectors, FPU, memory, constructors; the status of main() ends the emulator.
#include "board.h"

extern "C" {
extern std::uint32_t stack_top[], bss_begin[], bss_end[], data_begin[], data_end[], data_load[];
extern void (*init_array_begin[])();
extern void (*init_array_end[])();

int main();

/// Prepares the memory as C++ expects it, and runs the program.
[[noreturn, gnu::used]] void start() {
  for (std::uint32_t *to = data_begin, *from = data_load; to < data_end;) *to++ = *from++;
  for (std::uint32_t* to = bss_begin; to < bss_end;) *to++ = 0;
  for (auto* constructor = init_array_begin; constructor < init_array_end; ++constructor) (*constructor)();
  board::exit(main());
}

/// Enables the FPU (CPACR: full access to CP10, CP11) before the first function that may save its registers.
[[noreturn, gnu::naked]] void reset() {
  asm volatile(
      "ldr r0, =0xe000ed88\n ldr r1, [r0]\n orr r1, #0xf00000\n str r1, [r0]\n dsb\n isb\n"
      "b start\n .ltorg");
  __builtin_unreachable();
}

[[noreturn]] void fault() { board::exit(3); }

// Interrupts of a firmware that enables and defines them.
[[gnu::weak, gnu::alias("fault")]] void systick_elapsed();
[[gnu::weak, gnu::alias("fault")]] void uart0_received();
}

namespace {

struct Vectors {
  const void* initial_stack;
  void (*faults[6])();       // reset, NMI, hard fault, memory, bus, usage
  void (*not_enabled[8])();  // reserved, supervisor calls
  void (*systick)();
  void (*interrupts[1])();
};

[[gnu::section(".vectors"), gnu::used]] const Vectors vectors{
    stack_top, {reset, fault, fault, fault, fault, fault}, {}, systick_elapsed, {uart0_received}};

}  // namespace
