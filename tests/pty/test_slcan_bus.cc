// SLCAN in user space: our host against scripted adapters and our own adapter side, and that side against the
// slcan interface of python-can.
#include <gmock/gmock.h>

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "platform/linux/bus/slcan.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/program.h"
#include "tests/support/pseudo_terminal.h"

namespace godobject::test::test_slcan_bus {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

CanFrame numbered_frame(std::uint32_t id, std::uint8_t number) {
  CanFrame frame{.id = id, .size = 8};
  frame.data.fill(number);
  std::fill(frame.data.begin() + frame.size, frame.data.end(), std::uint8_t{0});
  return frame;
}

bool wait_for(int descriptor) {
  pollfd waiting{.fd = descriptor, .events = POLLIN, .revents = 0};
  return poll(&waiting, 1, 1000) > 0;
}

/// Returns false if no frame has come for a second.
bool receive(LinuxBus& bus, ReceivedFrame& frame) {
  while (!bus.try_receive(frame))
    if (!wait_for(bus.descriptor())) return false;
  return true;
}

/// An adapter with scripted answers: a fixed text per command line, by the line's first letter.
class ScriptedAdapter {
 public:
  explicit ScriptedAdapter(std::map<char, std::string> answers)
      : answers_(std::move(answers)), thread_([this] { serve(); }) {}
  ~ScriptedAdapter() {
    stop_ = true;
    thread_.join();
  }
  const std::string& path() const { return terminal_.slave(); }
  void say(const std::string& text) { EXPECT_TRUE(terminal_.send(text)); }
  /// Stops all answers.
  void hang_up() {
    stop_ = true;
    thread_.join();
    thread_ = std::thread([] {});
    terminal_.hang_up();
  }
  std::string requests() {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

 private:
  void serve() {
    for (std::string line; !stop_;) {
      const std::string text = terminal_.receive(1, 5);
      if (text.empty()) continue;
      const std::lock_guard lock(mutex_);
      requests_ += text;
      if (text != "\r") {
        line += text;
        continue;
      }
      if (!line.empty() && answers_.contains(line[0])) (void)terminal_.send(answers_.at(line[0]));
      line.clear();
    }
  }

  PseudoTerminal terminal_{};
  std::map<char, std::string> answers_;
  std::mutex mutex_{};
  std::string requests_{};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

const std::map<char, std::string> good_adapter{
    {'C', "\a"}, {'S', "\r"}, {'O', "\r"}, {'F', "F00\r"}, {'t', "z\r"}};

/// Returns good_adapter with some answers changed.
std::map<char, std::string> adapter_with(const std::map<char, std::string>& others) {
  std::map<char, std::string> answers = good_adapter;
  for (const auto& [command, answer] : others) answers[command] = answer;
  return answers;
}

/// Reads until `done`, or until no byte has come for a second.
template <class Done>
void pump(SlcanBus& bus, Done done) {
  ReceivedFrame frame;
  while (!done()) {
    while (bus.try_receive(frame)) continue;
    if (done() || !wait_for(bus.descriptor())) break;
  }
}

TEST(SlcanBus, OpensClosesAndCountsAcknowledgedFrames) {
  ScriptedAdapter adapter(good_adapter);
  SlcanBus bus(adapter.path(), {.bit_rate = 500e3});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  EXPECT_EQ(bus.state(), BusState::error_active);
  EXPECT_THAT(bus.trouble(), IsEmpty());
  EXPECT_EQ(bus.name(), adapter.path());
  EXPECT_EQ(bus.try_send({.id = 0x123, .size = 1}), SendResult::queued);
  EXPECT_EQ(bus.counters().sent, 0u) << "not acknowledged yet";
  pump(bus, [&] { return bus.counters().sent == 1; });
  EXPECT_EQ(bus.counters().sent, 1u);
  bus.close();
  EXPECT_EQ(bus.state(), BusState::closed);
  EXPECT_THAT(adapter.requests(), testing::StartsWith("V\rC\rS6\rO\rF\rt123100\r"));
}

TEST(SlcanBus, ReceivesFramesAmongGarbage) {
  ScriptedAdapter adapter(good_adapter);
  SlcanBus bus(adapter.path(), {});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  adapter.say("t18128\rt1812ABCD\r\r\n" + std::string(100, '?') + "\rT0000018100123\r");
  ReceivedFrame frame;
  ASSERT_TRUE(receive(bus, frame));
  EXPECT_EQ(frame.frame.id, 0x181u);
  EXPECT_EQ(frame.frame.data[1], 0xCD);
  ASSERT_TRUE(receive(bus, frame));
  EXPECT_TRUE(frame.frame.extended);
  EXPECT_EQ(bus.counters().received, 2u);
  EXPECT_THAT(bus.trouble(), HasSubstr("2 lines were garbled"));
}

TEST(SlcanBus, SaysWhatTheAdapterRefuses) {
  ScriptedAdapter rate(adapter_with({{'S', "\a"}}));
  SlcanBus bus(rate.path(), {});
  EXPECT_FALSE(bus.open());
  EXPECT_THAT(bus.trouble(), HasSubstr("refuses the bit rate"));
  EXPECT_EQ(bus.state(), BusState::closed);
  ScriptedAdapter channel(adapter_with({{'O', "\a"}}));
  SlcanBus other(channel.path(), {});
  EXPECT_FALSE(other.open());
  EXPECT_THAT(other.trouble(), HasSubstr("refuses to open its channel"));
}

TEST(SlcanBus, GivesUpWhereNothingAnswers) {
  PseudoTerminal silent;
  SlcanBus bus(silent.slave() + ",9600", {});
  EXPECT_FALSE(bus.open());
  EXPECT_THAT(bus.trouble(), HasSubstr("no adapter answers"));
  EXPECT_THAT(bus.trouble(), HasSubstr("9600 baud"));
}

TEST(SlcanBus, RefusesWhatSlcanCannotDoBeforeItTouchesThePort) {
  SlcanBus rate("/dev/null", {.bit_rate = 83.3e3});
  EXPECT_FALSE(rate.open());
  EXPECT_THAT(rate.trouble(), HasSubstr("no bit rate of 83300"));
  SlcanBus fd("/dev/null", {.data_bit_rate = 5e6});
  EXPECT_FALSE(fd.open());
  EXPECT_THAT(fd.trouble(), HasSubstr("no CAN FD"));
  SlcanBus baud("/dev/null,fast", {});
  EXPECT_FALSE(baud.open());
  EXPECT_THAT(baud.trouble(), HasSubstr("not a number"));
  SlcanBus no_port("/dev/null", {});
  EXPECT_FALSE(no_port.open());
  EXPECT_THAT(no_port.trouble(), HasSubstr("not a terminal"));
}

/// Stock CANables answer only V, with texts of their own.
TEST(SlcanBus, AnAdapterThatAcknowledgesNothingIsKnownByItsVersion) {
  for (const std::string version :
       {"V1013\r", "b158aa7 github.com/somebody/canable-fw.git\r", "v0.4\r\n", "FF12\n"}) {
    ScriptedAdapter adapter({{'V', version}});
    SlcanBus bus(adapter.path(), {.bit_rate = 500e3});
    ASSERT_TRUE(bus.open()) << version << bus.trouble();
    EXPECT_THAT(bus.trouble(), IsEmpty()) << version;
    EXPECT_EQ(bus.counters().error_frames, 0u);
    ASSERT_EQ(bus.try_send({.id = 0x123, .size = 1}), SendResult::queued);
    adapter.say("t1812ABCD\r");
    ReceivedFrame frame;
    ASSERT_TRUE(receive(bus, frame));
    EXPECT_EQ(frame.frame.id, 0x181u);
    for (int ms = 0; ms < 1000 && !adapter.requests().ends_with("t123100\r"); ++ms)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_THAT(adapter.requests(), HasSubstr("S6\r"));
    EXPECT_THAT(adapter.requests(), HasSubstr("O\r"));
    EXPECT_THAT(adapter.requests(), HasSubstr("t123100\r"));
  }
}

TEST(SlcanBus, AnAdapterThatAcknowledgesWithLineFeedIsOne) {
  for (const std::string end : {"\n", "\r\n", "\n\r"}) {
    ScriptedAdapter adapter(
        {{'V', "V1013\r"}, {'C', end}, {'S', end}, {'O', end}, {'F', "F00" + end}, {'t', "z" + end}});
    SlcanBus bus(adapter.path(), {});
    ASSERT_TRUE(bus.open()) << bus.trouble();
    for (int i = 0; i < 3; ++i) ASSERT_EQ(bus.try_send({.id = 0x123}), SendResult::queued);
    pump(bus, [&] { return bus.counters().sent == 3; });
    EXPECT_EQ(bus.counters().sent, 3u);
    EXPECT_THAT(bus.trouble(), IsEmpty());
  }
}

TEST(SlcanBus, ARefusalOfAnAdapterThatEndsLinesWithLineFeedIsOne) {
  ScriptedAdapter adapter({{'V', "V1013\r"}, {'C', "\n"}, {'S', "\n"}, {'O', "\a"}});
  SlcanBus bus(adapter.path(), {});
  EXPECT_FALSE(bus.open());
  EXPECT_THAT(bus.trouble(), HasSubstr("refuses to open its channel"));
}

/// Some adapters repeat their previous command upon an empty line.
TEST(SlcanBus, NoEmptyLineIsEverWritten) {
  for (const bool acknowledges : {false, true}) {
    ScriptedAdapter adapter(acknowledges ? good_adapter : std::map<char, std::string>{{'V', "V1013\r"}});
    std::string last_frames;
    {
      SlcanBus bus(adapter.path(), {});
      ASSERT_TRUE(bus.open()) << bus.trouble();
      ASSERT_EQ(bus.try_send({.id = 0x20B, .size = 4}), SendResult::queued);
      last_frames = std::string(bus.line_rest()->text()) + bus.as_written({.id = 0x20B, .size = 4}) +
                    bus.as_written({.id = 0, .size = 2});
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_EQ(last_frames, "t20B400000000\rt00020000\r");
    EXPECT_THAT(adapter.requests(), testing::Not(testing::StartsWith("\r")));
    EXPECT_THAT(adapter.requests(), testing::Not(HasSubstr("\r\r")));
  }
}

/// A terminal that echoes and a device that sends by itself are no adapters.
TEST(SlcanBus, WhatAnswersVWithoutMeaningItIsNoAdapter) {
  ScriptedAdapter echo({{'V', "V\r"}, {'C', "C\r"}, {'S', "S8\r"}, {'O', "O\r"}, {'F', "F\r"}});
  SlcanBus bus(echo.path(), {});
  EXPECT_FALSE(bus.open());
  EXPECT_THAT(bus.trouble(), HasSubstr("no adapter answers"));
  PseudoTerminal receiver;
  std::atomic<bool> stop{false};
  std::thread talking([&] {
    for (int second = 0; !stop; ++second) {
      (void)receiver.send("$GPRMC,0815" + std::to_string(second) +
                          ",A,4807.038,N,01131.000,E,022.4,084.4*6A\r\n");
      std::this_thread::sleep_for(std::chrono::milliseconds(70));
    }
  });
  SlcanBus other(receiver.slave(), {});
  EXPECT_FALSE(other.open());
  EXPECT_THAT(other.trouble(), HasSubstr("no adapter answers"));
  stop = true;
  talking.join();
}

/// UCCB reads the first command of a USB packet and drops the others.
TEST(SlcanLine, EveryLineIsAWriteOfItsOwn) {
  std::array<int, 2> ends{};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, ends.data()), 0);
  SlcanLine line;
  line.port().adopt(ends[0], "socket");
  std::vector<std::string> put, seen;
  const auto drain = [&] {
    std::array<char, 4096> buffer{};
    for (ssize_t n = 0; (n = read(ends[1], buffer.data(), buffer.size())) > 0;)
      seen.emplace_back(buffer.data(), static_cast<std::size_t>(n));
  };
  for (std::uint32_t i = 0; put.size() < 3000; ++i) {
    const std::string text = SlcanLine::text_of(numbered_frame(i & 0x7FF, static_cast<std::uint8_t>(i)));
    if (line.put(text)) put.push_back(text);
    else drain();
  }
  for (std::size_t before = 0; seen.size() < put.size() && (before == 0 || seen.size() > before);) {
    before = seen.size();
    line.flush();
    drain();
  }
  EXPECT_EQ(seen, put);
  close(ends[1]);
}

/// The last frames follow the rest of the line that a full terminal cut off.
TEST(SlcanLine, TheRestOfACutLineIsKept) {
  int num_cut = 0;
  for (std::uint8_t size = 0; size <= 8; ++size) {
    PseudoTerminal terminal;
    SlcanLine line;
    ASSERT_TRUE(line.port().open(terminal.slave(), {}));
    CanFrame frame = numbered_frame(0x181, 7);
    frame.size = size;
    std::fill(frame.data.begin() + size, frame.data.end(), std::uint8_t{0});
    const std::string text = SlcanLine::text_of(frame);
    while (line.put(text)) continue;
    const std::string rest(line.rest().text());
    const std::string seen = terminal.receive(1 << 20, 50);
    EXPECT_EQ((seen + rest).size() % text.size(), 0u) << seen.size() << " and " << rest;
    EXPECT_TRUE((seen + rest).ends_with(text));
    num_cut += rest.empty() ? 0 : 1;
  }
  EXPECT_GT(num_cut, 0);
}

TEST(SlcanBus, GarbageIsCountedAsErrorFrames) {
  std::mt19937 random(1);
  for (const int kind : {0, 1, 2}) {  // random bytes, bytes without a line end, refusals that cut lines off
    ScriptedAdapter adapter(good_adapter);
    SlcanBus bus(adapter.path(), {});
    ASSERT_TRUE(bus.open()) << bus.trouble();
    std::string garbage(3000, '\0');
    for (char& c : garbage)
      c = static_cast<char>(kind == 0 ? random() : kind == 1 ? 0x80 : random() % 2 ? 'x' : '\a');
    adapter.say(garbage);
    pump(bus, [] { return false; });
    EXPECT_GE(bus.counters().error_frames, kind == 1 ? 1u : 10u) << kind;
    EXPECT_EQ(bus.counters().last_error, BusError::form);
    const std::uint64_t before = bus.counters().error_frames;
    bus.close();
    EXPECT_EQ(bus.counters().error_frames, before) << "kept over close()";
  }
}

TEST(SlcanBus, FramesOfCanFdAreNamed) {
  ScriptedAdapter adapter(good_adapter);
  SlcanBus bus(adapter.path(), {});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  adapter.say("d1813ABCDEF\rB00000181F" + std::string(128, '0') + "\rb18190011223344556677889900AA\r" +
              "D0000018101234\r");
  pump(bus, [&] { return bus.trouble().find("4 CAN FD") != std::string::npos; });
  EXPECT_THAT(bus.trouble(), HasSubstr("4 CAN FD frames arrived"));
  EXPECT_EQ(bus.counters().error_frames, 0u);
}

TEST(SlcanBus, FlagsOfTheAdapterBecomeStates) {
  ScriptedAdapter adapter(adapter_with({{'F', "FA5\r"}}));
  SlcanBus bus(adapter.path(), {});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  adapter.say("FA5\r");  // bus error, error passive, error warning, receive queue full
  pump(bus, [&] { return bus.state() != BusState::error_active; });
  EXPECT_EQ(bus.state(), BusState::error_passive);
  EXPECT_GE(bus.counters().error_frames, 1u);
  EXPECT_GE(bus.counters().receive_overflow, 1u);
  EXPECT_THAT(bus.trouble(), HasSubstr("termination"));
}

TEST(SlcanBus, ErrorLinesOfTheKernelsDialectBecomeStatesUpToBusOff) {
  ScriptedAdapter adapter(adapter_with({{'F', "\a"}}));
  SlcanBus bus(adapter.path(), {});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  adapter.say("sw096100\r");
  pump(bus, [&] { return bus.state() == BusState::error_warning; });
  EXPECT_EQ(bus.state(), BusState::error_warning);
  EXPECT_EQ(bus.counters().transmit_error_counter, 100);
  EXPECT_EQ(bus.counters().receive_error_counter, 96);
  adapter.say("e1a\rsb255000\r");
  pump(bus, [&] { return bus.state() == BusState::bus_off; });
  EXPECT_EQ(bus.counters().last_error, BusError::acknowledge);
  EXPECT_EQ(bus.counters().bus_off_events, 1u);
  EXPECT_EQ(bus.try_send({.id = 0x80}), SendResult::off);
  EXPECT_THAT(bus.trouble(), HasSubstr("bus-off"));
}

TEST(SlcanBus, AFrameTheAdapterRefusesIsCountedAsDropped) {
  ScriptedAdapter adapter(adapter_with({{'t', "\a"}}));
  SlcanBus bus(adapter.path(), {});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  ASSERT_EQ(bus.try_send({.id = 0x80}), SendResult::queued);
  pump(bus, [&] { return bus.counters().send_dropped == 1; });
  EXPECT_EQ(bus.counters().send_dropped, 1u);
  EXPECT_EQ(bus.counters().sent, 0u);
  EXPECT_THAT(bus.trouble(), HasSubstr("refused 1 frames"));
}

TEST(SlcanBus, UnpluggedIsGone) {
  ScriptedAdapter adapter(good_adapter);
  SlcanBus bus(adapter.path(), {});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  adapter.hang_up();
  ASSERT_TRUE(wait_for(bus.descriptor()));
  ReceivedFrame frame;
  EXPECT_FALSE(bus.try_receive(frame));
  EXPECT_EQ(bus.state(), BusState::gone);
  EXPECT_THAT(bus.trouble(), HasSubstr("reopen"));
  EXPECT_EQ(bus.try_send({.id = 0x80}), SendResult::down);
  EXPECT_FALSE(bus.open());
}

/// Our host on the terminal of our adapter side, opened.
class OurTwoEnds : public testing::Test {
 protected:
  OurTwoEnds() {
    EXPECT_TRUE(adapter_.open()) << adapter_.trouble();
    host_ = std::make_unique<SlcanBus>(adapter_.name(), BusSettings{});
    EXPECT_THAT(adapter_.trouble(), HasSubstr("waits for the other end"));
    EXPECT_EQ(adapter_.try_send({.id = 0x80}), SendResult::down);
    std::atomic<bool> opened{false};
    std::thread opening([&] {
      EXPECT_TRUE(host_->open()) << host_->trouble();
      opened = true;
    });
    ReceivedFrame frame;
    while (!opened) {
      EXPECT_FALSE(adapter_.try_receive(frame));
      pollfd waiting{.fd = adapter_.descriptor(), .events = POLLIN, .revents = 0};
      poll(&waiting, 1, 10);
    }
    opening.join();
    EXPECT_EQ(adapter_.state(), BusState::error_active);
    EXPECT_THAT(adapter_.trouble(), IsEmpty());
  }

