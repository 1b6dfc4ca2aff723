#include "platform/view/frame.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "platform/scene/joint/joints.h"
#include "platform/session/record.h"

namespace godobject {
namespace {

/// Writes numbers one after the other into a frame of the right size.
class FrameWriter {
 public:
  explicit FrameWriter(std::span<std::uint8_t> bytes) noexcept : to_(bytes) {}

  template <std::integral T>
  FrameWriter& put(T value) noexcept {
    to_.put(value);
    return *this;
  }
  FrameWriter& put(double value) noexcept {
    to_.put(static_cast<float>(value));
    return *this;
  }
  FrameWriter& put(const Vec3& a) noexcept { return put(a.x()).put(a.y()).put(a.z()); }
  FrameWriter& put(const Pose& X) noexcept { return put(X.p).put(Vec3(X.q.vec())).put(X.q.w()); }
  FrameWriter& put(const Wrench& F) noexcept { return put(F.f).put(F.tau); }
  FrameWriter& put_f64(double value) noexcept { return put(std::bit_cast<std::uint64_t>(value)); }

 private:
  ByteWriter to_;
};

std::uint8_t flags_of(const ViewSample& sample) noexcept {
  const CycleRecord& record = sample.record;
  return static_cast<std::uint8_t>(
      (record.engaged ? frame_engaged : 0) | (record.on_hold ? frame_on_hold : 0) |
      (record.force_oscillates ? frame_oscillates : 0) | (sample.paused ? frame_paused : 0) |
      (sample.missed_deadlines ? frame_missed_deadlines : 0));
}

}  // namespace

void encode(const ViewSample& sample, std::span<const std::size_t> driven, std::span<const Vec3> vertices,
            std::vector<std::uint8_t>& out, std::span<const std::size_t> children) {
  const CycleRecord& record = sample.record;
  const std::size_t num_values = record.joint_q.size() + record.device_q.size() + record.drive_torque.size() +
                                 2 * children.size() + 2 * record.term_forces.size();
  const std::size_t num_contacts = std::min(sample.num_touching, max_frame_contacts);
  out.resize(frame_header_bytes + record.bodies.size() * frame_body_bytes +
             driven.size() * frame_driven_bytes + num_contacts * frame_contact_bytes +
             vertices.size() * frame_vertex_bytes + num_values * frame_value_bytes);
  FrameWriter to(out);
  to.put(frame_magic).put(view_version).put(static_cast<std::uint16_t>(frame_header_bytes)).put(record.cycle);
  to.put_f64(record.t).put(static_cast<std::uint8_t>(sample.phase)).put(flags_of(sample));
  to.put(static_cast<std::uint16_t>(driven.size())).put(static_cast<std::uint32_t>(record.fault));
  to.put(active_limits(record)).put(static_cast<std::uint32_t>(record.rig_faults));
  to.put(record.held ? static_cast<std::int32_t>(*record.held) : -1);
  for (const std::size_t n : {record.bodies.size(), num_contacts, vertices.size()})
    to.put(static_cast<std::uint32_t>(n));
  to.put(1e-3 * static_cast<double>(record.step_ns)).put(1e-3 * static_cast<double>(sample.wake_ns));
  to.put(record.energy.total).put(record.energy.balance);
  to.put(record.following.m).put(record.following.rad).put(record.hand_W);
  to.put(static_cast<std::uint32_t>(sample.counters.frames));
  to.put(static_cast<std::uint32_t>(sample.counters.incomplete_syncs));
  to.put(static_cast<std::uint32_t>(record.contacts.num_contacts)).put(record.contacts.deepest);
  to.put(static_cast<std::uint32_t>(num_values)).put(sample.impact_speed).put(sample.num_impacts);
  for (const BodyView& body : record.bodies) to.put(body.X_WB);
  for (const std::size_t i : driven) {
    const BodyView& body = record.bodies[i];
    to.put(body.target.X_WD).put(body.coupling_B).put(body.feedback_D);
  }
  for (std::size_t i = 0; i < num_contacts; ++i) {
    const ContactView& contact = sample.touching[i];
    const auto index = [](std::size_t body) {
      return body == world ? UINT32_MAX : static_cast<std::uint32_t>(body);
    };
    to.put(contact.is_node ? UINT32_MAX : index(contact.a))
        .put(contact.is_on_net ? UINT32_MAX : index(contact.b))
        .put(contact.p_W)
        .put(contact.n_W)
        .put(contact.F_W);
  }
  for (const Vec3& p : vertices) to.put(p);
  for (const std::vector<double>* list : {&record.joint_q, &record.device_q, &record.drive_torque})
    for (const double value : *list) to.put(value);
  for (const std::size_t child : children)
    to.put(record.bodies[child].joint_C.f.norm()).put(record.bodies[child].joint_C.tau.norm());
  for (const Wrench& F : record.term_forces) to.put(F.f.norm()).put(F.tau.norm());
}

ViewBodies::ViewBodies(const SceneConfig& scene) : driven(driven_bodies(scene)) {
  for (const JointConfig& joint : scene.joints)
    children.push_back(body_named(scene, joint.child).value_or(0));
}

std::vector<ViewValue> view_values(const SceneConfig& scene) {
  std::vector<ViewValue> values;
  const auto put_force = [&](std::string_view of, std::size_t index) {
    values.push_back({of, index, "force", "N"});
    values.push_back({of, index, "torque", "N m"});
  };
  for (std::size_t i = 0; i < scene.joints.size(); ++i)
    for (std::size_t c = 0; c < num_coordinates(scene.joints[i].kind); ++c) {
      const bool turns = is_turn(scene.joints[i].kind, c);
      values.push_back({"joint", i, turns ? "angle" : "displacement", turns ? "rad" : "m"});
    }
  if (scene.device && scene.device->rig) {
    const RigParams& rig = *scene.device->rig;
    const auto slides = [&](std::size_t i) { return rig.tree.joints[i].kind != DeviceJointKind::hinge; };
    for (std::size_t i = 0; i < rig.tree.joints.size(); ++i)
      values.push_back({"device", i, slides(i) ? "displacement" : "angle", slides(i) ? "m" : "rad"});
    for (const DriveParams& drive : rig.drives) {
      const auto joint = std::ranges::find(rig.tree.joints, drive.joint, &DeviceJoint::name);
      const auto i = static_cast<std::size_t>(joint - rig.tree.joints.begin());
      values.push_back({"device", i, slides(i) ? "drive force" : "drive torque", slides(i) ? "N" : "N m"});
    }
  }
  for (std::size_t i = 0; i < scene.joints.size(); ++i) put_force("joint", i);
  for (std::size_t i = 0; i < term_names(scene).size(); ++i) put_force("term", i);
  return values;
}

bool ViewPace::may_run(Nanoseconds now, Nanoseconds step) noexcept GODOBJECT_NONBLOCKING {
  constexpr Nanoseconds max_lag = 20'000'000;
  const double speed = speed_.load(std::memory_order_relaxed);
  if (speed == unlimited) return true;
  if (!(speed > 0)) {
    due_ = now;
    if (steps_.load(std::memory_order_relaxed) == 0) return false;
    steps_.fetch_sub(1, std::memory_order_relaxed);
    return true;
  }
  steps_.store(0, std::memory_order_relaxed);
  if (now + step / 2 < due_) return false;
  due_ = std::max(due_, now - max_lag) + static_cast<Nanoseconds>(static_cast<double>(step) / speed);
  return true;
}

ParseResult decode(std::span<const std::uint8_t> bytes, PointerMessage& out) noexcept {
  if (const ParseResult size = check_size(bytes.size(), pointer_bytes); size != ParseResult::ok) return size;
  ByteReader from(bytes);
  std::uint32_t magic = 0;
  std::uint16_t version = 0, buttons = 0;
  PointerMessage message;
  std::array<float, 6> x{};
  from.get(magic).get(version).get(buttons).get(message.number).get(message.target);
  for (float& value : x) from.get(value);
  if (magic != pointer_magic) return ParseResult::other_message;
  if (version != view_version || buttons > (pointer_holds | pointer_moves)) return ParseResult::bad_value;
  message.holds = (buttons & pointer_holds) != 0;
  message.moves = (buttons & pointer_moves) != 0;
  message.dp_W = Vec3(static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2]));
  message.dphi_W = Vec3(static_cast<double>(x[3]), static_cast<double>(x[4]), static_cast<double>(x[5]));
  // Negated, so that NaN fails.
  if (!(message.dp_W.norm() <= max_pointer_shift) || !(message.dphi_W.norm() <= max_pointer_turn))
    return ParseResult::bad_value;
  out = message;
  return ParseResult::ok;
}

