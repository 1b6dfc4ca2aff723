#include "platform/view/live.h"

namespace godobject {
namespace {

/// Pause between a frame and the next request, ns; with the server's own period at most 60 frames a second.
constexpr Nanoseconds frame_pause = 13'000'000;

}  // namespace

LiveView::LiveView(const Session& session, const ViewAbout& about, PointerDevice* pointer,
                   JointPointer* joints)
    : tap_(session),
      scene_(scene_json(session.scene(), about)),
      driven_(driven_bodies(session.scene())),
      pointer_(pointer),
      joints_(joints) {
  for (const std::size_t body : driven_) places_.push_back(session.scene().bodies[body].X_WB.p);
}

ViewBytes LiveView::frame() {
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
  for (std::size_t i = 0; i < driven_.size(); ++i) places_[i] = sample->record.bodies[driven_[i]].X_WB.p;
  auto bytes = std::make_shared<std::vector<std::uint8_t>>();
  encode(*sample, driven_, sample->net_nodes, *bytes);
  return bytes;
}

bool LiveView::point(std::uint64_t client, const PointerMessage& message) {
  return pointer_ != nullptr && message.target < places_.size() &&
         pointer_->take(client, message, places_[message.target]);
}

}  // namespace godobject
