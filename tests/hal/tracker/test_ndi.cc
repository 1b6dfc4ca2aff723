#include "hal/tracker/ndi.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "hal/tracker/ndi_reply.h"
#include "tests/support/ndi_stream.h"
#include "tests/support/shared_data.h"

namespace godobject::ndi::test_ndi {
namespace {

using Event = ReplyReceiver::Event;
using Bytes = std::vector<std::uint8_t>;
using test::NdiExchange;

std::string text_of(std::span<const std::uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }
Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

std::uint16_t options_of(const std::string& command) {
  return static_cast<std::uint16_t>(std::stoul(command.substr(3, 4), nullptr, 16));
}

/// Counts over all replies of a stream.
struct Tally {
  int replies = 0, right_crc = 0, tx = 0, bx = 0, poses = 0, missing = 0, not_parsed = 0;
  std::map<std::pair<int, std::uint32_t>, Pose> tx_poses, bx_poses;  // by handle and frame
};

ParseResult parse_poses(Event event, std::span<const std::uint8_t> content, std::uint16_t options,
                        PoseReply& reply) {
  return event == Event::binary ? parse_bx(content, options, reply) : parse_tx(content, options, reply);
}

Tally tally(const std::vector<NdiExchange>& stream) {
  Tally t;
  for (const NdiExchange& exchange : stream) {
    if (exchange.reply.empty()) continue;
    ReplyReceiver receiver;
    Event event = Event::more;
    for (const std::uint8_t byte : exchange.reply) {
      EXPECT_EQ(event, Event::more) << exchange.command;
      event = receiver.push(byte);
    }
    ++t.replies;
    if (event == Event::text || event == Event::binary) ++t.right_crc;
    const bool tx = exchange.command.starts_with("TX:"), bx = exchange.command.starts_with("BX:");
    if (!tx && !bx) continue;
    EXPECT_EQ(event, bx ? Event::binary : Event::text) << exchange.command;
    ++(bx ? t.bx : t.tx);
    PoseReply reply;
    if (parse_poses(event, receiver.content(), options_of(exchange.command), reply) != ParseResult::ok) {
      ++t.not_parsed;
      ADD_FAILURE() << exchange.command << " " << text_of(exchange.reply);
      continue;
    }
    if ((options_of(exchange.command) & option::transforms) == 0) continue;
    for (const HandlePose& pose : reply.all()) {
      if (pose.status == HandleStatus::missing) ++t.missing;
      if (pose.status != HandleStatus::valid) continue;
      ++t.poses;
      (bx ? t.bx_poses : t.tx_poses)[{pose.handle, pose.frame}] = pose.X_TH;
    }
  }
  return t;
}

const std::filesystem::path streams = "data/ndi/streams";

TEST(NdiCommand, GoldenVectors) {
  EXPECT_EQ(text_of(make_command("INIT", "").bytes()), "INIT:E3A5\r");
  EXPECT_EQ(text_of(make_command("COMM", "50000").bytes()), "COMM:500000048\r");
  EXPECT_EQ(text_of(make_command("TSTART", "80").bytes()), "TSTART:801B0B\r");
  EXPECT_EQ(text_of(make_handle_command("PINIT", 0x01).bytes()), "PINIT:0131EA\r");
  EXPECT_EQ(text_of(make_handle_command("PENA", 0x01, "D").bytes()), "PENA:01D6D3B\r");
  EXPECT_EQ(text_of(make_command("PHRQ", "**********0A**").bytes()), "PHRQ:**********0A**62D3\r");
  EXPECT_EQ(make_command("PVWR", std::string(200, '0')).size, 0u) << "too long";
}

TEST(NdiCommand, ToolDefinitionAsRecorded) {
  const auto path = test::shared_file(streams / "polaris_stream_08_31_2005_NDICommandInterpreter.txt");
  if (path.empty()) GTEST_SKIP() << "no recorded NDI streams";
  // Rebuilds the uploaded file from the commands, then the commands from the file.
  Bytes file;
  std::vector<std::string> recorded;
  for (const NdiExchange& exchange : test::read_counted_stream(path, true)) {
    if (!exchange.command.starts_with("PVWR:01")) continue;
    recorded.push_back(exchange.command + "\r");
    for (std::size_t i = 0; i < block_size; ++i)
      file.push_back(
          static_cast<std::uint8_t>(std::stoul(exchange.command.substr(11 + 2 * i, 2), nullptr, 16)));
  }
  ASSERT_GE(recorded.size(), 10u);
  while (file.back() == 0) file.pop_back();
  for (std::size_t block = 0; block < recorded.size(); ++block)
    EXPECT_EQ(text_of(make_write_command(0x01, block * block_size, file).bytes()), recorded[block]);
}

TEST(NdiReply, Kinds) {
  EXPECT_EQ(classify(bytes_of("OKAY")).kind, ReplyKind::okay);
  EXPECT_EQ(classify(bytes_of("RESET")).kind, ReplyKind::reset);
  EXPECT_EQ(classify(bytes_of("ERROR0D")).kind, ReplyKind::error);
  EXPECT_EQ(classify(bytes_of("ERROR0D")).code, 0x0D);
  EXPECT_EQ(classify(bytes_of("WARNING02")).code, 0x02);
  EXPECT_EQ(classify(bytes_of("ERROR")).kind, ReplyKind::data);
  EXPECT_EQ(classify(bytes_of("ERRORxx")).kind, ReplyKind::data);
  EXPECT_EQ(classify({}).kind, ReplyKind::data);
  for (int code = 0; code < 256; ++code) {
    EXPECT_GT(std::string_view(error_text(static_cast<std::uint8_t>(code))).size(), 5u);
    EXPECT_GT(std::string_view(warning_text(static_cast<std::uint8_t>(code))).size(), 5u);
  }
}

TEST(NdiReply, PolarisRecording) {
  const auto path = test::shared_file(streams / "polaris_stream_03_31_2005_1.txt");
  if (path.empty()) GTEST_SKIP() << "no recorded NDI streams";
  const Tally t = tally(test::read_tagged_stream(path));
  EXPECT_EQ(t.replies, 1019);
  EXPECT_EQ(t.right_crc, 1019);
  EXPECT_EQ(t.poses, 762);
  EXPECT_EQ(t.missing, 238);
}

TEST(NdiReply, AuroraRecording) {
  const auto path = test::shared_file(streams / "aurora_stream_03_30_2005_2.txt");
  if (path.empty()) GTEST_SKIP() << "no recorded NDI streams";
  const Tally t = tally(test::read_tagged_stream(path));
  EXPECT_EQ(t.replies, 1018);
  EXPECT_EQ(t.right_crc, 1018);
  EXPECT_EQ(t.poses, 780);
  EXPECT_EQ(t.missing, 220);
  EXPECT_EQ(t.poses - static_cast<int>(t.tx_poses.size()), 390) << "the host polls faster than it measures";
}

TEST(NdiReply, BinaryAndTextOfOneRecording) {
  const auto binary = test::shared_file(streams / "polaris_stream_08_31_2005_NDICommandInterpreter.bin");
  const auto text = test::shared_file(streams / "polaris_stream_08_31_2005_NDICommandInterpreter.txt");
  if (binary.empty() || text.empty()) GTEST_SKIP() << "no recorded NDI streams";
  const Tally b = tally(test::read_counted_stream(binary, false));
  EXPECT_EQ(b.bx, 151);
  EXPECT_EQ(b.tx, 151);
  EXPECT_EQ(b.right_crc, b.replies);
  EXPECT_EQ(b.not_parsed, 0);
  const Tally t = tally(test::read_counted_stream(text, true));
  EXPECT_EQ(t.replies - t.bx, 200) << "text replies of the twin";
  EXPECT_EQ(t.right_crc, t.replies);
  EXPECT_EQ(t.bx_poses.size(), b.bx_poses.size());
  // No frame was requested in both formats. The tool moves slowly, so TX continues where BX ends.
  const auto& [last_key, last] = *b.bx_poses.rbegin();
  const auto& [next_key, next] = *b.tx_poses.begin();
  EXPECT_EQ(last_key.first, next_key.first);
  EXPECT_EQ(next_key.second - last_key.second, 3u) << "60 Hz frames, polled at 20 Hz";
  EXPECT_LT((next.p - last.p).norm(), 5e-3);
  EXPECT_LT(next.q.angularDistance(last.q), 0.1);
}

/// Checks the results of a corrupted reply, up to its end or a silence.
void expect_no_wrong_pose(const Bytes& reply, std::uint16_t options, const PoseReply& right, int& errors) {
  ReplyReceiver receiver;
  bool whole = false;
  for (const std::uint8_t byte : reply) {
    const Event event = receiver.push(byte);
    if (event != Event::text && event != Event::binary) continue;
    PoseReply parsed;
    if (parse_poses(event, receiver.content(), options, parsed) != ParseResult::ok) continue;
    whole = true;
    ASSERT_EQ(parsed.num_handles, right.num_handles);
    for (std::size_t i = 0; i < parsed.num_handles; ++i) {
      ASSERT_EQ(parsed.handles[i].status, right.handles[i].status);
      ASSERT_EQ(parsed.handles[i].X_TH.p, right.handles[i].X_TH.p);
      ASSERT_EQ(parsed.handles[i].X_TH.q.coeffs(), right.handles[i].X_TH.q.coeffs());
    }
  }
  if (!whole) ++errors;
}

/// Reply to BX2 that another author has written: the stub of a Vega in ArtiSynth
/// (hamidreza-aftabi/artisynth_istar, commit 8c1362c, src/artisynth/istar/NDI/NDIStubServer.java). It has a
/// frame with a tool and its four markers, of a sample of 30 June 2016.
constexpr std::string_view bx2_of_artisynth =
    "c4a5a40057d3010001000100a000000000000100000002000000bf052e38cb74755712a2d92a01000200020030000000"
    "00000100000001000020c9ffb43ecfbcacbec91e41be62125a3fdd243dc3675552c2f678d4c4213d093f030050000000"
    "0000010000000100040000000000cf1756c3c80797c1a4f8d6c400000100aec72ec3d3ded0c1d7c3d0c40000020029fc"
    "47c3beffb1c27bfcd7c4000003004cb727c35bb198c2e12ad2c4969d";

TEST(NdiReply, Bx2OfAnotherAuthor) {
  ReplyReceiver receiver;
  Event event = Event::more;
  for (std::size_t i = 0; i < bx2_of_artisynth.size(); i += 2) {
    ASSERT_EQ(event, Event::more) << i;
    event = receiver.push(
        static_cast<std::uint8_t>(std::stoul(std::string(bx2_of_artisynth.substr(i, 2)), nullptr, 16)));
  }
  ASSERT_EQ(event, Event::binary) << "with its two CRCs";
  PoseReply reply;
  ASSERT_EQ(parse_bx2(receiver.content(), reply), ParseResult::ok);
  EXPECT_EQ(reply.t_ns, 1'467'315'403'718'905'874);  // 0x577574CB s, 0x2AD9A212 ns
  ASSERT_EQ(reply.num_handles, 1u);
  const HandlePose& pose = reply.handles[0];
  EXPECT_EQ(pose.handle, 1);
  EXPECT_EQ(pose.status, HandleStatus::valid);
  EXPECT_EQ(pose.frame, 0x382E05BFu);
  EXPECT_LT((pose.X_TH.p - Vec3(-0.189144, -0.0525834, -1.69978)).norm(), 1e-7);
  EXPECT_LT((pose.X_TH.q.coeffs() - Quat(0.353514, -0.337378, -0.188594, 0.851843).coeffs()).norm(), 1e-6);
  EXPECT_NEAR(pose.error_m, 0.536089e-3, 1e-9);
}

TEST(NdiReply, ACorruptedRecordingGivesErrorsAndNoWrongPose) {
  const auto path = test::shared_file(streams / "polaris_stream_08_31_2005_NDICommandInterpreter.bin");
  if (path.empty()) GTEST_SKIP() << "no recorded NDI streams";
  int corrupted = 0, errors = 0;
  int nth = 0;
  for (const NdiExchange& exchange : test::read_counted_stream(path, false)) {
    const bool tx = exchange.command.starts_with("TX:");
    if ((!tx && !exchange.command.starts_with("BX:")) || ++nth % 10 != 0) continue;
    const std::uint16_t options = options_of(exchange.command);
    ReplyReceiver receiver;
    Event event = Event::more;
    for (const std::uint8_t byte : exchange.reply) event = receiver.push(byte);
    PoseReply right;
    ASSERT_EQ(parse_poses(event, receiver.content(), options, right), ParseResult::ok);
    for (std::size_t at = 0; at < exchange.reply.size(); ++at) {
      for (const int flip : {0x01, 0x02, 0x04, 0x08, 0x10, 0x20, 0x40, 0x80, 0xFF, 0x55}) {
        Bytes reply = exchange.reply;
        reply[at] = static_cast<std::uint8_t>(reply[at] ^ flip);
        expect_no_wrong_pose(reply, options, right, errors);
        ++corrupted;
      }
      Bytes lost = exchange.reply;
      lost.erase(lost.begin() + static_cast<std::ptrdiff_t>(at));
      expect_no_wrong_pose(lost, options, right, errors);
      ++corrupted;
    }
  }
  EXPECT_GT(corrupted, 10'000);
  EXPECT_EQ(errors, corrupted);
}

TEST(NdiReply, DisabledHandlesEndEarly) {
  PoseReply reply;
  ASSERT_EQ(parse_tx(bytes_of("0201DISABLED\n0AUNOCCUPIED\n0000"), option::transforms, reply),
            ParseResult::ok);
  ASSERT_EQ(reply.num_handles, 2u);
  EXPECT_EQ(reply.handles[0].status, HandleStatus::disabled);
  EXPECT_EQ(reply.handles[1].handle, 0x0A);
  const Bytes body{0x02, 0x01, 0x04, 0x02, 0x02, 0x31, 0, 0, 0, 0x07, 0, 0, 0, 0x10, 0x00};
  ASSERT_EQ(parse_bx(body, option::transforms, reply), ParseResult::ok);
  EXPECT_EQ(reply.handles[0].status, HandleStatus::disabled);
  EXPECT_EQ(reply.handles[1].status, HandleStatus::missing);
  EXPECT_EQ(reply.handles[1].frame, 7u);
  EXPECT_NE(system_status_text(reply.system_status), nullptr);
}

TEST(NdiReply, PoseThatIsNone) {
  // Valid by its status, but not a rotation; then far away.
  const std::string rest = "+015650000003100000001\n0000";
  PoseReply reply;
  EXPECT_EQ(parse_tx(bytes_of("0101+00000+00000+00000+00000+011455+002063-073118" + rest), option::transforms,
                     reply),
            ParseResult::bad_value);
  EXPECT_EQ(parse_tx(bytes_of("0101+10000+00000+00000+00000+011455+0020x3-073118" + rest), option::transforms,
                     reply),
            ParseResult::bad_value);
}

TEST(NdiReply, NoPoseOfANumberThatIsNone) {
  for (int none = -1; none < 8; ++none) {  // of q_0, q_x, q_y, q_z, t_x, t_y, t_z, error
    Bytes body{0x01, 0x01, 0x01};
    for (int i = 0; i < 8; ++i) {
      const float value = i == none ? std::numeric_limits<float>::quiet_NaN() : i == 0 ? 1.0f : 0.0f;
      const auto bits = std::bit_cast<std::uint32_t>(value);
      for (unsigned shift = 0; shift < 32; shift += 8)
        body.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
    body.insert(body.end(), {0x31, 0, 0, 0, 0x07, 0, 0, 0, 0x10, 0x00});
    PoseReply reply;
    EXPECT_EQ(parse_bx(body, option::transforms, reply), none < 0 ? ParseResult::ok : ParseResult::bad_value)
        << none;
  }
}

TEST(NdiReply, PortHandlesAndPlate) {
  PortHandles handles;
  ASSERT_EQ(parse_phsr(bytes_of("0201001020 1F"), handles), ParseResult::bad_value);
  ASSERT_EQ(parse_phsr(bytes_of("02010010201F"), handles), ParseResult::ok);
  ASSERT_EQ(handles.size, 2u);
  EXPECT_EQ(handles.handles[1].handle, 0x02);
  EXPECT_EQ(handles.handles[1].status, 0x01F);
  EXPECT_EQ(parse_phsr(bytes_of("FF"), handles), ParseResult::too_long);
  ToolPlate plate;
  ASSERT_EQ(parse_phinf(bytes_of("01000001Traxtal Tech0013211140231"), plate), ParseResult::ok);
  EXPECT_STREQ(plate.manufacturer.data(), "Traxtal Tech");
  EXPECT_STREQ(plate.serial.data(), "32111402");
  EXPECT_EQ(plate.port_bits, 0x31);
  EXPECT_EQ(parse_phinf(bytes_of("01000001Traxtal"), plate), ParseResult::too_short);
}

TEST(NdiReply, AnyBytesAreSurvived) {
  std::mt19937 random(3);
  const std::string_view alphabet = "0123456789ABCDEF+-MISSING\n\r\xC4\xA5";
  ReplyReceiver receiver;
  PoseReply reply;
  PortHandles handles;
  ToolPlate plate;
  Bytes noise(600);
  for (int i = 0; i < 3000; ++i) {
    for (std::uint8_t& byte : noise) {
      byte = static_cast<std::uint8_t>(
          i % 2 == 0 ? random() : static_cast<unsigned>(alphabet[random() % alphabet.size()]));
      if (receiver.push(byte) != Event::more) static_cast<void>(classify(receiver.content()));
    }
    const std::span<const std::uint8_t> some = std::span(noise).first(random() % noise.size());
    noise[0] = i % 4 < 2 ? noise[0] : '0';
    const auto options = static_cast<std::uint16_t>(random());
    static_cast<void>(parse_tx(some, options, reply));
    static_cast<void>(parse_bx(some, options, reply));
    static_cast<void>(parse_phsr(some, handles));
    static_cast<void>(parse_phinf(some, plate));
    static_cast<void>(classify(some));
    ASSERT_LE(reply.num_handles, max_handles);
    ASSERT_LE(handles.size, max_handles);
  }
}

}  // namespace
}  // namespace godobject::ndi::test_ndi
