#include "platform/linux/serial_port.h"

// The kernel defines termios2 and BOTHER; the C library's <termios.h> defines the same names without them.
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "platform/rt/cyclic.h"
#include "platform/rt/signals.h"

namespace godobject {
namespace {

constexpr double max_baud_error = 0.025;  // because a receiver must sample the tenth bit within half a bit
constexpr int max_latency_timer_ms = 1;

std::string text_of(int error) { return std::generic_category().message(error); }

std::string remedy_of(int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO: return "; check that it is plugged in: ls -l /dev/serial/by-id lists the ports";
    case EACCES:
      return "; join the group that owns it (ls -l), usually: sudo adduser $USER dialout, then log in again";
    case EBUSY: return "; another program uses it: fuser -v names it";
    default: return "";
  }
}

/// True for slaves of UNIX 98 pseudo-terminals, which have the majors 136 to 143
/// (Documentation/admin-guide/devices.txt).
bool is_pseudo_terminal(int fd) {
  struct stat status {};
  return fstat(fd, &status) == 0 && major(status.st_rdev) >= 136 && major(status.st_rdev) <= 143;
}

bool is_connection_lost(int error) {
  return error == EIO || error == ENXIO || error == ENODEV || error == EPIPE;
}

constexpr const char* udev_rule =
    R"(ACTION=="add", SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{latency_timer}="1")";

Pty fail(Pty pty, const std::string& what) {
  pty.why = "no pseudo-terminal: " + what + ": " + std::generic_category().message(errno);
  for (int* const fd : {&pty.master, &pty.slave}) {
    if (*fd >= 0) ::close(*fd);
    *fd = -1;
  }
  return pty;
}

}  // namespace

std::optional<int> read_latency_timer_ms(const std::string& path, std::string_view sysfs) {
  std::error_code error;
  const std::filesystem::path real = std::filesystem::canonical(path, error);  // through /dev/serial/by-id
  if (error) return std::nullopt;
  std::ifstream file(std::filesystem::path(sysfs) / "class/tty" / real.filename() / "device/latency_timer");
  int milliseconds = 0;
  if (!(file >> milliseconds)) return std::nullopt;
  return milliseconds;
}

bool SerialPort::fail(std::string why) {
  why_ = std::move(why);
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  state_ = SerialState::failed;
  return false;
}

bool SerialPort::open(const std::string& path, const SerialSettings& settings) {
  close();
  path_ = path;
  fd_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) return fail("cannot be opened: " + text_of(errno) + remedy_of(errno));
  if (isatty(fd_) == 0) return fail("is not a terminal; give a serial port like /dev/ttyUSB0 or /dev/pts/3");
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) return fail("is in use by another program: fuser -v names it");
  // A pseudo-terminal is excluded: there the flag would outlive this program and exclude the next one.
  if (!is_pseudo_terminal(fd_) && ioctl(fd_, TIOCEXCL) != 0)
    return fail("cannot be opened exclusively: " + text_of(errno));
  state_ = SerialState::open;
  if (!configure(settings.baud)) return false;
  if (settings.low_latency) request_low_latency();
  ioctl(fd_, TCFLSH, TCIOFLUSH);
  return true;
}

void SerialPort::adopt(int descriptor, std::string name) {
  close();
  fd_ = descriptor;
  path_ = std::move(name);
  state_ = SerialState::open;
}

void SerialPort::close() noexcept {
  if (fd_ >= 0) {
    if (!is_pseudo_terminal(fd_)) ioctl(fd_, TIOCNXCL);
    ::close(fd_);
  }
  fd_ = -1;
  state_ = SerialState::closed;
  low_latency_ = LowLatency::not_requested;
  latency_timer_ms_.reset();
  error_ = 0;
  why_.clear();
}

