#include "sim/tracker/tracker.h"

#include <algorithm>
#include <cmath>

#include "sim/tracker/ndi.h"
#include "sim/tracker/openigtlink.h"
#include "sim/tracker/polhemus.h"

namespace godobject {

SimTracker::SimTracker(double rate_hz, std::uint64_t seed) noexcept
    : period_(std::llround(1e9 / rate_hz)), random_(seed) {}

void SimTracker::advance(Nanoseconds now) noexcept {
  if (!started_) next_measurement_ = now;
  started_ = true;
  while (now >= next_measurement_) {
    measurement_.poses = poses_;
    measurement_.t = next_measurement_;
    ++measurement_.frame;
    next_measurement_ += period_;
    measured(now);
  }
}

void SimTracker::send(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept {
  if (faults.silent || bytes.empty() || random_.chance(faults.drop_probability)) return;
  Message message;
  message.size = std::min(bytes.size(), message.data.size());
  std::copy_n(bytes.begin(), message.size, message.data.begin());
  if (random_.chance(faults.corrupt_probability)) {
    const std::uint64_t bit = random_.next() % (8 * message.size);
    message.data[bit / 8] = static_cast<std::uint8_t>(message.data[bit / 8] ^ (1u << (bit % 8)));
  }
  message.due = now + faults.delay;
  if (!queue_.push(message)) ++lost_messages_;
}

std::size_t SimTracker::transmit(std::span<std::uint8_t> out, Nanoseconds now) noexcept {
  std::size_t size = 0;
  while (!queue_.empty() && queue_.front().due <= now && size < out.size()) {
    const Message& first = queue_.front();
    const std::size_t part = std::min(out.size() - size, first.size - sent_);
    std::copy_n(first.data.begin() + static_cast<std::ptrdiff_t>(sent_), part,
                out.begin() + static_cast<std::ptrdiff_t>(size));
    size += part;
    sent_ += part;
    if (sent_ < first.size) break;
    sent_ = 0;
    queue_.pop();
  }
  return size;
}

std::unique_ptr<SimTracker> make_sim_tracker(const TrackerParams& params, double rate_hz,
                                             std::uint64_t seed) {
  if (params.protocol == TrackerProtocol::ndi) return std::make_unique<SimNdi>(params, rate_hz, seed);
  if (params.protocol == TrackerProtocol::openigtlink)
    return std::make_unique<SimOpenIgtLink>(params, rate_hz, seed);
  return std::make_unique<SimPolhemus>(params, rate_hz, seed);
}

}  // namespace godobject
