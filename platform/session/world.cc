#include "platform/session/world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "platform/scene/contact/params.h"

namespace godobject {
namespace {

// Bounds of plausible values in a room with a tool.
constexpr double max_distance = 100, max_speed = 10;            // m, m/s
constexpr double max_stiffness = 1e6, max_plane_damping = 1e4;  // N/m, N s/m
constexpr double max_valid_s = 1, max_extrapolated_s = 0.1;     // s
constexpr double max_damper_m = 2e-3;                           // displacement for a damper's force, m
constexpr double max_normal_error = 1e-3;                       // of the normal
constexpr double forgotten_s = 50;                              // time constant of the energy balance, s

Vec3 vec(const std::array<double, 3>& a) noexcept { return {a[0], a[1], a[2]}; }
std::array<double, 3> array_of(const Vec3& a) noexcept { return {a.x(), a.y(), a.z()}; }

bool is_plane(const WorldPlane& plane) noexcept {
  return plane.id != 0 && vec(plane.p_W_m).norm() <= max_distance &&  // each false for NaN
         std::abs(vec(plane.n_W).norm() - 1) <= max_normal_error && vec(plane.v_W_m_s).norm() <= max_speed &&
         vec(plane.moved_W_m).norm() <= max_distance && plane.k_N_m > 0 && plane.k_N_m <= max_stiffness &&
         plane.c_Ns_m >= 0 && plane.c_Ns_m <= max_plane_damping;
}

}  // namespace

WorldPlanes::WorldPlanes(const SceneConfig& scene, const Engine& engine, WorldLink& link, LoopClock clock,
                         const WorldLimits& limits)
    : link_(link),
      clock_(clock),
      limits_(limits),
      h_(scene.step),
      tracks_(scene.world_planes),
      contacts_(engine.composition().all_contacts()),
      sums_(num_sums),
      settled_J_(limits.allowance_J) {
  tool_.num_bodies = static_cast<std::uint32_t>(std::min(scene.bodies.size(), max_world_bodies));
}

// --- before a step --------------------------------------------------------------------------------

void WorldPlanes::begin(Engine& engine) noexcept {
  before_s_ = now_s_;
  now_s_ = 1e-9 * static_cast<double>(clock_());
  if (tool_.number == 0) before_s_ = now_s_;
  for (Track& track : tracks_) {
    track.advance = predicted(track) - track.predicted;
    track.predicted += track.advance;
  }
  WorldPacket packet;
  if (link_.receive(packet)) {
    const double age_s = now_s_ - packet.t_s;
    if (!is_valid(packet) || !(age_s >= 0)) ++counters_.malformed;
    else if (age_s > packet.valid_s) ++counters_.late;
    else take(packet, engine);
  }
  if (counters_.live && now_s_ - newest_.t_s > newest_.valid_s) {
    counters_.live = false;
    ++counters_.silences;
    for (Track& track : tracks_) release(track);
  }
  available_J_ = std::max(credit_J(), 0.0);
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    if (track.id == 0) continue;
    if (track.is_released) fade(track);
    else move(track, engine);
    const double k = track.k * track.fade;
    const Vec3 n_W = vec(track.sample.n_W);
    if (track.id == 0) engine.set_plane(i, {.p_W = parked_plane});
    else
      engine.set_plane(i, {.p_W = point_of(track) - track.offset * n_W,
                           .n_W = n_W,
                           .k = k,
                           .c = track.sample.c_Ns_m * k / track.sample.k_N_m});
  }
}

bool WorldPlanes::is_valid(const WorldPacket& packet) const noexcept {
  if (packet.magic != WorldPacket::magic_of_worlds || packet.version != WorldPacket::version_of_worlds ||
      packet.number <= newest_.number || packet.answers > tool_.number || packet.answers < newest_.answers ||
      !(packet.valid_s > 0 && packet.valid_s <= max_valid_s) || packet.num_planes > tracks_.size())
    return false;
  for (std::size_t i = 0; i < packet.num_planes; ++i) {
    if (!is_plane(packet.planes[i])) return false;
    for (std::size_t j = 0; j < i; ++j)
      if (packet.planes[i].id == packet.planes[j].id) return false;
  }
  return true;
}

