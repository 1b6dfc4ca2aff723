// The object dictionaries of the simulated nodes, read and written by SDO on the wire, and their effect.
#include "sim/node/canopen/object_dictionary.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "hal/canopen/sdo/client.h"
#include "sim/node/drive.h"
#include "sim/node/encoder.h"

namespace godobject::test_object_dictionary {
namespace {

using canopen::NmtCommand;
using canopen::ObjectAddress;
using canopen::ObjectType;
using sdo::AbortCode;
using sdo::TransferState;

constexpr Nanoseconds ms = 1'000'000;
constexpr std::uint8_t drive_id = 5, encoder_id = 6;
constexpr std::int64_t off = 0x80000000;

struct Network : ::testing::Test {
  Network() {
    EXPECT_TRUE(host.open() && drive_port.open() && encoder_port.open());
    run_to(2 * ms);
    log.clear();
  }

  void run_to(Nanoseconds t) {
    while (wire.now() < t) {
      advance(wire, nodes, std::min(t, wire.now() + ms));
      for (ReceivedFrame received; host.try_receive(received);) {
        if (client) client->on_frame(received.frame);
        log.push_back(received.frame);
      }
    }
  }
  void run_for(Nanoseconds duration) { run_to(wire.now() + duration); }
  void send(const CanFrame& frame) { ASSERT_EQ(host.try_send(frame), SendResult::queued); }
  void start() {
    send(canopen::make_nmt(NmtCommand::start, 0));
    run_for(ms);
    log.clear();
  }
  int count(std::uint32_t id) const { return static_cast<int>(std::ranges::count(log, id, &CanFrame::id)); }
  /// Returns the bytes of the newest frame with this identifier.
  std::string bytes(std::uint32_t id) const {
    std::string text;
    for (const CanFrame& frame : log)
      if (frame.id == id) text.assign(frame.bytes().begin(), frame.bytes().end());
    return text;
  }

  void finish() {
    for (int i = 0; i < 100 && client->busy(); ++i) {
      client->poll(wire.now(), host);
      run_for(ms);
    }
    EXPECT_FALSE(client->busy());
  }
  AbortCode write(std::uint8_t node, ObjectAddress address, ObjectType type, std::int64_t value) {
    std::array<std::uint8_t, 4> data{};
    const auto used = std::span(data).first(canopen::size_of(type));
    canopen::encode_number(value, used);
    client.emplace(node);
    EXPECT_TRUE(client->write(address, used));
    finish();
    return client->abort_code();
  }
  std::int64_t read(std::uint8_t node, ObjectAddress address, bool negative = false) {
    client.emplace(node);
    EXPECT_TRUE(client->read(address));
    finish();
    EXPECT_EQ(client->state(), TransferState::done);
    return canopen::decode_number(client->data(), negative);
  }
  AbortCode read_error(std::uint8_t node, ObjectAddress address) {
    client.emplace(node);
    EXPECT_TRUE(client->read(address));
    finish();
    return client->abort_code();
  }

