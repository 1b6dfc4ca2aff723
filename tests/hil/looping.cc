// The program godobject, with a step that loops forever once the first word of the file $GODOBJECT_LOOP is
// not 0. The second word is then the time of day at which the loop began, s: test_torque_gone.py.
#include <fcntl.h>
#include <sys/mman.h>

#include <atomic>
#include <chrono>
#include <cstdlib>

#include "platform/cli/program.h"
#include "platform/simulated/session.h"

namespace godobject {
namespace {

struct Shared {
  std::atomic<std::uint64_t> begins;
  std::atomic<double> t_begin_s;
};

/// Returns the shared memory; null without the file.
Shared* shared() {
  const char* const path = std::getenv("GODOBJECT_LOOP");
  const int fd = path != nullptr ? open(path, O_RDWR | O_CLOEXEC) : -1;
  if (fd < 0) return nullptr;
  void* const memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  return memory == MAP_FAILED ? nullptr : static_cast<Shared*>(memory);
}

class Looping final : public WrappedEngine {
 public:
  using WrappedEngine::WrappedEngine;

  StepReport step(std::span<const BodySample> samples) noexcept override {
    if (shared_ != nullptr && shared_->begins.load() != 0) {
      const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
      shared_->t_begin_s = now.count();
      while (shared_->begins.load() != 0) continue;
    }
    return WrappedEngine::step(samples);
  }

 private:
  Shared* shared_ = shared();
};

}  // namespace
}  // namespace godobject

int main(int argc, char** argv) {
  using namespace godobject;
  return run_program(
      argc, argv,
      {.simulated = simulated_devices(),
       .add_verb = add_simulate,
       .engine = [](std::unique_ptr<Engine> engine, const SceneConfig&) -> std::unique_ptr<Engine> {
         return std::make_unique<Looping>(std::move(engine));
       }});
}
