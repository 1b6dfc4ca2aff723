// A running session as the source of a view.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "platform/rt/cyclic.h"
#include "platform/view/drawing.h"
#include "platform/view/frame.h"
#include "platform/view/pointer.h"
#include "platform/view/server/server.h"

namespace godobject {

/// Pause between a frame and the next request, ns; with the server's own period at most 60 frames a second.
inline constexpr Nanoseconds frame_pause = 13'000'000;

class LiveView final : public ViewSource {
 public:
  /// pointer, joints: null if pages move no bodies, no joints. All must outlive this object.
  LiveView(const Session& session, const ViewAbout& about, PointerDevice* pointer,
           JointPointer* joints = nullptr);

  /// For the loop.
  ViewTap& tap() noexcept { return tap_; }

  std::string scene() override { return scene_; }
  ViewBytes frame() override;
  bool point(std::uint64_t client, const PointerMessage& message) override;
  bool set_pace(std::uint64_t client, const PaceMessage& message) override;
  bool move_joints(std::uint64_t client, const JointsMessage& message) override {
    return joints_ != nullptr && joints_->take(client, message);
  }
  void leave(std::uint64_t client) override {
    if (pointer_ != nullptr) pointer_->leave(client);
    if (joints_ != nullptr) joints_->leave(client);
    if (pacer_ == client) static_cast<void>(set_pace(client, {}));
  }

 private:
  ViewTap tap_;
  std::string scene_;
  ViewBodies bodies_;
  PointerDevice* pointer_;
  JointPointer* joints_;
  std::vector<Vec3> places_;  // positions of the driven bodies in the last frame
  MonotonicClock clock_;
  Nanoseconds shown_ = 0;  // time of the last frame
  bool requested_ = false;
  std::optional<std::uint64_t> pacer_;  // client that set the pace; the run goes on when it leaves
};

inline LiveView::LiveView(const Session& session, const ViewAbout& about, PointerDevice* pointer,
                          JointPointer* joints)
    : tap_(session, about.takes_pace),
      scene_(scene_json(session.scene(), about)),
      bodies_(session.scene()),
      pointer_(pointer),
      joints_(joints) {
  for (const std::size_t body : bodies_.driven) places_.push_back(session.scene().bodies[body].X_WB.p);
}

inline ViewBytes LiveView::frame() {
  const Nanoseconds now = clock_.now();
  if (!requested_) {
    if (now - shown_ < frame_pause) return nullptr;
    tap_.ask();
    requested_ = true;
    return nullptr;
  }
  const ViewSample* const sample = tap_.get();
  if (sample == nullptr) return nullptr;
  requested_ = false;
  shown_ = now;
  for (std::size_t i = 0; i < places_.size(); ++i)
    places_[i] = sample->record.bodies[bodies_.driven[i]].X_WB.p;
  auto bytes = std::make_shared<std::vector<std::uint8_t>>();
  encode(*sample, bodies_.driven, sample->net_nodes, *bytes, bodies_.children);
  return bytes;
}

inline bool LiveView::set_pace(std::uint64_t client, const PaceMessage& message) {
  if (tap_.pace() == nullptr) return false;
  tap_.pace()->set(message.speed, message.steps);
  pacer_ = client;
  return true;
}

inline bool LiveView::point(std::uint64_t client, const PointerMessage& message) {
  return pointer_ != nullptr && message.target < places_.size() &&
         pointer_->take(client, message, places_[message.target]);
}

}  // namespace godobject
