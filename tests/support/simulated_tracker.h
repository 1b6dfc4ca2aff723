// A tracker of the host and its simulated far end, on a line without delay, in steps of 1 ms.
#pragma once

#include <functional>
#include <memory>

#include "sim/tracker/tracker.h"

namespace godobject::test {

inline TrackerParams tracker_params(TrackerProtocol protocol, const std::vector<std::string>& tools) {
  TrackerParams params;
  params.name = "tracker";
  params.protocol = protocol;
  params.port = "/dev/ttyUSB0";
  for (const std::string& tool : tools) params.tools.push_back({.body = "body", .tool = tool, .X_TH = {}});
  return params;
}

struct SimulatedTracker {
  SimulatedTracker(std::unique_ptr<Tracker> host, std::unique_ptr<SimTracker> device)
      : tracker(std::move(host)), far(std::move(device)) {
    tracker->opened(now);
  }

  void step() {
    now += 1'000'000;
    far->advance(now);
    std::array<std::uint8_t, 256> bytes{};
    while (const std::size_t size = far->transmit(bytes, now)) {
      std::vector<std::uint8_t> arrived(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      if (damage) damage(arrived);
      tracker->receive(arrived, now);
    }
    for (;;) {
      const LineRequest request = tracker->next(now);
      if (request.kind == LineRequest::Kind::none) return;
      if (request.kind == LineRequest::Kind::send) far->receive(request.bytes, now);
      if (request.kind == LineRequest::Kind::reopen) tracker->opened(now);
      if (request.kind == LineRequest::Kind::serial_break) {
        ++breaks;
        if (understands_breaks) far->serial_break(now);
      }
      if (request.kind == LineRequest::Kind::set_baud) baud = request.baud;
    }
  }

  /// Steps until the condition holds or limit_s has passed; returns the condition.
  bool run_until(const std::function<bool()>& condition, double limit_s) {
    const Nanoseconds end = now + static_cast<Nanoseconds>(1e9 * limit_s);
    while (now < end) {
      if (condition()) return true;
      step();
    }
    return condition();
  }
  void run(double s) {
    run_until([] { return false; }, s);
  }
  bool track(double limit_s = 10) {
    return run_until([&] { return tracker->report().state == TrackerState::tracking; }, limit_s);
  }
  const ToolSample& tool(std::size_t i) const { return tracker->report().tools[i]; }

  std::unique_ptr<Tracker> tracker;
  std::unique_ptr<SimTracker> far;
  std::function<void(std::vector<std::uint8_t>&)> damage;  // modifies sent bytes, as a noisy line does
  Nanoseconds now = 1'000'000'000;
  std::uint32_t baud = 0;
  int breaks = 0;
  bool understands_breaks = true;
};

}  // namespace godobject::test