  SimCanWire wire{{}};
  SimCanPort host{wire}, drive_port{wire}, encoder_port{wire};
  SimDrive drive{drive_port, {.drive = {.joint = "j", .node_id = drive_id}}};
  SimEncoder encoder{encoder_port, encoder_id, {.counts_per_unit = 1000, .modulus_counts = 4096}, 0};
  SimCanopenNode* nodes[2] = {&drive, &encoder};
  std::optional<sdo::Client> client;
  std::vector<CanFrame> log;
};

TEST_F(Network, DeviceTypesAndIdentity) {
  EXPECT_EQ(read(drive_id, {0x1000, 0}) & 0xFFFF, 402);
  EXPECT_EQ(read(encoder_id, {0x1000, 0}) & 0xFFFF, 406);
  EXPECT_EQ(read(drive_id, {0x1018, 1}), sim_drive_identity.vendor);
  EXPECT_EQ(read(drive_id, {0x6076, 0}), 100) << "0.1 N m in mN m";
  EXPECT_EQ(read(drive_id, {0x6061, 0}, true), 10);
}

TEST_F(Network, NameComesInSegments) {
  client.emplace(encoder_id);
  ASSERT_TRUE(client->read({0x1008, 0}));
  finish();
  EXPECT_EQ(std::string(client->data().begin(), client->data().end()), "simulated CiA 406 encoder");
}

TEST_F(Network, RejectionsOfCiA301) {
  EXPECT_EQ(read_error(drive_id, {0x2000, 0}), AbortCode::no_object);
  EXPECT_EQ(read_error(drive_id, {0x1018, 9}), AbortCode::no_sub_index);
  EXPECT_EQ(write(drive_id, {0x1000, 0}, ObjectType::u32, 1), AbortCode::read_only);
  EXPECT_EQ(write(drive_id, {0x1017, 0}, ObjectType::u8, 1), AbortCode::too_short);
  EXPECT_EQ(write(drive_id, {0x1017, 0}, ObjectType::u32, 1), AbortCode::too_long);
  EXPECT_EQ(write(drive_id, {0x6007, 0}, ObjectType::i16, 4), AbortCode::value_too_high);
  EXPECT_EQ(write(drive_id, {0x6007, 0}, ObjectType::i16, -1), AbortCode::value_too_low);
  EXPECT_EQ(write(drive_id, {0x6060, 0}, ObjectType::i8, 1), AbortCode::invalid_value);
}

TEST_F(Network, SegmentedDownloadIsCheckedByItsObject) {
  client.emplace(drive_id);
  const std::array<std::uint8_t, 9> nine{};
  ASSERT_TRUE(client->write({0x1017, 0}, nine));
  finish();
  EXPECT_EQ(client->abort_code(), AbortCode::too_long);
}

TEST_F(Network, BlockTransferIsUnknown) {
  send(sdo::make_frame(sdo::request_cob_id(drive_id), {0xA0, 0x08, 0x10, 0, 20}));
  run_for(ms);
  ASSERT_EQ(log.size(), 1u);
  sdo::Message answer;
  ASSERT_EQ(sdo::parse_frame(log[0], sdo::response_cob_id(drive_id), answer), ParseResult::ok);
  EXPECT_EQ(sdo::abort_code_of(answer), AbortCode::unknown_command);
}

// Random requests in any order: no access out of bounds (checked by the sanitizers), and the node keeps
// working.
TEST_F(Network, SurvivesAnyRequest) {
  std::uint32_t random = 1;
  const auto next = [&random] { return (random = random * 1664525u + 1013904223u) >> 16; };
  for (int i = 0; i < 50000; ++i) {
    CanFrame frame{.id = i % 8 == 0 ? lss::request_cob_id : sdo::request_cob_id(drive_id), .size = 8};
    for (std::uint8_t& byte : std::span(frame.data).first(8)) byte = static_cast<std::uint8_t>(next());
    if (i % 2 == 0) {  // existing objects
      frame.data[2] = static_cast<std::uint8_t>(i % 4 == 0 ? 0x10 : 0x1A);
      frame.data[1] = static_cast<std::uint8_t>(next() % 32);
      frame.data[3] = static_cast<std::uint8_t>(next() % 9);
    }
    drive.on_frame(frame, wire.now());
  }
  run_for(ms);
  send(canopen::make_nmt(NmtCommand::reset_node, 0));
  run_for(5 * ms);
  EXPECT_EQ(drive.nmt_state(), canopen::NmtState::pre_operational);
  EXPECT_EQ(read(drive.node_id(), {0x1000, 0}) & 0xFFFF, 402);
}

TEST_F(Network, StoppedNodeDoesNotAnswer) {
  send(canopen::make_nmt(NmtCommand::stop, drive_id));
  run_for(ms);
  send(sdo::make_frame(sdo::request_cob_id(drive_id),
                       sdo::make_plain(sdo::Request::initiate_upload, ObjectAddress{0x1000, 0})));
  run_for(ms);
  EXPECT_EQ(log.size(), 0u);
}

TEST_F(Network, MappingChangesOnlyWhileThePdoIsOffAndEmpty) {
  const ObjectAddress cob_id{0x1800, 1}, count{0x1A00, 0}, first{0x1A00, 1};
  EXPECT_EQ(write(drive_id, count, ObjectType::u8, 0), AbortCode::unsupported_access) << "it is on";
  EXPECT_EQ(write(drive_id, cob_id, ObjectType::u32, 0x1FF), AbortCode::invalid_value)
      << "another identifier while it is on";
  ASSERT_EQ(write(drive_id, cob_id, ObjectType::u32, off | 0x185), AbortCode::none);
  EXPECT_EQ(write(drive_id, first, ObjectType::u32, 0x60410010), AbortCode::unsupported_access)
      << "the count is not 0";
  ASSERT_EQ(write(drive_id, count, ObjectType::u8, 0), AbortCode::none);
  EXPECT_EQ(write(drive_id, cob_id, ObjectType::u32, 0x185), AbortCode::invalid_value) << "it is empty";
  EXPECT_EQ(write(drive_id, first, ObjectType::u32, 0x20000010), AbortCode::no_object);
  EXPECT_EQ(write(drive_id, first, ObjectType::u32, 0x60760020), AbortCode::not_mappable);
  EXPECT_EQ(write(drive_id, first, ObjectType::u32, 0x60640010), AbortCode::not_mappable) << "wrong length";
  for (std::uint8_t sub = 1; sub <= 3; ++sub)
    ASSERT_EQ(write(drive_id, {0x1A00, sub}, ObjectType::u32, 0x60640020), AbortCode::none);
  EXPECT_EQ(write(drive_id, count, ObjectType::u8, 3), AbortCode::pdo_length_exceeded);
  EXPECT_EQ(write(drive_id, count, ObjectType::u8, 9), AbortCode::pdo_length_exceeded);
  EXPECT_EQ(write(drive_id, {0x1800, 2}, ObjectType::u8, 250), AbortCode::invalid_value);
  EXPECT_EQ(write(drive_id, {0x1600, 0}, ObjectType::u8, 0), AbortCode::unsupported_access);
}

TEST_F(Network, DriveSendsMappedObjectsOnRequest) {
  ASSERT_EQ(write(drive_id, {0x1800, 1}, ObjectType::u32, off | 0x185), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1A00, 0}, ObjectType::u8, 0), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1A00, 1}, ObjectType::u32, 0x60610008), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1A00, 2}, ObjectType::u32, 0x60410010), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1A00, 0}, ObjectType::u8, 2), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1800, 2}, ObjectType::u8, 3), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1800, 1}, ObjectType::u32, 0x1C5), AbortCode::none);
  start();
  for (int i = 0; i < 6; ++i) {
    send(canopen::make_sync());
    run_for(ms);
  }
  EXPECT_EQ(count(0x185), 0);
  EXPECT_EQ(count(0x1C5), 2) << "every third SYNC";
  EXPECT_EQ(bytes(0x1C5), std::string("\x0A\x50\x02", 3)) << "mode 10, Switch On Disabled";
}

