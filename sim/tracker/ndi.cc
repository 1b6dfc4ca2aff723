#include "sim/tracker/ndi.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "hal/base/codec.h"
#include "hal/base/crc16.h"
#include "hal/tracker/ndi_tracker.h"

namespace godobject {
namespace {

namespace error {
constexpr std::uint8_t invalid_command = 0x01, bad_crc = 0x04, no_handle = 0x08, wrong_mode = 0x0C,
                       not_initialised = 0x0E, system_not_initialised = 0x10;
}

std::span<const std::uint8_t> as_bytes(std::string_view text) noexcept {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Text that grows in place and is truncated at its capacity.
class Text {
 public:
  explicit Text(std::span<std::uint8_t> out) noexcept : out_(out) {}

  [[gnu::format(printf, 2, 3)]] void add(const char* format, ...) noexcept {
    std::array<char, 128> part{};
    std::va_list arguments;
    va_start(arguments, format);
    const int size = std::vsnprintf(part.data(), part.size(), format, arguments);
    va_end(arguments);
    const std::size_t fits = std::min(static_cast<std::size_t>(std::max(size, 0)), out_.size() - size_);
    std::copy_n(part.begin(), fits, out_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += fits;
  }
  std::span<const std::uint8_t> bytes() const noexcept { return out_.first(size_); }

 private:
  std::span<std::uint8_t> out_;
  std::size_t size_ = 0;
};

std::span<const std::uint8_t> finish(Text& text) noexcept {
  text.add("%04X\r", unsigned{crc16<crc16_arc>(text.bytes())});
  return text.bytes();
}

constexpr std::size_t binary_header = 6;  // C4 A5, size, CRC

/// Returns x in multiples of `unit`, clamped to +-limit.
int scaled(double x, double unit, int limit) noexcept { return saturate_to<int>(x / unit, -limit, limit); }

void put_float(ByteWriter& out, double value) noexcept {
  out.put(std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

}  // namespace

std::span<const std::uint8_t> make_tx_reply(const ndi::PoseReply& reply,
                                            std::span<std::uint8_t> out) noexcept {
  Text text(out);
  text.add("%02zX", reply.num_handles);
  for (const ndi::HandlePose& h : reply.all()) {
    text.add("%02X", unsigned{h.handle});
    if (h.status == ndi::HandleStatus::disabled) {
      text.add("DISABLED\n");
      continue;
    }
    const Pose& X = h.X_TH;
    if (h.status == ndi::HandleStatus::missing) {
      text.add("MISSING");
    } else {
      for (const double q : {X.q.w(), X.q.x(), X.q.y(), X.q.z()}) text.add("%+06d", scaled(q, 1e-4, 99'999));
      for (const double p : {X.p.x(), X.p.y(), X.p.z()}) text.add("%+07d", scaled(p, 1e-5, 999'999));
      text.add("%+06d", scaled(h.error_m, 1e-7, 99'999));
    }
    text.add("%08X%08X\n", h.port_bits, h.frame);
  }
  text.add("%04X", unsigned{reply.system_status});
  return finish(text);
}

namespace {

/// Adds head and CRCs to the body at out[6], whose writer is given.
std::span<const std::uint8_t> finish_binary(ByteWriter& body, std::span<std::uint8_t> out) noexcept {
  const std::size_t size = body.size();
  body.put(crc16<crc16_arc>(out.subspan(binary_header, size)));
  if (!body.ok()) return {};
  ByteWriter(out).put(std::uint16_t{0xA5C4}).put(static_cast<std::uint16_t>(size)).put(std::uint16_t{0});
  ByteWriter(out.subspan(4)).put(crc16<crc16_arc>(out.first(4)));
  return out.first(binary_header + size + 2);
}

void put_pose(ByteWriter& body, const ndi::HandlePose& h) noexcept {
  const Pose& X = h.X_TH;
  for (const double q : {X.q.w(), X.q.x(), X.q.y(), X.q.z()}) put_float(body, q);
  for (const double p : {X.p.x(), X.p.y(), X.p.z()}) put_float(body, 1e3 * p);
  put_float(body, 1e3 * h.error_m);
}

}  // namespace

std::span<const std::uint8_t> make_bx_reply(const ndi::PoseReply& reply,
                                            std::span<std::uint8_t> out) noexcept {
  if (out.size() < binary_header + 2) return {};
  ByteWriter body(out.subspan(binary_header));
  body.put(static_cast<std::uint8_t>(reply.num_handles));
  for (const ndi::HandlePose& h : reply.all()) {
    body.put(h.handle).put(static_cast<std::uint8_t>(h.status));
    if (h.status == ndi::HandleStatus::disabled) continue;
    if (h.status == ndi::HandleStatus::valid) put_pose(body, h);
    body.put(h.port_bits).put(h.frame);
  }
  body.put(reply.system_status);
  return finish_binary(body, out);
}

std::span<const std::uint8_t> make_bx2_reply(const ndi::PoseReply& reply,
                                             std::span<std::uint8_t> out) noexcept {
  if (out.size() < binary_header + 2) return {};
  ByteWriter body(out.subspan(binary_header));
  constexpr std::uint16_t version = 1, one = 1, of_frame = 1, of_poses = 2, missing = 0x100, unplugged = 0x21;
  constexpr std::uint32_t head = 12, frame_bytes = 16 + 4;
  std::uint32_t pose_bytes = head;
  for (const ndi::HandlePose& h : reply.all()) pose_bytes += h.status == ndi::HandleStatus::valid ? 36u : 4u;
  body.put(version).put(one);
  body.put(of_frame).put(head + frame_bytes + pose_bytes).put(std::uint16_t{0}).put(std::uint32_t{1});
  const std::uint32_t frame = reply.num_handles > 0 ? reply.handles[0].frame : 0;
  body.put(std::uint8_t{2}).put(std::uint8_t{0}).put(std::uint16_t{0}).put(frame);
  body.put(static_cast<std::uint32_t>(reply.t_ns / 1'000'000'000))
      .put(static_cast<std::uint32_t>(reply.t_ns % 1'000'000'000));
  body.put(version).put(one);
  body.put(of_poses).put(pose_bytes).put(std::uint16_t{0}).put(static_cast<std::uint32_t>(reply.num_handles));
  for (const ndi::HandlePose& h : reply.all()) {
    const bool is_outside = (h.port_bits & ndi::port_status::out_of_volume) != 0;
    const auto status = h.status == ndi::HandleStatus::valid ? static_cast<std::uint16_t>(is_outside ? 2 : 0)
                        : h.status == ndi::HandleStatus::missing
                            ? missing
                            : static_cast<std::uint16_t>(missing | unplugged);
    body.put(std::uint16_t{h.handle}).put(status);
    if (h.status == ndi::HandleStatus::valid) put_pose(body, h);
  }
  return finish_binary(body, out);
}

SimNdi::SimNdi(const TrackerParams& params, double rate_hz, std::uint64_t seed)
    : SimTracker(rate_hz, seed), num_tools_(std::min(params.tools.size(), max_tracked_tools)) {
  for (std::size_t i = 0; i < num_tools_; ++i) {
    ports_[i].handle = ndi_handle(params.tools[i].tool);
    ports_[i].wired = ports_[i].handle.has_value();
  }
}

void SimNdi::forget_tools() noexcept {
  initialised_ = tracking_ = foreign_initialised_ = false;
  for (Port& port : ports_) {
    port.initialised = port.enabled = false;
    port.written = 0;
    if (!port.wired) port.handle.reset();
  }
}

void SimNdi::serial_break(Nanoseconds now) noexcept {
  forget_tools();
  line_size_ = 0;
  send_text("RESET", now);
}

void SimNdi::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept {
  for (const std::uint8_t byte : bytes) {
    if (byte != '\r') {
      if (line_size_ < line_.size()) line_[line_size_++] = static_cast<char>(byte);
      continue;
    }
    const std::string_view line(line_.data(), line_size_);
    line_size_ = 0;
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || line.size() < colon + 5) {
      send_error(error::invalid_command, now);
      continue;
    }
    const std::string_view content = line.substr(0, line.size() - 4);
    std::array<char, 5> crc{};
    std::snprintf(crc.data(), crc.size(), "%04X", unsigned{crc16<crc16_arc>(as_bytes(content))});
    if (line.substr(content.size()) != crc.data()) {
      send_error(error::bad_crc, now);
    } else {
      answer(content.substr(0, colon), content.substr(colon + 1), now);
    }
  }
}

void SimNdi::answer(std::string_view command, std::string_view parameters, Nanoseconds now) noexcept {
  const bool poses = command == "TX" || command == "BX" || command == "BX2";
  if ((command == "BX" && text_only_) || (command == "BX2" && !has_bx2_))
    return send_error(error::invalid_command, now);
  if (command == "COMM") return send_text("OKAY", now);
  if (command == "VER") return send_text("Simulated Control Firmware\nNDI S/N: none\n", now);
  if (command == "INIT") {
    forget_tools();
    initialised_ = true;
    return send_text("OKAY", now);
  }
  if (poses) {
    if (!tracking_) return send_error(error::wrong_mode, now);
    return answer_poses(command, parameters, now);
  }
  if (command == "TSTOP") {
    tracking_ = false;
    return send_text("OKAY", now);
  }
  if (!initialised_) return send_error(error::system_not_initialised, now);
  if (tracking_) return send_error(error::wrong_mode, now);
  if (command == "TSTART") {
    tracking_ = true;
    if (parameters == "80") restart_frames();
    return send_text("OKAY", now);
  }
  if (command == "PHSR") return answer_phsr(parameters, now);
  if (command == "PHRQ") return answer_phrq(now);
  answer_handle_command(command, parameters, now);
}

void SimNdi::answer_handle_command(std::string_view command, std::string_view parameters,
                                   Nanoseconds now) noexcept {
  constexpr std::array known{"PVWR", "PINIT", "PENA", "PDIS", "PHF", "PHINF"};
  if (std::ranges::find(known, command) == known.end()) return send_error(error::invalid_command, now);
  const auto handle = ndi_handle(parameters.substr(0, 2));
  if (handle && *handle >= first_foreign_ && *handle < first_foreign_ + num_foreign_) {
    foreign_initialised_ = foreign_initialised_ || command == "PINIT";
    return send_text("OKAY", now);
  }
  Port* const port = port_of(parameters.substr(0, 2));
  if (port == nullptr) return send_error(error::no_handle, now);
  if (command == "PHINF") return answer_phinf(*port, now);
  if (command == "PVWR") {
    port->written += ndi::block_size;
  } else if (command == "PINIT") {
    if (!port->wired && port->written == 0) return send_error(0x13, now);
    port->initialised = true;
  } else if (command == "PENA") {
    if (!port->initialised) return send_error(error::not_initialised, now);
    port->enabled = true;
  } else if (command == "PDIS") {
    port->enabled = false;
  } else {
    port->handle.reset();
  }
  send_text("OKAY", now);
}

/// Answers PHSR: 00 all, 01 to be freed, 02 not initialised, 03 initialised and not enabled, 04 enabled.
void SimNdi::answer_phsr(std::string_view parameters, Nanoseconds now) noexcept {
  std::array<std::uint8_t, 2048> reply{};
  Text text(reply);
  std::array<std::size_t, max_tracked_tools> listed{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < num_tools_; ++i) {
    const Port& port = ports_[i];
    if (!port.handle || !is_plugged(i)) continue;
    const bool wanted = parameters == "00" || (parameters == "02" && !port.initialised) ||
                        (parameters == "03" && port.initialised && !port.enabled) ||
                        (parameters == "04" && port.enabled);
    if (wanted) listed[count++] = i;
  }
  const bool foreign_wanted = parameters == "00" || parameters == (foreign_initialised_ ? "03" : "02");
  const std::size_t num_foreign = foreign_wanted ? num_foreign_ : 0;
  text.add("%02zX", num_foreign + count);
  for (std::size_t i = 0; i < num_foreign; ++i)
    text.add("%02X%03X", unsigned{first_foreign_} + static_cast<unsigned>(i),
             foreign_initialised_ ? 0x011u : 0x001u);
  for (std::size_t i = 0; i < count; ++i)
    text.add("%02X%03X", unsigned{*ports_[listed[i]].handle}, port_bits(listed[i]) & 0xFFFu);
  send(finish(text), now);
}

/// Assigns the next free handle to the next passive tool.
void SimNdi::answer_phrq(Nanoseconds now) noexcept {
  for (std::size_t i = 0; i < num_tools_; ++i) {
    if (ports_[i].handle || ports_[i].wired) continue;
    std::uint8_t handle = 1;
    const auto taken = [&] {
      return std::ranges::any_of(ports_, [&](const Port& port) { return port.handle == handle; });
    };
    while (taken()) ++handle;
    ports_[i].handle = handle;
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02X", unsigned{handle});
    return send_text(digits.data(), now);
  }
  send_error(error::no_handle, now);
}

void SimNdi::answer_phinf(const Port& port, Nanoseconds now) noexcept {
  std::array<std::uint8_t, 64> reply{};
  Text text(reply);
  text.add("01000000%-12s001%08X%02X", "Simulated", unsigned{*port.handle},
           port_bits(static_cast<std::size_t>(&port - ports_.data())) & 0xFFu);
  send(finish(text), now);
}

std::uint32_t SimNdi::port_bits(std::size_t tool) const noexcept {
  const Port& port = ports_[tool];
  return (port.wired ? ndi::port_status::tool_in_port : 0u) |
         (port.initialised ? ndi::port_status::initialised : 0u) |
         (port.enabled ? ndi::port_status::enabled : 0u) |
         (faults.out_of_volume[tool] ? ndi::port_status::out_of_volume : 0u);
}

ndi::HandlePose SimNdi::pose_of(std::size_t tool) const noexcept {
  ndi::HandlePose pose{.handle = *ports_[tool].handle, .X_TH = measurement().poses[tool], .error_m = 1e-4};
  pose.port_bits = port_bits(tool);
  pose.frame = measurement().frame;
  pose.status = !is_plugged(tool)      ? ndi::HandleStatus::disabled
                : faults.missing[tool] ? ndi::HandleStatus::missing
                                       : ndi::HandleStatus::valid;
  return pose;
}

void SimNdi::answer_poses(std::string_view command, std::string_view parameters, Nanoseconds now) noexcept {
  const bool is_known =
      command == "BX2" ? parameters == "--6d=tools" : parameters == "0001" || parameters == "0801";
  if (!is_known) return send_error(0x23, now);
  ndi::PoseReply reply;
  reply.t_ns = sim_ndi_clock_ns + measurement().t;
  for (std::size_t i = 0; i < num_foreign_; ++i)
    reply.handles[reply.num_handles++] = {.handle = static_cast<std::uint8_t>(first_foreign_ + i),
                                          .status = ndi::HandleStatus::valid,
                                          .X_TH = X_foreign_,
                                          .port_bits = ndi::port_status::enabled,
                                          .frame = measurement().frame};
  for (std::size_t i = 0; i < num_tools_; ++i) {
    if (ports_[i].handle && ports_[i].enabled) reply.handles[reply.num_handles++] = pose_of(i);
  }
  std::array<std::uint8_t, max_message> bytes{};
  send(command == "BX2"  ? make_bx2_reply(reply, bytes)
       : command == "BX" ? make_bx_reply(reply, bytes)
                         : make_tx_reply(reply, bytes),
       now);
}

SimNdi::Port* SimNdi::port_of(std::string_view digits) noexcept {
  const auto handle = ndi_handle(digits);
  const auto found =
      std::ranges::find_if(ports_, [&](const Port& port) { return handle && port.handle == handle; });
  return found == ports_.end() ? nullptr : &*found;
}

void SimNdi::send_text(std::string_view content, Nanoseconds now) noexcept {
  std::array<std::uint8_t, 256> reply{};
  Text text(reply);
  text.add("%.*s", static_cast<int>(content.size()), content.data());
  send(finish(text), now);
}

void SimNdi::send_error(std::uint8_t code, Nanoseconds now) noexcept {
  std::array<std::uint8_t, 16> reply{};
  Text text(reply);
  text.add("ERROR%02X", unsigned{code});
  send(finish(text), now);
}

}  // namespace godobject
