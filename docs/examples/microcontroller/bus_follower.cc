// A tool on a bus: an ODrive's encoder moves it, its force becomes the drive's torque. The hand on the drive holds
// the weight of the tool. Ends after 400 samples; the rig: bus-follower.toml.
#include "hal/drive/odrive.h"
#include "line.h"
#include "scenes.h"
#include "uart_bus.h"

namespace {

using namespace scenes;

constexpr std::uint8_t node = 1;
constexpr double m_per_motor_rad = 0.02;
constexpr double cycle_s = 5e-3;
constexpr std::uint32_t max_answer_cycles = 80;  // until a sample arrives, of a rig on a busy machine
constexpr int num_samples = 400, printed_every = 10;
constexpr int max_silent_cycles = 10;  // without a sample: no rig

struct Insertion : Follower {
  using Feedback = LimitedFeedback;
};
static_assert(Scene<Insertion>);

/// The drive as its frames report it, and the way to torque control.
class Drive {
 public:
  void begin_cycle() { fresh_ = false; }
  void receive(const CanFrame& frame) {
    if (check(frame, node, odrive::Command::encoder_estimates, 8) == ParseResult::ok) {
      odrive::EncoderEstimates now;
      ByteReader(frame.bytes()).get(now.position_rev).get(now.velocity_rev_per_s);
      if (!std::isfinite(now.position_rev) || !std::isfinite(now.velocity_rev_per_s)) return;
      estimates_ = now;
      fresh_ = true;
    } else if (parse_heartbeat(frame, node, heartbeat_) == ParseResult::ok) {
      if (!enabled() && step_ == 0) step_ = 3;
    }
  }
  /// Returns the command of a cycle: a step towards torque control, else the torque.
  CanFrame command(double force_N) {
    switch (step_ > 0 ? step_-- : 0) {
      case 3: return odrive::make_clear_errors(node);
      case 2: return odrive::make_torque_mode(node);
      case 1: return odrive::make_set_axis_state(node, odrive::axis_closed_loop);
      default:
        return odrive::make_input_torque(node, enabled() ? static_cast<float>(force_N * m_per_motor_rad) : 0);
    }
  }
  bool enabled() const { return heartbeat_.axis_state == odrive::axis_closed_loop && heartbeat_.error == 0; }
  bool fresh() const { return fresh_; }
  double position() const { return 2 * pi * m_per_motor_rad * static_cast<double>(estimates_.position_rev); }

 private:
  odrive::Heartbeat heartbeat_;
  odrive::EncoderEstimates estimates_;
  bool fresh_ = false;  // a sample has arrived in this cycle
  int step_ = 0;        // steps left until torque control
};

Params<Insertion> par;
State<Insertion> x;
Input<Insertion> in;
Output<Insertion> out;
Scratch<Insertion> w;
board::UartBus bus;
Drive drive;
board::Line line;
std::atomic<std::uint32_t> cycles = 0;  // of SysTick

void set_up() {
  par.h = Real(cycle_s);
  par.gravity_W = {0, 0, Real(-9.81)};
  par.bodies[0].body = body(0.2, 1e-4, 1e-4, 1e-4);
  par.bodies[0].coupling = {.k = 500, .g = 14, .k_r = 1, .g_r = 0.02};
  par.bodies[0].feedback.gains = {.k = 500, .g = 1, .k_r = 0, .g_r = 0};
  place(x, 0, {});
}

/// Starts the interrupts of SysTick, one a cycle.
void start_cycles() {
  board::systick().reload = static_cast<std::uint32_t>(cycle_s * board::ticks_per_s) - 1;
  board::systick().value = 0;
  board::systick().control = 7;  // enabled, with interrupt, core clock
}

/// Waits for the drive's sample, at most max_answer_cycles.
void receive(std::uint32_t begin) {
  drive.begin_cycle();
  for (;;) {
    for (CanFrame frame; bus.try_receive(frame);) drive.receive(frame);
    if (drive.fresh() || cycles - begin >= max_answer_cycles) return;
    board::wait_for_interrupt();
  }
}

void print() {
  line << "sample," << drive.position() << "," << static_cast<double>(out.bodies[0].X_WB.p.z()) << ","
       << static_cast<double>(out.bodies[0].feedback.F_D.f.z()) << "," << std::uint64_t{drive.enabled()};
  line.end();
}

/// Moves the tool: with the drive's position until the drive is enabled, then by a step of the core.
void move() {
  const auto z = static_cast<Real>(drive.position());
  auto& device = in.devices[0];
  // The velocity is that of the positions, because cycles of an emulated board may take longer than a step.
  const Real z_last = device.target.X_WD.p.z();
  device.target = {.X_WD = {.p = {0, 0, z}}, .V_WD = {.v = {0, 0, (z - z_last) / par.h}}};
  device.valid = drive.fresh();
  if (drive.enabled()) step(par, in, x, w, out);
  else place(x, 0, {.X_WB = device.target.X_WD});
}

/// Returns the number of samples after which the loop ended; fewer than num_samples if the bus fell silent.
int loop() {
  int samples = 0;
  for (int silent = 0; samples < num_samples && silent < max_silent_cycles; ++silent) {
    const std::uint32_t begin = cycles;
    bus.try_send(odrive::make_request(node, odrive::Command::encoder_estimates));
    receive(begin);
    move();
    bus.try_send(drive.command(static_cast<double>(out.bodies[0].feedback.F_D.f.z())));
    if (drive.fresh()) {
      silent = 0;
      if (samples++ % printed_every == 0) print();
    }
    while (cycles == begin) board::wait_for_interrupt();
  }
  return samples;
}

}  // namespace

extern "C" void systick_elapsed() { ++cycles; }
extern "C" void uart0_received() { board::receive_bytes(); }

int main() {
  set_up();
  bus.open();
  start_cycles();
  const int samples = loop();
  bus.try_send(odrive::make_input_torque(node, 0));
  bus.try_send(odrive::make_set_axis_state(node, odrive::axis_idle));
  line << "# " << std::uint64_t(samples) << " samples, " << std::uint64_t{board::received.num_dropped()}
       << " bytes dropped, fault " << std::uint64_t(out.fault);
  line.end();
  return samples == num_samples && out.fault == Fault::none ? 0 : 1;
}
