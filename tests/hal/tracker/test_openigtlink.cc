// Messages of OpenIGTLink: whole, in pieces, damaged and absurd; and the tracker that receives them.
#include "hal/tracker/openigtlink_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>

namespace godobject::test_openigtlink {
namespace {

using openigtlink::Message;
using openigtlink::Receiver;
using Event = Receiver::Event;
using Bytes = std::vector<std::uint8_t>;

constexpr Nanoseconds ms = 1'000'000;
const Pose somewhere{.p = Vec3(0.1, -0.2, 1.5), .q = Quat(0.5, -0.5, 0.5, 0.5)};

Bytes bytes_of(Message message) {
  const auto bytes = message.finish();
  return {bytes.begin(), bytes.end()};
}
Bytes transform(const std::string& name, const Pose& X, Nanoseconds t = 0) {
  return bytes_of(Message("TRANSFORM", name, t).pose(X));
}
Bytes transform_of(const std::array<float, 12>& numbers) {
  Message message("TRANSFORM", "probe", 0);
  for (const float x : numbers) message.number(std::bit_cast<std::uint32_t>(x), 4);
  return bytes_of(message);
}
void put(Bytes& bytes, std::size_t at, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i)
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * (size - 1 - i)));
}
/// Corrects length and CRC of a changed message.
Bytes sealed(Bytes bytes) {
  put(bytes, 42, bytes.size() - 58, 8);
  put(bytes, 50, openigtlink::crc64(std::span(bytes).subspan(58)), 8);
  return bytes;
}
std::vector<Event> events_of(Receiver& receiver, std::span<const std::uint8_t> bytes) {
  std::vector<Event> events;
  while (!bytes.empty()) events.push_back(receiver.push(bytes));
  return events;
}

TEST(OpenIgtLink, TheCrcHasItsCheckValue) {
  const std::string text = "123456789";
  EXPECT_EQ(openigtlink::crc64(Bytes(text.begin(), text.end())), 0x6C40DF5F0B497347u);
}

TEST(OpenIgtLink, AMessageIsReadInPiecesOfAnySize) {
  constexpr Nanoseconds t = 1'631'416'514'717'133'000;
  Bytes stream = transform("probe", somewhere, t);
  const Bytes other = bytes_of(Message("IMAGE", "ct", 0).text("", 3000));
  stream.insert(stream.end(), other.begin(), other.end());
  const Bytes again = stream;
  stream.insert(stream.end(), again.begin(), again.end());
  for (const std::size_t piece :
       {std::size_t{1}, std::size_t{7}, std::size_t{58}, std::size_t{500}, stream.size()}) {
    Receiver receiver;
    std::vector<Event> events;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      auto bytes = std::span<const std::uint8_t>(stream).subspan(at, std::min(piece, stream.size() - at));
      while (!bytes.empty()) {
        const Event event = receiver.push(bytes);
        if (event != Event::more) events.push_back(event);
        if (event != Event::message) continue;
        ASSERT_EQ(receiver.num_poses(), 1u);
        EXPECT_EQ(receiver.pose(0).name, "probe");
        EXPECT_LE(std::abs(receiver.header().t - t), 1);
        ASSERT_TRUE(receiver.pose(0).X_TH);
        EXPECT_LT((receiver.pose(0).X_TH->p - somewhere.p).norm(), 1e-7);
        EXPECT_NEAR(std::abs(receiver.pose(0).X_TH->q.dot(somewhere.q)), 1, 1e-7);
      }
    }
    EXPECT_EQ(events, (std::vector{Event::message, Event::passed, Event::message, Event::passed})) << piece;
  }
}

TEST(OpenIgtLink, TdataHasSeveralTools) {
  Message message("TDATA", "tracker", 0);
  for (const char* name : {"probe", "a name of 20 letters", "reference"})
    message.text(name, 20).number(2, 1).number(0, 1).pose(somewhere);
  Receiver receiver;
  EXPECT_EQ(events_of(receiver, bytes_of(message)), std::vector{Event::message});
  ASSERT_EQ(receiver.num_poses(), 3u);
  EXPECT_EQ(receiver.pose(1).name, "a name of 20 letters");
  EXPECT_EQ(receiver.pose(2).name, "reference");
  EXPECT_TRUE(receiver.pose(2).X_TH);
}

TEST(OpenIgtLink, LaterVersionsHaveAnExtendedHeaderAndMetaData) {
  Bytes bytes = transform("probe", somewhere);
  Bytes extended(12);
  put(extended, 0, 12, 2);
  put(extended, 2, 4, 2);
  put(extended, 4, 6, 4);
  bytes.insert(bytes.begin() + 58, extended.begin(), extended.end());
  bytes.resize(bytes.size() + 10);
  put(bytes, 0, 2, 2);
  Receiver receiver;
  EXPECT_EQ(events_of(receiver, sealed(bytes)), std::vector{Event::message});
  EXPECT_TRUE(receiver.pose(0).X_TH);
  put(bytes, 58, 100, 2);  // beyond the body
  EXPECT_EQ(events_of(receiver, sealed(bytes)), std::vector{Event::malformed});
  put(bytes, 58, 4, 2);  // too short
  EXPECT_EQ(events_of(receiver, sealed(bytes)), std::vector{Event::malformed});
}

