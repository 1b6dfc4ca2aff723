// A running session as the source of a view, and of poses for clients of OpenIGTLink.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
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

  /// Continues with another session of the same scene and its devices. Not while a loop runs.
  void restart(const Session& session, PointerDevice* pointer, JointPointer* joints);

  std::string scene() override { return scene_; }
  ViewBytes frame() override;
  bool point(std::uint64_t client, const PointerMessage& message) override;
  bool set_pace(std::uint64_t client, const PaceMessage& message) override;
  bool move_joints(std::uint64_t client, const JointsMessage& message) override {
    const std::lock_guard lock(mutex_);
    return joints_ != nullptr && joints_->take(client, message);
  }
  std::string reset() override {
    if (no_reset_.empty()) tap_.reset();
    return no_reset_;
  }
  void leave(std::uint64_t client) override {
    const std::lock_guard lock(mutex_);
    if (pointer_ != nullptr) pointer_->leave(client);
    if (joints_ != nullptr) joints_->leave(client);
    if (pacer_ == client) static_cast<void>(set_pace(client, {}));
  }

 private:
  void place(const Session& session) {
    places_.clear();
    for (const std::size_t body : bodies_.driven) places_.push_back(session.scene().bodies[body].X_WB.p);
  }

  ViewTap tap_;
  std::string scene_, no_reset_;
  ViewBodies bodies_;
  std::mutex mutex_;  // guards the three members below, between the view's thread and restart()
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
      no_reset_(about.no_reset),
      bodies_(session.scene()),
      pointer_(pointer),
      joints_(joints) {
  place(session);
}

inline void LiveView::restart(const Session& session, PointerDevice* pointer, JointPointer* joints) {
  const std::lock_guard lock(mutex_);
  pointer_ = pointer;
  joints_ = joints;
  place(session);
  tap_.restart();
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
  const std::lock_guard lock(mutex_);
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
  const std::lock_guard lock(mutex_);
  return pointer_ != nullptr && message.target < places_.size() &&
         pointer_->take(client, message, places_[message.target]);
}

// ---- OpenIGTLink -----------------------------------------------------------------------------------
// At each period a client receives
//   TRANSFORM  pose of each body in the world, device: its name
//   TDATA      poses of all bodies, device: godobject
//   SENSOR     displayed force, N, and torque, N m, of each driven body, about its target's origin; devices:
//              <body>.force, <body>.torque. A device that grips bodies has hand.force and hand.torque instead
//   STATUS     1 while it runs, 13 before, 19 after, 18 with a fault of the device, 2 with one of the core;
//              sub-code: the cycle; device: godobject
// Names are cut at 20 characters. Messages have the time of day of the step that they describe. On real buses
// and trackers it is t_bus of the trace, otherwise the time of sending.

/// Server of OpenIGTLink for a running session, on a thread of its own.
class OpenIgtLinkServer {
 public:
  struct Settings {
    std::string address = "127.0.0.1";  // IPv4, of the listening socket
    std::uint16_t port = 18944;
    double rate_hz = 60;
    Nanoseconds wall_origin_ns = 0;  // time of day when the clock of the buses is 0
  };

  /// Listens and starts the thread. Returns null with the reason and the remedy in why_not.
  static std::unique_ptr<OpenIgtLinkServer> start(const Settings& settings, const Session& session,
                                                  std::string& why_not);
  ~OpenIgtLinkServer();
  OpenIgtLinkServer(const OpenIgtLinkServer&) = delete;
  OpenIgtLinkServer& operator=(const OpenIgtLinkServer&) = delete;

  /// For the loop.
  ViewTap& tap() noexcept { return tap_; }

 private:
  /// A connected client.
  struct Client {
    int descriptor = -1;
    std::vector<std::uint8_t> unsent{};  // rest of messages; until it is sent, the client receives no others
  };

  OpenIgtLinkServer(int listener, const Settings& settings, const Session& session);
  void run(const std::stop_token& stop);
  void accept_clients();
  /// Removes clients that have closed, and drops the bytes that others have sent.
  void listen_to_clients();
  void send_to_clients(const ViewSample& sample);
  void send_rest(Client& client);

  int listener_;
  Nanoseconds period_, wall_origin_ns_;
  const SceneConfig scene_;
  std::vector<std::size_t> driven_;
  ViewTap tap_;
  std::vector<Client> clients_;
  std::vector<std::uint8_t> bytes_;  // messages of a period
  MonotonicClock clock_;
  std::jthread thread_;  // last, so that it ends before the other members
};

/// Appends the messages of a sample. driven: indices of the driven bodies. t: time of day, ns.
void append_openigtlink(const ViewSample& sample, const SceneConfig& scene,
                        const std::vector<std::size_t>& driven, Nanoseconds t,
                        std::vector<std::uint8_t>& bytes);

}  // namespace godobject
