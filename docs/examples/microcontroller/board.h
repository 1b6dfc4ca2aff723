// The board under trace.cc: text, exit status, counters of instructions and of stack. On the host: text alone.
#pragma once

#include <cstddef>
#include <cstdint>

#ifdef __arm__

extern "C" std::uint32_t bss_end[];

namespace board {

/// Calls the debugger or emulator (ARM semihosting).
inline std::uint32_t semihost(std::uint32_t operation, const void* argument) {
  register std::uint32_t r0 asm("r0") = operation;
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}
inline void write(const char* text) { semihost(0x04, text); }  // SYS_WRITE0
[[noreturn]] inline void exit(int status) {
  const std::uint32_t reason_and_status[] = {0x20026, static_cast<std::uint32_t>(status)};
  semihost(0x20, reason_and_status);  // SYS_EXIT_EXTENDED
  for (;;) {
  }
}

struct SysTick {
  volatile std::uint32_t control, reload, value;
};
inline SysTick& systick() { return *reinterpret_cast<SysTick*>(0xe000e010); }
inline constexpr std::uint32_t range = 1 << 24;
inline constexpr double ticks_per_s = 25e6;

inline void start_ticks() {
  systick().reload = range - 1;
  systick().value = 0;
  systick().control = 5;  // enabled, core clock
}
/// Ticks of 40 ns. QEMU with -icount shift=6 lets 64 ns pass per instruction.
inline std::uint32_t ticks() { return range - systick().value; }
inline std::uint32_t instructions(std::uint32_t begin, std::uint32_t end) {
  return static_cast<std::uint32_t>(std::uint64_t{(end - begin) % range} * 40 / 64);
}

/// Sleeps until an interrupt.
inline void wait_for_interrupt() { asm volatile("wfi" ::: "memory"); }

inline std::uint32_t* frame() { return static_cast<std::uint32_t*>(__builtin_frame_address(0)); }
inline constexpr std::uint32_t paint = 0xc5c5c5c5;

/// Paints the free stack, but for `margin` words below this frame.
[[gnu::noinline]] inline void paint_stack() {
  constexpr int margin = 8;
  for (volatile std::uint32_t* word = bss_end; word < frame() - margin; ++word) *word = paint;
}
/// Returns the bytes below this frame that lost their paint.
[[gnu::noinline]] inline std::uint32_t stack_bytes() {
  const std::uint32_t* word = bss_end;
  while (*word == paint) ++word;
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(frame()) -
                                    reinterpret_cast<std::uintptr_t>(word));
}

}  // namespace board

#else

#include <cstdio>

namespace board {

inline void write(const char* text) { std::fputs(text, stdout); }
inline void start_ticks() {}
inline std::uint32_t ticks() { return 0; }
inline std::uint32_t instructions(std::uint32_t, std::uint32_t) { return 0; }
inline void paint_stack() {}
inline std::uint32_t stack_bytes() { return 0; }

}  // namespace board

#endif