/// Replaces the samples of the planes by those of a valid packet.
void WorldPlanes::take(const WorldPacket& packet, const Engine& engine) noexcept {
  constexpr double none = -1;  // depth of a plane that the tool does not touch
  std::array<double, max_world_planes> depth{};
  std::array<const WorldPlane*, max_world_planes> sample{};
  const Sums& sums = sums_[packet.answers % num_sums];
  const bool is_known = packet.answers > newest_.answers && sums.number == packet.answers;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    if (track.id == 0) continue;
    depth[i] = depth_of(track, engine);
    for (std::size_t j = 0; j < packet.num_planes; ++j)
      if (packet.planes[j].id == track.id) sample[i] = &packet.planes[j];
    if (is_known) settled_J_ += work_of_world(i, sample[i], packet.t_s - newest_.t_s, sums);
    if (sample[i] == nullptr) release(track);
  }
  if (is_known) {
    settled_J_ = std::min(settled_J_ - (sums.work_J - answered_J_), limits_.allowance_J);
    answered_J_ = sums.work_J;
  }
  const std::uint64_t answers = is_known ? packet.answers : newest_.answers;
  newest_ = packet;
  newest_.answers = answers;
  counters_.live = true;
  ++counters_.packets;
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    if (sample[i] != nullptr) assign(tracks_[i], *sample[i], depth[i], engine);
  for (std::size_t j = 0; j < packet.num_planes; ++j) {
    const WorldPlane& plane = packet.planes[j];
    if (std::ranges::any_of(tracks_, [&](const Track& track) { return track.id == plane.id; })) continue;
    // the free track, or the released one with the smallest force
    const auto rank = [](const Track& track) noexcept {
      return track.id == 0 ? -1 : track.is_released ? track.F : std::numeric_limits<double>::infinity();
    };
    Track& track = *std::ranges::min_element(tracks_, {}, rank);
    track = {.id = plane.id, .k = plane.k_N_m};
    assign(track, plane, none, engine);
  }
}

/// Returns the work of the other simulation on a plane since the packet before, J, by the mean force.
/// sample: new sample; null if there is none. dt: time since the packet before, s.
/// sums: those of the answered step.
double WorldPlanes::work_of_world(std::size_t i, const WorldPlane* sample, double dt,
                                  const Sums& sums) noexcept {
  Track& track = tracks_[i];
  if (sums.id[i] != track.id) return 0;  // the plane is newer than this step
  const Vec3 taken_W = sums.J_W[i] - track.J_done_W;
  track.J_done_W = sums.J_W[i];
  const Vec3 v_before_W = vec(track.sample.v_W_m_s);
  if (sample == nullptr) return -taken_W.dot(v_before_W);
  if ((sample->flags & WorldPlane::has_moved) != 0 && dt > 0)
    return -taken_W.dot(vec(sample->moved_W_m)) / dt;
  return -0.5 * taken_W.dot(v_before_W + vec(sample->v_W_m_s));
}

/// Sets the sample of a track without a change of the tool's depth, which is depth_before, m.
void WorldPlanes::assign(Track& track, const WorldPlane& sample, double depth_before,
                         const Engine& engine) noexcept {
  const double k_before = track.k * track.fade;
  track.sample = sample;
  track.sample.n_W = array_of(vec(sample.n_W).normalized());
  track.k = sample.k_N_m;
  track.fade = 1;
  track.is_released = false;
  track.offset = 0;
  track.predicted = predicted(track);
  // a stiffer plane keeps the force, a softer one the depth: the energy of its spring does not rise
  const double depth = std::max(depth_before, 0.0) * std::min(1.0, k_before / track.k);
  const double now = depth_of(track, engine);
  if (now > 0 || depth > 0) track.offset = now - depth;
}

/// Stops a plane, whose force then fades.
void WorldPlanes::release(Track& track) noexcept {
  if (track.is_released || track.id == 0) return;
  track.sample.p_W_m = array_of(point_of(track));
  track.sample.v_W_m_s = {};
  track.predicted = track.advance = 0;
  track.is_released = true;
}

void WorldPlanes::fade(Track& track) noexcept {
  track.advance = 0;
  track.fade -= h_ / limits_.release_s;
  if (track.fade <= 0) track = {};
}

/// Moves a plane towards its sample. Its work on the tool is limited to the credit.
void WorldPlanes::move(Track& track, const Engine& engine) noexcept {
  const double depth = depth_of(track, engine);
  if (depth <= 0) {
    track.offset = std::max(track.offset + depth, 0.0);
    track.advance = 0;
  }
  const double most = limits_.max_recovery * h_;
  const double recovered = std::clamp(track.offset * h_ / limits_.recovery_s, -most, most);
  track.offset -= recovered;
  track.advance += recovered;
  if (track.advance <= 0) return;
  const double F = std::max(track.F, track.k * std::max(depth, 0.0));
  if (F * track.advance > available_J_) {
    const double allowed = available_J_ / F;
    track.offset += track.advance - allowed;
    track.advance = allowed;
    ++counters_.limited;
  }
  available_J_ -= F * track.advance;
}