TEST(OpenIgtLink, DamagedMessagesAreDroppedAndTheNextIsRead) {
  const Bytes good = transform("probe", somewhere);
  for (std::size_t at = 50; at < good.size(); ++at) {  // CRC and body
    Bytes bad = good;
    bad[at] ^= 0x10;
    bad.insert(bad.end(), good.begin(), good.end());
    Receiver receiver;
    EXPECT_EQ(events_of(receiver, bad), (std::vector{Event::bad_crc, Event::message})) << at;
  }
  Receiver receiver;
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_EQ(events_of(receiver, sealed(longer)), std::vector{Event::malformed});
  EXPECT_EQ(events_of(receiver, bytes_of(Message("TDATA", "", 0).text("", 69))),
            std::vector{Event::malformed});
  EXPECT_EQ(events_of(receiver, bytes_of(Message("TRANSFORM", "", 0))), std::vector{Event::malformed});
  EXPECT_EQ(events_of(receiver, good), std::vector{Event::message});
}

TEST(OpenIgtLink, OtherBytesAreNoHeader) {
  const Bytes good = transform("probe", somewhere);
  for (const auto& change :
       {std::function([](Bytes& b) { put(b, 0, 0, 2); }),  // version
        std::function([](Bytes& b) { put(b, 0, 4, 2); }), std::function([](Bytes& b) { b[2] = 0; }),  // type
        std::function([](Bytes& b) { b[3] = 0xff; }), std::function([](Bytes& b) { b[14] = 7; }),  // device
        std::function([](Bytes& b) { put(b, 42, 8193, 8); })}) {                                   // length
    Bytes bad = good;
    change(bad);
    Receiver receiver;
    EXPECT_EQ(events_of(receiver, std::span(bad).first(58)), std::vector{Event::no_header});
  }
}

TEST(OpenIgtLink, AbsurdPosesAreNone) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinite = std::numeric_limits<float>::infinity();
  Receiver receiver;
  const auto has_pose = [&](const std::array<float, 12>& numbers) {
    EXPECT_EQ(events_of(receiver, transform_of(numbers)), std::vector{Event::message});
    return receiver.pose(0).X_TH.has_value();
  };
  EXPECT_TRUE(has_pose({1, 0, 0, 0, 1, 0, 0, 0, 1, 9999, 0, 0}));
  EXPECT_FALSE(has_pose({1, 0, 0, 0, 1, 0, 0, 0, 1, 10001, 0, 0}));  // 10 m
  EXPECT_FALSE(has_pose({1, 0, 0, 0, 1, 0, 0, 0, 1, nan, 0, 0}));
  EXPECT_FALSE(has_pose({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, infinite, 0}));
  EXPECT_FALSE(has_pose({nan, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}));
  EXPECT_FALSE(has_pose({2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0}));   // scaled
  EXPECT_FALSE(has_pose({1, 0, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0}));  // mirrored
  EXPECT_FALSE(has_pose({1, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0}));   // sheared
  EXPECT_FALSE(has_pose({}));
}

// ---- tracker ---------------------------------------------------------------------------------------

class OpenIgtLinkTracking : public testing::Test {
 protected:
  OpenIgtLinkTracking() {
    TrackerParams params;
    params.name = "plus";
    params.protocol = TrackerProtocol::openigtlink;
    params.port = "tcp:127.0.0.1:18944";
    for (const char* tool : {"probe", "reference"})
      params.tools.push_back({.body = "tool", .tool = tool, .X_TH = {}});
    MadeTracker made = make_tracker(params, {});
    EXPECT_TRUE(made.errors.empty());
    tracker_ = std::move(made.tracker);
    tracker_->opened(now_);
    EXPECT_EQ(tracker_->next(now_).kind, LineRequest::Kind::send);
    EXPECT_EQ(tracker_->next(now_).kind, LineRequest::Kind::none);
  }
  /// Receives after this time.
  void receive(const Bytes& bytes, Nanoseconds after = 10 * ms) {
    now_ += after;
    tracker_->receive(bytes, now_);
  }
  const TrackerReport& report() const { return tracker_->report(); }
  const ToolSample& tool(std::size_t i = 0) const { return report().tools[i]; }

  std::unique_ptr<Tracker> tracker_;
  Nanoseconds now_ = 5'000 * ms;
};

TEST_F(OpenIgtLinkTracking, ItsRequestIsAWholeMessage) {
  tracker_->opened(now_);
  Receiver receiver;
  EXPECT_EQ(events_of(receiver, tracker_->next(now_).bytes), std::vector{Event::passed});
  EXPECT_STREQ(receiver.header().type.data(), "STT_TDATA");
  EXPECT_EQ(receiver.header().body_size, 36u);
}

