#include "hal/drive/moteus.h"

#include <algorithm>

namespace godobject {

namespace moteus {
namespace {

constexpr std::uint8_t filling = 0x50;
constexpr std::uint32_t max_count = 64;  // upper bound for any frame

constexpr std::size_t size_of(ValueType type) noexcept {
  switch (type) {
    case ValueType::int8: return 1;
    case ValueType::int16: return 2;
    case ValueType::int32:
    case ValueType::real: break;
  }
  return 4;
}

// Quantum of a register as int8, int16 and int32.
using Quanta = std::array<double, 3>;
constexpr Quanta quanta_of(std::uint32_t reg) noexcept {
  switch (reg) {
    case position:
    case command_position: return {1e-2, 1e-4, 1e-5};
    case velocity:
    case command_velocity: return {1e-1, 2.5e-4, 1e-5};
    case torque:
    case feedforward_torque:
    case max_torque: return {0.5, 1e-2, 1e-3};
    case voltage: return {0.5, 0.1, 1e-3};
    case temperature: return {1, 0.1, 1e-3};
    case kp_scale:
    case kd_scale: return {1.0 / 127, 1.0 / 32767, 1.0 / 2147483647};
    case watchdog_timeout: return {1e-2, 1e-3, 1e-6};
    default: return {1, 1, 1};
  }
}

template <class T>
double read_integer(ByteReader reader, double quantum) noexcept {
  T raw = 0;
  reader.get(raw);
  return raw == std::numeric_limits<T>::min() ? std::numeric_limits<double>::quiet_NaN() : quantum * raw;
}

template <class T>
void write_integer(ByteWriter writer, double value, double quantum) noexcept {
  constexpr T nan = std::numeric_limits<T>::min();
  const auto saturated =
      saturate_to<T>(value / quantum, static_cast<T>(nan + 1), std::numeric_limits<T>::max());
  writer.put(std::isnan(value) ? nan : saturated);
}

constexpr std::uint8_t fd_size(std::uint8_t size) noexcept {
  constexpr std::array<std::uint8_t, 7> sizes{8, 12, 16, 20, 24, 32, 48};
  for (const std::uint8_t s : sizes)
    if (size <= s) return s;
  return 64;
}

}  // namespace

double Subframe::value(std::uint32_t index) const noexcept {
  const Quanta quanta = quanta_of(first + index);
  const ByteReader reader(bytes.subspan(index * size_of(type), size_of(type)));
  switch (type) {
    case ValueType::int8: return read_integer<std::int8_t>(reader, quanta[0]);
    case ValueType::int16: return read_integer<std::int16_t>(reader, quanta[1]);
    case ValueType::int32: return read_integer<std::int32_t>(reader, quanta[2]);
    case ValueType::real: break;
  }
  float real = 0;
  ByteReader(reader).get(real);
  return static_cast<double>(real);
}

// Parses a varuint: seven bits per byte, least significant first; bit 7: another byte follows.
bool SubframeReader::take_varuint(std::uint32_t& value) noexcept {
  value = 0;
  for (int shift = 0; shift < 32 && !bytes_.empty(); shift += 7) {
    const std::uint8_t byte = bytes_.front();
    bytes_ = bytes_.subspan(1);
    value |= static_cast<std::uint32_t>(byte & 0x7Fu) << shift;
    if ((byte & 0x80u) == 0) return true;
  }
  return false;
}

bool SubframeReader::next(Subframe& out) noexcept {
  while (!bytes_.empty() && bytes_.front() == filling) bytes_ = bytes_.subspan(1);
  if (bytes_.empty() || !ok_) return false;
  const unsigned head = bytes_.front();
  bytes_ = bytes_.subspan(1);
  ok_ = false;
  if (head >= 0x30) return false;
  out.kind = static_cast<SubframeKind>(head >> 4);
  out.type = static_cast<ValueType>((head >> 2) & 3u);
  out.count = head & 3u;
  if (out.count == 0 && !take_varuint(out.count)) return false;
  if (out.count > max_count || !take_varuint(out.first)) return false;
  const std::size_t size = out.kind == SubframeKind::read ? 0 : out.count * size_of(out.type);
  if (bytes_.size() < size) return false;
  out.bytes = bytes_.first(size);
  bytes_ = bytes_.subspan(size);
  ok_ = true;
  return true;
}

void SubframeWriter::put(std::span<const std::uint8_t> bytes) noexcept {
  full_ = full_ || bytes_.size() - size_ < bytes.size();
  if (full_) return;
  std::ranges::copy(bytes, bytes_.begin() + size_);
  size_ = static_cast<std::uint8_t>(size_ + bytes.size());
}

// Writes the head of a sub-frame. Registers used here are below 80h: a varuint of one byte.
void SubframeWriter::head(SubframeKind kind, ValueType type, Register first, std::uint8_t count) noexcept {
  const bool count_in_head = count >= 1 && count <= 3;
  const auto code = static_cast<std::uint8_t>(
      static_cast<unsigned>(kind) << 4 | static_cast<unsigned>(type) << 2 | (count_in_head ? count : 0u));
  const auto reg = static_cast<std::uint8_t>(first);
  if (count_in_head) put(std::array{code, reg});
  else put(std::array{code, count, reg});
}

void SubframeWriter::read(ValueType type, Register first, std::uint8_t count) noexcept {
  head(SubframeKind::read, type, first, count);
}

void SubframeWriter::write(std::span<const std::uint8_t> values, Register first) noexcept {
  head(SubframeKind::write, ValueType::int8, first, static_cast<std::uint8_t>(values.size()));
  put(values);
}

void SubframeWriter::write(float value, Register reg) noexcept {
  head(SubframeKind::write, ValueType::real, reg, 1);
  std::array<std::uint8_t, 4> bytes{};
  ByteWriter(bytes).put(value);
  put(bytes);
}

void SubframeWriter::reply(ValueType type, Register first, std::span<const double> values) noexcept {
  head(SubframeKind::reply, type, first, static_cast<std::uint8_t>(values.size()));
  for (std::uint32_t i = 0; i < values.size(); ++i) {
    const Quanta quanta = quanta_of(first + i);
    std::array<std::uint8_t, 4> bytes{};
    const ByteWriter writer(bytes);
    switch (type) {
      case ValueType::int8: write_integer<std::int8_t>(writer, values[i], quanta[0]); break;
      case ValueType::int16: write_integer<std::int16_t>(writer, values[i], quanta[1]); break;
      case ValueType::int32: write_integer<std::int32_t>(writer, values[i], quanta[2]); break;
      case ValueType::real: ByteWriter(writer).put(static_cast<float>(values[i])); break;
    }
    put(std::span(bytes).first(size_of(type)));
  }
}

CanFrame SubframeWriter::frame(std::uint32_t id) const noexcept {
  CanFrame frame{
      .id = id, .extended = id > 0x7FFu, .fd = true, .bit_rate_switch = true, .size = fd_size(size_)};
  std::fill_n(std::ranges::copy(std::span(bytes_).first(size_), frame.data.begin()).out, frame.size - size_,
              filling);
  return frame;
}

namespace {

void put_query(SubframeWriter& out) noexcept {
  out.read(ValueType::int32, mode, 4);  // mode, position, velocity, torque
  out.read(ValueType::int8, fault, 1);
}

}  // namespace

std::vector<CanFilter> filters(std::uint8_t node) {
  constexpr std::uint32_t all = 0x1FFF'FFFF, all_standard = 0x7FF, reply_requested = 0x8000;
  const std::uint32_t from = std::uint32_t{node} << 8;
  std::vector<CanFilter> filters{{.id = from, .mask = all & ~0xFFu, .extended = true},
                                 {.id = reply_requested | node, .mask = all, .extended = true}};
  if (from <= all_standard) filters.push_back({.id = from, .mask = all_standard});
  return filters;
}

CanFrame make_query(std::uint8_t node) noexcept {
  SubframeWriter out;
  put_query(out);
  return out.frame(request_id(node));
}

CanFrame make_torque(std::uint8_t node, float torque_Nm, float watchdog_s) noexcept {
  SubframeWriter out;
  out.write(std::array<std::uint8_t, 1>{mode_position}, mode);
  out.write(torque_Nm, feedforward_torque);
  out.write(std::array<std::uint8_t, 2>{0, 0}, kp_scale);  // kp_scale and kd_scale
  out.write(watchdog_s, watchdog_timeout);
  put_query(out);
  return out.frame(request_id(node));
}

double watchdog_s(double cycle_s) noexcept {
  constexpr double shortest_s = 0.02;
  constexpr double cycles = 4;
  return std::max(shortest_s, cycles * cycle_s);
}

CanFrame make_stop(std::uint8_t node, bool with_query) noexcept {
  SubframeWriter out;
  out.write(std::array<std::uint8_t, 1>{mode_stopped}, mode);
  if (with_query) put_query(out);
  return out.frame(with_query ? request_id(node) : command_id(node));
}

ParseResult parse_reply(const CanFrame& frame, std::uint8_t node, Reply& out) noexcept {
  if (sender(frame) != node) return ParseResult::other_message;
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
  std::array<double, fault + 1> values;
  values.fill(missing);
  values[fault] = 0;
  SubframeReader reader(frame.bytes());
  for (Subframe subframe; reader.next(subframe);) {
    if (subframe.kind != SubframeKind::reply) return ParseResult::bad_value;
    for (std::uint32_t i = 0; i < subframe.count; ++i)
      if (subframe.first + i < values.size()) values[subframe.first + i] = subframe.value(i);
  }
  const bool numbers = std::isfinite(values[mode]) && std::isfinite(values[position]) &&
                       std::isfinite(values[velocity]) && std::isfinite(values[torque]);
  if (!reader.ok() || !numbers) return ParseResult::bad_value;
  out = {.mode = saturate_to<int>(values[mode]),
         .position_rev = values[position],
         .velocity_rev_per_s = values[velocity],
         .torque_Nm = values[torque],
         .fault = saturate_to<int>(values[fault])};
  return ParseResult::ok;
}

CanFrame make_reply(std::uint8_t node, const Reply& reply) noexcept {
  SubframeWriter out;
  out.reply(ValueType::int32, mode,
            std::array{double(reply.mode), reply.position_rev, reply.velocity_rev_per_s, reply.torque_Nm});
  out.reply(ValueType::int8, fault, std::array{double(reply.fault)});
  return out.frame(reply_id(node));
}

}  // namespace moteus

DriveMessage MoteusLink::decode(const CanFrame& frame, DriveTelemetry& out) noexcept {
  moteus::Reply reply;
  ParseResult result = moteus::parse_reply(frame, node_, reply);
  const double counts = counts_per_motor_turn * reply.position_rev;
  if (result == ParseResult::ok && std::abs(counts) > std::numeric_limits<std::int32_t>::max())
    result = ParseResult::bad_value;
  if (result != ParseResult::ok) return {.result = result};
  heard_ = true;
  cycles_silent_ = 0;
  mode_ = reply.mode;
  const bool failed = mode_ == moteus::mode_fault;
  out.position_counts = static_cast<std::uint32_t>(saturate_to<std::int32_t>(counts));
  out.velocity_counts_per_s = counts_per_motor_turn * reply.velocity_rev_per_s;
  out.torque_Nm = reply.torque_Nm;
  out.state = mode_ == moteus::mode_position            ? MotorState::enabled
              : failed || mode_ == moteus::mode_timeout ? MotorState::fault
                                                        : MotorState::off;
  out.internal_limit =
      !failed && reply.fault >= moteus::first_limit_code && reply.fault <= moteus::last_limit_code;
  out.error_code = failed ? static_cast<std::uint32_t>(reply.fault) : 0;
  out.own_state = static_cast<std::uint32_t>(mode_);
  out.has_own_state = true;
  out.powered = mode_ == moteus::mode_position;
  return {.result = result, .position = true, .alive = true};
}

std::optional<CanFrame> MoteusLink::request(const DriveOrder& order) const noexcept {
  const bool enabled = mode_ == moteus::mode_position;
  const bool latched = mode_ == moteus::mode_fault || mode_ == moteus::mode_timeout;
  const bool stop = order.goal == DriveGoal::off || order.goal == DriveGoal::quick_stop ||
                    (order.goal == DriveGoal::enable && latched);
  if (!heard_ || (order.goal == DriveGoal::hold && !enabled)) return moteus::make_query(node_);
  if (stop) return moteus::make_stop(node_, true);
  if (cycles_silent_ > max_cycles_silent_) return moteus::make_query(node_);
  return moteus::make_torque(node_, static_cast<float>(order.torque_Nm), watchdog_s_);
}

// Returns a stop at once; a torque is sent with the next request.
DriveFrame MoteusLink::command(const DriveOrder& order, Nanoseconds) const noexcept {
  const bool stop =
      order.goal == DriveGoal::off || (order.goal == DriveGoal::quick_stop && mode_ == moteus::mode_position);
  return stop ? DriveFrame{moteus::make_stop(node_, false)} : DriveFrame{};
}

std::vector<CyclicMessage> MoteusLink::messages(double cycle_s, double) const {
  return {{"torque command and query", moteus::make_torque(node_, 0, watchdog_s_), cycle_s},
          {"drive reply", moteus::make_reply(node_, {}), cycle_s}};
}

}  // namespace godobject
