// Planes of another, slower simulation around the tool (docs/how-to/slow-world.md). It computes the
// surroundings at 60 to 500 Hz; the core touches their planes in every step.
//
// A plane moves by its velocity until its sample is too old. A new sample changes the plane, but not the
// depth of the tool. The difference is made up for within `recovery_s`.
//
// A plane that advances against a force does work on the tool. It is limited to the work of the other
// simulation on the planes and a small allowance: a passivity observer and controller.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "platform/device/hand_device.h"
#include "platform/engine/engine.h"
#include "platform/scene/scene.h"

namespace godobject {

// Packets between the simulations: little-endian, without padding, world frame, SI units.

inline constexpr std::size_t max_world_planes = 6, max_world_bodies = 8;

/// Plane that surrounds the tool, as a solid below it.
struct WorldPlane {
  enum Flag : std::uint32_t { has_moved = 1 };

  std::uint32_t id = 0;                         // > 0; the same while it is the same contact
  std::uint32_t flags = 0;                      // has_moved: moved_W_m is known
  std::array<double, 3> p_W_m{}, n_W{0, 0, 1};  // a point; normal, out of the solid
  std::array<double, 3> v_W_m_s{};              // velocity of the solid there
  // displacement of the solid there since the packet before; unknown: the mean of both velocities acts
  std::array<double, 3> moved_W_m{};
  double k_N_m = 0, c_Ns_m = 0;  // stiffness > 0, damping; of each touching sphere
};
static_assert(sizeof(WorldPlane) == 120);

/// State of the surroundings, from the other simulation.
struct WorldPacket {
  static constexpr std::uint32_t magic_of_worlds = 0x314e4957, version_of_worlds = 1;  // "WIN1"

  std::uint32_t magic = magic_of_worlds, version = version_of_worlds;
  std::uint64_t number = 0;   // greater than that of the packet before
  std::uint64_t answers = 0;  // number of the newest ToolPacket whose impulses this state contains
  double t_s = 0;             // time of the state on CLOCK_MONOTONIC
  double valid_s = 0;         // time for which it may be used, at most 1 s
  std::uint32_t num_planes = 0;
  std::uint32_t reserved = 0;
  std::array<WorldPlane, max_world_planes> planes{};
};
static_assert(sizeof(WorldPacket) == 48 + max_world_planes * 120);

struct ToolBody {
  std::array<double, 3> p_W_m{};
  std::array<double, 4> q_W_wxyz{1, 0, 0, 0};
  std::array<double, 3> w_W_rad_s{}, v_W_m_s{};  // v: of the centre of mass
};

/// Impulse on a plane since its first sample.
struct WorldImpulse {
  std::uint32_t id = 0;  // 0: none
  std::uint32_t reserved = 0;
  std::array<double, 3> p_W_m{};   // point at which the newest force acts
  std::array<double, 3> J_W_Ns{};  // on the other simulation
};

/// State of the tool after a step, to the other simulation.
struct ToolPacket {
  enum Flag : std::uint32_t { live = 1 };

  std::uint64_t number = 0;                   // of the step, from 1
  double t_s = 0, t_run_s = 0;                // CLOCK_MONOTONIC; time of the run
  std::uint32_t flags = 0;                    // live: newest WorldPacket is in use
  std::uint32_t num_bodies = 0;               // bodies of the scene, at most max_world_bodies
  std::array<double, 3> f_W_N{}, tau_W_Nm{};  // of the planes on all bodies, about the first body's centre
  std::array<ToolBody, max_world_bodies> bodies{};
  std::array<WorldImpulse, max_world_planes> planes{};
};
static_assert(sizeof(ToolPacket) == 80 + max_world_bodies * 104 + max_world_planes * 56);

/// Exchange with the other simulation. Real-time, wait-free.
class WorldLink {
 public:
  virtual ~WorldLink() = default;
  /// Copies the newest packet. Returns false if there is none since the last call.
  virtual bool receive(WorldPacket& packet) noexcept GODOBJECT_NONBLOCKING = 0;
  virtual void send(const ToolPacket& packet) noexcept GODOBJECT_NONBLOCKING = 0;
};

struct WorldLimits {
  double allowance_J = 0.01;  // energy that the planes may add without work of the other simulation
  double recovery_s = 0.02;   // time constant in which a plane reaches its sample
  double max_recovery = 0.5;  // m/s
  double release_s = 0.25;    // time in which the force of a plane without samples fades
};

struct WorldCounters {
  bool live = false;            // the newest packet is in use
  std::uint64_t packets = 0;    // used
  std::uint64_t malformed = 0;  // refused: count, number, a value that is no plane, a time in the future
  std::uint64_t late = 0;       // ignored: older than valid_s
  std::uint64_t silences = 0;   // times that no packet came in time
  std::uint64_t limited = 0;    // steps in which passivity held a plane back
};

/// Planes of a scene with `world_planes`. No function but the constructor allocates.
class WorldPlanes {
 public:
  /// engine: that of the scene. link: must outlive this object. clock: CLOCK_MONOTONIC.
  WorldPlanes(const SceneConfig& scene, const Engine& engine, WorldLink& link, LoopClock clock,
              const WorldLimits& limits = {});