std::array<std::uint8_t, pointer_bytes> encode(const PointerMessage& message) noexcept {
  std::array<std::uint8_t, pointer_bytes> bytes{};
  FrameWriter to(bytes);
  const int buttons = (message.holds ? pointer_holds : 0) | (message.moves ? pointer_moves : 0);
  to.put(pointer_magic).put(view_version).put(static_cast<std::uint16_t>(buttons)).put(message.number);
  to.put(message.target).put(message.dp_W).put(message.dphi_W);
  return bytes;
}

ParseResult decode(std::span<const std::uint8_t> bytes, PaceMessage& out) noexcept {
  if (const ParseResult size = check_size(bytes.size(), pace_bytes); size != ParseResult::ok) return size;
  ByteReader from(bytes);
  std::uint32_t magic = 0;
  std::uint16_t version = 0, steps = 0;
  float speed = 0;
  from.get(magic).get(version).get(steps).get(speed);
  if (magic != pace_magic) return ParseResult::other_message;
  const double given = static_cast<double>(speed);
  const bool is_speed =
      given == ViewPace::unlimited || (given >= 0 && given <= max_pace_speed);  // false for NaN
  if (version != view_version || steps > max_pace_steps || !is_speed) return ParseResult::bad_value;
  out = {.steps = steps, .speed = given};
  return ParseResult::ok;
}

