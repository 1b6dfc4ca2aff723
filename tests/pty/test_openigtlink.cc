// OpenIGTLink on the loopback: with peers of Debian's library in both directions, and with hand-made bytes.
// Tests with the library are skipped where it is missing (libopenigtlink-dev).
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <map>

#include <nlohmann/json.hpp>

#ifdef GODOBJECT_TEST_OPENIGTLINK
#include <igtlClientSocket.h>
#include <igtlMessageHeader.h>
#include <igtlSensorMessage.h>
#include <igtlServerSocket.h>
#include <igtlStatusMessage.h>
#include <igtlTrackingDataMessage.h>
#include <igtlTransformMessage.h>
#include <igtl_unit.h>
#endif

#include "hal/tracker/openigtlink.h"
#include "platform/linux/device_threads.h"
#include "platform/rig/buses.h"
#include "platform/simulated/session.h"
#include "platform/view/live.h"
#include "tests/support/background_program.h"
#include "tests/support/free_port.h"
#include "tests/support/held_run.h"
#include "tests/support/loopback_server.h"
#include "tests/support/program.h"
#include "tests/support/tracker_thread.h"

namespace godobject::test::test_openigtlink_on_loopback {
namespace {

using openigtlink::Message;
using testing::HasSubstr;

bool send_all(int client, std::span<const std::uint8_t> bytes) {
  return send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

std::unique_ptr<TrackerThread> start(const std::string& port) {
  TrackerParams params;
  params.name = "plus";
  params.protocol = TrackerProtocol::openigtlink;
  params.port = port;
  params.tools.push_back({.body = "tool", .tool = "probe", .X_TH = {}});
  return std::make_unique<TrackerThread>(make_tracker(params, {}).tracker);
}

TEST(OpenIgtLinkThread, AServerThatIsGoneIsConnectedAgain) {
  // Each connection brings ten poses, and ends.
  const LoopbackServer server([](int client) {
    for (int i = 0; i < 10; ++i) {
      Message message("TRANSFORM", "probe", 0);
      if (!send_all(client, message.pose({.p = Vec3(0.001 * i, 0, 0), .q = Quat::Identity()}).finish()))
        return;
      usleep(2000);
    }
  });
  const auto thread = start(server.address());
  TrackerReport report;
  EXPECT_TRUE(read_until(*thread, report, [&] { return report.counters.samples >= 20; }))
      << report.text.data();
  EXPECT_GE(server.connections(), 2);
  EXPECT_GE(report.counters.restarts, 1u);
  EXPECT_EQ(report.counters.malformed, 0u);
}

TEST(OpenIgtLinkThread, MalformedBytesAreCountedAndTheConnectionIsMadeAgain) {
  std::atomic<int> number{0};
  const LoopbackServer server([&](int client) {
    const int first = number++;
    if (first == 0) {
      const std::string noise(300, '\xA5');
      send_all(client, std::span(reinterpret_cast<const std::uint8_t*>(noise.data()), noise.size()));
      usleep(100'000);
      return;
    }
    for (int i = 0; i < 300; ++i) {
      Message message("TRANSFORM", "probe", 0);
      const auto bytes = message.pose({.p = Vec3(0.1, 0, 0), .q = Quat::Identity()}).finish();
      std::vector<std::uint8_t> sent(bytes.begin(), bytes.end());
      if (i % 2 == 1) sent[70] ^= 1;  // the CRC is wrong
      if (!send_all(client, sent)) return;
      usleep(2000);
    }
  });
  const auto thread = start(server.address());
  TrackerReport report;
  EXPECT_TRUE(read_until(*thread, report, [&] { return report.state == TrackerState::failed; }));
  EXPECT_THAT(report.text.data(), HasSubstr("sends no OpenIGTLink"));
  EXPECT_EQ(report.counters.malformed, 1u);
  EXPECT_TRUE(read_until(*thread, report, [&] { return report.counters.bad_crc >= 2; }))
      << report.text.data();
  EXPECT_GE(report.counters.samples, 2u);
  EXPECT_NEAR(report.tools[0].X_TH.p.x(), 0.1, 1e-6);
}

TEST(OpenIgtLinkThread, AMissingServerIsNamed) {
  std::string address;
  {
    const LoopbackServer closed([](int) {});
    address = closed.address();
  }
  const auto thread = start(address);
  TrackerReport report;
  EXPECT_TRUE(read_until(*thread, report, [&] { return report.text[0] != '\0'; }));
  EXPECT_EQ(report.state, TrackerState::opening);
  EXPECT_THAT(report.text.data(), HasSubstr(address + ": cannot be connected: Connection refused"));
}

// ---- the server ------------------------------------------------------------------------------------

/// Returns a session on a simulated rig that it takes for a real one, whose clock begins at 0.
std::unique_ptr<Session> session_on_buses() {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml");
  std::vector<std::string> errors;
  const RigProfiles profiles = checked_profiles(*loaded.scene, "", errors);
  SceneConfig scene = *std::move(loaded.scene);
  Motion motion(scene);
  auto link = std::make_unique<SimLink>(sim_rig_config(scene), scene.step, hand_of(motion),
                                        gather_time(scene.step) / gather_polls, profiles);
  return std::move(Session::make(std::move(scene), std::move(motion), std::move(link)).session);
}

/// Appends the times of the complete messages that a client has received.
void receive_times(int client, openigtlink::Receiver& receiver, std::vector<Nanoseconds>& times) {
  std::array<std::uint8_t, 4096> received{};
  const ssize_t size = recv(client, received.data(), received.size(), MSG_DONTWAIT);
  if (size <= 0) return;
  std::span<const std::uint8_t> bytes = std::span(received).first(static_cast<std::size_t>(size));
  while (!bytes.empty())
    if (receiver.push(bytes) != openigtlink::Receiver::Event::more) times.push_back(receiver.header().t);
}

TEST(OpenIgtLinkServer, MessagesHaveTheTimeOfTheirStep) {
  const std::unique_ptr<Session> session = session_on_buses();
  ASSERT_NE(session, nullptr);
  OpenIgtLinkServer::Settings settings{.rate_hz = 200, .wall_origin_ns = 1'700'000'000'000'000'000};
  settings.port = static_cast<std::uint16_t>(free_port());
  std::string why_not;
  const auto server = OpenIgtLinkServer::start(settings, *session, why_not);
  ASSERT_NE(server, nullptr) << why_not;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(settings.port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int client = socket(AF_INET, SOCK_STREAM, 0);
  ASSERT_EQ(connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);

  ASSERT_TRUE(session->boot(usual_boot_limit_s));
  CycleRecord record = session->at_start();
  std::vector<Nanoseconds> steps, times;
  openigtlink::Receiver receiver;
  for (int i = 0; i < 5000 && times.size() < 100; ++i) {
    session->cycle(record);
    steps.push_back(record.t_bus_ns + settings.wall_origin_ns);
    server->tap().offer(*session, record);
    usleep(1000);
    receive_times(client, receiver, times);
  }
  close(client);
  ASSERT_GE(times.size(), 100u);
  EXPECT_GT(times.back(), times.front());
  for (const Nanoseconds t : times) {
    const auto step = std::ranges::lower_bound(steps, t - 1);  // 2^-32 s are rounded
    ASSERT_NE(step, steps.end());
    EXPECT_LE(*step, t + 1);
  }
}

// ---- the library's peers ---------------------------------------------------------------------------

class OpenIgtLinkRun : public ProgramTest {};

#ifdef GODOBJECT_TEST_OPENIGTLINK

/// Sends the pose of the probe, at rest, as the library packs it, until the client is gone.
void serve_probe(int client, bool as_tdata) {
  for (;;) {
    igtl::Matrix4x4 matrix{{0, -1, 0, 50}, {1, 0, 0, 40}, {0, 0, 1, 30}, {0, 0, 0, 1}};  // mm
    igtl::TimeStamp::Pointer now = igtl::TimeStamp::New();
    now->GetTime();
    igtl::MessageBase::Pointer message;
    if (as_tdata) {
      igtl::TrackingDataMessage::Pointer data = igtl::TrackingDataMessage::New();
      igtl::TrackingDataElement::Pointer tool = igtl::TrackingDataElement::New();
      tool->SetName("probe");
      tool->SetType(igtl::TrackingDataElement::TYPE_6D);
      tool->SetMatrix(matrix);
      data->AddTrackingDataElement(tool);
      message = data;
    } else {
      igtl::TransformMessage::Pointer transform = igtl::TransformMessage::New();
      transform->SetMatrix(matrix);
      message = transform;
    }
    message->SetDeviceName("probe");
    message->SetTimeStamp(now);
    message->Pack();
    if (!send_all(client, std::span(static_cast<const std::uint8_t*>(message->GetPackPointer()),
                                    static_cast<std::size_t>(message->GetPackSize()))))
      return;
    usleep(10'000);
  }
}

TEST_F(OpenIgtLinkRun, ARunFollowsItsMessages) {
  for (const bool as_tdata : {false, true}) {
    const LoopbackServer server([&](int client) { serve_probe(client, as_tdata); });
    std::string scene = read_file(GODOBJECT_SOURCE_DIR "/sim/scenes/tracked.toml");
    const auto replace = [&](const std::string& from, const std::string& to) {
      ASSERT_NE(scene.find(from), std::string::npos) << from;
      scene.replace(scene.find(from), from.size(), to);
    };
    replace("\"ndi\"", "\"openigtlink\"");
    replace("\"/dev/serial/by-id/usb-NDI_NDI_Host_USB_Converter-if00-port0\"",
            "\"" + server.address() + "\"");
    replace("tool = \"01\"", "tool = \"probe\"");
    replace("stale_after = 0.1", "stale_after = 1.0");  // a busy machine
    ProgramResult result;
    const nlohmann::json report = run_unless_held(
        write("scene.toml", scene) + " --tracker scene --duration 1.5 --trace " + path("trace.csv"),
        path("report.json"), result);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    ASSERT_TRUE(report.contains("trackers")) << result.output;
    const nlohmann::json& tracker = report["trackers"][0];
    EXPECT_EQ(tracker["state"], "tracking");
    EXPECT_GT(tracker["samples"], 10);
    EXPECT_EQ(tracker["bad_crc"], 0);
    EXPECT_EQ(tracker["malformed"], 0);
    EXPECT_EQ(tracker["tools"][0]["state"], "valid");
    // The camera looks down from 1.5 m; the handle is 0.1 m below the markers along the tracker's -z.
    const std::string trace = read_file(path("trace.csv"));
    const std::string last = trace.substr(trace.rfind('\n', trace.size() - 2) + 1);
    double t = 0, x = 0, y = 0, z = 0;
    ASSERT_EQ(std::sscanf(last.c_str(), "%lf,%lf,%lf,%lf", &t, &x, &y, &z), 4);
    EXPECT_NEAR(x, 0.05, 1e-3);
    EXPECT_NEAR(y, -0.04, 1e-3);
    EXPECT_NEAR(z, 1.5 - 0.03 + 0.1, 1e-3);
  }
}

TEST_F(OpenIgtLinkRun, ItsClientReadsPosesWrenchesAndState) {
  const int port = free_port();
  BackgroundProgram run(
      {"run", "sim/scenes/wall.toml", "--openigtlink", std::to_string(port), "--duration", "60", "--quiet"});
  igtl::ClientSocket::Pointer client = igtl::ClientSocket::New();
  bool is_connected = false;
  for (int i = 0; i < 500 && !is_connected; ++i) {
    is_connected = client->ConnectToServer("127.0.0.1", port) == 0;
    if (!is_connected) usleep(20'000);
  }
  ASSERT_TRUE(is_connected);
  client->SetReceiveTimeout(10'000);
  std::map<std::string, int> seen;
  std::vector<double> times;
  igtlInt64 last_cycle = -1;
  for (int i = 0; i < 400 && seen["STATUS"] < 20; ++i) {
    igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
    header->InitPack();
    ASSERT_EQ(client->Receive(header->GetPackPointer(), header->GetPackSize()), header->GetPackSize());
    ASSERT_TRUE(header->Unpack() & igtl::MessageHeader::UNPACK_HEADER);
    const std::string type = header->GetDeviceType(), device = header->GetDeviceName();
    const auto receive = [&](auto message) {
      message->SetMessageHeader(header);
      message->AllocatePack();
      EXPECT_EQ(client->Receive(message->GetPackBodyPointer(), message->GetPackBodySize()),
                message->GetPackBodySize());
      EXPECT_TRUE(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) << type;  // with its CRC
      return message;
    };
    ++seen[type];
    if (type == "TRANSFORM") {
      EXPECT_EQ(device, "peg");
      igtl::Matrix4x4 matrix;
      receive(igtl::TransformMessage::New())->GetMatrix(matrix);
      EXPECT_LT(std::abs(matrix[0][3]), 1000);  // mm
      EXPECT_NEAR(matrix[0][0] * matrix[0][0] + matrix[1][0] * matrix[1][0] + matrix[2][0] * matrix[2][0], 1,
                  1e-5);
      igtl::TimeStamp::Pointer time = igtl::TimeStamp::New();
      header->GetTimeStamp(time);
      times.push_back(time->GetTimeStamp());
    } else if (type == "TDATA") {
      const igtl::TrackingDataMessage::Pointer data = receive(igtl::TrackingDataMessage::New());
      ASSERT_EQ(data->GetNumberOfTrackingDataElements(), 1);
      igtl::TrackingDataElement::Pointer tool;
      data->GetTrackingDataElement(0, tool);
      EXPECT_STREQ(tool->GetName(), "peg");
    } else if (type == "SENSOR") {
      const igtl::SensorMessage::Pointer sensor = receive(igtl::SensorMessage::New());
      EXPECT_TRUE(device == "peg.force" || device == "peg.torque") << device;
      ASSERT_EQ(sensor->GetLength(), 3u);
      igtl_unit_data unit{};
      unit.unit[0] = IGTL_UNIT_SI_DERIVED_NEWTON;
      unit.exp[0] = 1;
      unit.unit[1] = device == "peg.torque" ? IGTL_UNIT_SI_BASE_METER : IGTL_UNIT_SI_BASE_NONE;
      unit.exp[1] = device == "peg.torque" ? 1 : 0;
      EXPECT_EQ(sensor->GetUnit(), igtl_unit_pack(&unit)) << device;
      for (unsigned k = 0; k < 3; ++k) EXPECT_LT(std::abs(sensor->GetValue(k)), 100);
    } else {
      ASSERT_EQ(type, "STATUS");
      const igtl::StatusMessage::Pointer status = receive(igtl::StatusMessage::New());
      EXPECT_TRUE(status->GetCode() == igtl::StatusMessage::STATUS_OK ||
                  status->GetCode() == igtl::StatusMessage::STATUS_NOT_READY)
          << status->GetCode();
      if (status->GetCode() == igtl::StatusMessage::STATUS_OK) {
        EXPECT_STREQ(status->GetStatusString(), "running");
      }
      EXPECT_GE(status->GetSubCode(), last_cycle);
      last_cycle = status->GetSubCode();
    }
  }
  EXPECT_EQ(seen["STATUS"], 20);
  EXPECT_GE(seen["TRANSFORM"], 20);
  EXPECT_GE(seen["TDATA"], 20);
  EXPECT_GE(seen["SENSOR"], 40);
  EXPECT_GT(last_cycle, 0);
  // The rate is not above 60 Hz; a busy machine has a lower one.
  EXPECT_GT(times.back() - times.front(), 0.9 * static_cast<double>(times.size() - 1) / 60);
  client->CloseSocket();
}

#else

TEST_F(OpenIgtLinkRun, AgainstItsLibrary) { GTEST_SKIP() << "no OpenIGTLink (libopenigtlink-dev)"; }

#endif

TEST_F(OpenIgtLinkRun, OptionsAreChecked) {
  const LoopbackServer taken([](int) { usleep(1000); });
  const std::string port = taken.address().substr(taken.address().rfind(':') + 1);
  for (const auto& [option, expected] :
       {std::pair<std::string, const char*>{"--openigtlink " + port, "end the program that has it"},
        {"--openigtlink 0", "is no TCP port"},
        {"--openigtlink 70000", "is no TCP port"},
        {"--openigtlink host:18944", "is no IPv4 address"},
        {"--openigtlink 18944 --openigtlink-rate 0", "--openigtlink-rate"}}) {
    const ProgramResult result = run_program("run sim/scenes/wall.toml --duration 0.1 --quiet " + option);
    EXPECT_NE(result.exit_code, 0) << option;
    EXPECT_THAT(result.output, HasSubstr(expected)) << option;
  }
  std::string scene = read_file(GODOBJECT_SOURCE_DIR "/sim/scenes/tracked.toml");
  scene.replace(scene.find("\"ndi\""), 5, "\"openigtlink\"");
  const ProgramResult result = run_program("check " + write("scene.toml", scene));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("must be tcp:HOST:PORT for openigtlink"));
}

}  // namespace
}  // namespace godobject::test::test_openigtlink_on_loopback
