// Server of OpenIGTLink, declared in live.h.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>

#include "hal/tracker/openigtlink.h"
#include "platform/rt/signals.h"
#include "platform/view/live.h"

namespace godobject {
namespace {

using openigtlink::Message;

constexpr std::size_t max_clients = 16;
constexpr Nanoseconds wake_period = 1'000'000;
constexpr const char* own_name = "godobject";
// Units of SENSOR: a code of 6 bits and an exponent of 4 for each factor, after 4 bits of a prefix.
constexpr std::uint64_t metre = 1, newton = 11, factor_1 = 50, factor_2 = 40;
constexpr std::uint64_t unit_N = (newton << 4 | 1) << factor_1, unit_Nm = unit_N | (metre << 4 | 1)
                                                                                       << factor_2;

void append(Message& message, std::vector<std::uint8_t>& bytes) {
  const std::span<const std::uint8_t> all = message.finish();
  bytes.insert(bytes.end(), all.begin(), all.end());
}

void append_sensor(const std::string& name, std::uint64_t unit, const Vec3& a, Nanoseconds t,
                   std::vector<std::uint8_t>& bytes) {
  Message message("SENSOR", name, t);
  message.number(3, 1).number(0, 1).number(unit, 8);
  for (int i = 0; i < 3; ++i) message.real(a[i]);
  append(message, bytes);
}

void append_wrench(const std::string& name, const Wrench& F, Nanoseconds t,
                   std::vector<std::uint8_t>& bytes) {
  constexpr std::size_t longest = openigtlink::max_name - std::string_view(".torque").size();
  append_sensor(name.substr(0, longest) + ".force", unit_N, F.f, t, bytes);
  append_sensor(name.substr(0, longest) + ".torque", unit_Nm, F.tau, t, bytes);
}

struct Status {
  std::uint64_t code;
  const char* text;
};

Status status_of(const ViewSample& sample) {
  if (any(sample.record.rig_faults)) return {.code = 18, .text = "fault of the device"};
  if (sample.record.fault != Fault::none) return {.code = 2, .text = "fault of the simulation"};
  if (sample.phase == RunPhase::running) return {.code = 1, .text = "running"};
  if (sample.phase < RunPhase::running) return {.code = 13, .text = "booting"};
  return {.code = 19, .text = "stopping"};
}

}  // namespace

void append_openigtlink(const ViewSample& sample, const SceneConfig& scene,
                        const std::vector<std::size_t>& driven, Nanoseconds t,
                        std::vector<std::uint8_t>& bytes) {
  constexpr std::uint64_t six_degrees_of_freedom = 2;
  constexpr std::size_t most_tools = 50;  // in a message of Message's capacity
  const CycleRecord& record = sample.record;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    Message message("TRANSFORM", scene.bodies[i].name, t);
    append(message.pose(record.bodies[i].X_WB), bytes);
  }
  for (std::size_t first = 0; first < scene.bodies.size(); first += most_tools) {
    Message message("TDATA", own_name, t);
    for (std::size_t i = first; i < std::min(first + most_tools, scene.bodies.size()); ++i)
      message.text(scene.bodies[i].name, openigtlink::max_name)
          .number(six_degrees_of_freedom, 1)
          .number(0, 1)
          .pose(record.bodies[i].X_WB);
    append(message, bytes);
  }
  if (grips_bodies(scene)) append_wrench("hand", record.hand_W, t, bytes);
  else
    for (const std::size_t i : driven)
      append_wrench(scene.bodies[i].name, record.bodies[i].feedback_D, t, bytes);
  const Status status = status_of(sample);
  const std::string_view text = status.text;
  Message message("STATUS", own_name, t);
  append(message.number(status.code, 2).number(record.cycle, 8).text("", 20).text(text, text.size() + 1),
         bytes);
}

std::unique_ptr<OpenIgtLinkServer> OpenIgtLinkServer::start(const Settings& settings, const Session& session,
                                                            std::string& why_not) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(settings.port);
  const std::string where = settings.address + ":" + std::to_string(settings.port);
  if (inet_pton(AF_INET, settings.address.c_str(), &address.sin_addr) != 1) {
    why_not = "--openigtlink: '" + settings.address + "' is no IPv4 address: give PORT or ADDRESS:PORT";
    return nullptr;
  }
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int one = 1;
  setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
  if (listener < 0 || bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener, static_cast<int>(max_clients)) != 0) {
    why_not = "--openigtlink: cannot listen on " + where + ": " + std::generic_category().message(errno) +
              ": give another port, or end the program that has it";
    if (listener >= 0) close(listener);
    return nullptr;
  }
  return std::unique_ptr<OpenIgtLinkServer>(new OpenIgtLinkServer(listener, settings, session));
}

OpenIgtLinkServer::OpenIgtLinkServer(int listener, const Settings& settings, const Session& session)
    : listener_(listener),
      period_(static_cast<Nanoseconds>(1e9 / settings.rate_hz)),
      wall_origin_ns_(settings.wall_origin_ns),
      scene_(session.scene()),
      driven_(driven_bodies(scene_)),
      tap_(session),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

OpenIgtLinkServer::~OpenIgtLinkServer() {
  thread_ = {};
  for (const Client& client : clients_) close(client.descriptor);
  close(listener_);
}

void OpenIgtLinkServer::run(const std::stop_token& stop) {
  const ThreadSetup setup("openigtlink");
  Nanoseconds due = clock_.now();
  bool is_pending = false;
  while (!stop.stop_requested()) {
    accept_clients();
    listen_to_clients();
    for (Client& client : clients_) send_rest(client);
    const Nanoseconds now = clock_.now();
    if (!is_pending && now >= due && !clients_.empty()) {
      tap_.ask();
      is_pending = true;
      due = std::max(due + period_, now);
    }
    if (const ViewSample* const sample = is_pending ? tap_.get() : nullptr; sample != nullptr) {
      is_pending = false;
      send_to_clients(*sample);
    }
    clock_.sleep_until(now + wake_period);
  }
}

void OpenIgtLinkServer::accept_clients() {
  for (;;) {
    const int descriptor = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (descriptor < 0) return;
    if (clients_.size() == max_clients) {
      close(descriptor);
      continue;
    }
    const int one = 1;
    setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    clients_.push_back({.descriptor = descriptor});
  }
}

void OpenIgtLinkServer::listen_to_clients() {
  std::erase_if(clients_, [](const Client& client) {
    std::array<std::uint8_t, 4096> dropped{};
    const ssize_t size = recv(client.descriptor, dropped.data(), dropped.size(), MSG_DONTWAIT);
    if (size > 0 || (size < 0 && (errno == EAGAIN || errno == EINTR))) return false;
    close(client.descriptor);
    return true;
  });
}

void OpenIgtLinkServer::send_to_clients(const ViewSample& sample) {
  bytes_.clear();
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const Nanoseconds t_day_ns =
      sample.t_ns != 0 ? sample.t_ns + wall_origin_ns_ : Nanoseconds{std::chrono::nanoseconds(now).count()};
  append_openigtlink(sample, scene_, driven_, t_day_ns, bytes_);
  for (Client& client : clients_) {
    if (!client.unsent.empty()) continue;
    client.unsent = bytes_;
    send_rest(client);
  }
}

void OpenIgtLinkServer::send_rest(Client& client) {
  if (client.unsent.empty()) return;
  const ssize_t size =
      send(client.descriptor, client.unsent.data(), client.unsent.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  // A disconnected client is removed when it is read.
  if (size > 0) client.unsent.erase(client.unsent.begin(), client.unsent.begin() + size);
}

}  // namespace godobject
