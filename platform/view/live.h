// A running session as the source of a view.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "platform/rt/cyclic.h"
#include "platform/view/drawing.h"
#include "platform/view/frame.h"
#include "platform/view/pointer.h"
#include "platform/view/server/server.h"

namespace godobject {

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
  bool move_joints(std::uint64_t client, const JointsMessage& message) override {
    return joints_ != nullptr && joints_->take(client, message);
  }
  void leave(std::uint64_t client) override {
    if (pointer_ != nullptr) pointer_->leave(client);
    if (joints_ != nullptr) joints_->leave(client);
  }

 private:
  ViewTap tap_;
  std::string scene_;
  std::vector<std::size_t> driven_;
  PointerDevice* pointer_;
  JointPointer* joints_;
  std::vector<Vec3> places_;  // positions of the driven bodies in the last frame
  MonotonicClock clock_;
  Nanoseconds shown_ = 0;  // time of the last frame
  bool requested_ = false;
};

}  // namespace godobject
