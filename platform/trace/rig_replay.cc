#include "platform/trace/rig_replay.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <limits>

#include "platform/rt/loop_calls.h"
#include "platform/session/passivity.h"

namespace godobject {
namespace {

std::string text_of(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", x);
  return text.data();
}

std::string difference(const std::string& name, const std::string& recorded, const std::string& replayed) {
  return name + " is " + recorded + " in the recording, " + replayed + " in the replay";
}

JointVector vector_of(std::span<const double> numbers) {
  JointVector q(static_cast<Eigen::Index>(numbers.size()));
  std::ranges::copy(numbers, q.begin());
  return q;
}

}  // namespace

// ---- buses ----------------------------------------------------------------------------------------

ReplayedLink::ReplayedLink(std::size_t num_buses) {
  for (std::size_t i = 0; i < num_buses; ++i) {
    buses_.push_back(std::make_unique<ReplayedBus>(*this, static_cast<std::uint8_t>(i)));
    ports_.push_back(buses_.back().get());
  }
}

bool ReplayedLink::skip_to_restart() noexcept {
  const auto is_restart = [](const LinkEvent& event) {
    return event.kind == LinkEvent::Kind::call && event.call == RigCall::restart;
  };
  events_.erase(events_.begin(), std::ranges::find_if(events_, is_restart));
  return !events_.empty();
}

std::optional<std::uint32_t> ReplayedLink::next_command() const noexcept {
  if (events_.empty() || events_.front().kind != LinkEvent::Kind::call ||
      events_.front().call != RigCall::command)
    return std::nullopt;
  return events_.front().cycle;
}

std::optional<LinkEvent> ReplayedLink::take_call() noexcept {
  if (events_.empty() || events_.front().kind == gap) {
    end_ = End::missing;
    return std::nullopt;
  }
  const LinkEvent call = events_.front();
  if (call.kind != LinkEvent::Kind::call || (call.call != RigCall::restart && call.results != results_)) {
    end_ = End::other;
    return std::nullopt;
  }
  events_.pop_front();
  results_ = 0;
  return call;
}

void ReplayedLink::begin_again() noexcept {
  results_ = 0;
  sent_ = {};
  end_ = End::none;
  for (const std::unique_ptr<ReplayedBus>& bus : buses_) bus->begin_again();
}

/// Returns the recorded result of a call of this kind; null if it was the usual one.
const LinkEvent* ReplayedLink::result(LinkEvent::Kind kind, std::uint8_t bus) noexcept {
  if (end_ != End::none) return nullptr;
  if (events_.empty() || events_.front().kind == gap) {
    end_ = End::missing;
    return nullptr;
  }
  const LinkEvent& next = events_.front();
  if (results_ < next.results) {
    ++results_;
    return nullptr;
  }
  if (next.kind != kind || next.bus != bus) {
    const bool lacks_events = next.kind == LinkEvent::Kind::call && next.call == RigCall::restart;
    end_ = lacks_events ? End::missing : End::other;
    return nullptr;
  }
  taken_ = next;
  const loop::MayWait scope;  // no rig waits for a replay
  events_.pop_front();
  results_ = 0;
  return &taken_;
}

/// Returns a recorded time, which no call lacks.
Nanoseconds ReplayedLink::time(LinkEvent::Kind kind, Nanoseconds otherwise) noexcept {
  const LinkEvent* const event = result(kind, 0);
  if (event == nullptr && end_ == End::none) end_ = End::other;
  return now_ = event != nullptr ? event->t_ns : otherwise;
}

Nanoseconds ReplayedLink::begin_cycle(double /*motion_time*/) noexcept {
  return time(LinkEvent::Kind::began, now_);
}

Nanoseconds ReplayedLink::wait(Nanoseconds until) noexcept { return time(LinkEvent::Kind::waited, until); }

SendResult ReplayedLink::ReplayedBus::try_send(const CanFrame& frame) noexcept {
  link_.sent_.add(index_, frame);
  const LinkEvent* const event = link_.result(LinkEvent::Kind::refused, index_);
  return event != nullptr ? static_cast<SendResult>(event->value) : SendResult::queued;
}

bool ReplayedLink::ReplayedBus::try_receive(ReceivedFrame& out) noexcept {
  const LinkEvent* const event = link_.result(LinkEvent::Kind::received, index_);
  if (event != nullptr) out = {.frame = event->frame, .t_ns = event->t_ns};
  return event != nullptr;
}

BusState ReplayedLink::ReplayedBus::state() const noexcept {
  if (const LinkEvent* const event = link_.result(LinkEvent::Kind::state, index_))
    state_ = static_cast<BusState>(event->value);
  return state_;
}

bool ReplayedLink::ReplayedBus::is_live() const noexcept {
  if (const LinkEvent* const event = link_.result(LinkEvent::Kind::live, index_))
    is_live_ = event->value != 0;
  return is_live_;
}

void ReplayedLink::ReplayedBus::begin_again() noexcept {
  state_ = BusState::error_active;
  is_live_ = true;
}

// ---- the device -----------------------------------------------------------------------------------

std::string RigReplay::why_not(const SceneConfig& scene, std::span<const double> start) {
  if (!scene.device || !scene.device->rig) return "its scene has no rig";
  if (start.size() != scene.device->rig->tree.joints.size()) return "its device has other joints";
  const std::vector<std::string> complaints = RigDevice::complaints(scene);
  return complaints.empty() ? "" : complaints.front();
}

RigReplay::RigReplay(const SceneConfig& scene, std::span<const double> start)
    : scene_(scene),
      driven_(driven_bodies(scene)),
      samples_(scene.bodies.size()),
      F_hand_W_(scene.bodies.size()) {
  auto link = std::make_unique<ReplayedLink>(scene.device->rig->buses.size());
  link_ = link.get();
  device_.emplace(scene, std::move(link), passivity_controllers(scene, vector_of(start)));
  period_.step = scene.step;
}

void RigReplay::add(std::uint64_t first, std::span<const LinkEvent> events) {
  if (first != next_event_) link_->add_gap();
  begins_later_ = begins_later_ || (first > 0 && next_event_ == 0);
  for (const LinkEvent& event : events) link_->add(event);
  next_event_ = first + events.size();
}

std::string RigReplay::step(const CycleRecord& row, bool compares) {
  for (;;) {
    const std::uint64_t next = link_->next_command().value_or(row.cycle);
    // The wrench of a missing row is unknown, and with it the state of the rig.
    is_lost_ = is_lost_ || next < row.cycle;
    if (next > row.cycle || (is_lost_ && !link_->skip_to_restart())) {
      if (!first_missing_) first_missing_ = row.cycle;
      return "";
    }
    const std::optional<LinkEvent> call = link_->take_call();
    std::string found = call ? repeat(*call, &row, compares) : "";
    if (link_->end() == ReplayedLink::End::other) return "the order of the rig's calls differs";
    if (!found.empty()) return found;
    if (link_->end() == ReplayedLink::End::missing) is_lost_ = true;
    else if (call->call == RigCall::commanded) break;
  }
  ++num_rows_;
  return compares ? compare(row) : "";
}

std::string RigReplay::end() {
  while (!is_lost_) {
    const std::optional<LinkEvent> call = link_->take_call();
    if (link_->end() == ReplayedLink::End::missing) break;
    // A command without a row is that of a row that was lost or cut off.
    if (call && call->call == RigCall::command) break;
    const std::string found = call ? repeat(*call, nullptr, true) : "";
    if (link_->end() == ReplayedLink::End::other) return "the order of the rig's calls differs";
    if (!found.empty()) return found;
  }
  return "";
}

/// Repeats one call, and compares before it if it shall. row: that of a command.
std::string RigReplay::repeat(const LinkEvent& call, const CycleRecord* row, bool compares) {
  if (call.call == RigCall::restart) {
    is_lost_ = false;
    link_->begin_again();
    device_->restart();
    return "";
  }
  if (!compares) link_->take_sent(call.sent);  // only frames from here on are compared
  else if (std::string found = compare(call); !found.empty()) return found;
  switch (call.call) {
    case RigCall::boot: device_->boot(period_); break;
    case RigCall::arm: static_cast<void>(device_->arm()); break;
    case RigCall::read: device_->read(period_, samples_); break;
    case RigCall::command:
      if (row != nullptr) command(call, *row);
      break;
    case RigCall::commanded: break;
    case RigCall::trouble: device_->tell(static_cast<RunTrouble>(call.value)); break;
    case RigCall::disarm: device_->disarm(); break;
    case RigCall::quick_stop: device_->quick_stop(); break;
    case RigCall::run_down: static_cast<void>(device_->run_down(period_)); break;
    case RigCall::stop: device_->stop(period_); break;
    case RigCall::close: device_->close(period_); break;
    case RigCall::restart: break;
  }
  return "";
}

/// Commands the recorded wrench, as Session::command() does.
void RigReplay::command(const LinkEvent& call, const CycleRecord& row) {
  for (const std::size_t body : driven_)
    F_hand_W_[body] = grips_bodies(scene_) ? row.hand_W : row.bodies[body].feedback_D;
  Shown shown{.drives = {}, .oscillates = call.value != 0};
  device_->command(period_, F_hand_W_, shown);
}

/// Compares the rig before a call.
std::string RigReplay::compare(const LinkEvent& call) const {
  const RigState state = device_->rig().state();
  if (state != call.rig_state)
    return difference("the state of the rig", std::string(name_of(call.rig_state)),
                      std::string(name_of(state)));
  return link_->sent() == call.sent ? "" : "the frames that the rig sends differ";
}

/// Compares the rig after the command of a row.
std::string RigReplay::compare(const CycleRecord& row) const {
  const Rig& rig = device_->rig();
  const RigParams& params = *scene_.device->rig;
  if (rig.faults() != row.rig_faults)
    return difference("rig_fault", std::to_string(static_cast<std::uint32_t>(row.rig_faults)),
                      std::to_string(static_cast<std::uint32_t>(rig.faults())));
  const auto differ = [](double a, double b) {
    return std::bit_cast<std::uint64_t>(a) != std::bit_cast<std::uint64_t>(b);
  };
  for (std::size_t i = 0; i < row.device_q.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double q = k < device_->q().size() ? device_->q()[k] : std::numeric_limits<double>::quiet_NaN();
    if (differ(row.device_q[i], q))
      return difference("device." + params.tree.joints[i].name + ".q", text_of(row.device_q[i]), text_of(q));
  }
  for (std::size_t i = 0; i < row.drive_torque.size(); ++i) {
    const double torque = rig.commanded_torque_Nm(i), energy = rig.generated_energy_J(i);
    const std::string name = "drive." + params.drives[i].joint;
    if (differ(row.drive_torque[i], torque))
      return difference(name + ".torque", text_of(row.drive_torque[i]), text_of(torque));
    if (differ(row.drive_energy[i], energy))
      return difference(name + ".generated", text_of(row.drive_energy[i]), text_of(energy));
  }
  return "";
}

}  // namespace godobject