ParseResult decode(std::span<const std::uint8_t> bytes, ResetMessage& /*out*/) noexcept {
  if (const ParseResult size = check_size(bytes.size(), reset_bytes); size != ParseResult::ok) return size;
  ByteReader from(bytes);
  std::uint32_t magic = 0;
  std::uint16_t version = 0, reserved = 0;
  from.get(magic).get(version).get(reserved);
  if (magic != reset_magic) return ParseResult::other_message;
  return version == view_version && reserved == 0 ? ParseResult::ok : ParseResult::bad_value;
}

ParseResult decode(std::span<const std::uint8_t> bytes, JointsMessage& out) noexcept {
  if (const ParseResult size = check_size(bytes.size(), joints_bytes); size != ParseResult::ok) return size;
  ByteReader from(bytes);
  std::uint32_t magic = 0;
  std::uint16_t version = 0, buttons = 0;
  JointsMessage message;
  from.get(magic).get(version).get(buttons).get(message.number).get(message.num_joints);
  if (magic != pointer_magic) return ParseResult::other_message;
  if (version != joints_version || buttons > pointer_holds || message.num_joints > max_joints)
    return ParseResult::bad_value;
  message.holds = (buttons & pointer_holds) != 0;
  for (std::size_t i = 0; i < max_joints; ++i) {
    float dq = 0;
    from.get(dq);
    message.dq[i] = static_cast<double>(dq);
    const double largest = i < message.num_joints ? max_joint_shift : 0;
    if (!(std::abs(message.dq[i]) <= largest)) return ParseResult::bad_value;  // also true for NaN
  }
  out = message;
  return ParseResult::ok;
}

std::array<std::uint8_t, joints_bytes> encode(const JointsMessage& message) noexcept {
  std::array<std::uint8_t, joints_bytes> bytes{};
  FrameWriter to(bytes);
  const int buttons = message.holds ? pointer_holds : 0;
  to.put(pointer_magic).put(joints_version).put(static_cast<std::uint16_t>(buttons));
  to.put(message.number).put(message.num_joints);
  for (const double dq : message.dq) to.put(static_cast<float>(dq));
  return bytes;
}

}  // namespace godobject