TEST_F(Network, CommandsComeByTheMappingOfTheRpdo) {
  ASSERT_EQ(write(drive_id, {0x1400, 1}, ObjectType::u32, off | 0x205), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1600, 0}, ObjectType::u8, 0), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1600, 1}, ObjectType::u32, 0x60710010), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1600, 2}, ObjectType::u32, 0x60400010), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1600, 0}, ObjectType::u8, 2), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1400, 2}, ObjectType::u8, 255), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1400, 1}, ObjectType::u32, 0x205), AbortCode::none);
  start();
  for (const unsigned controlword : {0x06u, 0x07u, 0x0Fu}) {
    CanFrame command{.id = 0x205, .size = 4};
    command.data = {0x64, 0x00, static_cast<std::uint8_t>(controlword), 0x00};
    send(command);
    run_for(ms);
  }
  EXPECT_EQ(drive.drive_state(), cia402::DriveState::operation_enabled) << "at once: no SYNC was sent";
  EXPECT_NEAR(drive.applied_torque_Nm(), 0.01, 1e-12);
}

TEST_F(Network, HeartbeatAndEventTimerAreObeyed) {
  ASSERT_EQ(write(encoder_id, {0x1017, 0}, ObjectType::u16, 10), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1801, 5}, ObjectType::u16, 50), AbortCode::none);
  start();
  run_for(100 * ms);
  EXPECT_EQ(count(0x706), 10);
  EXPECT_EQ(count(0x285), 2);
  ASSERT_EQ(write(encoder_id, {0x1017, 0}, ObjectType::u16, 0), AbortCode::none);
  log.clear();
  run_for(100 * ms);
  EXPECT_EQ(count(0x706), 0);
}

TEST_F(Network, ResetCommunicationBringsTheCommunicationBack) {
  ASSERT_EQ(write(encoder_id, {0x1017, 0}, ObjectType::u16, 10), AbortCode::none);
  ASSERT_EQ(write(encoder_id, {0x1800, 1}, ObjectType::u32, off | 0x186), AbortCode::none);
  ASSERT_EQ(write(encoder_id, {0x6000, 0}, ObjectType::u16, 1), AbortCode::none);
  send(canopen::make_nmt(NmtCommand::reset_communication, encoder_id));
  run_for(2 * ms);
  EXPECT_EQ(read(encoder_id, {0x1017, 0}), 0);
  EXPECT_EQ(read(encoder_id, {0x1800, 1}), 0x186);
  EXPECT_EQ(read(encoder_id, {0x6000, 0}), 1);
  send(canopen::make_nmt(NmtCommand::reset_node, encoder_id));
  run_for(2 * ms);
  EXPECT_EQ(read(encoder_id, {0x6000, 0}), 0);
}

