#include "platform/device/rig.h"

#include <array>
#include <cmath>

#include "hal/rig/validate.h"

namespace godobject {

Nanoseconds gather_time(double step) noexcept {
  constexpr double gather_share = 0.75;  // fraction of the period
  const auto period_ns = static_cast<double>(std::llround(step * 1e9));
  return static_cast<Nanoseconds>(gather_share * period_ns) / gather_polls * gather_polls;
}

std::vector<std::string> RigDevice::complaints(const SceneConfig& scene) {
  const RigParams& rig = *scene.device->rig;
  std::vector<std::string> errors = validate(rig, scene.step);
  if (scene.device->kind == DeviceKind::admittance)
    errors.push_back("an admittance device runs only with --bus direct");
  if (!errors.empty()) return errors;
  const std::vector<std::optional<std::size_t>> by_handle = driven_by_handles(scene);
  for (std::size_t handle = 0; handle < by_handle.size(); ++handle)
    if (!by_handle[handle])
      errors.push_back("handle of body '" + rig.tree.handles[handle].body +
                       "': the scene has no coupled body of this name");
  return errors;
}

RigDevice::RigDevice(const SceneConfig& scene, std::unique_ptr<RigLink> link,
                     std::vector<PassivityParams> controllers)
    : params_(*scene.device->rig),
      cycle_s_(scene.step),
      joints_(scene),
      link_(std::move(link)),
      controllers_(std::move(controllers)),
      swings_(params_.drives, cycle_s_),
      gather_ns_(gather_time(cycle_s_)) {
  const std::vector<std::size_t> driven = driven_bodies(scene);
  for (const std::optional<std::size_t>& target : driven_by_handles(scene))
    bodies_.push_back(driven[*target]);
  for (CanBus* const bus : link_.buses()) timed_.emplace_back(*bus);
  make_rig();
}

void RigDevice::make_rig() {
  std::vector<CanBus*> buses;
  for (TimedBus& bus : timed_) buses.push_back(&bus);
  rig_.emplace(params_, cycle_s_, buses);
  rig_->control_passivity(controllers_);
}

void RigDevice::boot(Period& period) noexcept {
  note(RigCall::boot);
  static_cast<void>(exchange(period, true));
  static_cast<void>(send(period, {}));
}

/// Begins a period on the buses. A simulated device computes the rest of the last one.
void RigDevice::begin(Period& period) noexcept {
  for (TimedBus& bus : timed_) bus.time_by(period.stages);
  const InStage stage(period.stages, Stage::wait);
  period.began = link_.begin_cycle(period.t);
  period.has_begun = true;
}

Nanoseconds RigDevice::wait(Period& period, Nanoseconds until) noexcept {
  const InStage stage(period.stages, Stage::wait);
  return link_.wait(until);
}

/// Sends SYNC and receives the answers, until all have arrived or their share of the period is over.
DeviceSample RigDevice::exchange(Period& period, bool starting) noexcept {
  begin(period);
  if (starting) rig_->start(period.began);
  rig_->receive(period.began);  // before SYNC: a serial line stamps frames when it reads them
  rig_->sync(period.began);
  period.now = period.began;
  const Nanoseconds deadline = period.began + gather_ns_;
  do {
    period.now = wait(period, deadline);
    rig_->receive(period.now);
  } while (!rig_->complete() && period.now < deadline);
  return rig_->read(period.now);
}

void RigDevice::read(Period& period, std::span<BodySample> samples) noexcept {
  note(RigCall::read);
  const DeviceSample device = exchange(period, false);
  const bool valid = device.valid && device.fresh;
  buttons_before_ = buttons_;
  buttons_ = device.buttons;
  q_ = device.q;
  const bool has_clutch = rig_->has_button(ButtonUse::clutch);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    BodySample& sample = samples[bodies_[k]];
    sample.target = device.handles[k];
    sample.valid = valid;
    if (has_clutch) sample.clutch = buttons_.clutch;
  }
  joints_.write({.q = device.q, .q_dot = device.q_dot}, valid, samples);
}

/// Displays the wrenches on the drives, and watches the drives' commands for oscillation between their
/// bounds.
void RigDevice::command(Period& period, std::span<const Wrench> F_hand_W, Shown& shown) noexcept {
  note(RigCall::command, shown.oscillates ? 1 : 0,
       static_cast<std::uint32_t>(std::llround(period.t / cycle_s_)));
  std::array<Wrench, max_handles> of_handles;
  for (std::size_t k = 0; k < bodies_.size(); ++k) of_handles[k] = F_hand_W[bodies_[k]];
  shown.drives = send(period, std::span(of_handles).first(bodies_.size()));
  const std::optional<std::size_t> drive = swings_.commands(*rig_, shown.drives);
  if (drive) shown.oscillates = true;
  if (shown.oscillates) rig_->force_oscillates(drive);
  shown.faults = rig_->faults();
  note(RigCall::commanded);
}

void RigDevice::tell(RunTrouble trouble) noexcept {
  note(RigCall::trouble, static_cast<std::uint8_t>(trouble));
  switch (trouble) {
    case RunTrouble::energy_gained: return rig_->energy_gained();
    case RunTrouble::deadlines_missed: return rig_->deadlines_missed();
  }
}

CommandReport RigDevice::send(Period& period, std::span<const Wrench> F_hand_W) noexcept {
  const CommandReport report = rig_->command(F_hand_W, period.now);
  link_.end_cycle();
  return report;
}

/// Receives frames in a period without SYNC.
void RigDevice::take_in(Period& period) noexcept {
  begin(period);
  period.now = wait(period, period.began);
  rig_->receive(period.now);
}

bool RigDevice::run_down(Period& period) noexcept {
  note(RigCall::run_down);
  if (!commands_torque()) return false;
  static_cast<void>(exchange(period, false));
  static_cast<void>(send(period, {}));
  return true;
}

void RigDevice::stop(Period& period) noexcept {
  note(RigCall::stop);
  take_in(period);  // makes space in the transmit queues
  rig_->stop();
}

/// True if any drive on a bus that still works is commanded torque.
bool RigDevice::commands_torque() const noexcept {
  for (std::size_t i = 0; i < rig_->num_drives(); ++i)
    if (rig_->commanded_torque_Nm(i) != 0 && !is_cut_off(link_.ports()[params_.drives[i].bus]->state()))
      return true;
  return false;
}

void RigDevice::restart() {
  note(RigCall::restart);
  earlier_rigs_ = counters();
  make_rig();
  swings_.reset();
}

RigCounters RigDevice::counters() const noexcept {
  static_assert(sizeof(RigCounters) == 7 * sizeof(std::uint64_t), "every counter is added up here");
  RigCounters sum = earlier_rigs_;
  const RigCounters& now = rig_->counters();
  sum.syncs += now.syncs;
  sum.incomplete_syncs += now.incomplete_syncs;
  sum.frames += now.frames;
  sum.malformed += now.malformed;
  sum.repeated += now.repeated;
  sum.foreign += now.foreign;
  sum.receive_truncated += now.receive_truncated;
  return sum;
}

}  // namespace godobject
