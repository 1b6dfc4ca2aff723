#include "hal/tracker/address.h"

#include <gtest/gtest.h>

#include <string>

namespace godobject::test_address {
namespace {

std::string parsed(std::string_view text, std::string_view port) {
  const auto address = parse_tcp_address(text, port);
  return address ? address->host + " " + address->port : "none";
}

TEST(TrackerAddress, IsParsed) {
  EXPECT_EQ(parsed("tcp:127.0.0.1:18944", ""), "127.0.0.1 18944");
  EXPECT_EQ(parsed("tcp:plus.local", default_tcp_port(TrackerProtocol::openigtlink)), "plus.local 18944");
  EXPECT_EQ(parsed("tcp:vega", default_tcp_port(TrackerProtocol::ndi)), "vega 8765");
  EXPECT_EQ(parsed("tcp:[::1]:5000", ""), "::1 5000");
  EXPECT_EQ(parsed("tcp:[::1]", "18944"), "::1 18944");
  for (const char* text : {"", "tcp:", "/dev/ttyUSB0", "udp:host:1", "tcp:host:0", "tcp:host:65536",
                           "tcp:host:x", "tcp::18944", "tcp:[::1", "tcp:[::1]x", "tcp:host:"})
    EXPECT_EQ(parsed(text, "18944"), "none") << text;
}

TEST(TrackerAddress, OnlySomeProtocolsHaveServers) {
  EXPECT_TRUE(default_tcp_port(TrackerProtocol::polhemus).empty());
  EXPECT_TRUE(is_on_network({.name = "", .port = "tcp:vega", .tools = {}}));
  EXPECT_FALSE(is_on_network({.name = "", .port = "/dev/ttyUSB0", .tools = {}}));
}

}  // namespace
}  // namespace godobject::test_address