/// Sets raw mode: no echo, signals, flow control or translation. TCSETSW2 waits until the output has left.
bool SerialPort::configure(std::uint32_t baud) {
  const std::string rate = std::to_string(baud) + " baud";
  if (baud == 0) return fail("needs a baud rate above 0");
  termios2 line{};
  if (ioctl(fd_, TCGETS2, &line) != 0) return fail("its settings cannot be read: " + text_of(errno));
  line.c_iflag = line.c_oflag = line.c_lflag = 0;
  line.c_cflag = CS8 | CREAD | CLOCAL | BOTHER | BOTHER << IBSHIFT;
  line.c_ispeed = line.c_ospeed = baud;
  line.c_cc[VMIN] = 1;  // so that 0 bytes mean hung up, and EAGAIN means none yet
  line.c_cc[VTIME] = 0;
  if (ioctl(fd_, TCSETSW2, &line) != 0) return fail("refuses " + rate + ": " + text_of(errno));
  termios2 actual{};
  if (ioctl(fd_, TCGETS2, &actual) != 0) return fail("its settings cannot be read: " + text_of(errno));
  const double error = static_cast<double>(actual.c_ospeed) / baud - 1;
  if (error > max_baud_error || error < -max_baud_error)
    return fail("does not support " + rate + ": its nearest rate is " + std::to_string(actual.c_ospeed));
  return true;
}

void SerialPort::request_low_latency() {
  latency_error_ = 0;
  low_latency_ = LowLatency::refused;
  serial_struct serial{};
  if (ioctl(fd_, TIOCGSERIAL, &serial) != 0) {
    latency_error_ = errno;
    if (errno == ENOTTY || errno == EINVAL) low_latency_ = LowLatency::not_a_uart;
    return;
  }
  serial.flags |= ASYNC_LOW_LATENCY;
  if (ioctl(fd_, TIOCSSERIAL, &serial) != 0) latency_error_ = errno;
  serial_struct actual{};
  const bool is_set = ioctl(fd_, TIOCGSERIAL, &actual) == 0 && (actual.flags & ASYNC_LOW_LATENCY) != 0;
  latency_timer_ms_ = read_latency_timer_ms(path_);
  if (is_set && latency_timer_ms_.value_or(0) <= max_latency_timer_ms) low_latency_ = LowLatency::in_effect;
}

void SerialPort::lost(int error) noexcept {
  error_ = error;
  state_ = is_connection_lost(error) ? SerialState::hung_up : SerialState::failed;
}

std::size_t SerialPort::read(std::span<std::uint8_t> out) noexcept {
  if (state_ != SerialState::open || out.empty()) return 0;
  const MonotonicClock clock;
  const Nanoseconds begin = clock.now();
  const ssize_t n = loop::read(fd_, out.data(), out.size());
  slow_calls_.add(clock.now() - begin);
  if (n > 0) return static_cast<std::size_t>(n);
  if (n == 0) {
    lost(EIO);
  } else if (loop::error() != EAGAIN && loop::error() != EINTR) {
    lost(loop::error());
  }
  return 0;
}

std::size_t SerialPort::write(std::span<const std::uint8_t> bytes) noexcept {
  if (state_ != SerialState::open || bytes.empty()) return 0;
  const BusWrite write;
  if (!write.allowed()) return 0;
  const MonotonicClock clock;
  const Nanoseconds begin = clock.now();
  const ssize_t n = loop::write(fd_, bytes.data(), bytes.size());
  slow_calls_.add(clock.now() - begin);
  if (n >= 0) return static_cast<std::size_t>(n);
  if (loop::error() != EAGAIN && loop::error() != EINTR) lost(loop::error());
  return 0;
}

