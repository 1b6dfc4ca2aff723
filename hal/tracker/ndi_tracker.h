// NDI tracker (Polaris, Vega, Aurora), from the opened line to poses: reset, bit rate, tools, tracking,
// polling. t_ns of a sample is the arrival of the first byte of its reply. BX2, which a network has, gives
// the tracker's own time instead, mapped to this clock.
#pragma once

#include <optional>
#include <string_view>

#include "hal/base/stamp_clock.h"
#include "hal/tracker/ndi.h"
#include "hal/tracker/ndi_reply.h"
#include "hal/tracker/tracker.h"
#include "hal/tracker/unread_bytes.h"

namespace godobject {

/// Returns the port handle named by two digits; nullopt for any other text, which is the name of a definition
/// file.
std::optional<std::uint8_t> ndi_handle(std::string_view tool) noexcept;

std::unique_ptr<Tracker> make_ndi_tracker(const TrackerParams& params, ToolDefinitions definitions,
                                          std::vector<std::string>& errors);

class NdiTracker final : public Tracker {
 public:
  NdiTracker(const TrackerParams& params, ToolDefinitions definitions);

  std::uint32_t first_baud() const noexcept override { return ndi::default_baud; }
  void opened(Nanoseconds now) noexcept override;
  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept override;
  LineRequest next(Nanoseconds now) noexcept override;

 private:
  /// Steps in their order.
  enum class Step : std::uint8_t {
    slow_down,           // sets the line to 9600 bit/s
    send_break,          // the tracker answers RESET
    set_rate,            // COMM
    follow_rate,         // sets the line to the rate of COMM
    initialise,          // INIT
    list_used,           // PHSR:01, handles of an earlier run or of unplugged tools
    free_handle,         // PHF
    request_handle,      // PHRQ, for a tool with a definition
    write_definition,    // PVWR, block by block
    list_uninitialised,  // PHSR:02
    initialise_handle,   // PINIT
    list_disabled,       // PHSR:03
    read_plate,          // PHINF
    enable_handle,       // PENA
    start,               // TSTART
    poll,                // BX or TX, until the line is lost
  };

  /// Commands for poses. Firmware without one receives the next.
  enum class Poll : std::uint8_t { bx2, bx, tx };

  static constexpr int max_tries = 3;  // per step
  static const char* name_of(Step step) noexcept;

  ndi::Command command() const noexcept;
  Nanoseconds patience() const noexcept;
  Nanoseconds poll_patience() const noexcept;
  LineRequest send(Nanoseconds now) noexcept;
  void go(Step step) noexcept;
  void restart(Nanoseconds now) noexcept;
  void give_up_or_restart(const char* why, Nanoseconds now) noexcept;
  void on_silence(Nanoseconds now) noexcept;
  void on_poll_answered(Nanoseconds now) noexcept;
  void on_lost_reply(Nanoseconds now) noexcept;
  void on_text(std::span<const std::uint8_t> text, Nanoseconds now) noexcept;
  void on_error(std::uint8_t code, Nanoseconds now) noexcept;
  void on_okay(Nanoseconds now) noexcept;
  void on_data(std::span<const std::uint8_t> text, Nanoseconds now) noexcept;
  void on_handles(std::span<const std::uint8_t> text, Nanoseconds now) noexcept;
  void on_poses(ndi::ReplyReceiver::Event event, std::span<const std::uint8_t> content,
                Nanoseconds now) noexcept;
  ParseResult parse(std::span<const std::uint8_t> content, ndi::PoseReply& reply) const noexcept;
  void take(const ndi::HandlePose& pose, Nanoseconds t) noexcept;
  [[gnu::format(printf, 2, 3)]] void refuse(const char* format, ...) noexcept;
  void next_handle() noexcept;
  void next_definition() noexcept;
  std::optional<std::size_t> tool_of(std::uint8_t handle) const noexcept;
  const char* unread_or(const char* otherwise) noexcept;
  bool was_tracking() const noexcept { return report_.state == TrackerState::tracking; }

  ToolDefinitions definitions_;
  std::array<std::optional<std::uint8_t>, max_tracked_tools> handles_{};  // handles of the tools
  std::array<bool, max_tracked_tools> enabled_{};
  ndi::ReplyReceiver receiver_;
  UnreadBytes unread_;
  std::array<char, 140> unread_text_{};
  ndi::Command command_;
  Step step_ = Step::slow_down;
  bool awaiting_ = false;     // a reply is awaited
  bool reply_began_ = false;  // the first byte of the reply has arrived
  Poll poll_ = Poll::bx;
  StampClock clock_;                 // of BX2
  bool plain_start_ = false;         // TSTART without a parameter
  bool by_default_rate_ = true;      // this attempt begins with a break at 9600 bit/s
  Nanoseconds deadline_ = 0;         // deadline of the reply
  Nanoseconds not_before_ = 0;       // earliest time of the next command
  Nanoseconds quiet_until_ = 0;      // latest end of the wait for the rest of a broken reply
  Nanoseconds t_reply_ = 0;          // arrival of the first byte of the reply
  Nanoseconds boot_deadline_ = 0;    // deadline for tracking to begin
  int tries_ = 0;                    // attempts of this step; polls since the last answer
  int num_unanswered_ = 0;           // polls
  Nanoseconds t_polled_ = 0;         // time of the last poll
  Nanoseconds t_first_polled_ = 0;   // time of the first poll since the last answer
  Nanoseconds answer_time_ = 0;      // from the first poll to the answer, if the poll was repeated
  Nanoseconds longest_answer_ = 0;   // longest recent time from a poll to the end of its reply; 0: unknown
  int passes_ = 0;                   // number of times through list_uninitialised
  ndi::PortHandles listed_;          // reply to the last PHSR
  std::size_t at_ = 0;               // index of the current handle in listed_
  std::size_t tool_ = 0;             // index of the current tool with a definition
  std::size_t address_ = 0;          // address of the current block
  std::array<char, 120> refused_{};  // reason that a tool is not tracked; empty: none
};

}  // namespace godobject