  /// Moves the planes of the engine before its step.
  void begin(Engine& engine) noexcept GODOBJECT_NONBLOCKING;
  /// Sends the state after the step. t: time of the run, s.
  void end(const Engine& engine, double t) noexcept GODOBJECT_NONBLOCKING;

  const WorldCounters& counters() const noexcept { return counters_; }
  /// Returns the energy that the planes may add at present, J.
  double credit_J() const noexcept { return settled_J_ - (work_J_ - answered_J_); }

 private:
  struct Track {
    std::uint32_t id = 0;  // 0: free
    WorldPlane sample{};
    double offset = 0;             // the plane lies below its sample by this, m
    double k = 0;                  // N/m
    double fade = 1;               // share of k that is left; falls once the plane is released
    bool is_released = false;      // true if its sample is out of use
    double predicted = 0;          // motion along the normal since the time of the sample, m
    double advance = 0;            // motion along the normal before the present step, m
    double F = 0;                  // normal force, mean over the last step, N
    Vec3 J_W = Vec3::Zero();       // impulse on the other simulation, N s
    Vec3 J_done_W = Vec3::Zero();  // part of it that the other simulation has taken
    Vec3 p_W = Vec3::Zero();       // point at which the newest force acts, m
  };
  /// Sums at the end of a step.
  struct Sums {
    std::uint64_t number = 0;
    double work_J = 0;                         // of the planes on the tool
    std::array<Vec3, max_world_planes> J_W{};  // impulses of the tracks
    std::array<std::uint32_t, max_world_planes> id{};
  };
  static constexpr std::size_t num_sums = 1024;

  bool is_valid(const WorldPacket& packet) const noexcept;
  void take(const WorldPacket& packet, const Engine& engine) noexcept;
  double work_of_world(std::size_t i, const WorldPlane* sample, double dt, const Sums& sums) noexcept;
  void assign(Track& track, const WorldPlane& sample, double depth_before, const Engine& engine) noexcept;
  void release(Track& track) noexcept;
  void fade(Track& track) noexcept;
  void move(Track& track, const Engine& engine) noexcept;
  void observe(const Engine& engine) noexcept;
  double predicted(const Track& track) const noexcept;
  Vec3 point_of(const Track& track) const noexcept;
  double depth_of(const Track& track, const Engine& engine) const noexcept;
  double extrapolated_s(double t_s) const noexcept;

  WorldLink& link_;
  LoopClock clock_;
  WorldLimits limits_;
  double h_;
  std::vector<Track> tracks_;
  std::vector<ContactView> contacts_;
  std::vector<Sums> sums_;  // of the last steps, at number % num_sums
  WorldPacket newest_;
  ToolPacket tool_;
  double now_s_ = 0, before_s_ = 0;  // this step and the one before, on the clock, s
  // Energy balance of the planes: credit_J() = settled - work since the answered step.
  double settled_J_, work_J_ = 0, answered_J_ = 0;
  double available_J_ = 0;  // left of the credit in this step
  WorldCounters counters_;
};

}  // namespace godobject