bool SerialPort::wait_readable(Nanoseconds timeout) noexcept {
  if (fd_ < 0) return false;
  timeout = std::max(timeout, Nanoseconds{0});
  timespec limit{};
  limit.tv_sec = static_cast<time_t>(timeout / 1'000'000'000);
  limit.tv_nsec = static_cast<long>(timeout % 1'000'000'000);
  pollfd waiting{.fd = fd_, .events = POLLIN, .revents = 0};
  return ppoll(&waiting, 1, &limit, nullptr) > 0;
}

bool SerialPort::set_baud(std::uint32_t baud) { return state_ == SerialState::open && configure(baud); }

void SerialPort::send_break() noexcept {
  if (fd_ >= 0) ioctl(fd_, TCSBRK, 0);
}

void SerialPort::discard_input() noexcept {
  if (fd_ >= 0) ioctl(fd_, TCFLSH, TCIFLUSH);
}

std::string SerialPort::trouble() const {
  switch (state_) {
    case SerialState::open: return "";
    case SerialState::closed: return path_.empty() ? "no serial port is open" : path_ + ": closed";
    case SerialState::hung_up:
      return path_ + ": gone (" + text_of(error_) +
             "); plug it in again, or start the other end again, and reopen it";
    case SerialState::failed: break;
  }
  return path_ + ": " + (why_.empty() ? text_of(error_) + remedy_of(error_) : why_);
}

std::string SerialPort::slowness() const {
  if (slow_calls_.count == 0) return "";
  std::array<char, 24> longest{};
  std::snprintf(longest.data(), longest.size(), "%.1f ms", 1e-6 * static_cast<double>(slow_calls_.longest));
  const bool is_late = low_latency_ == LowLatency::refused;
  return path_ + ": " + std::to_string(slow_calls_.count) +
         " reads or writes of this terminal were delayed by the kernel, " + longest.data() +
         " at most, because its worker for terminals waits for other programs" +
         (is_late ? "; give the port low latency (see its udev rule)" : "") +
         "; end programs that load this machine, use a kernel with PREEMPT_RT, or a CAN adapter with a "
         "driver "
         "(socketcan:)";
}

std::string SerialPort::latency_report() const {
  const std::string timer =
      latency_timer_ms_ ? ", latency timer " + std::to_string(*latency_timer_ms_) + " ms" : "";
  switch (low_latency_) {
    case LowLatency::not_requested: return path_ + ": low latency was not requested";
    case LowLatency::in_effect: return path_ + ": low latency is in effect" + timer;
    case LowLatency::not_a_uart:
      return path_ + ": not a UART: no low-latency setting (a pseudo-terminal or ttyACM needs none)";
    case LowLatency::refused: break;
  }
  return path_ + ": low latency refused" + (latency_error_ != 0 ? " (" + text_of(latency_error_) + ")" : "") +
         timer +
         ": received bytes may be delayed; put this line into /etc/udev/rules.d/99-latency.rules and plug "
         "the "
         "adapter in again: " +
         udev_rule;
}

RtStep check_serial_port(const std::string& name, const std::string& path,
                         const std::filesystem::path& root) {
  const std::filesystem::path file = root / std::filesystem::path(path).relative_path();
  const std::string sysfs = (root / "sys").string();
  if (eaccess(file.c_str(), R_OK | W_OK) != 0)
    return {.name = name,
            .result = RtResult::failed,
            .detail = path + " cannot be opened: " + text_of(errno),
            .remedy = remedy_of(errno).empty() ? "see ls -l " + path : remedy_of(errno).substr(2)};
  const std::optional<int> timer_ms = read_latency_timer_ms(file.string(), sysfs);
  const std::string timer = timer_ms ? path + ", latency timer " + std::to_string(*timer_ms) + " ms" : path;
  if (timer_ms.value_or(0) <= max_latency_timer_ms)
    return {.name = name, .result = RtResult::ok, .detail = timer, .remedy = ""};
  std::string remedy = "echo '";
  remedy += udev_rule;
  remedy += "' >> /etc/udev/rules.d/99-latency.rules, and plug the adapter in again";
  return {.name = name,
          .result = RtResult::degraded,
          .detail = timer + ": received bytes are late, unless the run can set it",
          .remedy = remedy};
}

SerialAddress parse_serial_address(const std::string& where, std::uint32_t default_baud) {
  const std::size_t comma = where.rfind(',');
  if (comma == std::string::npos) return {.path = where, .baud = default_baud};
  SerialAddress address{.path = where.substr(0, comma)};
  const char* const end = where.data() + where.size();
  const auto [stop, error] = std::from_chars(where.data() + comma + 1, end, address.baud);
  if (error != std::errc{} || stop != end) address.baud = 0;
  return address;
}

Pty make_pty() {
  Pty pty{.master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (pty.master < 0) return fail(pty, "posix_openpt");
  std::array<char, 64> name{};
  if (grantpt(pty.master) != 0 || unlockpt(pty.master) != 0 ||
      ptsname_r(pty.master, name.data(), name.size()) != 0)
    return fail(pty, "its other end cannot be made ready");
  pty.name = name.data();
  pty.slave = ::open(name.data(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  termios raw{};
  raw.c_cflag = CS8;
  raw.c_cc[VMIN] = 1;
  if (pty.slave < 0 || ioctl(pty.slave, TCSETS, &raw) != 0) return fail(pty, pty.name);
  return pty;
}

}  // namespace godobject
