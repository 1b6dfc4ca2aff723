// A slow simulation beside a session, in the session's time: a block on a spring that meets the tool. It is
// exchanged at 60 Hz with up to 30 ms of jitter.
#pragma once

#include <cmath>
#include <deque>
#include <random>

#include "platform/session/session.h"

namespace godobject::test {

/// Clock of session and world, ns. One period a step.
inline Nanoseconds world_clock_ns = 0;
inline Nanoseconds read_world_clock() noexcept { return world_clock_ns; }

/// Block that slides along x, with its face towards the tool.
struct Block {
  double mass = 1, k = 0, g = 0;  // kg; spring and damper to the world, N/m, N s/m
  double rest = 0.03;             // x of its face where the spring is at rest, m
  double x = 0.03, v = 0;         // of its face, m, m/s
  bool is_fixed = false;          // true: moves at v whatever pushes it

  double energy() const { return 0.5 * mass * v * v + 0.5 * k * (x - rest) * (x - rest); }
  /// Moves it by t under a constant force, in substeps of 0.1 ms.
  void move(double t, double F) {
    if (is_fixed) x += t * v;
    if (is_fixed) return;
    const int n = std::max(1, static_cast<int>(std::ceil(t / 1e-4)));
    const double h = t / n;
    for (int i = 0; i < n; ++i) {
      v += h * (F - k * (x - rest) - g * v) / mass;
      x += h * v;
    }
  }
};

class SlowWorld final : public WorldLink {
 public:
  Block block;
  double rate_hz = 60, jitter_s = 0.03, valid_s = 0.15;
  double k = 1000, c = 5;  // of the contact of each sphere
  bool is_killed = false;
  std::optional<WorldPacket> forged;  // sent instead of the next packet
  ToolPacket tool;                    // newest
  std::uint64_t number = 0;

  bool receive(WorldPacket& packet) noexcept override {
    if (forged) {
      packet = *std::exchange(forged, std::nullopt);
      return true;
    }
    if (is_killed || tool.number == 0) return false;
    const double now_s = 1e-9 * static_cast<double>(world_clock_ns);
    if (now_s < due_s_) return false;
    packet = next_;
    const bool is_first = next_.number == 0;
    compute(now_s);
    return !is_first;
  }
  void send(const ToolPacket& packet) noexcept override { tool = packet; }

  WorldPlane plane() {
    return {.id = 1,
            .flags = WorldPlane::has_moved,
            .p_W_m = {block.x, 0, 0},
            .n_W = {-1, 0, 0},
            .v_W_m_s = {block.v, 0, 0},
            .moved_W_m = {block.x - std::exchange(x_before_, block.x), 0, 0},
            .k_N_m = k,
            .c_Ns_m = c};
  }
  /// Returns a packet of the state now, with a rising number.
  WorldPacket packet() {
    WorldPacket packet{.number = ++number,
                       .answers = tool.number,
                       .t_s = 1e-9 * static_cast<double>(world_clock_ns),
                       .valid_s = valid_s,
                       .num_planes = 1};
    packet.planes[0] = plane();
    return packet;
  }

 private:
  /// Computes the state of now, which is sent a period and some jitter later.
  void compute(double now_s) noexcept {
    const double dt = now_s - computed_s_;
    const double J = tool.planes[0].id == 1 ? tool.planes[0].J_W_Ns[0] : 0;
    if (computed_s_ > 0 && dt > 0) block.move(dt, (J - taken_) / dt);
    taken_ = J;
    computed_s_ = now_s;
    due_s_ = now_s + 1 / rate_hz + jitter_s * std::uniform_real_distribution<>()(random_);
    next_ = packet();
  }

  std::mt19937 random_{5};
  WorldPacket next_;
  double computed_s_ = 0, due_s_ = 0, taken_ = 0, x_before_ = 0;
};

}  // namespace godobject::test
