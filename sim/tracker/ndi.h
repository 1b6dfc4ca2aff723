// Simulated NDI tracker: answers the commands of the Combined API that a host needs for poses. Refuses
// commands in the wrong order with the API's own errors.
#pragma once

#include <optional>
#include <string_view>

#include "hal/tracker/ndi.h"
#include "hal/tracker/ndi_reply.h"
#include "sim/tracker/tracker.h"

namespace godobject {

class SimNdi final : public SimTracker {
 public:
  /// Tools named by a port handle are plugged in; the others exist once their definition is written.
  SimNdi(const TrackerParams& params, double rate_hz, std::uint64_t seed);

  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept override;
  void serial_break(Nanoseconds now) noexcept override;
  /// Sets firmware with the command BX2, as a Vega on a network has it.
  void set_bx2(bool has_bx2) noexcept { has_bx2_ = has_bx2; }
  /// Sets older firmware, for which BX is an invalid command.
  void set_text_only(bool text_only) noexcept { text_only_ = text_only; }
  /// Adds tools outside the scene, from handle `first` on, present in every reply. X: their pose, may be
  /// invalid.
  void set_foreign_tools(std::uint8_t first, std::size_t count, const Pose& X) noexcept {
    first_foreign_ = first;
    num_foreign_ = count;
    X_foreign_ = X;
  }
  /// Returns the bytes of the definition written for a tool.
  std::size_t definition_size(std::size_t tool) const noexcept { return ports_[tool].written; }

 private:
  struct Port {
    std::optional<std::uint8_t> handle;
    bool wired = false, initialised = false, enabled = false;
    std::size_t written = 0;
  };

  void forget_tools() noexcept;
  void answer(std::string_view command, std::string_view parameters, Nanoseconds now) noexcept;
  void answer_handle_command(std::string_view command, std::string_view parameters, Nanoseconds now) noexcept;
  void answer_phsr(std::string_view parameters, Nanoseconds now) noexcept;
  void answer_phrq(Nanoseconds now) noexcept;
  void answer_phinf(const Port& port, Nanoseconds now) noexcept;
  void answer_poses(std::string_view command, std::string_view parameters, Nanoseconds now) noexcept;
  void send_text(std::string_view content, Nanoseconds now) noexcept;
  void send_error(std::uint8_t code, Nanoseconds now) noexcept;
  Port* port_of(std::string_view digits) noexcept;
  std::uint32_t port_bits(std::size_t tool) const noexcept;
  ndi::HandlePose pose_of(std::size_t tool) const noexcept;
  bool is_plugged(std::size_t tool) const noexcept { return !(ports_[tool].wired && faults.disabled[tool]); }

  std::array<Port, max_tracked_tools> ports_{};
  std::size_t num_tools_ = 0;
  std::uint8_t first_foreign_ = 0;
  std::size_t num_foreign_ = 0;
  bool foreign_initialised_ = false;
  Pose X_foreign_{};
  std::array<char, 256> line_{};
  std::size_t line_size_ = 0;
  bool initialised_ = false, tracking_ = false, text_only_ = false, has_bx2_ = false;
};

/// Time of the simulated tracker's clock when that of the host is 0, ns.
inline constexpr Nanoseconds sim_ndi_clock_ns = 1'700'000'000'123'456'789;

/// Make replies to TX:0801, BX:0801 and BX2:--6d=tools for the wire; empty if `out` is too small.
std::span<const std::uint8_t> make_tx_reply(const ndi::PoseReply& reply,
                                            std::span<std::uint8_t> out) noexcept;
std::span<const std::uint8_t> make_bx_reply(const ndi::PoseReply& reply,
                                            std::span<std::uint8_t> out) noexcept;
std::span<const std::uint8_t> make_bx2_reply(const ndi::PoseReply& reply,
                                             std::span<std::uint8_t> out) noexcept;

}  // namespace godobject