  PtyBus adapter_{BusSettings{}};
  std::unique_ptr<SlcanBus> host_;
};

TEST_F(OurTwoEnds, FramesGoBothWaysWithoutAllocating) {
  AllocationGuard guard;
  for (std::uint8_t i = 0; i < 200; ++i) {
    ReceivedFrame frame;
    ASSERT_EQ(host_->try_send(numbered_frame(0x201, i)), SendResult::queued);
    ASSERT_TRUE(receive(adapter_, frame));
    ASSERT_EQ(frame.frame.data, numbered_frame(0x201, i).data);
    ASSERT_EQ(adapter_.try_send(numbered_frame(0x181, i)), SendResult::queued);
    ASSERT_TRUE(receive(*host_, frame));
    ASSERT_EQ(frame.frame.id, 0x181u);
    ASSERT_EQ(frame.frame.data, numbered_frame(0x181, i).data);
  }
  guard.disarm();
  EXPECT_EQ(guard.heap_calls(), 0) << guard.report();
  EXPECT_EQ(host_->counters().sent, 200u);
  EXPECT_EQ(host_->counters().received, 200u);
  EXPECT_EQ(adapter_.counters().received, 200u);
}

TEST_F(OurTwoEnds, AFullLineIsReportedAndQueuedFramesArriveWholeAndInOrder) {
  std::size_t num_queued = 0;
  while (host_->try_send(numbered_frame(0x201, static_cast<std::uint8_t>(num_queued))) == SendResult::queued)
    ASSERT_LT(++num_queued, 1'000'000u);
  EXPECT_EQ(host_->state(), BusState::error_active);
  EXPECT_EQ(host_->counters().send_refused, 1u);
  for (std::size_t i = 0; i < num_queued; ++i) {
    ReceivedFrame frame;
    while (!adapter_.try_receive(frame)) {
      ReceivedFrame none;
      EXPECT_FALSE(host_->try_receive(none));  // writes the queued bytes
      ASSERT_TRUE(wait_for(adapter_.descriptor())) << i << " of " << num_queued;
    }
    ASSERT_EQ(frame.frame.data[0], i % 256) << i;
  }
}

TEST_F(OurTwoEnds, TheAdapterIsDownAgainWhenTheHostHasClosed) {
  host_->close();
  ReceivedFrame frame;
  while (adapter_.state() == BusState::error_active && wait_for(adapter_.descriptor()))
    EXPECT_FALSE(adapter_.try_receive(frame));
  EXPECT_EQ(adapter_.state(), BusState::down);
}

TEST_F(OurTwoEnds, TheHostSeesTheAdapterGo) {
  adapter_.close();
  EXPECT_EQ(adapter_.name(), "");
  ReceivedFrame frame;
  EXPECT_FALSE(host_->try_receive(frame));
  EXPECT_EQ(host_->state(), BusState::gone);
}

TEST(PtyBus, RefusesWhatAnAdapterRefuses) {
  PtyBus adapter({.bit_rate = 500e3});
  ASSERT_TRUE(adapter.open());
  SerialPort host;
  ASSERT_TRUE(host.open(adapter.name(), {}));
  const auto ask = [&](std::string_view command) {
    EXPECT_EQ(host.write({reinterpret_cast<const std::uint8_t*>(command.data()), command.size()}),
              command.size());
    ReceivedFrame frame;
    EXPECT_FALSE(wait_for(adapter.descriptor()) && adapter.try_receive(frame)) << command;
    std::array<std::uint8_t, 64> answer{};
    EXPECT_TRUE(host.wait_readable(1'000'000'000)) << command;
    return std::string(answer.begin(), answer.begin() + static_cast<std::ptrdiff_t>(host.read(answer)));
  };
  EXPECT_EQ(ask("t0800\r"), "\a") << "the channel is closed";
  EXPECT_EQ(ask("F\r"), "\a");
  EXPECT_EQ(ask("S8\r"), "\r");
  EXPECT_EQ(ask("L\r"), "\r");
  EXPECT_THAT(adapter.trouble(), HasSubstr("expects 1000000 bit/s, this bus has 500000"));
  EXPECT_EQ(ask("t0800\r"), "\a") << "it only listens";
  EXPECT_EQ(ask("S6\r"), "\a") << "the channel is open";
  EXPECT_EQ(ask("O\r"), "\a") << "open already";
  EXPECT_EQ(ask("F\r"), "F00\r");
  EXPECT_EQ(ask("V\r"), "V1013\r");
  EXPECT_EQ(ask("N\r"), "NGODO\r");
  EXPECT_EQ(ask("Z1\r"), "\a");
  EXPECT_EQ(ask("s031C\r"), "\a");
  EXPECT_EQ(ask("\rC\r"), "\r") << "once: an empty line is no command";
}

/// python-can as the other end: sends eight frames, expects them back with the identifier increased by one.
constexpr const char* python_host = R"(
import sys, can
bus = can.Bus(sys.argv[1], bustype="slcan", bitrate=1000000, sleep_after_open=0)
for i in range(8):
    sent = can.Message(arbitration_id=0x100 + 2 * i, is_extended_id=i % 2 == 1, data=bytes(range(i)))
    bus.send(sent)
    answer = None
    while answer is None:  # the acknowledgement of our own frame is one, too
        answer = bus.recv(5)
    assert answer.arbitration_id == sent.arbitration_id + 1, answer
    assert answer.is_extended_id == sent.is_extended_id and answer.data == sent.data, answer
bus.shutdown()
print("all eight")
)";

TEST(PtyBus, PythonCanTalksToIt) {
  if (std::system("/usr/bin/python3 -c 'import can, serial' 2> /dev/null") != 0)
    GTEST_SKIP() << "/usr/bin/python3 has no module can: apt-get install python3-can python3-serial";
  PtyBus adapter({});
  ASSERT_TRUE(adapter.open());
  const std::string command =
      "timeout 30 /usr/bin/python3 -c '" + std::string(python_host) + "' " + adapter.name() + " 2>&1";
  std::FILE* const python = popen(command.c_str(), "r");
  ASSERT_NE(python, nullptr);
  bool finished = false;
  std::string output;
  while (!finished) {
    std::array<pollfd, 2> waiting{pollfd{.fd = adapter.descriptor(), .events = POLLIN, .revents = 0},
                                  pollfd{.fd = fileno(python), .events = POLLIN, .revents = 0}};
    ASSERT_GT(poll(waiting.data(), waiting.size(), 60'000), 0);
    for (ReceivedFrame frame; adapter.try_receive(frame);) {
      ++frame.frame.id;
      EXPECT_EQ(adapter.try_send(frame.frame), SendResult::queued);
    }
    if (waiting[1].revents == 0) continue;
    std::array<char, 4096> buffer{};
    const ssize_t n = read(fileno(python), buffer.data(), buffer.size());
    finished = n <= 0;
    if (n > 0) output.append(buffer.data(), static_cast<std::size_t>(n));
  }
  EXPECT_EQ(pclose(python), 0) << output;
  EXPECT_THAT(output, HasSubstr("all eight"));
  EXPECT_EQ(adapter.counters().received, 8u);
}

}  // namespace
}  // namespace godobject::test::test_slcan_bus