TEST_F(OpenIgtLinkTracking, APoseOfAToolIsASample) {
  receive(transform("other", somewhere));
  EXPECT_EQ(report().state, TrackerState::initialising);
  EXPECT_NE(std::string(report().text.data()).find("'other'"), std::string::npos);
  receive(transform("reference", somewhere));
  EXPECT_EQ(report().state, TrackerState::tracking);
  EXPECT_EQ(tool(0).state, ToolState::unseen);
  EXPECT_EQ(tool(1).state, ToolState::valid);
  EXPECT_EQ(tool(1).t_ns, now_);
  EXPECT_LT((tool(1).X_TH.p - somewhere.p).norm(), 1e-7);
  tracker_->expire(now_ + 101 * ms);
  EXPECT_EQ(tool(1).state, ToolState::stale);
}

TEST_F(OpenIgtLinkTracking, RefusedMessagesAreCountedAndChangeNoSample) {
  receive(transform("probe", somewhere, 1'000 * ms));
  const ToolSample before = tool();
  Bytes damaged = transform("probe", {}, 1'010 * ms);
  damaged.back() ^= 1;
  receive(damaged);
  EXPECT_EQ(report().counters.bad_crc, 1u);
  receive(transform("probe", {.p = Vec3(100, 0, 0), .q = Quat::Identity()}, 1'020 * ms));
  EXPECT_EQ(report().counters.malformed, 1u);
  receive(transform("probe", {}, 1'000 * ms));  // repeated
  receive(transform("probe", {}, 990 * ms));    // out of order
  EXPECT_EQ(report().counters.repeated, 2u);
  receive(transform("probe", {}, 1'050 * ms), 200 * ms);  // 190 ms late
  EXPECT_EQ(report().counters.lost_frames, 1u);
  EXPECT_EQ(tool().number, before.number);
  EXPECT_EQ(tool().X_TH.p, before.X_TH.p);
  EXPECT_EQ(report().counters.samples, 1u);
}

TEST_F(OpenIgtLinkTracking, TimesOfTheServerAreMappedToTheHost) {
  constexpr Nanoseconds offset = 1'631'416'514'000 * ms;  // time of day
  for (int i = 0; i < 50; ++i) {
    const Nanoseconds delay = (i * 7 % 5) * ms;  // 0 to 4 ms
    const Nanoseconds measured = 5'000 * ms + 20 * ms * i;
    now_ = measured + delay;
    tracker_->receive(transform("probe", somewhere, measured + offset), now_);
    if (i > 0) {
      EXPECT_NEAR(1e-6 * static_cast<double>(tool().t_ns - measured), 0, 0.1) << i;
    }
  }
  // A server whose clock was set goes on.
  receive(transform("probe", somewhere, offset - 3'600'000 * ms), 20 * ms);
  EXPECT_EQ(tool().t_ns, now_);
}

TEST_F(OpenIgtLinkTracking, AServerWithoutPosesFailsAndIsConnectedAgain) {
  receive(bytes_of(Message("STATUS", "plus", 0).number(1, 2).number(0, 8).text("", 20).text("", 1)));
  EXPECT_NE(std::string(report().text.data()).find("STATUS of 'plus'"), std::string::npos)
      << report().text.data();
  now_ += 10'001 * ms;
  EXPECT_EQ(tracker_->next(now_).kind, LineRequest::Kind::reopen);
  EXPECT_EQ(report().state, TrackerState::failed);
  EXPECT_NE(std::string(report().text.data()).find("STATUS of 'plus'"), std::string::npos)
      << report().text.data();
}

TEST_F(OpenIgtLinkTracking, AnotherProtocolIsNamedAndConnectedAgain) {
  const std::string text = "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain; charset=utf-8\r\n\r\n";
  receive(Bytes(text.begin(), text.end()));
  EXPECT_EQ(report().state, TrackerState::failed);
  EXPECT_EQ(report().counters.malformed, 1u);
  EXPECT_EQ(tracker_->next(now_).kind, LineRequest::Kind::reopen);
  tracker_->opened(now_);
  static_cast<void>(tracker_->next(now_));
  receive(transform("probe", somewhere));
  EXPECT_EQ(report().state, TrackerState::tracking);
}

TEST_F(OpenIgtLinkTracking, AMessageWithoutAnEndIsGivenUp) {
  Bytes image = bytes_of(Message("IMAGE", "ct", 0));
  put(image, 42, 1u << 28, 8);
  receive(image);
  for (int i = 0; i < 490; ++i) receive(transform("probe", somewhere));
  EXPECT_EQ(report().counters.samples, 0u);
  EXPECT_EQ(tracker_->next(now_).kind, LineRequest::Kind::none);
  now_ += 200 * ms;
  EXPECT_EQ(tracker_->next(now_).kind, LineRequest::Kind::reopen);
  EXPECT_EQ(report().counters.malformed, 1u);
}

TEST_F(OpenIgtLinkTracking, NamesOfToolsAreChecked) {
  TrackerParams params = tracker_->params();
  for (const char* name : {"", "a name of more letters"}) {
    params.tools[0].tool = name;
    EXPECT_EQ(make_tracker(params, {}).errors.size(), 1u) << name;
  }
}

}  // namespace
}  // namespace godobject::test_openigtlink