/// Returns the motion along the normal since the time of the sample, m. The core's dampers act against the
/// world at rest: a plane displaced by c / k times its speed has the force of a moving damper. The
/// displacement is limited, because it also makes the plane touch sooner.
double WorldPlanes::predicted(const Track& track) const noexcept {
  const WorldPlane& sample = track.sample;
  if (track.id == 0) return 0;
  const double v_n = vec(sample.n_W).dot(vec(sample.v_W_m_s));
  return v_n * extrapolated_s(now_s_) +
         std::clamp(v_n * sample.c_Ns_m / sample.k_N_m, -max_damper_m, max_damper_m);
}

Vec3 WorldPlanes::point_of(const Track& track) const noexcept {
  return vec(track.sample.p_W_m) + track.predicted * vec(track.sample.n_W);
}

double WorldPlanes::depth_of(const Track& track, const Engine& engine) const noexcept {
  return engine.depth_below(point_of(track), vec(track.sample.n_W)) - track.offset;
}

/// Returns the time by which the newest samples are extrapolated to t_s, s.
double WorldPlanes::extrapolated_s(double t_s) const noexcept {
  return std::clamp(t_s - newest_.t_s, 0.0, std::min(newest_.valid_s, max_extrapolated_s));
}

// --- after a step ---------------------------------------------------------------------------------

void WorldPlanes::end(const Engine& engine, double t) noexcept {
  ++tool_.number;
  tool_.t_s = now_s_;
  tool_.t_run_s = t;
  tool_.flags = counters_.live ? std::uint32_t{ToolPacket::live} : 0;
  for (std::size_t i = 0; i < tool_.num_bodies; ++i) {
    const BodyView body = engine.view(i);
    const Quat& q = body.X_WB.q;
    tool_.bodies[i] = {.p_W_m = array_of(body.X_WB.p),
                       .q_W_wxyz = {q.w(), q.x(), q.y(), q.z()},
                       .w_W_rad_s = array_of(body.V_WB.w),
                       .v_W_m_s = array_of(body.V_WB.v)};
  }
  observe(engine);
  Sums& sums = sums_[tool_.number % num_sums];
  sums.number = tool_.number;
  sums.work_J = work_J_;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const Track& track = tracks_[i];
    sums.J_W[i] = track.J_W;
    sums.id[i] = track.id;
    tool_.planes[i] = {.id = track.id, .p_W_m = array_of(track.p_W), .J_W_Ns = array_of(track.J_W)};
  }
  link_.send(tool_);
}

/// Adds the forces of a step to impulses, wrench and work.
void WorldPlanes::observe(const Engine& engine) noexcept {
  std::array<double, max_world_planes> F_before{};
  for (std::size_t i = 0; i < tracks_.size(); ++i) F_before[i] = std::exchange(tracks_[i].F, 0);
  // Late impulses may do more work on the other simulation than the tool has lost. They are then scaled down.
  const double passed_on = std::clamp(1 + credit_J() / limits_.allowance_J, 0.0, 1.0);
  double dissipated_J = 0;
  Vec3 f_W = Vec3::Zero(), tau_W = Vec3::Zero();
  std::array<Vec3, max_world_planes> moment;
  moment.fill(Vec3::Zero());
  const std::size_t num = std::min(engine.contacts(contacts_), contacts_.size());
  for (std::size_t c = 0; c < num; ++c) {
    const ContactView& contact = contacts_[c];
    const std::size_t i = contact.surface - engine.first_plane();
    if (contact.b != world || contact.is_on_net || contact.surface < engine.first_plane()) continue;
    Track& track = tracks_[i];
    const double F_n = contact.n_W.dot(contact.F_W);
    track.F += F_n;
    moment[i] += F_n * contact.p_W;
    track.J_W -= passed_on * h_ * contact.F_W;
    const BodyView body = engine.view(contact.a);
    const Vec3 v_W = body.V_WB.v + body.V_WB.w.cross(contact.p_W - body.X_WB.p);
    const double v_n = contact.n_W.dot(v_W);
    dissipated_J += track.sample.c_Ns_m * track.fade * v_n * (h_ * v_n - track.advance);
    f_W += contact.F_W;
    tau_W += (contact.p_W - engine.view(0).X_WB.p).cross(contact.F_W);
  }
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    if (track.F > 0) track.p_W = moment[i] / track.F;
    work_J_ += track.advance * 0.5 * (F_before[i] + track.F);
  }
  settled_J_ = std::min(settled_J_ + dissipated_J, limits_.allowance_J);
  settled_J_ += (limits_.allowance_J - settled_J_) * h_ / forgotten_s;
  tool_.f_W_N = array_of(f_W);
  tool_.tau_W_Nm = array_of(tau_W);
}

}  // namespace godobject
