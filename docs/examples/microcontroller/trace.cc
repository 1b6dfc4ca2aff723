// Runs a scene for 2 s; prints every 50th pose, then the steps, the instructions per step, the deepest stack
// and the size of the scene.
#include "board.h"
#include "scenes.h"

namespace {

using namespace scenes;

constexpr int num_steps = 2000, printed_every = 50;

/// A line of text. newlib's printf is not used: it allocates for a number with a fraction.
class Line {
 public:
  Line& operator<<(const char* text) {
    while (*text != 0) text_[size_++] = *text++;
    return *this;
  }
  Line& operator<<(std::uint64_t number) { return digits(number, 1); }
  /// Adds a number with 12 decimals, |x| < 1e6.
  Line& operator<<(Real x) {
    if (x < 0) text_[size_++] = '-';
    const Real size = std::abs(x);
    std::uint64_t whole = static_cast<std::uint64_t>(size);
    std::uint64_t rest =
        static_cast<std::uint64_t>((size - static_cast<Real>(whole)) * Real(1e12) + Real(0.5));
    if (rest == decimals) rest = 0, ++whole;
    digits(whole, 1);
    text_[size_++] = '.';
    return digits(rest, 12);
  }
  /// Prints the line and begins the next one.
  void end() {
    text_[size_++] = '\n';
    text_[size_] = 0;
    board::write(text_);
    size_ = 0;
  }

 private:
  static constexpr std::uint64_t decimals = 1'000'000'000'000;

  Line& digits(std::uint64_t number, int least) {
    char reversed[20];
    int n = 0;
    for (; number > 0 || n < least; number /= 10) reversed[n++] = static_cast<char>('0' + number % 10);
    while (n > 0) text_[size_++] = reversed[--n];
    return *this;
  }

  char text_[200];
  int size_ = 0;
};

template <Scene S>
[[gnu::noinline]] void one_step(Run<S>& run) {
  step(run.par, run.in, run.x, run.w, run.out);
}

template <Scene S>
void print_poses(Line& line, int number, const Run<S>& run) {
  for (std::size_t i = 0; i < num_bodies(run.par); ++i) {
    line << std::uint64_t(number) << "," << std::uint64_t(i);
    const Pose& X = run.out.bodies[i].X_WB;
    for (const Real a : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}) line << "," << a;
    line.end();
  }
}

/// Returns true if no step had a fault.
template <Scene S>
bool print_run(Line& line, Run<S>& run) {
  run.begin();
  if (validate(run.par) != Invalid::nothing) return false;
  std::uint64_t instructions = 0, most = 0;
  board::paint_stack();
  for (int number = 1; number <= num_steps; ++number) {
    run.sample(number);
    const std::uint32_t begin = board::ticks();
    one_step(run);
    const std::uint64_t taken = board::instructions(begin, board::ticks());
    instructions += taken;
    most = std::max(most, taken);
    if (run.out.fault != Fault::none) return false;
    if (number % printed_every == 0) print_poses(line, number, run);
  }
  line << "# " << std::uint64_t(num_steps) << " steps, instructions per step " << instructions / num_steps
       << ", most " << most << ", stack " << std::uint64_t(board::stack_bytes()) << " B, memory "
       << std::uint64_t(sizeof run) << " B";
  line.end();
  return true;
}

Run<SCENE> run;  // the type of a scene, defined by the build

}  // namespace

int main() {
  Line line;
  board::start_ticks();
  line << "step,body,x,y,z,qw,qx,qy,qz";
  line.end();
  return print_run(line, run) ? 0 : 1;
}