// The consumer starts with the first heartbeat it receives; 6007h selects the reaction.
TEST_F(Network, DriveReactsToALostHost) {
  ASSERT_EQ(write(drive_id, {0x1016, 1}, ObjectType::u32, 127 << 16 | 30), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x6007, 0}, ObjectType::i16, 2), AbortCode::none);
  ASSERT_EQ(write(drive_id, {0x1400, 5}, ObjectType::u16, 0), AbortCode::none);
  start();
  for (const std::uint16_t controlword : {cia402::shutdown, cia402::switch_on, cia402::enable_operation}) {
    send(cia402::make_command(drive_id, {.controlword = controlword}));
    send(canopen::make_sync());
    run_for(ms);
    send(canopen::make_sync());
    run_for(ms);
  }
  ASSERT_EQ(drive.drive_state(), cia402::DriveState::operation_enabled);
  run_for(100 * ms);
  EXPECT_EQ(drive.drive_state(), cia402::DriveState::operation_enabled) << "no heartbeat has been heard";
  send(canopen::make_heartbeat(127, canopen::NmtState::operational));
  run_for(25 * ms);
  EXPECT_EQ(drive.drive_state(), cia402::DriveState::operation_enabled);
  run_for(10 * ms);
  EXPECT_EQ(drive.drive_state(), cia402::DriveState::switch_on_disabled);
}

TEST_F(Network, PresetBecomesThePosition) {
  encoder.set_position(0.25, 2.0);
  EXPECT_EQ(read(encoder_id, {0x6004, 0}), 250);
  EXPECT_EQ(read(encoder_id, {0x6030, 1}, true), 2000);
  ASSERT_EQ(write(encoder_id, {0x6003, 0}, ObjectType::u32, 4000), AbortCode::none);
  EXPECT_EQ(read(encoder_id, {0x6004, 0}), 4000);
  EXPECT_EQ(read(encoder_id, {0x6509, 0}, true), 3750);
  encoder.set_position(0.35);
  EXPECT_EQ(read(encoder_id, {0x6004, 0}), 4) << "wraps at 4096";
  EXPECT_EQ(write(encoder_id, {0x6003, 0}, ObjectType::u32, 4096), AbortCode::value_too_high);
}

struct LssNetwork : Network {
  lss::Outcome run_lss() {
    for (int i = 0; i < 50 && master.outcome() == lss::Outcome::busy; ++i) {
      master.poll(wire.now(), host);
      run_for(ms);
      for (const CanFrame& frame : log) master.on_frame(frame);
      log.clear();
    }
    return master.outcome();
  }
  lss::Master master{20 * ms};
};

TEST_F(LssNetwork, NodeIdOfASelectedNode) {
  ASSERT_TRUE(master.set_node_id(40));
  EXPECT_EQ(run_lss(), lss::Outcome::no_answer) << "nobody is in configuration mode";
  ASSERT_TRUE(master.select(sim_encoder_identity));
  ASSERT_EQ(run_lss(), lss::Outcome::done);
  ASSERT_TRUE(master.set_node_id(0));
  EXPECT_EQ(run_lss(), lss::Outcome::rejected);
  ASSERT_TRUE(master.set_node_id(40));
  ASSERT_EQ(run_lss(), lss::Outcome::done);
  ASSERT_TRUE(master.switch_global(lss::Mode::waiting));
  ASSERT_EQ(run_lss(), lss::Outcome::done);
  EXPECT_EQ(encoder.node_id(), encoder_id) << "until the communication is reset";
  send(canopen::make_nmt(NmtCommand::reset_communication, 0));
  run_for(2 * ms);
  EXPECT_EQ(count(0x728), 1) << "boot-up of node 40";
  EXPECT_EQ(drive.node_id(), drive_id);
  EXPECT_EQ(read(40, {0x1800, 1}), 0x1A8) << "its identifiers follow";
  encoder.power_cycle(wire.now());
  run_for(2 * ms);
  EXPECT_EQ(encoder.node_id(), encoder_id) << "it was not stored";
}

TEST_F(LssNetwork, StoredSettingsOutliveThePower) {
  ASSERT_TRUE(master.select(sim_encoder_identity));
  ASSERT_EQ(run_lss(), lss::Outcome::done);
  ASSERT_TRUE(master.set_node_id(41));
  ASSERT_EQ(run_lss(), lss::Outcome::done);
  ASSERT_TRUE(master.set_bit_timing(5));
  EXPECT_EQ(run_lss(), lss::Outcome::rejected);
  ASSERT_TRUE(master.set_bit_timing(2));
  ASSERT_EQ(run_lss(), lss::Outcome::done);
  ASSERT_TRUE(master.store());
  ASSERT_EQ(run_lss(), lss::Outcome::done);
  encoder.power_cycle(wire.now());
  run_for(2 * ms);
  EXPECT_EQ(encoder.node_id(), 41);
  EXPECT_EQ(encoder.lss().bit_timing(), 2);
}

}  // namespace
}  // namespace godobject::test_object_dictionary
