#include "platform/linux/socket_device.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <system_error>

namespace godobject {
namespace {

static_assert(std::endian::native == std::endian::little);

/// Largest number of packets read in one period.
constexpr int max_packets = 64;
constexpr double max_norm_error = 1e-3;  // of the quaternion

std::size_t followed_body(const SceneConfig& scene) {
  const std::vector<std::size_t> driven = driven_bodies(scene);
  return driven.empty() ? 0 : driven.front();
}

StreamedSample start_of(const SceneConfig& scene, std::size_t body) {
  return {.X_WD = scene.bodies[body].X_WB, .state = StreamedSample::State::lost};
}

/// True if the sample is a pose within max_distance.
bool is_pose(const PosePacket& sample) noexcept {
  const Vec3 p(sample.p_WD_m[0], sample.p_WD_m[1], sample.p_WD_m[2]);
  const auto& q = sample.q_WD_wxyz;
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return p.norm() <= SocketDevice::max_distance && std::abs(norm - 1) <= max_norm_error;  // false for NaN
}

bool is_socket(const std::string& path) noexcept {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode);
}

int new_socket() noexcept { return socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0); }

}  // namespace

SocketDevice::SocketDevice(const SceneConfig& scene, LoopClock clock)
    : body_(followed_body(scene)),
      clock_(clock),
      stream_(start_of(scene, body_),
              {.stale_after = stale_after_ns, .speed = max_speed, .turn_rate = max_turn_rate}),
      newest_(start_of(scene, body_)) {}

SocketDevice::~SocketDevice() {
  if (program_ >= 0) send({.number = number_});
  disconnect();
  if (listener_ < 0) return;
  ::close(listener_);
  unlink(path_.c_str());
}

std::string SocketDevice::open(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string option = "--device: '" + path + "' ";
  if (path.empty() || path.size() >= sizeof address.sun_path)
    return option + "is no path of a socket: give one of 1 to " +
           std::to_string(sizeof address.sun_path - 1) + " bytes";
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const auto* const to = reinterpret_cast<const sockaddr*>(&address);
  const int listener = new_socket();
  if (listener < 0) return option + "cannot be made: " + std::generic_category().message(errno);
  int failed = bind(listener, to, sizeof address);
  if (failed != 0 && errno == EADDRINUSE && is_socket(path)) {
    // A program that was killed leaves a socket without a listener.
    const int probe = new_socket();
    const bool is_left = connect(probe, to, sizeof address) != 0 && errno == ECONNREFUSED;
    ::close(probe);
    errno = EADDRINUSE;
    if (is_left && unlink(path.c_str()) == 0) failed = bind(listener, to, sizeof address);
  }
  if (failed != 0 || listen(listener, 1) != 0) {
    const int error = errno;
    ::close(listener);
    return option + "cannot be listened on: " + std::generic_category().message(error) +
           ": give another path, or end the program that has it";
  }
  listener_ = listener;
  path_ = path;
  return "";
}

// --- one period -----------------------------------------------------------------------------------

void SocketDevice::read(Period& period, std::span<BodySample> samples) noexcept {
  period.begin_by(clock_);
  {
    const InStage stage(period.stages, Stage::receive);
    accept_program();
    receive();
  }
  stream_.play(period.now, period.step);
  const bool valid = program_ >= 0 && stream_.valid();
  was_valid_ = was_valid_ || valid;
  BodySample& sample = samples[body_];
  sample.target = stream_.target();
  sample.valid = valid;
  sample.engaged = sample.engaged && was_valid_;
  sample.clutch = stream_.heard().clutch;
  hold_pressed_ = stream_.heard().presses != stream_.heard_before().presses;
}

