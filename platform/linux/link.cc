#include "platform/linux/link.h"

#include <cmath>
#include <cstdlib>

namespace godobject {

LinuxLink::LinuxLink(std::vector<std::unique_ptr<LinuxBus>> buses, Nanoseconds period) : period_ns_(period) {
  for (std::unique_ptr<LinuxBus>& bus : buses) {
    ends_.push_back(std::make_unique<End>(std::move(bus), ends_.size()));
    ports_.push_back(&ends_.back()->paced);
  }
  polled_.resize(ends_.size());
}

Nanoseconds LinuxLink::begin_cycle(double /*motion_time*/) noexcept {
  const Nanoseconds now = clock_.now();
  const Nanoseconds since_last = now - t_cycle_ns_;
  // Whole periods left out are counted by the loop.
  if (since_last < period_ns_ + period_ns_ / 2) timing_.sync_jitter_ns.add(std::abs(since_last - period_ns_));
  t_cycle_ns_ = now;
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    ends_[i]->paced.advance_to(now);
    polled_[i] = {.fd = bus(i).descriptor(), .events = POLLIN, .revents = 0};
  }
  return now;
}

Nanoseconds LinuxLink::wait(Nanoseconds until) noexcept {
  const Nanoseconds left = until - clock_.now();
  if (left <= 0) return clock_.now();
  const timespec timeout{.tv_sec = left / 1'000'000'000, .tv_nsec = left % 1'000'000'000};
  const int ready = ppoll(polled_.data(), polled_.size(), &timeout, nullptr);
  // A missing bus is always readable. Reading it once a cycle, without waiting for it, keeps the loop asleep.
  if (ready > 0)
    for (pollfd& bus : polled_)
      if ((bus.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) bus.fd = -1;
  return clock_.now();
}

void LinuxLink::end_cycle() noexcept {
  const Nanoseconds t_received = t_received_ns();
  if (t_received > t_cycle_ns_) timing_.added_latency_ns.add(clock_.now() - t_received);
}

void LinuxLink::set_observer(const BusObserver& observer) noexcept {
  for (const std::unique_ptr<End>& end : ends_) end->watched.set_observer(observer);
}

Nanoseconds LinuxLink::t_received_ns() const noexcept {
  Nanoseconds latest = 0;
  for (const std::unique_ptr<End>& end : ends_) latest = std::max(latest, end->watched.t_received_ns());
  return latest;
}

}  // namespace godobject