void SocketDevice::command(Period& period, std::span<const Wrench> F_hand_W, Shown& shown) noexcept {
  withheld_ = withheld_ || shown.oscillates;
  if (program_ < 0) return;
  WrenchPacket wrench{.number = number_, .t_s = period.t};
  if (!withheld_) {
    const Wrench& F = F_hand_W[body_];
    wrench.f_W_N = {F.f.x(), F.f.y(), F.f.z()};
    wrench.tau_W_Nm = {F.tau.x(), F.tau.y(), F.tau.z()};
    wrench.flags = WrenchPacket::live;
  }
  const InStage stage(period.stages, Stage::send);
  send(wrench);
  shown_ = wrench;
}

/// Sends the last wrench of the run, scaled down linearly to zero within run_down_s.
bool SocketDevice::run_down(Period& period) noexcept {
  run_down_left_s_ -= period.step;
  if (program_ < 0 || run_down_left_s_ <= 0) return false;
  WrenchPacket wrench = shown_;
  wrench.t_s = period.t;
  for (double& f : wrench.f_W_N) f *= run_down_left_s_ / run_down_s;
  for (double& tau : wrench.tau_W_Nm) tau *= run_down_left_s_ / run_down_s;
  send(wrench);
  return true;
}

/// Sends a wrench of zero.
void SocketDevice::stop(Period& period) noexcept {
  if (program_ >= 0) send({.number = number_, .t_s = period.t});
}

/// Accepts a program, and refuses further ones.
void SocketDevice::accept_program() noexcept {
  const int fd = loop::accept(listener_);
  if (fd < 0) return;
  if (program_ >= 0) {
    ++counters_.refused;
    loop::close(fd);
    return;
  }
  // The kernel's smallest buffer holds a few wrenches. A slow program therefore does not display old ones.
  static_cast<void>(loop::set_send_buffer(fd, 0));
  program_ = fd;
  number_ = 0;
  pressed_ = false;
  ++newest_.path;
  ++counters_.connections;
  counters_.connected = true;
}

void SocketDevice::receive() noexcept {
  for (int i = 0; i < max_packets && program_ >= 0; ++i) {
    PosePacket sample;
    const ssize_t size = loop::receive(program_, &sample, sizeof sample, MSG_TRUNC);
    if (size < 0 && (loop::error() == EAGAIN || loop::error() == EINTR)) return;
    if (size <= 0) return disconnect();
    if (size == sizeof sample && sample.magic == PosePacket::magic_of_poses) take(sample);
    else ++counters_.malformed;
  }
}

void SocketDevice::take(const PosePacket& sample) noexcept {
  const Nanoseconds now = clock_();
  const double age_s = 1e-9 * static_cast<double>(now) - sample.t_s;
  if (!is_pose(sample) || sample.number <= number_ || !(age_s >= 0)) {
    ++counters_.malformed;
    return;
  }
  number_ = sample.number;
  if (age_s > 1e-9 * static_cast<double>(stale_after_ns)) {
    ++counters_.late;
    return;
  }
  ++counters_.samples;
  const auto& p = sample.p_WD_m;
  const auto& q = sample.q_WD_wxyz;
  newest_.X_WD = {.p = Vec3(p[0], p[1], p[2]), .q = Quat(q[0], q[1], q[2], q[3]).normalized()};
  newest_.state = (sample.flags & PosePacket::not_valid) != 0 ? StreamedSample::State::lost
                                                              : StreamedSample::State::leads;
  newest_.clutch = (sample.flags & PosePacket::clutch_open) == 0;
  const bool pressed = (sample.flags & PosePacket::button) != 0;
  if (pressed && !pressed_) ++newest_.presses;
  pressed_ = pressed;
  newest_.t = now - to_ns(age_s);
  stream_.push(newest_);
}

void SocketDevice::send(const WrenchPacket& wrench) noexcept {
  const ssize_t size = loop::send(program_, &wrench, sizeof wrench);
  if (size == sizeof wrench) ++counters_.wrenches;
  else if (size < 0 && loop::error() != EAGAIN && loop::error() != EINTR) disconnect();
  else ++counters_.not_sent;
}

void SocketDevice::disconnect() noexcept {
  if (program_ >= 0) loop::close(program_);
  program_ = -1;
  counters_.connected = false;
}

}  // namespace godobject
